//! Steps collected for one update.

use crate::nn::archive::{Archive, ArchiveError};

/// What follows a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The episode goes on.
    None,
    /// The episode is over, and the state after is worth nothing.
    Terminal,
    /// The episode is cut, and the state after has its value.
    Truncated,
}

/// Steps since the last update.
#[derive(Debug, Clone, Default)]
pub(super) struct Rollout {
    pub(super) states: Vec<f32>,
    pub(super) actions: Vec<u32>,
    pub(super) rewards: Vec<f32>,
    pub(super) ends: Vec<End>,
    /// States after truncated steps, in their order.
    pub(super) after: Vec<f32>,
}

impl Rollout {
    /// Adds a step.
    pub(super) fn push(
        &mut self,
        state: &[f32],
        action: usize,
        reward: f32,
        next: &[f32],
        end: End,
    ) {
        self.states.extend_from_slice(state);
        self.actions.push(action as u32);
        self.rewards.push(reward);
        self.ends.push(end);
        if end == End::Truncated {
            self.after.extend_from_slice(next);
        }
    }

    /// Forgets all steps.
    pub(super) fn clear(&mut self) {
        self.states.clear();
        self.actions.clear();
        self.rewards.clear();
        self.ends.clear();
        self.after.clear();
    }

    /// Adds the steps to an archive; states are rows of `width` numbers.
    pub(super) fn save(&self, prefix: &str, width: usize, archive: &mut Archive) {
        let name = |part: &str| format!("{prefix}{part}");
        let (count, after) = (self.actions.len(), self.after.len() / width);
        archive.put(&name("steps"), (count, after));
        archive.put_f32(name("states"), &[count, width], &self.states);
        archive.put_u32(name("actions"), &[count], &self.actions);
        archive.put_f32(name("rewards"), &[count], &self.rewards);
        let ends: Vec<u32> = self.ends.iter().map(|end| *end as u32).collect();
        archive.put_u32(name("ends"), &[count], &ends);
        archive.put_f32(name("after"), &[after, width], &self.after);
    }

    /// Returns the steps that an archive holds.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when they are missing or of another shape.
    pub(super) fn restore(
        prefix: &str,
        width: usize,
        archive: &Archive,
    ) -> Result<Self, ArchiveError> {
        let name = |part: &str| format!("{prefix}{part}");
        let (count, after): (usize, usize) = archive.get(&name("steps"))?;
        let end = |end: &u32| match end {
            0 => End::None,
            1 => End::Terminal,
            _ => End::Truncated,
        };
        Ok(Self {
            states: archive.f32(&name("states"), &[count, width])?.to_vec(),
            actions: archive.u32(&name("actions"), &[count])?.to_vec(),
            rewards: archive.f32(&name("rewards"), &[count])?.to_vec(),
            ends: archive.u32(&name("ends"), &[count])?.iter().map(end).collect(),
            after: archive.f32(&name("after"), &[after, width])?.to_vec(),
        })
    }
}
