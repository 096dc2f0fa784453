//! How methods rank across families: on every combination of one point MDP from each.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Do Point MDP-based Evaluations Affect Standard DRL
//! Evaluations Across Tasks?". The score of a method on a combination is the mean of its scores there.

use super::board::Board;
use super::error::AnalysisError;
use super::whole::Analysis;
use crate::stats::Direction;
use crate::stats::combinations::{MOST_COMBINATIONS, RankShares, rank_shares};
use crate::stats::score::mean;

/// How scores of different families are brought together before their mean is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Scale {
    /// Unchanged; for one objective, or for scores that are all relative to a baseline
    #[default]
    Score,
    /// From 0, the family's worst score, to 1, its best
    Range,
}

/// How methods rank across families.
#[derive(Debug, Clone, PartialEq)]
pub struct Across {
    /// Names of the methods, best first by [`Self::expected`].
    pub methods: Vec<String>,
    /// What the methods achieve on average over all combinations, on the scale of the comparison.
    pub expected: Vec<f64>,
    /// How often every method takes every rank, in the order of [`Self::methods`].
    pub ranks: RankShares,
    /// Whether less or more of [`Self::expected`] is better.
    pub direction: Direction,
    /// How scores were brought together.
    pub scale: Scale,
    /// The families in the order given: name and number of point MDPs that count.
    pub families: Vec<(String, usize)>,
    /// What people should know, such as methods that are left out.
    pub notes: Vec<String>,
}

/// Returns how methods rank across families.
///
/// # Arguments
///
/// * `families` — what messages call each, and what its records say.
/// * `methods` — whom to compare; `None` takes all that every family has, without its baseline.
///
/// # Errors
///
/// [`AnalysisError`] when there is nothing to compare or scores are not on one scale.
pub fn across(
    families: &[(String, Analysis)],
    methods: Option<&[String]>,
    scale: Scale,
) -> Result<Across, AnalysisError> {
    if families.len() < 2 {
        let reason =
            "across compares methods over several families; give two results directories or more";
        return Err(AnalysisError(reason.to_owned()));
    }
    if scale == Scale::Score {
        check_scale(families)?;
    }
    let mut notes = Vec::new();
    let methods = methods.map_or_else(|| common_methods(families, &mut notes), <[String]>::to_vec);
    let mut boards = Vec::new();
    for (name, analysis) in families {
        let board = Board::new(analysis, &methods);
        let board = board.map_err(|e| AnalysisError(format!("{name}: {e}")))?;
        notes.extend(board.notes.iter().map(|note| format!("{name}: {note}")));
        boards.push(board);
    }
    let direction = if scale == Scale::Score { boards[0].direction } else { Direction::Higher };
    let on_scale = |boards: &[Board]| boards.iter().map(|b| scores(b, scale)).collect();
    let all: Vec<Vec<Vec<f64>>> = on_scale(&boards);
    let of_family = |tasks: &Vec<Vec<f64>>, m: usize| {
        tasks.iter().map(|scores| scores[m]).sum::<f64>() / tasks.len() as f64
    };
    let expected: Vec<f64> = (0..methods.len())
        .filter_map(|m| mean(&all.iter().map(|tasks| of_family(tasks, m)).collect::<Vec<_>>()))
        .collect();
    let mut order: Vec<usize> = (0..methods.len()).collect();
    order.sort_by(|a, b| direction.compare(expected[*a], expected[*b]));
    boards.iter_mut().for_each(|board| board.reorder(&order));
    let ranks = rank_shares(&on_scale(&boards), direction).ok_or_else(|| {
        AnalysisError(format!(
            "more than {MOST_COMBINATIONS} combinations; give fewer families, or evaluate some on a sample (run --budget)"
        ))
    })?;
    let sizes = families.iter().zip(&boards).map(|((name, _), b)| (name.clone(), b.points.len()));
    Ok(Across {
        methods: order.iter().map(|m| methods[*m].clone()).collect(),
        expected: order.iter().map(|m| expected[*m]).collect(),
        ranks,
        direction,
        scale,
        families: sizes.collect(),
        notes,
    })
}

fn common_methods(families: &[(String, Analysis)], notes: &mut Vec<String>) -> Vec<String> {
    let all: Vec<Vec<String>> = families.iter().map(|(_, a)| Board::methods_of(a)).collect();
    let everywhere = |m: &&String| all.iter().all(|methods| methods.contains(m));
    let common: Vec<String> = all[0].iter().filter(everywhere).cloned().collect();
    for ((name, _), methods) in families.iter().zip(&all) {
        let only: Vec<&str> =
            methods.iter().filter(|m| !common.contains(m)).map(String::as_str).collect();
        if !only.is_empty() {
            let only = only.join(", ");
            notes.push(format!("{name}: {only} left out, because not every family has it"));
        }
    }
    common
}

/// Checks that a mean over scores of all families means something.
fn check_scale(families: &[(String, Analysis)]) -> Result<(), AnalysisError> {
    let what = |(_, analysis): &(String, Analysis)| {
        let identity = &analysis.manifest.identity;
        let measure = match analysis.reference.is_none() {
            true => identity.objective.clone(),
            false => "relative to a baseline".to_owned(),
        };
        format!("{measure}, {} is better", identity.direction.name())
    };
    let first = what(&families[0]);
    let Some(other) = families.iter().find(|family| what(family) != first) else { return Ok(()) };
    Err(AnalysisError(format!(
        "scores of {} ({first}) and {} ({}) cannot be averaged: give --scale range, which puts the worst score of each \
         family at 0 and its best at 1",
        families[0].0,
        other.0,
        what(other)
    )))
}

/// Returns the scores of a family on the scale of the comparison, shape `[tasks, methods]`.
fn scores(board: &Board, scale: Scale) -> Vec<Vec<f64>> {
    let all = || board.points.iter().flat_map(|p| p.scores.iter().copied());
    let (best, worst) = (board.direction.best(all()), board.direction.worst(all()));
    let (best, worst) = (best.unwrap_or(0.0), worst.unwrap_or(0.0));
    let of_point = |scores: &[f64]| match scale {
        Scale::Score => scores.to_vec(),
        // A family in which nothing differs says nothing of methods.
        Scale::Range if best == worst => vec![0.0; scores.len()],
        Scale::Range => scores.iter().map(|s| (worst - s) / (worst - best)).collect(),
    };
    board.points.iter().map(|p| of_point(&p.scores)).collect()
}
