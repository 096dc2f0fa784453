//! Tasks in packs: starting a job costs a batch system a second or more, so that short tasks share one.

use std::cmp::Reverse;
use std::ops::RangeInclusive;

/// Processor time that a pack is to take, seconds: the least keeps what a job costs (up to 2.6 s of a slot, measured on
/// Slurm) below 5%, the most lets a pack end before most limits of time and spreads what is left when nodes fail.
const SECONDS: RangeInclusive<f64> = 60.0..=1800.0;

/// Packs of a run that is neither short nor long: enough for the nodes of a usual cluster.
const USUAL: f64 = 500.0;

/// A pack of tasks.
#[derive(Debug, Clone, PartialEq)]
pub struct Pack {
    /// Rows of the plan, ascending.
    pub tasks: Vec<usize>,
    /// Processor time that they are expected to take, seconds.
    pub seconds: f64,
    /// Of this, that of the longest of them.
    pub longest_s: f64,
}

impl Pack {
    /// Returns the time that so many workers need for it at least, seconds: no task is shared by several.
    pub fn time_s(&self, workers: usize) -> f64 {
        (self.seconds / workers.max(1) as f64).max(self.longest_s)
    }
}

/// Returns tasks in packs, those that take longest first, so that none of them is waited for in the end.
///
/// # Arguments
///
/// * `tasks` — rows of the plan and the processor time that each is expected to take, seconds.
/// * `seconds` — processor time that a pack is to take at most, unless one task takes longer; `None` where it follows
///   from that of the whole.
pub fn packs(tasks: impl IntoIterator<Item = (usize, f64)>, seconds: Option<f64>) -> Vec<Pack> {
    let tasks: Vec<(usize, f64)> = tasks.into_iter().collect();
    let whole: f64 = tasks.iter().map(|(_, seconds)| seconds).sum();
    let usual = (whole / USUAL).clamp(*SECONDS.start(), *SECONDS.end());
    let most = seconds.unwrap_or(usual);
    let mut packs: Vec<Pack> = Vec::new();
    for (task, seconds) in tasks {
        match packs.last_mut() {
            Some(pack) if pack.seconds + seconds <= most => {
                pack.tasks.push(task);
                pack.seconds += seconds;
                pack.longest_s = pack.longest_s.max(seconds);
            }
            _ => packs.push(Pack { tasks: vec![task], seconds, longest_s: seconds }),
        }
    }
    packs.sort_by_key(|pack| Reverse((pack.seconds * 1e3) as u64));
    packs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(packs: &[Pack]) -> Vec<usize> {
        packs.iter().map(|pack| pack.tasks.len()).collect()
    }

    #[test]
    fn short_tasks_share_a_pack_and_a_long_one_has_its_own_which_comes_first() {
        let tasks = [(0, 20.0), (1, 20.0), (2, 20.0), (3, 20.0), (4, 500.0), (5, 1.0)];
        let packs = packs(tasks, None);
        assert_eq!(packs[0], Pack { tasks: vec![4], seconds: 500.0, longest_s: 500.0 });
        assert_eq!(packs[1], Pack { tasks: vec![0, 1, 2], seconds: 60.0, longest_s: 20.0 });
        assert_eq!(sizes(&packs), [1, 3, 1, 1]);
    }

    #[test]
    fn more_workers_take_less_time_but_not_less_than_the_longest_task() {
        let packs = packs([(0, 600.0), (1, 100.0), (2, 100.0)], Some(900.0));
        assert_eq!([1, 2, 8].map(|workers| packs[0].time_s(workers)), [800.0, 600.0, 600.0]);
    }

    #[test]
    fn every_task_is_in_one_pack() {
        let packs = packs((0..10_000).map(|task| (task, (task % 97) as f64)), None);
        let mut tasks: Vec<usize> = packs.iter().flat_map(|pack| pack.tasks.clone()).collect();
        tasks.sort_unstable();
        assert!(tasks.into_iter().eq(0..10_000));
        assert!(packs.iter().all(|pack| pack.seconds <= 1800.0));
    }

    #[test]
    fn packs_grow_with_the_run_to_half_an_hour() {
        assert_eq!(sizes(&packs((0..600).map(|task| (task, 10.0)), None)), [6; 100]);
        assert_eq!(sizes(&packs((0..50_000).map(|task| (task, 10.0)), None))[..500], [100; 500]);
        assert_eq!(
            sizes(&packs((0..1_000_000).map(|task| (task, 10.0)), None))[..5000],
            [180; 5000]
        );
        assert_eq!(sizes(&packs((0..9).map(|task| (task, 10.0)), Some(35.0))), [3, 3, 3]);
        assert!(packs([], None).is_empty());
    }
}
