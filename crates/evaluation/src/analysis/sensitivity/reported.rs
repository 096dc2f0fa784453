//! What is reported on one point MDP, or on a named scenario, beside what holds over the family.

use crate::analysis::board::Board;
use crate::analysis::error::AnalysisError;
use crate::analysis::ranks::ranks;
use crate::analysis::whole::Analysis;

/// What is reported, for the methods of a board.
#[derive(Debug, Clone, PartialEq)]
pub struct Reported {
    /// What it was measured on.
    pub name: String,
    /// Score of every method there; `None` for one that was not run there.
    pub scores: Vec<Option<f64>>,
    /// Rank of every method there, among those with a score.
    pub ranks: Vec<Option<f64>>,
    /// Rank of every method over the family, among the same.
    pub overall_ranks: Vec<Option<f64>>,
    /// Pairs of methods whose order over the family is the other one.
    pub reversals: Vec<Reversal>,
}

/// Two methods whose order turns round.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reversal {
    /// The better one here.
    pub here: String,
    /// The better one over the family, by importance.
    pub overall: String,
}

impl Reported {
    /// Takes what was measured on a point MDP of the family.
    pub(super) fn at(
        analysis: &Analysis,
        board: &Board,
        point: &str,
    ) -> Result<Self, AnalysisError> {
        let point = &board.points[board.position(analysis, point)?];
        let scores = point.scores.iter().copied().map(Some).collect();
        let name = analysis.points[point.index].row.name().to_owned();
        Ok(Self::new(board, name, scores))
    }

    /// Takes what was measured in another run, such as on a named scenario; over several point MDPs their weighted
    /// mean.
    pub(super) fn elsewhere(
        analysis: &Analysis,
        board: &Board,
        name: &str,
        other: &Analysis,
    ) -> Result<Self, AnalysisError> {
        let refused = |reason: String| {
            Err(AnalysisError::NotTogether(format!("--reported-results {name}: {reason}")))
        };
        let measure = |a: &Analysis| {
            let identity = &a.manifest.identity;
            let relative = if a.reference.is_none() { "" } else { " relative to a baseline" };
            format!("{}{relative}, {} is better", identity.objective, identity.direction.name())
        };
        if measure(analysis) != measure(other) {
            return refused(format!(
                "its scores are {}, those of the family {}; give results of the same task",
                measure(other),
                measure(analysis)
            ));
        }
        let has = |method: &&String| Board::methods_of(other).contains(method);
        let common: Vec<String> = board.methods.iter().filter(has).cloned().collect();
        if common.len() < 2 {
            let methods = board.methods.join(", ");
            return refused(format!(
                "it has results of fewer than two of {methods}; run them there"
            ));
        }
        let there = match Board::new(other, &common) {
            Ok(there) => there,
            Err(e) => return refused(e.to_string()),
        };
        let weights = there.weights();
        let score = |method: &String| {
            let m = there.methods.iter().position(|other| other == method)?;
            Some(there.points.iter().zip(&weights).map(|(p, w)| w * p.scores[m]).sum())
        };
        let name = match other.points.as_slice() {
            [point] => point.row.name().to_owned(),
            _ => name.to_owned(),
        };
        Ok(Self::new(board, name, board.methods.iter().map(score).collect()))
    }

    fn new(board: &Board, name: String, scores: Vec<Option<f64>>) -> Self {
        let weights = board.weights();
        let overall = |m: usize| {
            let sum = board.points.iter().zip(&weights).map(|(p, w)| w * p.scores[m]).sum();
            scores[m].map(|_| sum)
        };
        let overall: Vec<Option<f64>> = (0..scores.len()).map(overall).collect();
        Self {
            name,
            ranks: ranks_of(board, &scores),
            overall_ranks: ranks_of(board, &overall),
            reversals: reversals(board, &scores, &overall),
            scores,
        }
    }
}

fn ranks_of(board: &Board, scores: &[Option<f64>]) -> Vec<Option<f64>> {
    let known: Vec<f64> = scores.iter().copied().flatten().collect();
    let mut of_known = ranks(&known, board.direction).into_iter();
    scores.iter().map(|score| score.and_then(|_| of_known.next())).collect()
}

/// Returns the pairs of methods of which one is better here and the other overall.
pub(super) fn reversals(
    board: &Board,
    here: &[Option<f64>],
    overall: &[Option<f64>],
) -> Vec<Reversal> {
    let ahead = |values: &[Option<f64>], a: usize, b: usize| {
        let (Some(a), Some(b)) = (values[a], values[b]) else { return false };
        board.direction.is_worse(b, a)
    };
    let mut found = Vec::new();
    for a in 0..board.methods.len() {
        for b in 0..board.methods.len() {
            if ahead(here, a, b) && ahead(overall, b, a) {
                let name = |m: usize| board.methods[m].clone();
                found.push(Reversal { here: name(a), overall: name(b) });
            }
        }
    }
    found
}
