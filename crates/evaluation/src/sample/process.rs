//! A Gaussian process that says how alike the scores of a method are on two point MDPs, before it is evaluated.
//!
//! `cov(i, j) = s_i s_j (exp(-sum_c (x_ic - x_jc)^2 / (2 l_c^2)) + nugget [i = j])`, up to a factor that is the method's
//! own. Columns are what describes a point MDP, the baseline's objective and the scores of cheap methods, in logarithms
//! where all are above 0, standardised.
//!
//! Source: C. Rasmussen and C. Williams, "Gaussian Processes for Machine Learning", 2006, chapter 4.

use serde::{Deserialize, Serialize};

/// How alike the scores of a method are on the point MDPs of a design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// Length scale of every column: what describes point MDPs, then the inputs; in standard deviations over the family.
    pub length_scales: Vec<f64>,
    /// Variance of what no column explains, in proportion to that of what they explain.
    pub nugget: f64,
    /// By how much methods are expected to differ, in proportion to the family's mean, a value per point MDP.
    pub spread: Vec<f64>,
    /// Covariance with the overall performance without nugget, a value per point MDP.
    pub covariance: Vec<f64>,
    /// Variance of the overall performance without nugget.
    pub variance: f64,
}

/// Where point MDPs lie: rows of a design, scaled so that their squared distances are those of the kernel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places(Vec<Vec<f64>>);

impl Process {
    /// Returns where point MDPs lie.
    pub(super) fn places(&self, rows: &[Vec<f64>]) -> Places {
        Places::new(rows, &self.length_scales)
    }

    /// Returns the covariance of two scores without nugget.
    pub(super) fn smooth(&self, places: &Places, i: usize, j: usize) -> f64 {
        self.spread[i] * self.spread[j] * places.kernel(i, j)
    }

    /// Returns the variance of what no column explains of a score.
    pub(super) fn unexplained(&self, i: usize) -> f64 {
        self.nugget * self.spread[i].powi(2)
    }

    /// Whether it has the numbers of so many point MDPs and columns, each of which can be one.
    pub(super) fn fits(&self, size: usize, width: usize) -> bool {
        let positive = |x: &f64| *x > 0.0 && x.is_finite();
        [self.spread.len(), self.covariance.len()] == [size; 2]
            && self.length_scales.len() == width
            && self.length_scales.iter().chain(&self.spread).chain([&self.nugget]).all(positive)
            && self.covariance.iter().chain([&self.variance]).all(|x| x.is_finite())
    }
}

impl Places {
    pub(super) fn new(rows: &[Vec<f64>], lengths: &[f64]) -> Self {
        let scaled = |row: &Vec<f64>| row.iter().zip(lengths).map(|(x, l)| x / l).collect();
        Self(rows.iter().map(scaled).collect())
    }

    pub(super) fn squared_distance(&self, i: usize, j: usize) -> f64 {
        self.0[i].iter().zip(&self.0[j]).map(|(a, b)| (a - b).powi(2)).sum()
    }

    fn kernel(&self, i: usize, j: usize) -> f64 {
        libm::exp(-0.5 * self.squared_distance(i, j))
    }
}
