//! How methods rank across families: on every combination of one point MDP from each.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Do Point MDP-based Evaluations Affect Standard DRL
//! Evaluations Across Tasks?". The score of a method on a combination is the mean of its scores there.

use super::board::Board;
use super::error::AnalysisError;
use super::ranks::ranks;
use super::whole::Analysis;
use crate::stats::combinations::{Candidate, RankShares, expected_score, rank_shares};
use crate::stats::score::mean;
use crate::stats::{Direction, quantile::median};

/// How scores of different families are brought together before their mean is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Scale {
    /// Unchanged; for one objective, or for scores that are all relative to a baseline
    #[default]
    Score,
    /// From 0, the family's worst score, to 1, its best
    Range,
    /// The methods' ranks on each point MDP
    Rank,
}

/// What a combination weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Weighing {
    /// All combinations count the same, as in the paper
    #[default]
    Equal,
    /// The product of the importances of its point MDPs
    Importance,
}

/// A family, read.
#[derive(Debug)]
pub struct Family<'a> {
    /// What messages call it, such as its folder.
    pub name: String,
    /// What its records say.
    pub analysis: &'a Analysis,
}

/// How methods rank across families.
#[derive(Debug, Clone, PartialEq)]
pub struct Across {
    /// Names of the methods, best first by [`Self::expected`].
    pub methods: Vec<String>,
    /// What the methods achieve on average over all combinations, on the scale of the comparison.
    pub expected: Vec<f64>,
    /// Mean rank over all combinations.
    pub mean_rank: Vec<f64>,
    /// How often every method takes every rank, in the order of [`Self::methods`].
    pub ranks: RankShares,
    /// Whether less or more of [`Self::expected`] is better.
    pub direction: Direction,
    /// How scores were brought together.
    pub scale: Scale,
    /// What combinations weigh.
    pub weighing: Weighing,
    /// The families in the order given: name and number of point MDPs that count.
    pub families: Vec<(String, usize)>,
    /// The reported combination, where there is one.
    pub reported: Option<Reported>,
    /// What people should know, such as methods that are left out.
    pub notes: Vec<String>,
}

/// The combination that is reported, such as every family's usual point MDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Reported {
    /// Its point MDPs, in the order of the families.
    pub points: Vec<String>,
    /// Score of every method there, in the order of [`Across::methods`].
    pub scores: Vec<f64>,
    /// Rank of every method there, from 1; methods that tie have the mean of theirs.
    pub ranks: Vec<f64>,
}

