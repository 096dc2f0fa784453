//! M3: representatives of k-means clusters, each with the importance of its cluster.
//!
//! Which point MDPs these are is no matter of chance once the family and the seed are given, so no design says how far
//! the estimate may be off. What can be said: how much a representative differs from those of the nearest clusters is
//! about how much, or more than, the point MDPs of a cluster differ from each other. The interval takes every
//! representative for a random member of its cluster, with that variance; it does not cover that point MDPs near
//! centroids are unlike others, as where congestion begins.

use super::contract::{Estimator, Sample};
use super::neighbours::nearest;
use crate::stats::resampling::Contrast;
use crate::stats::{PointObjectives, Resampling};

/// Nearest representatives that one is compared with.
const NEIGHBOURS: usize = 2;

/// Returns how the choice of representatives is drawn anew.
pub(super) fn resampling(sample: Sample<'_>, scores: &[PointObjectives]) -> Resampling {
    match Estimator::Representatives.is_known(sample, scores.len()) {
        true => Resampling::whole(),
        false => Resampling::of(contrasts(sample, scores), scores.len() as f64 - 1.0),
    }
}

fn contrasts(sample: Sample<'_>, scores: &[PointObjectives]) -> Vec<Contrast> {
    let total: f64 = scores.iter().map(|p| p.weight).sum();
    let answered = sample.answered(scores.len());
    let k = NEIGHBOURS.min(scores.len().saturating_sub(1));
    let of = |(i, p): (usize, &PointObjectives)| {
        let size = f64::from(sample.points[i].count.max(1)) / answered;
        let within = (1.0 - sample.fixed(1.0 / size)).max(0.0);
        if k == 0 || within == 0.0 {
            return Contrast::new();
        }
        let scale = p.weight / total * (within * k as f64 / (k + 1) as f64).sqrt();
        let others = nearest(sample.points, i, k);
        let mut contrast: Contrast = others.into_iter().map(|j| (j, -scale / k as f64)).collect();
        contrast.push((i, scale));
        contrast
    };
    scores.iter().enumerate().map(of).collect()
}
