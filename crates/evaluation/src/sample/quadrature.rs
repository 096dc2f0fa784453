//! Bayesian quadrature: the point MDPs that say most of the family's score, and the weights that follow.
//!
//! [`Process`] says how alike scores are. From it follows what is left unknown of the overall performance when some
//! point MDPs are evaluated, before any is. The first `FIRST` are drawn at random, spread over what is known; then the
//! one that leaves least unknown is added, one after the other. So there is one order: every budget has the first of it.
//!
//! The family is finite. What is evaluated is known, so that it keeps its own score, and what is not has its nugget,
//! which counts for what is left unknown. With every point MDP evaluated the weights are the importance, and nothing is
//! unknown. The mean of scores is unknown and flat (universal kriging), so that weights sum to 1.
//!
//! Source: A. O'Hagan, "Bayes-Hermite quadrature", Journal of Statistical Planning and Inference 29 (1991); N. Cressie,
//! "Statistics for Spatial Data", 1993, section 3.4 (universal kriging).
//! Deviation: a weight below 0 is 0, and the others are those without that point MDP, so that shares and medians exist and
//! no estimate lies outside the scores.
//!
//! A Gaussian process that says how alike the scores of a method are on two point MDPs, before it is evaluated.
//!
//! `cov(i, j) = s_i s_j (exp(-sum_c (x_ic - x_jc)^2 / (2 l_c^2)) + nugget [i = j])`, up to a factor that is the method's
//! own. Columns are what describes a point MDP, the baseline's objective and the scores of cheap methods, in logarithms
//! where all are above 0, standardised.
//!
//! Source: C. Rasmussen and C. Williams, "Gaussian Processes for Machine Learning", 2006, chapter 4.
//!
//! The process that suits a design.
//!
//! Choices:
//! - **Length scales and nugget** suit the complete scores of the cheap methods ([`length_scales`]), each explained without
//!   its own column, on at most [`MOST_FITTED`] point MDPs. Columns of cheap scores share a length scale. Without cheap
//!   methods they are those of the prior.
//! - **Spread** `s_i` is one half and one half of what the cheap methods differ by around point MDP `i`, in proportion to the
//!   mean over the family: where control matters, methods differ. Without two cheap methods it is 1.
//! - Numbers that are kept are rounded, so that the choice of point MDPs does not hang on their last digits.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::balanced::{inclusion, pivotal};
use super::design::{Design, DesignPoint, Measure, Process};
use super::kmeans::{squared_distance, standardise};
use super::plan::Sampling;
use crate::model::{Curve, length_scales};
use basics::seed::derive;

/// Point MDPs that are drawn at random before any is chosen.
const FIRST: usize = 5;

/// Variance of the unknown mean of scores, in units of the process: so large that it says nothing.
const MEAN_VARIANCE: f64 = 100.0;

/// Multiples of the nugget that are thought possible for a method that was not seen before, each as likely: what learns
/// can be rougher than the cheap methods that the nugget suits.
const ROUGHNESS: [f64; 4] = [1.0, 4.0, 16.0, 100.0];

/// A design with its process.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature<'a> {
    process: &'a Process,
    places: Vec<Vec<f64>>,
    importance: Vec<f64>,
}

/// What evaluating some point MDPs says.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Weights of their scores, none below 0; they sum to 1.
    pub weights: Vec<f64>,
    covariance: DMatrix<f64>,
    nugget: Vec<f64>,
    with_family: DVector<f64>,
    importance: Vec<f64>,
    variance: f64,
    unexplained: f64,
    learned_once: bool,
}

impl<'a> Quadrature<'a> {
    /// Takes a design; `None` where it has no process, or one that is not its own.
    pub fn of(design: &'a Design) -> Option<Self> {
        let size = design.points.len();
        let width = design.points.first().map_or(0, |p| p.describing.len() + p.inputs.len());
        let process = design.process.as_ref().filter(|process| process.fits(size, width))?;
        let total: f64 = design.points.iter().map(|p| p.importance).sum();
        let importance = design.points.iter().map(|p| p.importance / total).collect();
        Some(Self {
            process,
            places: places(&standardised(design), &process.length_scales),
            importance,
        })
    }

