//! The mix: on every point MDP the method that is best on some evaluation seeds, scored on the other seeds.
//!
//! Of `n` seeds half, rounded down, choose, and every other one scores; the mix is the mean over all ways to choose them.
//! So nothing is scored on a seed that it was chosen with, and a method that is good by chance gains nothing. More than
//! [`MOST`] seeds are joined to as many groups, whose means stand for seeds.
//!
//! The interval: seed `k` gets the pseudo-value `n t - (n - 1) t_k` of the jackknife, with `t` the mix and `t_k` the mix
//! without that seed, chosen anew. Their mean is `t`, and their spread holds both the choice and the scoring; it is too
//! large rather than too small. They are resampled as the seeds of any method are, and so are the point MDPs of a sample.
//!
//! Source: B. Efron and C. Stein, "The jackknife estimate of variance", Annals of Statistics 9 (1981); W. Hoeffding, "A
//! class of statistics with asymptotically normal distribution", Annals of Mathematical Statistics 19 (1948).

use super::choice::{choice, weights};
use super::estimator::{Estimate, Sample};
use super::method::{MethodSummary, paired};
use super::points::{Evidence, PointSummary};
use super::reference::{AnalysisError, position};
use super::summaries::{Estimated, bounds};
use super::whole::Analysis;
use crate::stats::score::{mean, weighted_mean};
use crate::stats::{Direction, PointObjectives, improvement};

/// Fewest evaluation seeds: one chooses, and of two that score one can be left out.
const FEWEST: usize = 3;

/// Most seeds of which all ways to divide them are taken.
const MOST: usize = 10;

/// The best choice among several methods per point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Mix {
    /// Positions in [`Analysis::methods`] of those that it may take.
    pub methods: Vec<usize>,
    /// Its score.
    pub score: Estimated,
    /// By how much it is ahead of the best of them.
    pub ahead: Estimated,
    /// Its weighted mean objective.
    pub objective: f64,
    /// Share of the weight for which each method was chosen, in the order of [`Self::methods`].
    pub shares: Vec<f64>,
    /// The best two of them, and the best three, as positions in [`Analysis::methods`], with their score.
    pub smaller: Vec<(Vec<usize>, f64)>,
    /// The point MDPs.
    pub points: Vec<MixPoint>,
    /// Seeds that choose, and all.
    pub seeds: (usize, usize),
}

/// What the mix is on a point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct MixPoint {
    /// Position in [`Analysis::points`].
    pub index: usize,
    /// Position in [`Analysis::methods`] of the method that is best on all seeds.
    pub method: usize,
    /// Share of the ways to choose seeds in which that method was chosen.
    pub share: f64,
    /// Score of the mix.
    pub score: f64,
}

/// What was measured on a point MDP, replicates averaged.
struct Measured {
    /// Shape `[methods, seeds]`.
    objectives: Vec<Vec<f64>>,
    /// Shape `[seeds]`.
    baseline: Vec<f64>,
    /// Its mean.
    unit: f64,
    /// How often the point MDP was drawn.
    draws: u32,
}

impl Analysis {
    /// Returns the mix; `None` with fewer than two methods or three evaluation seeds.
    ///
    /// # Arguments
    ///
    /// * `named` — the methods that it may take; `None` for all that are ranked.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for a name that the run has not.
    pub fn mix(&self, named: Option<&[String]>) -> Result<Option<Mix>, AnalysisError> {
        let names = || self.methods.iter().map(|m| m.method.as_str());
        named.into_iter().flatten().try_for_each(|n| position("method", n, names()).map(drop))?;
        let is_named = |m: &MethodSummary| named.is_none_or(|named| named.contains(&m.method));
        let methods: Vec<usize> = (0..self.methods.len())
            .filter(|m| self.methods[*m].rank.is_some() && is_named(&self.methods[*m]))
            .collect();
        let indices: Vec<usize> = methods.iter().map(|m| self.methods[*m].index).collect();
        let measured = |p: &PointSummary| Measured::of(p, &indices);
        let (points, measured): (Vec<&PointSummary>, Vec<Measured>) =
            self.points.iter().filter_map(|p| Some((p, measured(p)?))).unzip();
        let few = measured.iter().map(|m| m.baseline.len()).min().unwrap_or(0) < FEWEST;
        if methods.len() < 2 || few {
            return Ok(None);
        }
        Ok(self.mixed(methods, &points, &measured))
    }

