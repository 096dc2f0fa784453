//! From the scores on a sample of point MDPs to the whole family.
//!
//! | sampling | estimator | weights | interval |
//! | --- | --- | --- | --- |
//! | with replacement (M1) | [`Estimator::WithReplacement`] | equal per draw | independent draws |
//! | without replacement (M2) | [`Estimator::WithoutReplacement`] | importance, renormalised | probabilities to be drawn |
//! | k-means (M3) | [`Estimator::Representatives`] | importance of the cluster | between neighbouring clusters |
//! | balanced | [`Estimator::Balanced`] | importance by probability | between neighbours in the sample |
//! | Bayesian quadrature | [`Estimator::BayesianQuadrature`] | least expected error under a Gaussian process | what the process leaves unknown |
//! | all | [`Estimator::Whole`] | importance | seeds and trainings only |
//!
//! A method that learned once on each point MDP has scores that another training would have changed. How much is not
//! known, so its interval takes all that neighbours differ by for the luck of training ([`Sample::learned_once`]): it is
//! that of a family without end, of which even the whole is a sample. That tends to be too wide.
//!
//! Source of M1 to M3: Jayawardana et al. (NeurIPS 2022), appendix, "Evaluate DRL methods on a family of MDPs". Of M2's
//! interval: J. Hájek, "Asymptotic theory of rejective sampling with varying probabilities from a finite population", Annals
//! of Mathematical Statistics 35 (1964). Of Bayesian quadrature: as in [`crate::sample::quadrature`]; C. Rasmussen and
//! Z. Ghahramani, "Bayesian Monte Carlo", NIPS 15 (2002).

use rand_chacha::ChaCha8Rng;

use crate::sample::quadrature::{Quadrature, Rule};
use crate::sample::{Design, SamplePlan, Sampling};
use crate::stats::quantile::{central, central_about, containing};
use crate::stats::resampling::Contrast;
use crate::stats::summary::{Statistics, only_mean};
use crate::stats::{
    Bootstrap, Direction, PointObjectives, Resampling, StatsError, bootstrap_all, degrees, means,
    stretch,
};

/// Neighbours in a local mean; with fewer, intervals of 20 to 40 skewed scores are too narrow.
const NEIGHBOURS: usize = 6;

/// Nearest representatives that one is compared with.
const NEAREST_CLUSTERS: usize = 2;

/// By how much intervals of Bayesian quadrature are wider than the process says: processes that suit known methods are too
/// sure of others.
const WIDENING: f64 = 1.5;

/// What an estimator knows of a sample beside the scores.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Number of point MDPs in the family.
    pub family_size: usize,
    /// Number of point MDPs that were chosen, with or without a score.
    pub chosen: usize,
    /// Tells methods apart, whose trainings have nothing in common.
    pub method: u64,
    /// Name of the method, or of the two that are compared, separated by a blank; empty for what no method measured.
    pub name: &'a str,
    /// Whether the method learned, once on each point MDP. Another training could have given another score, so the
    /// scores that were seen vary, too, and none of them is taken for known.
    pub learned_once: bool,
    /// How the point MDPs with a score were chosen, in the order of the scores.
    pub points: &'a [Chosen],
    /// What is known of the whole family, where that was kept.
    pub design: Option<&'a Design>,
    /// Resamples of an interval.
    pub resamples: usize,
    /// Share of such intervals that may miss what they are of, such as 0.05.
    pub alpha: f64,
}

/// How a point MDP came to be in the sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chosen {
    /// How often it was drawn, or for k-means the number of point MDPs in its cluster.
    pub count: u32,
    /// Probability to be in the sample, where it is known.
    pub inclusion: Option<f64>,
    /// Its importance.
    pub importance: f64,
    /// Its position in [`Sample::design`].
    pub row: Option<usize>,
    /// Where it lies; Euclidean distances tell which point MDPs are alike.
    pub at: Vec<f64>,
}

/// An estimate with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its interval; `None` where the spread cannot be estimated, as from one seed on a whole family.
    pub interval: Option<(f64, f64)>,
    /// Of what the resamples are, where that is another estimator's.
    pub centre: f64,
    /// Estimates from resampled data, shape `[resamples]`; empty where the spread cannot be estimated.
    pub resamples: Vec<f64>,
    /// Share of such intervals that may miss what they are of.
    pub alpha: f64,
    /// Degrees of freedom of the mean over seeds, where these alone make the spread: intervals are stretched for few of them
    /// ([`stretch`]).
    pub degrees: Option<f64>,
}

