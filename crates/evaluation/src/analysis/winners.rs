//! Who wins where: the best method of every point MDP, and how sure that is.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::points::{Evidence, PointSummary};
use super::summaries::{Estimated, bounds};
use crate::stats::bootstrap::RESAMPLES;
use crate::stats::quantile::containing;
use crate::stats::ranks::probability_of_first;
use crate::stats::resampling::factors;
use crate::stats::{Bootstrap, Direction, PointObjectives, Resampling, bootstrap, degrees};
use basics::seed::derive;

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
    /// How likely it is the best of all methods that have a result there, 0 to 1: the share of resamples in which it
    /// is, of the evaluation seeds, alike for all methods, and of the trainings where there are several; equal methods
    /// share. `None` without another method, where nothing was resampled, and where a method has no score. As the
    /// winner was chosen on the same seeds, it is rather too large than too small.
    pub probability: Option<f64>,
    /// Whether it is ahead of every other method by more than chance explains: the whole 95% interval of each lead,
    /// taken by itself, is above 0.
    pub is_decided: bool,
}

/// Returns the best method of every point MDP; `None` where none has a result.
pub(super) fn winners(evidence: Evidence<'_>) -> Vec<Option<Winner>> {
    evidence.points.par_iter().map(|point| winner(point, evidence)).collect()
}

fn winner(point: &PointSummary, evidence: Evidence<'_>) -> Option<Winner> {
    let Evidence { identity, reference, .. } = evidence;
    let objective = |method: usize| point.results[method].as_ref().map(|r| r.objective);
    let mut order: Vec<(f64, usize)> =
        (0..point.results.len()).filter_map(|m| Some((objective(m)?, m))).collect();
    order.sort_by(|a, b| identity.direction.compare(a.0, b.0));
    let best = order.first()?.1;
    let runner_up = order.get(1).map(|o| o.1);
    let measured = |m: usize| point.results[m].as_ref().and_then(|r| r.objectives.as_ref());
    let methods = order.iter().map(|(_, m)| (*m, measured(*m))).collect();
    let seed = derive(identity.base_seed, &["report", "winner", &point.row.point]);
    let contest = Contest::of(methods, seed, identity.direction);
    let (own, other) = (contest.resampled(0), contest.resampled(1));
    let divisor = (!reference.is_none()).then_some((1.0, 1.0));
    let is_no_divisor = |b: &&Bootstrap| divisor.is_none() || b.interval() != divisor;
    let of_best = measured(best).into_iter().flat_map(|o| o.method.iter().flatten());
    let bounds = bounds(evidence.most, of_best.copied());
    let estimated =
        |own: &Bootstrap| Estimated { value: own.estimate, interval: interval(own) }.cut(bounds);
    let interval = own.as_ref().filter(is_no_divisor).and_then(|own| estimated(own).interval);
    let lead = own.as_ref().zip(other.as_ref());
    let lead = lead.and_then(|(own, other)| contest.lead(own, other));
    let (probability, is_decided) = contest.outcome(own, other).unzip();
    let is_decided = is_decided.unwrap_or(false);
    Some(Winner { best, runner_up, interval, lead, probability, is_decided })
}

fn interval(of: &Bootstrap) -> Option<(f64, f64)> {
    of.interval().map(|interval| containing(interval, of.estimate))
}

/// What the methods that have a result on a point MDP measured there, the best one first.
struct Contest<'a> {
    /// Position in the manifest, and what was measured; nothing where there is no score.
    methods: Vec<(usize, Option<&'a PointObjectives>)>,
    /// Seed of the resamples.
    seed: u64,
    /// By how much resamples are further from the estimate than few seeds let them be, shape `[resamples]`.
    factors: Vec<f64>,
    direction: Direction,
}

