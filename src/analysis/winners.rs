//! Who wins where: the best method of every point MDP, and how sure that is.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::points::PointSummary;
use super::reference::Reference;
use crate::seed::derive;
use crate::stats::bootstrap::bootstrap;
use crate::stats::{Bootstrap, Direction, Resampling};
use crate::store::manifest::Identity;

/// The best method of a point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Winner {
    /// Position of the method with the best objective in the manifest; of equal ones the first.
    pub best: usize,
    /// The next one; `None` when no other has a result.
    pub runner_up: Option<usize>,
    /// 95% interval of the best method's score: noise between evaluation seeds, and between trainings
    /// where there are several.
    pub interval: Option<(f64, f64)>,
    /// 95% interval of how far the runner-up's score is behind, on the same seeds.
    pub lead: Option<(f64, f64)>,
}

impl Winner {
    /// Whether the lead is more than chance explains: the whole interval is above 0.
    pub fn is_decided(&self) -> bool {
        self.lead.is_some_and(|(low, _)| low > 0.0)
    }
}

/// Returns the best method of every point MDP; `None` where none has a result.
pub(super) fn winners(
    points: &[PointSummary],
    identity: &Identity,
    reference: &Reference,
) -> Vec<Option<Winner>> {
    points.par_iter().map(|point| winner(point, identity, reference)).collect()
}

fn winner(point: &PointSummary, identity: &Identity, reference: &Reference) -> Option<Winner> {
    let objective = |method: usize| point.results[method].as_ref().map(|r| r.objective);
    let mut order: Vec<(f64, usize)> =
        (0..point.results.len()).filter_map(|m| Some((objective(m)?, m))).collect();
    order.sort_by(|a, b| identity.direction.compare(a.0, b.0));
    let best = order.first()?.1;
    let runner_up = order.get(1).map(|o| o.1);
    let label = ["report", "winner", &point.row.point];
    let resampled = |method: usize| -> Option<Bootstrap> {
        let mut objectives = point.results[method].as_ref()?.objectives.clone()?;
        (objectives.weight, objectives.draws) = (1.0, 1);
        let mut rng = ChaCha8Rng::seed_from_u64(derive(identity.base_seed, &label));
        bootstrap(&[objectives], &Resampling::whole(), &mut rng, method as u64).ok()
    };
    let own = resampled(best);
    let other = runner_up.and_then(resampled);
    let divisor = (!reference.is_none()).then_some((1.0, 1.0));
    let is_no_divisor = |b: &&Bootstrap| divisor.is_none() || b.interval() != divisor;
    let interval = own.as_ref().filter(is_no_divisor).and_then(Bootstrap::interval);
    let lead = own.as_ref().zip(other.as_ref());
    let lead = lead.and_then(|(own, other)| match identity.direction {
        Direction::Lower => own.difference(other).interval(),
        Direction::Higher => other.difference(own).interval(),
    });
    Some(Winner { best, runner_up, interval, lead })
}