/// A way from the scores on a sample to the whole family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// M1, of independent draws by importance: the mean score over draws. Deviation: the paper prints a plain sum; a mean
    /// is meant. The interval is design-based: that of a mean of independent draws ([`Resampling::draws`]).
    WithReplacement,
    /// M2, of successive draws by importance.
    WithoutReplacement,
    /// M3, of representatives of k-means clusters.
    Representatives,
    /// That of samples by Bayesian quadrature.
    BayesianQuadrature,
    /// That of balanced samples.
    Balanced,
    /// That of a whole family.
    Whole,
}

impl Estimator {
    /// Returns its name in tables: M1 to M3, or that of the sampling.
    pub fn name(self) -> &'static str {
        match self {
            Self::WithReplacement => "M1",
            Self::WithoutReplacement => "M2",
            Self::Representatives => "M3",
            Self::BayesianQuadrature => "BQ",
            Self::Balanced => "balanced",
            Self::Whole => "all",
        }
    }

    /// Returns what must hold for its interval to be one, in a sentence or two.
    pub fn assumptions(self) -> &'static str {
        match self {
            Self::WithReplacement => "Draws are independent and by importance.",
            Self::WithoutReplacement => {
                "The estimate weighs importance twice and leans to important point MDPs; the interval is that of the \
                 same scores weighted by how likely each point MDP was drawn, widened to hold the estimate."
            }
            Self::Representatives => {
                "Representatives of clusters are no random sample. The interval takes each for a random member of its \
                 cluster, with the spread between neighbouring clusters; what all of them miss, it does not cover."
            }
            Self::BayesianQuadrature => {
                "Scores change over features and the scores of cheap methods about as fast as those of cheap methods \
                 do. Point MDPs are chosen, not drawn, so that a few extreme scores that nothing foretells are not \
                 covered."
            }
            Self::Balanced => {
                "Point MDPs that are alike have scores that are alike. A few extreme scores that a small sample may \
                 miss are not covered."
            }
            Self::Whole => "What is missing is missing at random.",
        }
    }

    /// Returns how many draws a point MDP stands for that the sample has with this count.
    pub fn draws(self, count: u32) -> u32 {
        if self == Self::WithReplacement { count } else { 1 }
    }

    /// Returns whether so many evaluated point MDPs are the family, so that their choice adds no uncertainty.
    pub fn is_whole(self, family_size: usize, evaluated: usize) -> bool {
        self != Self::WithReplacement && evaluated == family_size
    }

    /// Returns whether nothing but the noise of seeds is left unknown: the family is whole, and no training could have come
    /// out otherwise.
    pub fn is_known(self, sample: Sample<'_>, evaluated: usize) -> bool {
        self.is_whole(sample.family_size, evaluated) && !sample.learned_once
    }

    /// Returns the estimate of the overall performance `E = sum_i p_i s_i`.
    ///
    /// # Arguments
    ///
    /// Those of [`Self::estimate_all`].
    ///
    /// # Errors
    ///
    /// [`StatsError`] without point MDPs, for weights that sum to 0, and where a score is undefined.
    pub fn estimate(
        self,
        sample: Sample<'_>,
        scores: &[PointObjectives],
        rng: &mut ChaCha8Rng,
    ) -> Result<Estimate, StatsError> {
        let mut all = self.estimate_all(sample, scores, &only_mean(), rng)?;
        all.pop().flatten().ok_or(StatsError::Empty("the list of point MDPs with a weight"))
    }

    /// Returns the estimates of several statistics of the family from the same draws, in their order; `None`
    /// where one is undefined, such as the mean over a regime without a point MDP.
    ///
    /// # Arguments
    ///
    /// * `scores` — shape `[n]`; the evaluated point MDPs, each with its weight, how often it was drawn, the
    ///   objective of the method, shape `[replicates, seeds]`, and what it is divided by, shape `[seeds]`.
    ///   Weights need not sum to 1, so that an estimate without what is missing is over what is there.
    /// * `statistics` — shape `[k]`; functions of the means per point MDP. [`crate::stats::PointMeans::point`] is the
    ///   position in `scores`.
    /// * `rng` — equally seeded generators draw equal points and seeds for every method, which
    ///   [`Estimate::difference`] relies on.
    ///
    /// # Errors
    ///
    /// [`StatsError`] where a score is undefined.
    pub fn estimate_all(
        self,
        sample: Sample<'_>,
        scores: &[PointObjectives],
        statistics: &dyn Statistics,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let resampling = match self {
            Self::WithReplacement => Resampling::draws(scores),
            Self::Representatives => representatives(sample, scores),
            Self::Balanced => balanced(sample, scores),
            Self::Whole => whole(sample, scores),
            Self::WithoutReplacement => {
                return without_replacement(sample, scores, statistics, rng);
            }
            Self::BayesianQuadrature => {
                return bayesian_quadrature(sample, scores, statistics, rng);
            }
        };
        estimates(sample, scores, &resampling, statistics, rng)
    }
}