impl Contest<'_> {
    /// Returns the contest of methods; whoever has the fewest degrees of freedom decides how much all are stretched, since
    /// only equal factors leave what methods have in common out of their differences.
    fn of(
        methods: Vec<(usize, Option<&PointObjectives>)>,
        seed: u64,
        direction: Direction,
    ) -> Contest<'_> {
        let measured = methods.iter().filter_map(|(_, measured)| *measured);
        let degrees = measured.filter_map(|o| degrees(std::slice::from_ref(o)));
        let fewest = degrees.min_by(f64::total_cmp);
        let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &["few seeds"]));
        let factors = factors(fewest, RESAMPLES, &mut rng);
        Contest { methods, seed, factors, direction }
    }

    /// Returns the resampled score of the method at a place, as far from the estimate as few seeds ask; `None` without one.
    fn resampled(&self, place: usize) -> Option<Bootstrap> {
        let (method, measured) = self.methods.get(place)?;
        let objectives = PointObjectives { weight: 1.0, draws: 1, ..(*measured)?.clone() };
        let rng = ChaCha8Rng::seed_from_u64(self.seed);
        let all = bootstrap(&[objectives], &Resampling::whole(), &rng, *method as u64).ok()?;
        Some(all.centred().stretched(&self.factors))
    }

    fn lead(&self, of: &Bootstrap, other: &Bootstrap) -> Option<(f64, f64)> {
        match self.direction {
            Direction::Lower => interval(&of.difference(other)),
            Direction::Higher => interval(&other.difference(of)),
        }
    }

    /// Returns the share of resamples in which the first method is the best, and whether it is ahead of every other by
    /// more than chance explains; those of the first two are given.
    fn outcome(&self, own: Option<Bootstrap>, next: Option<Bootstrap>) -> Option<(f64, bool)> {
        // Methods that no resample could put ahead need none.
        let rest = (2..self.methods.len()).filter(|place| !self.is_always_behind(*place));
        let rest = rest.map(|place| self.resampled(place));
        let all: Vec<Bootstrap> = [own, next].into_iter().chain(rest).collect::<Option<_>>()?;
        let resamples: Vec<&[f64]> = all.iter().map(|b| b.resamples.as_slice()).collect();
        let probability = probability_of_first(&resamples, self.direction)?;
        let is_ahead = |other| self.lead(&all[0], other).is_some_and(|(low, _)| low > 0.0);
        Some((probability, all[1..].iter().all(is_ahead)))
    }

    /// Whether no resample puts a method ahead of the first one.
    fn is_always_behind(&self, place: usize) -> bool {
        let (Some(first), Some(other)) = (self.methods[0].1, self.methods[place].1) else {
            return false;
        };
        let (Ok(score), Ok(behind)) = (first.score(), other.score()) else { return false };
        if first.baseline != other.baseline {
            return false;
        }
        let lead = |first: f64, other: f64| match self.direction {
            Direction::Lower => other - first,
            Direction::Higher => first - other,
        };
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (seed, baseline) in first.baseline.iter().enumerate() {
            for x in &first.method {
                for y in &other.method {
                    let on_seed = lead(x[seed], y[seed]) / baseline;
                    (least, most) = (least.min(on_seed), most.max(on_seed));
                }
            }
        }
        let furthest = self.factors.iter().copied().fold(0.0, f64::max);
        lead(score, behind) > furthest * (most - least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a method measured on each seed, where the baseline has 10.
    fn measured(values: &[f64]) -> PointObjectives {
        let baseline = vec![10.0; values.len()];
        PointObjectives { weight: 0.1, draws: 1, method: vec![values.to_vec()], baseline }
    }

    fn outcome(direction: Direction, methods: &[&[f64]]) -> Option<(f64, bool)> {
        let measured: Vec<PointObjectives> = methods.iter().map(|m| measured(m)).collect();
        let methods = measured.iter().enumerate().map(|(m, o)| (m, Some(o))).collect();
        let contest = Contest::of(methods, 7, direction);
        contest.outcome(contest.resampled(0), contest.resampled(1))
    }

    fn probability(direction: Direction, methods: &[&[f64]]) -> Option<f64> {
        outcome(direction, methods).map(|(probability, _)| probability)
    }

    #[test]
    fn a_method_that_is_best_on_every_one_of_few_seeds_is_probably_the_best() {
        let methods: [&[f64]; 3] = [&[3.0, 4.0, 5.0], &[6.0, 5.0, 9.0], &[9.0, 8.0, 7.0]];
        // Of two degrees of freedom, Student's t leaves one in twenty for a lead of three standard errors.
        let p = probability(Direction::Lower, &methods).unwrap();
        assert!(p > 0.9 && p < 1.0, "{p}");
    }

    #[test]
    fn a_third_method_takes_from_the_winner_what_it_wins() {
        let two: [&[f64]; 2] = [&[1.0, 2.0, 9.0], &[8.0, 8.0, 8.0]];
        let three: [&[f64]; 3] = [two[0], two[1], &[9.5, 9.5, 8.5]];
        let four: [&[f64]; 4] = [two[0], two[1], three[2], &[30.0, 1.5, 30.0]];
        let of = |methods: &[&[f64]]| probability(Direction::Lower, methods).unwrap();
        assert!(of(&three) <= of(&two) && of(&four) < of(&three) - 0.05);
    }

    #[test]
    fn a_method_that_is_behind_on_every_seed_can_still_be_ahead() {
        // Behind by 0.5 and by 40: of one degree of freedom, Student's t leaves open whether by anything.
        let methods: [&[f64]; 3] = [&[50.0, 50.0], &[51.0, 51.0], &[50.5, 90.0]];
        let (probability, decided) = outcome(Direction::Lower, &methods).unwrap();
        assert!(probability < 0.95 && !decided, "{probability}");
        assert_eq!(outcome(Direction::Lower, &methods[..2]), Some((1.0, true)));
    }

    #[test]
    fn one_seed_or_a_method_without_a_score_says_nothing() {
        assert_eq!(probability(Direction::Lower, &[&[3.0], &[4.0]]), None);
        let measured = [measured(&[3.0, 9.0]), measured(&[4.0, 5.0])];
        let methods = vec![(0, Some(&measured[0])), (1, Some(&measured[1])), (2, None)];
        let contest = Contest::of(methods, 7, Direction::Lower);
        assert_eq!(contest.outcome(contest.resampled(0), contest.resampled(1)), None);
    }

    #[test]
    fn a_lead_on_the_next_alone_decides_nothing() {
        // The third has the worse mean than the second, but is the best on one of the seeds.
        let (first, second): (&[f64], &[f64]) = (&[2.0, 3.0, 4.0], &[5.0, 6.0, 7.0]);
        let third: &[f64] = &[1.0, 9.0, 20.0];
        assert_eq!(outcome(Direction::Lower, &[first, second]), Some((1.0, true)));
        let (probability, decided) = outcome(Direction::Lower, &[first, second, third]).unwrap();
        assert!(probability < 0.95 && !decided, "{probability}");
    }
}