    fn mixed(
        &self,
        methods: Vec<usize>,
        points: &[&PointSummary],
        measured: &[Measured],
    ) -> Option<Mix> {
        let identity = &self.manifest.identity;
        let direction = identity.direction;
        let weights = weights(identity, points);
        let all: Vec<usize> = (0..methods.len()).collect();
        let mixed: Vec<(f64, Vec<f64>)> =
            measured.iter().map(|m| m.mix(&all, m.every(), direction)).collect();
        let value = |of: &dyn Fn(usize) -> f64| {
            weighted_mean(weights.iter().enumerate().map(|(i, w)| (*w, of(i))))
        };
        let score_of = |members: &[usize]| {
            value(&|i| {
                let of = &measured[i];
                of.mix(members, of.every(), direction).0 / of.unit
            })
        };
        let smaller = [2, 3].into_iter().filter(|size| *size < methods.len()).filter_map(|size| {
            let larger = |set: Vec<usize>| {
                let next = set.last().map_or(0, |last| last + 1);
                (next..methods.len()).map(move |m| [&set[..], &[m]].concat())
            };
            let sets = (0..size)
                .fold(vec![Vec::new()], |sets, _| sets.into_iter().flat_map(larger).collect());
            let scored = sets.into_iter().filter_map(|set| Some((score_of(&set)?, set)));
            let (score, set) = scored.min_by(|a, b| direction.compare(a.0, b.0))?;
            Some((set.into_iter().map(|m| methods[m]).collect(), score))
        });
        let smaller = smaller.collect();
        let pseudo: Vec<Vec<f64>> = measured.iter().map(|m| m.pseudo_values(direction)).collect();
        let estimate = |of: &dyn Fn(usize) -> Vec<f64>| {
            let objectives: Vec<PointObjectives> = (0..points.len())
                .map(|i| PointObjectives {
                    weight: weights[i],
                    draws: measured[i].draws,
                    method: vec![of(i)],
                    baseline: measured[i].baseline.clone(),
                })
                .collect();
            self.estimated(&methods, points, &objectives)
        };
        let own = estimate(&|i| pseudo[i].clone())?;
        let ahead = estimate(&|i| {
            let best = [measured[i].objectives[0].clone()];
            improvement::ahead(&[pseudo[i].clone()], &best, direction).remove(0)
        })?;
        let values = measured.iter().flat_map(|m| m.objectives.iter().flatten().copied());
        let bounds = bounds(self.most, values);
        let mix_point = |(i, p): (usize, &&PointSummary)| {
            let of = &measured[i];
            let best = of.best(&all, of.every(), direction);
            let (method, share) = (methods[best], mixed[i].1[best]);
            MixPoint { index: p.index, method, share, score: mixed[i].0 / of.unit }
        };
        let seeds = measured.first()?.baseline.len();
        Some(Mix {
            score: Estimated { value: own.value, interval: own.interval }.cut(bounds),
            ahead: Estimated { value: ahead.value, interval: ahead.interval },
            objective: value(&|i| mixed[i].0)?,
            shares: all.iter().filter_map(|m| value(&|i| mixed[i].1[*m])).collect(),
            smaller,
            points: points.iter().enumerate().map(mix_point).collect(),
            seeds: (seeds / 2, seeds),
            methods,
        })
    }