impl Estimate {
    /// Returns an estimate with the percentiles of its resamples, of which a share `alpha` may miss what they are of.
    fn of(bootstrap: Bootstrap, (alpha, degrees): (f64, Option<f64>)) -> Self {
        let Bootstrap { estimate: value, resamples } = bootstrap;
        let interval = central(&resamples, alpha);
        Self { value, interval, centre: value, resamples, alpha, degrees }
    }

    /// Returns the estimate of a mean: its resamples lie about it, and the interval is that of [`central_about`].
    fn of_mean(bootstrap: Bootstrap, (alpha, degrees): (f64, Option<f64>)) -> Self {
        let of = Self::of(bootstrap.centred(), (alpha, degrees));
        Self { interval: of.about(alpha), ..of }
    }

    /// Returns the interval about the estimate that may miss what it is of with this probability.
    pub fn about(&self, alpha: f64) -> Option<(f64, f64)> {
        let spread = (alpha, stretch(self.degrees, alpha));
        let about = central_about(self.centre, &self.resamples, spread);
        about.map(|interval| containing(interval, self.value))
    }

    /// Returns the same with intervals that are stretched for other degrees of freedom.
    #[must_use]
    pub fn with_degrees(self, degrees: Option<f64>) -> Self {
        let of = Self { degrees, ..self };
        Self { interval: of.about(of.alpha), ..of }
    }

    /// Returns by how much this is better than another, as [`Self::difference`] does; negative where it is worse.
    pub fn ahead(&self, other: &Self, direction: Direction) -> Self {
        match direction {
            Direction::Lower => self.difference(other),
            Direction::Higher => other.difference(self),
        }
    }

    /// Returns `other - self`, resample by resample, which is much narrower than the two intervals suggest:
    /// both methods met the same seeds. Only meaningful for the same point MDPs and equally seeded generators.
    pub fn difference(&self, other: &Self) -> Self {
        let bootstrap = |e: &Self| Bootstrap { estimate: e.centre, resamples: e.resamples.clone() };
        let fewest = [self.degrees, other.degrees].into_iter().flatten().min_by(f64::total_cmp);
        let spread = (self.alpha, fewest);
        let of = Self::of_mean(bootstrap(self).difference(&bootstrap(other)), spread);
        let value = other.value - self.value;
        Self { value, interval: of.interval.map(|interval| containing(interval, value)), ..of }
    }
}

impl Sample<'_> {
    /// Returns by which share the choice of a point MDP does not vary, given its probability to be in the sample; 0 where
    /// its training could have come out otherwise.
    fn fixed(&self, inclusion: f64) -> f64 {
        if self.learned_once { 0.0 } else { inclusion }
    }

    /// Returns the share of the chosen point MDPs that have a score: what is missing is taken as missing at random.
    fn answered(&self, scores: usize) -> f64 {
        if self.chosen == 0 { 1.0 } else { (scores as f64 / self.chosen as f64).min(1.0) }
    }
}

fn estimates(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    resampling: &Resampling,
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let count = (sample.method, sample.resamples);
    let all = bootstrap_all(scores, resampling, rng, count, statistics)?;
    // Of a sample, the choice of point MDPs makes most of the variance, and has its own degrees of freedom.
    let degrees = if resampling.draws_points() { None } else { degrees(scores) };
    let spread = (sample.alpha, degrees);
    let (means, others) = (Estimate::of_mean, Estimate::of);
    let estimate =
        |(i, b)| Some(if i < statistics.means() { means(b?, spread) } else { others(b?, spread) });
    Ok(all.into_iter().enumerate().map(estimate).collect())
}

/// Returns the estimator of a sample.
pub fn estimator_of(plan: &SamplePlan) -> Estimator {
    match plan.sampling {
        Sampling::WithReplacement => Estimator::WithReplacement,
        Sampling::WithoutReplacement => Estimator::WithoutReplacement,
        Sampling::KMeans => Estimator::Representatives,
        Sampling::BayesianQuadrature => Estimator::BayesianQuadrature,
        Sampling::Balanced => Estimator::Balanced,
        Sampling::All => Estimator::Whole,
    }
}