    /// Returns the first point MDPs of the order, as positions in the design.
    ///
    /// # Arguments
    ///
    /// * `budget` — how many; at most the size of the family.
    /// * `seed` — of those that are drawn at random.
    pub fn order(&self, design: &Design, budget: usize, seed: u64) -> Vec<usize> {
        let size = self.importance.len();
        let budget = budget.min(size);
        let probabilities = inclusion(&self.importance, FIRST.min(size));
        let mut first = pivotal(&probabilities, &design.coordinates(), seed);
        let mut rng = ChaCha8Rng::seed_from_u64(derive(seed, &["sample", "bayesian-quadrature"]));
        first.shuffle(&mut rng);
        let own = |i: usize| self.process.spread[i].powi(2) + self.process.unexplained(i);
        let mut variances: Vec<f64> = (0..size).map(|i| own(i) + MEAN_VARIANCE).collect();
        let mut with_family: Vec<f64> =
            (0..size).map(|i| self.with_family(i) + MEAN_VARIANCE).collect();
        let mut is_chosen = vec![false; size];
        let mut order = Vec::with_capacity(budget);
        // Columns of the pivoted Cholesky factor of the covariance of all scores.
        let mut factor: Vec<Vec<f64>> = Vec::with_capacity(budget);
        while order.len() < budget {
            let gain = |i: &usize| with_family[*i].powi(2) / variances[*i];
            let open = (0..size).filter(|i| !is_chosen[*i]);
            let best = || open.rev().max_by(|a, b| gain(a).total_cmp(&gain(b)));
            let Some(next) = first.get(order.len()).copied().or_else(best) else { break };
            let root = variances[next].sqrt();
            let mut column: Vec<f64> = (0..size).map(|i| self.covariance(i, next)).collect();
            for before in &factor {
                let by = before[next];
                column.iter_mut().zip(before).for_each(|(c, b)| *c -= b * by);
            }
            column.iter_mut().for_each(|c| *c /= root);
            let said = with_family[next] / root;
            for (i, c) in column.iter().enumerate() {
                with_family[i] -= said * c;
                // What is left is never less than what no other point MDP explains.
                variances[i] = (variances[i] - c * c).max(self.process.unexplained(i));
            }
            is_chosen[next] = true;
            order.push(next);
            factor.push(column);
        }
        order
    }

    /// Returns the rule of some point MDPs.
    ///
    /// # Arguments
    ///
    /// * `rows` — their positions in the design, each once.
    /// * `learned_once` — whether another training could have given another score, so that what no other point MDP
    ///   explains of a score that was seen is not known either.
    pub fn rule(&self, rows: &[usize], learned_once: bool) -> Rule {
        let n = rows.len();
        let smooth = |i: usize, j: usize| self.process.smooth(&self.places, rows[i], rows[j]);
        let covariance = DMatrix::from_fn(n, n, smooth);
        let nugget: Vec<f64> = rows.iter().map(|i| self.process.unexplained(*i)).collect();
        let importance: Vec<f64> = rows.iter().map(|i| self.importance[*i]).collect();
        let with_family = rows.iter().map(|i| self.process.covariance[*i]);
        let squares = self.importance.iter().enumerate();
        let unexplained = squares.map(|(i, p)| p * p * self.process.unexplained(i)).sum();
        let mut rule = Rule {
            weights: vec![0.0; n],
            with_family: DVector::from_iterator(n, with_family),
            variance: self.process.variance,
            covariance,
            nugget,
            importance,
            unexplained,
            learned_once,
        };
        rule.weights = rule.best_weights();
        rule
    }

    /// Returns the covariance of two scores, with that of the unknown mean.
    fn covariance(&self, i: usize, j: usize) -> f64 {
        let nugget = if i == j { self.process.unexplained(i) } else { 0.0 };
        self.process.smooth(&self.places, i, j) + nugget + MEAN_VARIANCE
    }