    fn estimated(
        &self,
        methods: &[usize],
        points: &[&PointSummary],
        objectives: &[PointObjectives],
    ) -> Option<Estimate> {
        let identity = &self.manifest.identity;
        let chosen = choice(identity, self.design.as_ref(), &self.points);
        let once = |m: &MethodSummary| {
            self.learned.contains(&m.method) && identity.replicates_of(&m.method) == 1
        };
        let learned_once = methods.iter().any(|m| once(&self.methods[*m]));
        let evidence = Evidence {
            identity,
            reference: &self.reference,
            measures: &(),
            most: self.most,
            points: &self.points,
            chosen: &chosen,
            tasks: &self.tasks,
            episodes: &[],
            learned_once: &vec![learned_once; identity.methods.len()],
            design: self.design.as_ref(),
        };
        let index = self.methods[methods[0]].index;
        paired(evidence, index, points, |estimator, sample, rng| {
            estimator.estimate(Sample { name: "", ..sample }, objectives, rng).ok()
        })
    }
}

impl Measured {
    /// Returns what methods measured; `None` where one lacks a score, or has other seeds than the others.
    fn of(point: &PointSummary, indices: &[usize]) -> Option<Self> {
        let of = |index: &usize| point.results[*index].as_ref()?.objectives.as_ref();
        let all: Vec<&PointObjectives> = indices.iter().map(of).collect::<Option<_>>()?;
        let baseline = &all.first()?.baseline;
        if all.iter().any(|o| o.baseline != *baseline) {
            return None;
        }
        let averaged = |o: &&PointObjectives| {
            let of_seed =
                |s: usize| o.method.iter().map(|r| r[s]).sum::<f64>() / o.method.len() as f64;
            grouped(&(0..baseline.len()).map(of_seed).collect::<Vec<_>>())
        };
        let objectives = all.iter().map(averaged).collect();
        let baseline = grouped(baseline);
        Some(Self { objectives, unit: mean(&baseline)?, baseline, draws: all[0].draws })
    }

    fn every(&self) -> usize {
        (1 << self.baseline.len()) - 1
    }

    fn best(&self, members: &[usize], seeds: usize, direction: Direction) -> usize {
        let sum = |m: usize| -> f64 {
            let values = self.objectives[m].iter().enumerate();
            values.filter(|(s, _)| seeds >> s & 1 == 1).map(|(_, v)| v).sum()
        };
        let sums = members.iter().map(|m| (sum(*m), *m));
        sums.min_by(|a, b| direction.compare(a.0, b.0)).map_or(0, |best| best.1)
    }

    /// Returns the mean objective of the best of some methods on seeds that did not choose it, with the share of the ways
    /// in which every method was chosen.
    fn mix(&self, members: &[usize], seeds: usize, direction: Direction) -> (f64, Vec<f64>) {
        let chosen_on = self.baseline.len() as u32 / 2;
        let mut shares = vec![0.0; self.objectives.len()];
        let (mut sum, mut ways) = (0.0, 0.0);
        let choose = |set: &usize| set & !seeds == 0 && set.count_ones() == chosen_on;
        for choosing in (0..=self.every()).filter(choose) {
            let best = self.best(members, choosing, direction);
            let scoring = seeds & !choosing;
            let values = self.objectives[best].iter().enumerate();
            let held = values.filter(|(s, _)| scoring >> s & 1 == 1).map(|(_, v)| v);
            sum += held.sum::<f64>() / f64::from(scoring.count_ones());
            shares[best] += 1.0;
            ways += 1.0;
        }
        shares.iter_mut().for_each(|share| *share /= ways);
        (sum / ways, shares)
    }

    fn pseudo_values(&self, direction: Direction) -> Vec<f64> {
        let all: Vec<usize> = (0..self.objectives.len()).collect();
        let n = self.baseline.len() as f64;
        let whole = self.mix(&all, self.every(), direction).0;
        let without = |s: usize| self.mix(&all, self.every() & !(1 << s), direction).0;
        (0..self.baseline.len()).map(|s| n * whole - (n - 1.0) * without(s)).collect()
    }
}

/// Returns values whose mean is what the best of some methods gives on seeds that did not choose it, and whose spread is its
/// error: one per evaluation seed, or group of seeds; `None` with fewer than three seeds.
///
/// # Arguments
///
/// * `objectives` — shape `[methods, seeds]`.
pub fn of_best(objectives: &[Vec<f64>], direction: Direction) -> Option<Vec<f64>> {
    let objectives: Vec<Vec<f64>> = objectives.iter().map(|of| grouped(of)).collect();
    let baseline = objectives.first().filter(|of| of.len() >= FEWEST)?.clone();
    Some(Measured { objectives, baseline, unit: 1.0, draws: 1 }.pseudo_values(direction))
}