/// Returns how methods rank across families.
///
/// # Arguments
///
/// * `methods` — whom to compare; `None` takes all that every family has, without its baseline.
/// * `reported` — a point MDP per family, in their order; nothing for none.
///
/// # Errors
///
/// [`AnalysisError`] when there is nothing to compare or scores are not on one scale.
pub fn across(
    families: &[Family<'_>],
    methods: Option<&[String]>,
    reported: &[String],
    (scale, weighing): (Scale, Weighing),
) -> Result<Across, AnalysisError> {
    let refused = |text: String| Err(AnalysisError::NotTogether(text));
    if families.len() < 2 {
        return refused(
            "across compares methods over several families; give two results directories or more"
                .to_owned(),
        );
    }
    if !reported.is_empty() && reported.len() != families.len() {
        return refused(format!(
            "--reported is given {} times for {} families; give it once per family, in their order",
            reported.len(),
            families.len()
        ));
    }
    let mut notes = Vec::new();
    let methods = match methods {
        Some(methods) => methods.to_vec(),
        None => common_methods(families, &mut notes)?,
    };
    if methods.len() < 2 {
        return refused(format!(
            "there is only {} to compare; name two methods or more with --methods",
            methods.first().map_or("nothing", String::as_str)
        ));
    }
    if let Some(twice) = (1..methods.len()).find(|m| methods[..*m].contains(&methods[*m])) {
        return refused(format!("--methods has {} twice; name it once", methods[twice]));
    }
    if scale == Scale::Score {
        check_scale(families)?;
    }
    let mut boards = Vec::new();
    for family in families {
        let in_family =
            |e: AnalysisError| AnalysisError::NotTogether(format!("{}: {e}", family.name));
        let board = Board::new(family.analysis, &methods).map_err(in_family)?;
        notes.extend(board.lacks().map(|lacks| format!("{}: {lacks}", family.name)));
        let unknown = match weighing {
            Weighing::Equal => {
                "they were chosen by importance, so equal weights do not represent the family"
            }
            Weighing::Importance => "the effect of the others is not known",
        };
        notes.extend(board.sampled().map(|sampled| {
            format!("{}: {sampled}, and combinations are of these; {unknown}", family.name)
        }));
        boards.push(board);
    }
    let direction = match scale {
        Scale::Score => boards[0].direction,
        Scale::Range => Direction::Higher,
        Scale::Rank => Direction::Lower,
    };
    let mut candidates: Vec<Vec<Candidate>> =
        boards.iter().map(|board| candidates(board, scale, weighing)).collect();
    let expected: Vec<f64> = (0..methods.len()).map(|m| expected_score(&candidates, m)).collect();
    let mut order: Vec<usize> = (0..methods.len()).collect();
    order.sort_by(|a, b| direction.compare(expected[*a], expected[*b]));
    for task in candidates.iter_mut().flatten() {
        task.scores = order.iter().map(|m| task.scores[*m]).collect();
    }
    let ranks = rank_shares(&candidates, direction)
        .map_err(|e| AnalysisError::NotTogether(e.to_string()))?;
    let mean_rank = |shares: &Vec<f64>| {
        shares.iter().enumerate().map(|(r, share)| (r + 1) as f64 * share).sum::<f64>()
    };
    let reported = match reported.is_empty() {
        true => None,
        false => Some(report(families, &boards, reported, &candidates, direction)?),
    };
    Ok(Across {
        methods: order.iter().map(|m| methods[*m].clone()).collect(),
        expected: order.iter().map(|m| expected[*m]).collect(),
        mean_rank: ranks.shares.iter().map(mean_rank).collect(),
        ranks,
        direction,
        scale,
        weighing,
        families: families
            .iter()
            .zip(&boards)
            .map(|(f, b)| (f.name.clone(), b.points.len()))
            .collect(),
        reported,
        notes,
    })
}

/// Returns the methods that every family has results of, in the order of the first.
fn common_methods(
    families: &[Family<'_>],
    notes: &mut Vec<String>,
) -> Result<Vec<String>, AnalysisError> {
    let all: Vec<Vec<String>> = families.iter().map(|f| Board::methods_of(f.analysis)).collect();
    let everywhere = |m: &&String| all.iter().all(|methods| methods.contains(m));
    let common: Vec<String> = all[0].iter().filter(everywhere).cloned().collect();
    for (family, methods) in families.iter().zip(&all) {
        let only: Vec<&str> =
            methods.iter().filter(|m| !common.contains(m)).map(String::as_str).collect();
        if !only.is_empty() {
            let (name, only) = (&family.name, only.join(", "));
            notes.push(format!("{name}: {only} left out, because not every family has it"));
        }
    }
    if common.is_empty() {
        let have = |(f, methods): (&Family<'_>, &Vec<String>)| {
            format!(
                "{} has {}",
                f.name,
                if methods.is_empty() { "none".to_owned() } else { methods.join(", ") }
            )
        };
        let have: Vec<String> = families.iter().zip(&all).map(have).collect();
        return Err(AnalysisError::NotTogether(format!(
            "no method has results in every family: {}; evaluate the same methods in each",
            have.join("; ")
        )));
    }
    Ok(common)
}

/// Checks that a mean over scores of all families means something.
fn check_scale(families: &[Family<'_>]) -> Result<(), AnalysisError> {
    let what = |family: &Family<'_>| {
        let (identity, reference) =
            (&family.analysis.manifest.identity, &family.analysis.reference);
        let measure = match reference.is_none() {
            true => identity.objective.clone(),
            false => "relative to a baseline".to_owned(),
        };
        (measure, identity.direction)
    };
    let first = what(&families[0]);
    let Some(other) = families.iter().find(|family| what(family) != first) else { return Ok(()) };
    let say = |family: &Family<'_>| {
        let identity = &family.analysis.manifest.identity;
        let relative = match family.analysis.reference.name.as_str() {
            "" => String::new(),
            baseline => format!(" relative to {baseline}"),
        };
        let (objective, better) = (&identity.objective, identity.direction.name());
        format!("{} ({objective}{relative}, {better} is better)", family.name)
    };
    Err(AnalysisError::NotTogether(format!(
        "scores of {} and {} cannot be averaged: give --scale range, which puts the worst score of each \
         family at 0 and its best at 1, or --scale rank, which takes the methods' ranks on each point MDP",
        say(&families[0]),
        say(other)
    )))
}

/// Returns the tasks of a family on the scale of the comparison.
fn candidates(board: &Board, scale: Scale, weighing: Weighing) -> Vec<Candidate> {
    let all = || board.points.iter().flat_map(|p| p.scores.iter().copied());
    let (best, worst) = (board.direction.best(all()), board.direction.worst(all()));
    let (best, worst) = (best.unwrap_or(0.0), worst.unwrap_or(0.0));
    let scores = |scores: &[f64]| match scale {
        Scale::Score => scores.to_vec(),
        // A family in which nothing differs says nothing of methods.
        Scale::Range if best == worst => vec![0.0; scores.len()],
        Scale::Range => scores.iter().map(|s| (worst - s) / (worst - best)).collect(),
        Scale::Rank => ranks(scores, board.direction),
    };
    let weight = |weight: f64| match weighing {
        Weighing::Equal => 1.0,
        Weighing::Importance => weight,
    };
    let task = |p: &super::board::BoardPoint| Candidate {
        scores: scores(&p.scores),
        weight: weight(p.weight),
    };
    board.points.iter().map(task).collect()
}

fn report(
    families: &[Family<'_>],
    boards: &[Board],
    reported: &[String],
    candidates: &[Vec<Candidate>],
    direction: Direction,
) -> Result<Reported, AnalysisError> {
    let mut points = Vec::new();
    let mut chosen = Vec::new();
    for (i, family) in families.iter().enumerate() {
        let position = boards[i].position(family.analysis, &reported[i]).map_err(|e| {
            AnalysisError::NotTogether(format!("--reported of {}: {e}", family.name))
        })?;
        points.push(boards[i].points[position].id.clone());
        chosen.push(&candidates[i][position]);
    }
    let of = |m: usize| {
        let scores: Vec<f64> = chosen.iter().map(|task| task.scores[m]).collect();
        mean(&scores).unwrap_or(0.0)
    };
    let scores: Vec<f64> = (0..chosen[0].scores.len()).map(of).collect();
    let single: Vec<Vec<Candidate>> =
        chosen.into_iter().map(|task| vec![Candidate { weight: 1.0, ..task.clone() }]).collect();
    // The same ties as in the table.
    let shares =
        rank_shares(&single, direction).map_err(|e| AnalysisError::NotTogether(e.to_string()))?;
    let held = |shares: &Vec<f64>| {
        let held: Vec<f64> =
            (0..shares.len()).filter(|r| shares[*r] > 0.0).map(|r| (r + 1) as f64).collect();
        median(&held).unwrap_or(0.0)
    };
    Ok(Reported { points, scores, ranks: shares.shares.iter().map(held).collect() })
}