    /// Returns the covariance of a score with the overall performance, without that of the unknown mean.
    fn with_family(&self, i: usize) -> f64 {
        self.process.covariance[i] + self.process.unexplained(i) * self.importance[i]
    }
}

impl Rule {
    /// Returns the weights with the least expected error among those that are not below 0, nearly: a point MDP with the lowest
    /// weight below 0 goes, one after the other.
    fn best_weights(&self) -> Vec<f64> {
        let mut kept: Vec<usize> = (0..self.nugget.len()).collect();
        loop {
            let all = self.kriged(&kept);
            let lowest = (0..kept.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]));
            match lowest.filter(|i| all[*i] < 0.0) {
                Some(lowest) => drop(kept.remove(lowest)),
                None => {
                    let mut weights = vec![0.0; self.nugget.len()];
                    let total: f64 = all.iter().sum();
                    kept.iter().zip(&all).for_each(|(i, w)| weights[*i] = w / total);
                    return weights;
                }
            }
        }
    }

    /// Returns the weights of universal kriging with some of the point MDPs.
    fn kriged(&self, kept: &[usize]) -> Vec<f64> {
        let n = kept.len();
        let entry = |a: usize, b: usize| self.covariance[(kept[a], kept[b])];
        let mut matrix = DMatrix::from_fn(n, n, entry);
        (0..n).for_each(|a| matrix[(a, a)] += self.nugget[kept[a]]);
        let with_family =
            kept.iter().map(|i| self.with_family[*i] + self.nugget[*i] * self.importance[*i]);
        let Some(cholesky) = matrix.cholesky() else { return vec![1.0 / n as f64; n] };
        let simple = cholesky.solve(&DVector::from_iterator(n, with_family));
        let ones = cholesky.solve(&DVector::from_element(n, 1.0));
        let lacks = (1.0 - simple.sum()) / ones.sum();
        (0..n).map(|a| simple[a] + lacks * ones[a]).collect()
    }

    /// Returns the standard error of the estimate for a method with these scores: how far they are from what the process
    /// says of each other, times how much of the family that leaves unknown, averaged over how rough the method can be.
    pub fn standard_error(&self, scores: &[f64]) -> f64 {
        let fits: Vec<(f64, f64)> =
            ROUGHNESS.iter().filter_map(|times| self.with_nugget(*times, scores)).collect();
        let most = fits.iter().map(|f| f.0).fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut total) = (0.0, 0.0);
        for (likelihood, squared) in fits {
            let weight = libm::exp(likelihood - most);
            sum += weight * squared;
            total += weight;
        }
        if total > 0.0 { (sum / total).sqrt() } else { 0.0 }
    }

    /// Returns the logarithm of the restricted likelihood of scores and the expected squared error with a multiple of the
    /// nugget; `None` where scores do not differ.
    fn with_nugget(&self, times: f64, scores: &[f64]) -> Option<(f64, f64)> {
        let n = scores.len();
        let cholesky = self.factorised(times)?;
        let scores = DVector::from_column_slice(scores);
        let ones = cholesky.solve(&DVector::from_element(n, 1.0));
        let mean = ones.dot(&scores) / ones.sum();
        let off = scores.add_scalar(-mean);
        let amplitude = off.dot(&cholesky.solve(&off)) / (n as f64 - 1.0);
        if !(amplitude > 0.0 && amplitude.is_finite()) {
            return None;
        }
        let half: f64 = cholesky.l_dirty().diagonal().iter().map(|d| libm::log(*d)).sum();
        let likelihood =
            -half - 0.5 * libm::log(ones.sum()) - 0.5 * (n as f64 - 1.0) * libm::log(amplitude);
        Some((likelihood, amplitude * self.squared_error(times)))
    }

    /// Returns the expected squared error of the weights, up to the method's factor.
    fn squared_error(&self, times: f64) -> f64 {
        let weights = DVector::from_column_slice(&self.weights);
        let smooth = weights.dot(&(&self.covariance * &weights));
        let mut error = smooth - 2.0 * weights.dot(&self.with_family) + self.variance;
        let mut unexplained = self.unexplained;
        for ((w, p), nugget) in self.weights.iter().zip(&self.importance).zip(&self.nugget) {
            // Of what is evaluated, only what weighs more or less than its importance is wrong; of one of many trainings,
            // all that it weighs.
            let wrong = if self.learned_once { *w } else { w - p };
            unexplained += nugget * (wrong.powi(2) - p * p);
        }
        error += times * unexplained.max(0.0);
        error.max(0.0)
    }

    fn factorised(&self, times: f64) -> Option<Cholesky<f64, Dyn>> {
        let mut matrix = self.covariance.clone();
        (0..matrix.nrows()).for_each(|i| matrix[(i, i)] += times * self.nugget[i]);
        matrix.cholesky()
    }

    /// Returns contrasts of scores, a row each, whose squares sum to the squared standard error of a method that is as rough as
    /// the nugget says: what each score differs by from what those before it say.
    pub fn innovations(&self) -> Vec<Vec<f64>> {
        let n = self.nugget.len();
        let mut matrix = self.covariance.add_scalar(MEAN_VARIANCE);
        (0..n).for_each(|i| matrix[(i, i)] += self.nugget[i]);
        let Some(cholesky) = matrix.cholesky() else { return Vec::new() };
        let mut inverse = DMatrix::identity(n, n);
        cholesky.l().solve_lower_triangular_mut(&mut inverse);
        let scale = (self.squared_error(1.0) / (n as f64 - 1.0).max(1.0)).sqrt();
        let row = |i: usize| (0..=i).map(|j| scale * inverse[(i, j)]).collect();
        (0..n).map(row).collect()
    }
}

