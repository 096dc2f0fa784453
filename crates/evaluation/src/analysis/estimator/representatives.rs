//! M3: representatives of k-means clusters, each with the importance of its cluster.
//!
//! Which point MDPs these are is no matter of chance once the family and the seed are given, so no design says how far
//! the estimate may be off. What can be said: how much a representative differs from those of the nearest clusters is
//! about how much, or more than, the point MDPs of a cluster differ from each other. The interval takes every
//! representative for a random member of its cluster, with that variance; it does not cover that point MDPs near
//! centroids are unlike others, as where congestion begins.

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample};
use super::neighbours::nearest;
use super::weighted::estimates;
use crate::stats::resampling::Contrast;
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError};

/// Nearest representatives that one is compared with.
const NEIGHBOURS: usize = 2;

/// The estimator of M3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Representatives;

impl Estimator for Representatives {
    fn name(&self) -> &'static str {
        "M3"
    }

    fn assumptions(&self) -> &'static str {
        "Representatives of clusters are no random sample. The interval takes each for a random member of its cluster, \
         with the spread between neighbouring clusters; what all of them miss, it does not cover."
    }

    fn estimate_all(
        &self,
        sample: Sample<'_>,
        scores: &[PointObjectives],
        statistics: &dyn Statistics,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let resampling = match self.is_known(sample, scores.len()) {
            true => Resampling::whole(),
            false => Resampling::of(contrasts(sample, scores), scores.len() as f64 - 1.0),
        };
        estimates(sample, scores, &resampling, statistics, rng)
    }
}

/// Returns for every cluster its representative against those of the nearest clusters.
fn contrasts(sample: Sample<'_>, scores: &[PointObjectives]) -> Vec<Contrast> {
    let total: f64 = scores.iter().map(|p| p.weight).sum();
    let answered = sample.answered(scores.len());
    let k = NEIGHBOURS.min(scores.len().saturating_sub(1));
    let of = |(i, p): (usize, &PointObjectives)| {
        let size = f64::from(sample.points[i].count.max(1)) / answered;
        let within = (1.0 - sample.fixed(1.0 / size)).max(0.0);
        if k == 0 || within == 0.0 {
            return None;
        }
        let scale = p.weight / total * (within * k as f64 / (k + 1) as f64).sqrt();
        let others = nearest(sample.points, i, k);
        let mut contrast: Contrast = others.into_iter().map(|j| (j, -scale / k as f64)).collect();
        contrast.push((i, scale));
        Some(contrast)
    };
    scores.iter().enumerate().filter_map(of).collect()
}
