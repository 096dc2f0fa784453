//! How much of a family a class of point MDPs is: counted in instances where all of it was evaluated, else as a share
//! of the weight.

use super::points::PointSummary;
use super::whole::Analysis;
use crate::stats::score::weighted_mean;

/// By how much counts that importance and instances imply may differ, relative to the count.
const SAME_COUNT: f64 = 1e-6;

/// How much of a family a class of point MDPs is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FamilyShare {
    /// So many instances of all; of a family that was evaluated as a whole.
    Counted(u64, u64),
    /// A share of the weight, which estimates that of the instances.
    Share(f64),
}

impl FamilyShare {
    /// Returns the extent in words, such as `3 of 7 intersections`.
    ///
    /// # Arguments
    ///
    /// * `percent` — how a share is written.
    pub fn in_words(self, instance: &str, percent: impl Fn(f64) -> String) -> String {
        match self {
            Self::Counted(n, 1) => format!("{n} of 1 {instance}"),
            Self::Counted(n, all) => format!("{n} of {all} {instance}s"),
            Self::Share(share) => format!("about {} of the {instance}s", percent(share)),
        }
    }

    /// Whether there is none.
    pub fn is_none(self) -> bool {
        match self {
            Self::Counted(n, _) => n == 0,
            Self::Share(share) => share <= 0.0,
        }
    }
}

impl Analysis {
    /// Whether all point MDPs of the family were to be evaluated.
    pub fn is_whole(&self) -> bool {
        self.points.len() == self.manifest.identity.sample.family_size
    }

    /// Returns how much of the family is so.
    pub fn extent(&self, is_so: impl Fn(&PointSummary) -> bool) -> FamilyShare {
        let so = || self.points.iter().filter(|p| is_so(p));
        match self.is_whole() {
            true => {
                let count = |p: &PointSummary| u64::from(p.row.instances);
                FamilyShare::Counted(so().map(count).sum(), self.points.iter().map(count).sum())
            }
            false => {
                let total: f64 = self.points.iter().map(|p| p.weight).sum();
                FamilyShare::Share(so().map(|p| p.weight).sum::<f64>() / total)
            }
        }
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
