//! How far a run goes whose sample grows: as far as the look that is under way. Whether there is another look, its results
//! decide, and the command that began the run looks at them.

use std::collections::BTreeSet;

use super::dropped::{Dropped, Needed};
use super::manifest::{Identity, Task};

/// The tasks that a run is to do, as far as is known yet.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reach {
    /// The look that is under way, from 1, and how many there may be; `None` where the sample does not grow.
    pub look: Option<(usize, usize)>,
    /// By task, whether it is among them.
    has: Vec<bool>,
}

impl Reach {
    /// Returns the tasks up to the first look that has every task on which something was done; without growth all.
    ///
    /// # Arguments
    ///
    /// * `plan` — all tasks, each at its number.
    /// * `dropped` — methods that are no longer evaluated.
    /// * `begun` — whether something was done on a task, or somebody was asked to do it.
    pub fn of(
        identity: &Identity,
        plan: &[Task],
        dropped: &[Dropped],
        begun: impl Fn(usize) -> bool,
    ) -> Self {
        let sample = &identity.sample;
        let points: BTreeSet<&str> =
            plan.iter().filter(|t| begun(t.task)).map(|t| &*t.point).collect();
        let Some((look, now)) = sample.first_look_with(&points) else {
            return Self { look: None, has: vec![true; plan.len()] };
        };
        let drawn: BTreeSet<&str> = now.draws.iter().map(|d| d.point.as_str()).collect();
        let looks = sample.growth.as_ref().map_or(0, |growth| growth.looks.len());
        let needed = Needed::of(sample, dropped);
        let has = plan.iter().map(|t| drawn.contains(&*t.point) && needed.has(t)).collect();
        Self { look: Some((look + 1, looks)), has }
    }

    /// Returns whether a task is to be done, as far as is known yet.
    pub fn has(&self, task: usize) -> bool {
        self.has.get(task).copied().unwrap_or(false)
    }

    /// Returns how many tasks are to be done, as far as is known yet.
    pub fn count(&self) -> usize {
        self.has.iter().filter(|has| **has).count()
    }

    /// Returns whether results may ask for more tasks.
    pub fn may_grow(&self) -> bool {
        self.look.is_some_and(|(look, looks)| look < looks)
    }
}