/// Most point MDPs that length scales are fitted on; more change them little.
const MOST_FITTED: usize = 90;

/// Share of the spread that cheap methods decide.
const FROM_CHEAP: f64 = 0.5;

/// Least nugget: below it, point MDPs that are nearly the same make weights inexact.
const LEAST_NUGGET: f64 = 1e-3;

/// Significant digits of what is kept.
const DIGITS: i32 = 4;

impl Design {
    /// Returns the same with the [`Process`] that follows from it.
    pub fn modelled(self) -> Self {
        Self { process: Some(process(&self)), ..self }
    }

    /// Returns a design with all that a sampling needs of it.
    pub fn for_sampling(self, sampling: Sampling) -> Self {
        if sampling == Sampling::BayesianQuadrature { self.modelled() } else { self }
    }
}

fn process(design: &Design) -> Process {
    let rows = standardised(design);
    let describing = design.points.first().map_or(0, |p| p.describing.len());
    let is_score =
        |c: usize| c >= describing && design.inputs[c - describing].measure == Measure::Score;
    let width = describing + design.inputs.len();
    let own = (0..width).filter(|c| !is_score(*c)).count();
    let mut next = 0..own;
    let groups: Vec<usize> =
        (0..width).map(|c| if is_score(c) { own } else { next.next().unwrap_or(own) }).collect();
    let fitted = fitted(&rows);
    let column = |c: usize| fitted.iter().map(|row| rows[*row][c]).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
    let curve = |c: usize| Curve {
        values: fitted.iter().map(|row| design.points[*row].inputs[c - describing]).collect(),
        column: Some(c),
    };
    let curves: Vec<Curve> = (0..width).filter(|c| is_score(*c)).map(curve).collect();
    let found = length_scales(&columns, &groups, &curves);
    let lengths: Vec<f64> = groups.iter().map(|g| rounded(found.lengths[*g])).collect();
    let places = places(&rows, &lengths);
    let spread = spread(design, &places);
    let mut process = Process {
        length_scales: lengths,
        nugget: rounded(found.noise.max(LEAST_NUGGET)),
        covariance: Vec::new(),
        variance: 0.0,
        spread,
    };
    let importance: Vec<f64> = design.points.iter().map(|p| p.importance).collect();
    let total: f64 = importance.iter().sum();
    let share = |p: &f64| p / total;
    let size = importance.len();
    let of = |i: usize| {
        let smooth = |j: usize| process.smooth(&places, i, j) * share(&importance[j]);
        (0..size).map(smooth).sum::<f64>()
    };
    process.covariance = (0..size).map(of).collect();
    process.variance = process.covariance.iter().zip(&importance).map(|(c, p)| c * share(p)).sum();
    process
}

