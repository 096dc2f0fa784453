//! What a run says of its family.

use super::whole::Analysis;
use crate::stats::score::weighted_mean;

/// By how much counts that importance and instances imply may differ, relative to the count.
const SAME_COUNT: f64 = 1e-6;

impl Analysis {
    /// Whether all point MDPs of the family were to be evaluated.
    pub fn is_whole(&self) -> bool {
        self.points.len() == self.manifest.identity.sample.family_size
    }

    /// Returns the mean objectives of two methods over the point MDPs that both finished, and how many these are.
    pub fn objectives_shared(&self, a: usize, b: usize) -> Option<(f64, f64, usize)> {
        let both = self.points.iter().filter_map(|p| {
            Some((p.weight, p.results[a].as_ref()?.objective, p.results[b].as_ref()?.objective))
        });
        let both: Vec<(f64, f64, f64)> = both.collect();
        let of_a = weighted_mean(both.iter().map(|(w, a, _)| (*w, *a)))?;
        let of_b = weighted_mean(both.iter().map(|(w, _, b)| (*w, *b)))?;
        Some((of_a, of_b, both.len()))
    }

    /// Returns the number of instances of the whole family; `None` where importance is something else than the
    /// number of a point MDP's instances among all.
    pub fn family_instances(&self) -> Option<f64> {
        let mut counts = (self.points.iter())
            .filter(|p| p.row.importance > 0.0)
            .map(|p| f64::from(p.row.instances) / p.row.importance);
        let first = counts.next().filter(|count| *count > 0.0)?;
        let same = |count: f64| (count / first - 1.0).abs() < SAME_COUNT;
        let whole = (first.round() / first - 1.0).abs() < SAME_COUNT;
        (whole && counts.all(same)).then(|| first.round())
    }
}
