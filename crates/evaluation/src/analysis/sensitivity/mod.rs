//! How far the ranking of methods depends on which point MDPs count how much: failures, other importance, and the
//! one point MDP that is usually reported.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Further experiments on approximation algorithms" and
//! "Impact of Point MDP Distribution on Evaluations"; figure of reported and overall performance.

mod distributions;
mod failures;
mod reported;

pub use distributions::{Distribution, NAMED, RANDOM, RandomRanks, random_importance};
pub use failures::{Failures, FailuresOf, failures};
pub use reported::{Reported, Reversal};

use super::board::Board;
use super::error::AnalysisError;
use super::whole::Analysis;
use crate::stats::Limit;

/// What is asked of the records of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Whom to compare; `None` takes all methods with results but the baseline.
    pub methods: Option<Vec<String>>,
    /// From which value of a metric on a method fails on a point MDP; `None` does not look for failures.
    pub failure: Option<Limit>,
    /// Features by which importance is multiplied, each for a distribution of its own.
    pub weigh_by: Vec<String>,
    /// Concentration of random distributions, above 0: 1 makes all equally likely, less makes few point MDPs count.
    pub concentration: f64,
    /// Seed of random distributions.
    pub seed: u64,
    /// Point MDPs that are reported for the family.
    pub reported: Vec<String>,
}

/// How far the ranking of methods depends on which point MDPs count how much.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The methods, best first by importance, and their scores.
    pub board: Board,
    /// Where methods fail.
    pub failures: Option<Failures>,
    /// Overall performance by importance, with equal weights, by features, and under [`NAMED`] random distributions.
    pub distributions: Vec<Distribution>,
    /// How ranks vary over [`RANDOM`] random distributions.
    pub random: RandomRanks,
    /// What is reported, beside what holds overall.
    pub reported: Vec<Reported>,
}

impl Sensitivity {
    /// Looks at the records of a family.
    ///
    /// # Arguments
    ///
    /// * `elsewhere` — results on what is reported for the family, such as a named scenario, with what to call each.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for names that are not in the results, and where methods have nothing in common.
    pub fn new(
        analysis: &Analysis,
        question: &Question,
        elsewhere: &[(String, Analysis)],
    ) -> Result<Self, AnalysisError> {
        let methods = question.methods.clone().unwrap_or_else(|| Board::methods_of(analysis));
        // Names that there are not are told before how many there are.
        let board = Board::new(analysis, &methods)?;
        if methods.len() < 2 {
            let only = methods.first().map_or("no method", String::as_str);
            return Err(AnalysisError::NotTogether(format!(
                "there is only {only} to compare; name two methods or more with --methods, or finish the run"
            )));
        }
        if let Some(twice) = (1..methods.len()).find(|m| methods[..*m].contains(&methods[*m])) {
            let twice = &methods[twice];
            return Err(AnalysisError::NotTogether(format!(
                "--methods has {twice} twice; name it once"
            )));
        }
        let board = best_first(board);
        let failures =
            question.failure.as_ref().map(|limit| failures(analysis, &board, limit)).transpose()?;
        let mut distributions = vec![Distribution::importance(&board), Distribution::equal(&board)];
        for feature in &question.weigh_by {
            distributions.push(Distribution::by_feature(analysis, &board, feature)?);
        }
        let (named, random) = distributions::random(&board, question.concentration, question.seed);
        distributions.extend(named);
        let mut reported = Vec::new();
        for point in &question.reported {
            reported.push(Reported::at(analysis, &board, point)?);
        }
        for (name, other) in elsewhere {
            reported.push(Reported::elsewhere(analysis, &board, name, other)?);
        }
        Ok(Self { board, failures, distributions, random, reported })
    }

    /// Returns the distribution by importance, which the others are held against.
    pub fn overall(&self) -> &Distribution {
        &self.distributions[0]
    }

    /// Returns the pairs of methods whose order turns round under a distribution.
    pub fn reversals(&self, distribution: &Distribution) -> Vec<Reversal> {
        let of = |d: &Distribution| d.overall.iter().copied().map(Some).collect::<Vec<_>>();
        reported::reversals(&self.board, &of(distribution), &of(self.overall()))
    }
}

/// Returns a board whose methods are sorted by their overall performance.
fn best_first(board: Board) -> Board {
    let overall = Distribution::importance(&board).overall;
    let mut order: Vec<usize> = (0..board.methods.len()).collect();
    order.sort_by(|a, b| board.direction.compare(overall[*a], overall[*b]));
    let mut sorted = board.clone();
    sorted.methods = order.iter().map(|m| board.methods[*m].clone()).collect();
    for (point, old) in sorted.points.iter_mut().zip(&board.points) {
        point.scores = order.iter().map(|m| old.scores[*m]).collect();
    }
    sorted
}