/// Returns what is known of every point MDP, a row each: in logarithms where all values of a column are above 0, columns
/// standardised.
fn standardised(design: &Design) -> Vec<Vec<f64>> {
    let columns = design.points.first().map_or(0, |p| p.describing.len());
    let positive: Vec<bool> =
        (0..columns).map(|c| design.points.iter().all(|p| p.describing[c] > 0.0)).collect();
    let value = |(x, positive): (&f64, &bool)| if *positive { libm::log(*x) } else { *x };
    let row = |(p, inputs): (&DesignPoint, Vec<f64>)| {
        let describing: Vec<f64> = p.describing.iter().zip(&positive).map(value).collect();
        [describing, inputs].concat()
    };
    let rows: Vec<Vec<f64>> =
        design.points.iter().zip(design.transformed_inputs()).map(row).collect();
    standardise(&rows)
}

/// Returns the rows that length scales are fitted on, spread over all.
fn fitted(rows: &[Vec<f64>]) -> Vec<usize> {
    if rows.len() <= MOST_FITTED {
        return (0..rows.len()).collect();
    }
    let share = MOST_FITTED as f64 / rows.len() as f64;
    pivotal(&vec![share; rows.len()], rows, 0)
}

/// Returns by how much methods are expected to differ around every point MDP.
fn spread(design: &Design, places: &[Vec<f64>]) -> Vec<f64> {
    let size = design.points.len();
    let scores: Vec<usize> =
        (0..design.inputs.len()).filter(|c| design.inputs[*c].measure == Measure::Score).collect();
    if scores.len() < 2 {
        return vec![1.0; size];
    }
    let variance = |p: &DesignPoint| {
        let mean = scores.iter().map(|c| p.inputs[*c]).sum::<f64>() / scores.len() as f64;
        let squares = scores.iter().map(|c| (p.inputs[*c] - mean).powi(2));
        squares.sum::<f64>() / (scores.len() - 1) as f64
    };
    let variances: Vec<f64> = design.points.iter().map(variance).collect();
    let around = |i: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (j, variance) in variances.iter().enumerate() {
            // Over half a length scale.
            let weight = libm::exp(-2.0 * squared_distance(&places[i], &places[j]));
            sum += weight * variance;
            weights += weight;
        }
        (sum / weights).sqrt()
    };
    let deviations: Vec<f64> = (0..size).map(around).collect();
    let mean = deviations.iter().sum::<f64>() / size as f64;
    let of = |deviation: &f64| match mean > 0.0 {
        true => rounded(1.0 - FROM_CHEAP + FROM_CHEAP * deviation / mean),
        false => 1.0,
    };
    deviations.iter().map(of).collect()
}

/// Returns a number above 0 with [`DIGITS`] significant digits.
fn rounded(x: f64) -> f64 {
    let shift = DIGITS - 1 - libm::floor(libm::log10(x)) as i32;
    match shift {
        0.. => (x * 10f64.powi(shift)).round() / 10f64.powi(shift),
        _ => (x / 10f64.powi(-shift)).round() * 10f64.powi(-shift),
    }
}

/// Returns where point MDPs lie: rows of a design, scaled so that their squared distances are those of the kernel.
fn places(rows: &[Vec<f64>], lengths: &[f64]) -> Vec<Vec<f64>> {
    let scaled = |row: &Vec<f64>| row.iter().zip(lengths).map(|(x, l)| x / l).collect();
    rows.iter().map(scaled).collect()
}

impl Process {
    /// Returns the covariance of two scores without nugget.
    fn smooth(&self, places: &[Vec<f64>], i: usize, j: usize) -> f64 {
        self.spread[i] * self.spread[j] * libm::exp(-0.5 * squared_distance(&places[i], &places[j]))
    }

