//! What an estimator is given, what it gives, and what estimators have in common: statistics of weighted point MDPs,
//! resampled as a design says.

use rand_chacha::ChaCha8Rng;

use super::{balanced, bayesian_quadrature, representatives, whole_family, without_replacement};
use crate::sample::Design;
use crate::stats::quantile::{central, central_about, containing};
use crate::stats::summary::{MeanOfScores, Statistics};
use crate::stats::{
    Bootstrap, Direction, PointObjectives, Resampling, StatsError, bootstrap_all, degrees, stretch,
};

/// What an estimator knows of a sample beside the scores.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// Number of point MDPs in the family.
    pub family_size: usize,
    /// Number of point MDPs that were chosen, with or without a score.
    pub chosen: usize,
    /// Tells methods apart, whose trainings have nothing in common.
    pub method: u64,
    /// Name of the method.
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
        let mut all = self.estimate_all(sample, scores, &MeanOfScores, rng)?;
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
            Self::Representatives => representatives::resampling(sample, scores),
            Self::Balanced => balanced::resampling(sample, scores),
            Self::Whole => whole_family::resampling(sample, scores),
            Self::WithoutReplacement => {
                return without_replacement::estimate_all(sample, scores, statistics, rng);
            }
            Self::BayesianQuadrature => {
                return bayesian_quadrature::estimate_all(sample, scores, statistics, rng);
            }
        };
        estimates(sample, scores, &resampling, statistics, rng)
    }
}

impl Estimate {
    /// Returns an estimate with the percentiles of its resamples, of which a share `alpha` may miss what they are of.
    pub fn of(bootstrap: Bootstrap, (alpha, degrees): (f64, Option<f64>)) -> Self {
        let Bootstrap { estimate: value, resamples } = bootstrap;
        let interval = central(&resamples, alpha);
        Self { value, interval, centre: value, resamples, alpha, degrees }
    }

    /// Returns the estimate of a mean: its resamples lie about it, and the interval is that of [`central_about`].
    pub fn of_mean(bootstrap: Bootstrap, (alpha, degrees): (f64, Option<f64>)) -> Self {
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
    pub(super) fn fixed(&self, inclusion: f64) -> f64 {
        if self.learned_once { 0.0 } else { inclusion }
    }

    /// Returns the share of the chosen point MDPs that have a score: what is missing is taken as missing at random.
    pub(super) fn answered(&self, scores: usize) -> f64 {
        if self.chosen == 0 { 1.0 } else { (scores as f64 / self.chosen as f64).min(1.0) }
    }
}

/// Returns the statistics with their intervals.
pub(super) fn estimates(
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