/// Returns how the choice of a balanced sample is drawn anew: Hajek's estimator, with the spread between neighbours. A sample
/// that is spread over features differs from what might have been drawn instead as its point MDPs differ from neighbours.
fn balanced(sample: Sample<'_>, scores: &[PointObjectives]) -> Resampling {
    let answered = sample.answered(scores.len());
    let probability = |c: &Chosen| sample.fixed(c.inclusion.unwrap_or(1.0) * answered);
    let inclusion: Vec<f64> = sample.points.iter().map(probability).collect();
    if inclusion.iter().all(|pi| *pi >= 1.0) {
        return Resampling::whole();
    }
    let weights: Vec<f64> = scores.iter().map(|p| p.weight).collect();
    let contrasts = local_means(sample.points, &weights, &inclusion, NEIGHBOURS);
    Resampling::of(contrasts, scores.len() as f64 - 1.0)
}

/// Returns how the choice of representatives is drawn anew.
///
/// Which point MDPs these are is no matter of chance, so no design says how far the estimate may be off. How much one differs
/// from those of the nearest clusters is about how much, or more than, the point MDPs of a cluster differ from each other: each
/// is taken for a random member of its cluster with that variance. What all miss, as where congestion begins, is not covered.
fn representatives(sample: Sample<'_>, scores: &[PointObjectives]) -> Resampling {
    if Estimator::Representatives.is_known(sample, scores.len()) {
        return Resampling::whole();
    }
    let total: f64 = scores.iter().map(|p| p.weight).sum();
    let answered = sample.answered(scores.len());
    let k = NEAREST_CLUSTERS.min(scores.len().saturating_sub(1));
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
    Resampling::of(scores.iter().enumerate().map(of).collect(), scores.len() as f64 - 1.0)
}

/// Returns how what is left unknown of a whole family is drawn anew: nothing but the noise of seeds and trainings where all
/// point MDPs have results; else those that have are taken for a random part of it.
fn whole(sample: Sample<'_>, scores: &[PointObjectives]) -> Resampling {
    let weights: Vec<f64> = scores.iter().map(|p| p.weight).collect();
    let share = scores.len() as f64 / sample.family_size.max(1) as f64;
    let inclusion = vec![sample.fixed(share); scores.len()];
    if sample.learned_once {
        let contrasts = local_means(sample.points, &weights, &inclusion, NEIGHBOURS);
        Resampling::of(contrasts, scores.len() as f64 - 1.0)
    } else {
        Resampling::distinct(&weights, &inclusion)
    }
}

/// Returns the contrasts of the local mean variance estimator: every point MDP against the mean of itself and its
/// nearest neighbours in the sample.
fn local_means(
    points: &[Chosen],
    weights: &[f64],
    inclusion: &[f64],
    neighbours: usize,
) -> Vec<Contrast> {
    let total: f64 = weights.iter().sum();
    let n = points.len();
    let k = neighbours.min(n.saturating_sub(1));
    let mut contrasts = Vec::with_capacity(n);
    for i in 0..n {
        let scale = (1.0 - inclusion[i]).max(0.0);
        if scale == 0.0 || k == 0 {
            contrasts.push(Contrast::new());
            continue;
        }
        let scale = (scale * (k + 1) as f64 / k as f64).sqrt() / total;
        let group = nearest(points, i, k);
        let share = scale / (k + 1) as f64;
        let mut contrast: Contrast = group.iter().map(|j| (*j, -share * weights[*j])).collect();
        contrast.push((i, (scale - share) * weights[i]));
        contrasts.push(contrast);
    }
    contrasts
}