fn grouped(values: &[f64]) -> Vec<f64> {
    let groups = values.len().min(MOST);
    let of_group = |g: usize| values.iter().skip(g).step_by(groups).copied().collect::<Vec<f64>>();
    (0..groups).filter_map(|g| mean(&of_group(g))).collect()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::estimator::Estimator;
    use super::*;
    use crate::stats::quantile::ALPHA;

    const LOWER: Direction = Direction::Lower;

    fn measured(objectives: Vec<Vec<f64>>) -> Measured {
        Measured { baseline: vec![20.0; objectives[0].len()], unit: 20.0, objectives, draws: 1 }
    }

    #[test]
    fn a_method_that_is_good_on_one_seed_only_is_chosen_by_chance_and_gains_nothing() {
        // As good as the first on average. Two of five seeds choose, so the good one is among these in four of ten ways.
        let lucky = measured(vec![vec![10.0; 5], vec![12.0, 12.0, 2.0, 12.0, 12.0]]);
        let (objective, shares) = lucky.mix(&[0, 1], lucky.every(), LOWER);
        assert!((shares[1] - 0.4).abs() < 1e-12 && (objective - 10.8).abs() < 1e-12, "{objective}");
        // One that is always better is always taken, and of pseudo-values the mean is the mix.
        let better = measured(vec![vec![10.0, 11.0, 12.0], vec![9.0, 8.0, 7.0]]);
        assert_eq!(better.mix(&[0, 1], better.every(), LOWER), (8.0, vec![0.0, 1.0]));
        let pseudo = of_best(&lucky.objectives, LOWER).unwrap();
        assert!((mean(&pseudo).unwrap() - objective).abs() < 1e-9, "{pseudo:?}");
        assert_eq!(grouped(&(0..20).map(f64::from).collect::<Vec<_>>())[3], 8.0);
    }

    #[test]
    fn the_interval_holds_what_the_mix_gives_on_average_over_other_seeds() {
        // Three methods that are nearly alike, of which noise decides who is chosen.
        let draw = |rng: &mut ChaCha8Rng| -> Vec<Measured> {
            let of = |i: usize, rng: &mut ChaCha8Rng| {
                let level = |m: usize| 8.0 + ((i * 7 + m * 3) % 5) as f64 / 2.0;
                let mut seeds =
                    |m: usize| (0..5).map(|_| level(m) + 4.0 * rng.random::<f64>()).collect();
                measured((0..3).map(&mut seeds).collect())
            };
            (0..40).map(|i| of(i, rng)).collect()
        };
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let value = |points: &[Measured]| {
            let all = points.iter().map(|m| m.mix(&[0, 1, 2], m.every(), LOWER).0 / 20.0);
            mean(&all.collect::<Vec<_>>()).unwrap()
        };
        let truth: Vec<f64> = (0..400).map(|_| value(&draw(&mut rng))).collect();
        let truth = mean(&truth).unwrap();
        let holds = |_: &i32| {
            let objectives: Vec<PointObjectives> = draw(&mut rng)
                .into_iter()
                .map(|m| PointObjectives {
                    weight: 1.0,
                    draws: 1,
                    method: vec![m.pseudo_values(LOWER)],
                    baseline: m.baseline,
                })
                .collect();
            let sample = Sample {
                family_size: 40,
                chosen: 40,
                method: 0,
                name: "",
                learned_once: false,
                points: &[],
                design: None,
                resamples: 300,
                alpha: ALPHA,
            };
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let e = Estimator::Whole.estimate(sample, &objectives, &mut rng).unwrap();
            e.interval.is_some_and(|(low, high)| low <= truth && truth <= high)
        };
        let held = (0..100).filter(holds).count();
        assert!((92..=100).contains(&held), "{held} of 100");
    }
}