    /// Returns the variance of what no column explains of a score.
    fn unexplained(&self, i: usize) -> f64 {
        self.nugget * self.spread[i].powi(2)
    }

    /// Whether it has the numbers of so many point MDPs and columns, each of which can be one.
    fn fits(&self, size: usize, width: usize) -> bool {
        let positive = |x: &f64| *x > 0.0 && x.is_finite();
        [self.spread.len(), self.covariance.len()] == [size; 2]
            && self.length_scales.len() == width
            && self.length_scales.iter().chain(&self.spread).chain([&self.nugget]).all(positive)
            && self.covariance.iter().chain([&self.variance]).all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::design::{DesignPoint, Input, Measure};
    use super::*;

    /// A design with two cheap methods, the places of whose point MDPs are given.
    fn design(at: &[(f64, f64)]) -> Design {
        let input = |method: &str| Input { method: method.to_owned(), measure: Measure::Score };
        let total: f64 = at.iter().map(|(_, importance)| importance).sum();
        let point = |(i, (x, importance)): (usize, &(f64, f64))| DesignPoint {
            point: format!("p{i}"),
            importance: importance / total,
            describing: vec![*x],
            inputs: vec![1.5 + x.sin(), 1.2 + (0.5 * x).cos()],
        };
        let points = at.iter().enumerate().map(point).collect();
        Design { inputs: vec![input("a"), input("b")], points, ..Design::default() }.modelled()
    }

    /// Point MDPs at -1, 0 and 1 in a column, half as alike as they can be when they are neighbours, with a nugget of one half.
    fn three() -> Design {
        let point = |i: usize| DesignPoint {
            point: format!("p{i}"),
            importance: 1.0 / 3.0,
            describing: vec![i as f64 - 1.0],
            inputs: Vec::new(),
        };
        let process = Process {
            length_scales: vec![(1.5 / (2.0 * 2f64.ln())).sqrt()],
            nugget: 0.5,
            spread: vec![1.0; 3],
            covariance: vec![1.5625 / 3.0, 2.0 / 3.0, 1.5625 / 3.0],
            variance: 5.125 / 9.0,
        };
        let points = (0..3).map(point).collect();
        Design { points, process: Some(process), ..Design::default() }
    }

    #[test]
    fn weights_and_error_are_those_of_a_posterior_computed_by_hand() {
        let design = three();
        let quadrature = Quadrature::of(&design).unwrap();
        // K = ((1.5, 0.5), (0.5, 1.5)); with the family (0.6875, 2.5 / 3); the mean takes what is left, in halves.
        let rule = quadrature.rule(&[0, 1], false);
        assert!((rule.weights[0] - 0.427_083_333).abs() < 1e-8, "{:?}", rule.weights);
        assert!((rule.weights[1] - 0.572_916_667).abs() < 1e-8);
        assert!((rule.squared_error(1.0) - 0.204_644_097).abs() < 1e-8);
    }

    #[test]
    fn the_standard_error_of_innovations_is_that_of_the_process() {
        let at: Vec<(f64, f64)> = (0..30).map(|i| (f64::from(i * 7 % 30), 1.0)).collect();
        let design = design(&at);
        let rows: Vec<usize> = (0..30).step_by(3).collect();
        let rule = Quadrature::of(&design).unwrap().rule(&rows, false);
        let scores: Vec<f64> = rows.iter().map(|r| (*r as f64 * 0.9).sin()).collect();
        let mean: f64 = rule.weights.iter().zip(&scores).map(|(w, y)| w * y).sum();
        let squares = rule
            .innovations()
            .into_iter()
            .map(|row| row.iter().zip(&scores).map(|(a, y)| a * (y - mean)).sum::<f64>().powi(2));
        let (_, expected) = rule.with_nugget(1.0, &scores).unwrap();
        let found: f64 = squares.sum();
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn weights_are_shares_and_those_of_the_whole_family_its_importance(
            at in prop::collection::vec((-9.0f64..9.0, 0.1f64..3.0), 6..24), seed in 0u64..99,
        ) {
            let design = design(&at);
            let quadrature = Quadrature::of(&design).unwrap();
            for budget in 1..=at.len() {
                let mut rows = quadrature.order(&design, budget, seed);
                let rule = quadrature.rule(&rows, false);
                prop_assert!((rule.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
                prop_assert!(rule.weights.iter().all(|w| *w >= 0.0));
                // Whatever the order in which they are given.
                let reversed: Vec<usize> = rows.iter().rev().copied().collect();
                let other = quadrature.rule(&reversed, false);
                for (a, b) in rule.weights.iter().zip(other.weights.iter().rev()) {
                    prop_assert!((a - b).abs() < 1e-6);
                }
                rows.sort_unstable();
                rows.dedup();
                prop_assert_eq!(rows.len(), budget);
            }
            let rows: Vec<usize> = (0..at.len()).collect();
            let whole = quadrature.rule(&rows, false);
            for (w, p) in whole.weights.iter().zip(&design.points) {
                prop_assert!((w - p.importance).abs() < 1e-9);
            }
            prop_assert!(whole.squared_error(1.0) < 1e-9);
        }

        #[test]
        fn every_budget_has_the_beginning_of_one_order(
            at in prop::collection::vec((-9.0f64..9.0, 0.1f64..3.0), 6..24), seed in 0u64..99,
        ) {
            let design = design(&at);
            let quadrature = Quadrature::of(&design).unwrap();
            let all = quadrature.order(&design, at.len(), seed);
            for budget in 1..=at.len() {
                prop_assert_eq!(&quadrature.order(&design, budget, seed)[..], &all[..budget]);
            }
        }
    }
}

#[cfg(test)]
mod fit {
    use super::super::design::Input;
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        let found = [1234567.0, 0.000123456, 1.0, 99.999].map(rounded);
        assert_eq!(found, [1235000.0, 0.0001235, 1.0, 100.0]);
    }

    fn design(scores: &[[f64; 2]]) -> Design {
        let input = |method: &str| Input { method: method.to_owned(), measure: Measure::Score };
        let point = |(i, inputs): (usize, &[f64; 2])| DesignPoint {
            point: format!("p{i}"),
            importance: 1.0 / scores.len() as f64,
            describing: vec![i as f64 - 1.0],
            inputs: inputs.to_vec(),
        };
        let points = scores.iter().enumerate().map(point).collect();
        Design { inputs: vec![input("a"), input("b")], points, ..Design::default() }
    }

    #[test]
    fn methods_are_expected_to_differ_where_cheap_ones_do() {
        let scores: Vec<[f64; 2]> =
            (0..30).map(|i| [0.5, if i < 20 { 0.52 } else { 2.5 }]).collect();
        let process = super::process(&design(&scores));
        assert!(process.spread[5] < 0.8 && process.spread[25] > 1.5, "{:?}", process.spread);
        let mean = process.spread.iter().sum::<f64>() / 30.0;
        assert!((mean - 1.0).abs() < 1e-3);
    }

    #[test]
    fn without_cheap_scores_the_prior_is_left() {
        let plain = design(&[[1.0; 2]; 5]).without(&["a", "b"]);
        let process = super::process(&plain);
        assert_eq!((process.length_scales, process.spread), (vec![1.0], vec![1.0; 5]));
        assert_eq!(process.nugget, 0.1111);
    }

    #[test]
    fn what_was_kept_of_another_design_does_not_fit() {
        let (own, other) = (design(&[[1.0, 2.0]; 5]), design(&[[1.0, 2.0]; 6]));
        let process = super::process(&own);
        let fits = |process: &Process, design: &Design| {
            let design = Design { process: Some(process.clone()), ..design.clone() };
            crate::sample::quadrature::Quadrature::of(&design).is_some()
        };
        assert!(fits(&process, &own) && !fits(&process, &other));
        assert!(!fits(&process, &own.without(&["a"])));
        assert!(!fits(&Process { nugget: f64::NAN, ..process }, &own));
    }
}