/// Returns the `k` nearest others, nearest first, of equally near ones the first.
fn nearest(points: &[Chosen], i: usize, k: usize) -> Vec<usize> {
    let distance = |j: usize| -> f64 {
        points[i].at.iter().zip(&points[j].at).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let mut others: Vec<(f64, usize)> =
        (0..points.len()).filter(|j| *j != i).map(|j| (distance(j), j)).collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    others.into_iter().take(k).map(|(_, j)| j).collect()
}

/// Returns the paper's estimates, which weigh importance once more and so lean to what happens at important point MDPs, with
/// intervals that are free of that: those of the same scores weighted by importance over the probability to be drawn (Hajek's
/// estimator), widened to hold the estimate.
fn without_replacement(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let answered = sample.answered(scores.len());
    let probability = |c: &Chosen| {
        // Plans from before probabilities were kept: that of a sample in proportion to importance.
        c.inclusion.unwrap_or_else(|| (c.importance * sample.chosen as f64).min(1.0))
    };
    let inclusion: Vec<f64> = sample.points.iter().map(|c| probability(c) * answered).collect();
    let unbiased: Vec<PointObjectives> = (scores.iter().zip(sample.points).zip(&inclusion))
        .map(|((p, c), pi)| PointObjectives { weight: c.importance / pi, ..p.clone() })
        .collect();
    let weights: Vec<f64> = unbiased.iter().map(|p| p.weight).collect();
    let fixed: Vec<f64> = inclusion.iter().map(|pi| sample.fixed(*pi)).collect();
    let resampling = Resampling::distinct(&weights, &fixed);
    let mut all = estimates(sample, &unbiased, &resampling, statistics, rng)?;
    let mut own = Vec::with_capacity(all.len());
    statistics.values(&means(scores)?, &mut own);
    for (value, estimate) in own.into_iter().zip(&mut all) {
        let (Some(e), Some(value)) = (estimate.as_mut(), value) else { continue };
        e.value = value;
        e.interval = e.interval.map(|(low, high)| (low.min(value), high.max(value)));
    }
    Ok(all)
}

/// Returns the weighted means of the scores that were seen, with the weights of least expected error under the process, which
/// gives them to whatever point MDPs have a score: no score is predicted.
///
/// The interval comes from the same process. Its size is the method's own: how far its scores are from what the process says
/// of each by the others. How rough the method is beside that is weighed by the likelihood of its scores.
fn bayesian_quadrature(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    if Estimator::Whole.is_known(sample, scores.len()) {
        return Estimator::Whole.estimate_all(sample, scores, statistics, rng);
    }
    let rows: Option<Vec<usize>> = sample.points.iter().map(|c| c.row).collect();
    let design = sample.design.map(|design| design.for_methods(sample.name));
    let (Some(quadrature), Some(rows)) = (design.as_deref().and_then(Quadrature::of), rows) else {
        // Without what is known of the family, the chosen ones are taken for a random part of it.
        return Estimator::Whole.estimate_all(sample, scores, statistics, rng);
    };
    let rule = quadrature.rule(&rows, sample.learned_once);
    let weighed: Vec<PointObjectives> = (scores.iter().zip(&rule.weights))
        .map(|(p, weight)| PointObjectives { weight: *weight, ..p.clone() })
        .collect();
    let observed: Vec<f64> = means(scores)?.iter().map(|m| m.score).collect();
    let resampling = innovations(&rule, &observed);
    estimates(sample, &weighed, &resampling, statistics, rng)
}

fn innovations(rule: &Rule, scores: &[f64]) -> Resampling {
    let innovations = rule.innovations();
    let mean: f64 = rule.weights.iter().zip(scores).map(|(w, y)| w * y).sum();
    let said =
        |row: &Vec<f64>| row.iter().zip(scores).map(|(a, y)| a * (y - mean)).sum::<f64>().powi(2);
    let smooth = innovations.iter().map(said).sum::<f64>().sqrt();
    let widen = WIDENING * if smooth > 0.0 { rule.standard_error(scores) / smooth } else { 1.0 };
    let contrast = |row: Vec<f64>| row.into_iter().map(|a| widen * a).enumerate().collect();
    Resampling::of(innovations.into_iter().map(contrast).collect(), scores.len() as f64 - 1.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::stats::improvement;

    fn points(at: &[f64]) -> Vec<Chosen> {
        at.iter().map(|x| Chosen { at: vec![*x], ..Chosen::default() }).collect()
    }

    fn standard_error(at: &[f64], values: &[f64], pi: f64, k: usize) -> f64 {
        let weights = vec![1.0; at.len()];
        let contrasts = local_means(&points(at), &weights, &vec![pi; at.len()], k);
        Resampling::of(contrasts, at.len() as f64 - 1.0).standard_error(&weights, values)
    }

    #[test]
    fn with_all_neighbours_it_is_that_of_independent_draws() {
        let values = [1.0, 2.0, 4.0, 9.0];
        let se = standard_error(&[0.0, 1.0, 2.0, 3.0], &values, 0.2, 3);
        let variance = values.iter().map(|y| (y - 4.0f64).powi(2)).sum::<f64>() / 3.0;
        assert!((se - (0.8 * variance / 4.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_follows_the_coordinates_adds_little() {
        let at: Vec<f64> = (0..20).map(f64::from).collect();
        let rough: Vec<f64> = (0..20).map(|i| f64::from(i * 7 % 20)).collect();
        assert!(4.0 * standard_error(&at, &at, 0.2, 2) < standard_error(&at, &rough, 0.2, 2));
    }

    #[test]
    fn a_sample_of_everything_has_empty_contrasts() {
        let of = |at: &[f64], pi: f64| {
            local_means(&points(at), &vec![1.0; at.len()], &vec![pi; at.len()], 4)
        };
        assert_eq!(of(&[0.0, 1.0], 1.0), vec![Contrast::new(); 2]);
        assert_eq!(of(&[0.0], 0.3), vec![Contrast::new()]);
    }

    const FAMILY: usize = 60;

    /// Scores that follow a feature, each with the luck of one training: one in ten goes wrong.
    fn trained(rng: &mut ChaCha8Rng) -> Vec<PointObjectives> {
        let of = |i: usize| {
            let luck = if rng.random::<f64>() < 0.1 { 1.0 } else { 0.0 };
            let score = 0.5 + i as f64 / FAMILY as f64 + luck;
            let method = vec![vec![10.0 * score, 10.1 * score]];
            PointObjectives { weight: 1.0, draws: 1, method, baseline: vec![10.0, 10.1] }
        };
        (0..FAMILY).map(of).collect()
    }

    /// Returns the estimate of a whole family, whose intervals may miss with this probability.
    fn estimated(objectives: &[PointObjectives], alpha: f64, learned_once: bool) -> Estimate {
        let at: Vec<f64> = (0..FAMILY).map(|i| i as f64).collect();
        let sample = Sample {
            family_size: FAMILY,
            chosen: FAMILY,
            method: 0,
            name: "m",
            learned_once,
            points: &points(&at),
            design: None,
            resamples: 400,
            alpha,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        Estimator::Whole.estimate(sample, objectives, &mut rng).unwrap()
    }

    /// Of 100 intervals, how many hold the mean over all trainings that there could be.
    fn held(learned_once: bool) -> usize {
        let truth = 0.5 + (FAMILY as f64 - 1.0) / 2.0 / FAMILY as f64 + 0.1;
        let mut luck = ChaCha8Rng::seed_from_u64(5);
        let holds = |_: &u64| {
            let e = estimated(&trained(&mut luck), 0.05, learned_once);
            e.interval.is_some_and(|(low, high)| low <= truth && truth <= high)
        };
        (0..100u64).filter(holds).count()
    }

    #[test]
    fn the_interval_of_a_whole_family_holds_what_other_trainings_would_give() {
        let (without, with) = (held(false), held(true));
        assert!(without < 30 && (90..=100).contains(&with), "{without} and {with} of 100");
    }

    #[test]
    fn without_replicates_the_difference_of_means_is_the_mean_of_differences() {
        let mut luck = ChaCha8Rng::seed_from_u64(9);
        let mut measured = |level: f64| -> Vec<PointObjectives> {
            let noisy = |luck: &mut ChaCha8Rng, of: f64| of * (0.8 + 0.4 * luck.random::<f64>());
            let on = |i: usize| PointObjectives {
                weight: 1.0 + (i % 7) as f64,
                draws: 1,
                method: vec![(0..5).map(|_| noisy(&mut luck, level + i as f64)).collect()],
                baseline: (0..5).map(|seed| 60.0 + (i * seed) as f64).collect(),
            };
            (0..FAMILY).map(on).collect()
        };
        let (x, y) = (measured(20.0), measured(24.0));
        let differences: Vec<PointObjectives> = (x.iter().zip(&y))
            .map(|(x, y)| PointObjectives {
                method: improvement::differences(&y.method, &x.method),
                ..x.clone()
            })
            .collect();
        let direct = estimated(&differences, 0.05, false);
        let apart = estimated(&x, 0.05, false).ahead(&estimated(&y, 0.05, false), Direction::Lower);
        let apart = apart.with_degrees(degrees(&differences));
        let ends = |e: &Estimate| {
            let (low, high) = e.interval.unwrap();
            [low, e.value, high]
        };
        assert!(ends(&direct)[0] < ends(&direct)[2]);
        for (a, b) in ends(&direct).into_iter().zip(ends(&apart)) {
            assert!((a - b).abs() < 1e-12, "{direct:?} {apart:?}");
        }
    }
}
