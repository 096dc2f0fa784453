//! How methods rank across families: on every combination of one point MDP from each.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Do Point MDP-based Evaluations Affect Standard DRL
//! Evaluations Across Tasks?". The score of a method on a combination is the mean of its scores there.

use rayon::prelude::*;

use super::board::Board;
use super::reference::AnalysisError;
use super::whole::Analysis;
use crate::stats::Direction;
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

const MOST_COMBINATIONS: u128 = 10_000_000_000;

/// Distance of sums, relative to the largest score, below which they are equal.
const EQUAL: f64 = 1e-12;

/// How often every method takes every rank.
#[derive(Debug, Clone, PartialEq)]
pub struct RankShares {
    /// Shape `[methods, ranks]`; methods that tie share the ranks that they take together.
    pub shares: Vec<Vec<f64>>,
    /// Share of the combinations in which the methods rank in their order, without a tie.
    pub in_order: f64,
    /// Share of those with a tie.
    pub tied: f64,
    /// Number of combinations.
    pub combinations: u128,
}

/// What was counted of some combinations.
#[derive(Clone, Default)]
struct Counts {
    by_rank: Vec<Vec<f64>>,
    in_order: f64,
    tied: f64,
}

/// Returns how often every method takes every rank; `None` for more than [`MOST_COMBINATIONS`].
///
/// # Arguments
///
/// * `families` — shape `[families, tasks, methods]`: scores, at least one task each.
fn rank_shares(families: &[Vec<Vec<f64>>], direction: Direction) -> Option<RankShares> {
    let combinations: u128 = families.iter().map(|tasks| tasks.len() as u128).product();
    let (first, rest) = families.split_first()?;
    if combinations > MOST_COMBINATIONS {
        return None;
    }
    let methods = first.first()?.len();
    let largest = families.iter().flatten().flatten().fold(0.0f64, |most, s| most.max(s.abs()));
    let tolerance = EQUAL * largest;
    let none = Counts { by_rank: vec![vec![0.0; methods]; methods], ..Counts::default() };
    let counted: Vec<Counts> = first
        .par_iter()
        .map(|task| {
            let mut counts = none.clone();
            each(rest, task, &mut |sums| counts.add(sums, direction, tolerance));
            counts
        })
        .collect();
    let share =
        |of: &dyn Fn(&Counts) -> f64| counted.iter().map(of).sum::<f64>() / combinations as f64;
    let of_method = |m: usize| (0..methods).map(|r| share(&|c| c.by_rank[m][r])).collect();
    Some(RankShares {
        shares: (0..methods).map(of_method).collect(),
        in_order: share(&|c| c.in_order),
        tied: share(&|c| c.tied),
        combinations,
    })
}

/// Calls with the sums of every combination of a task of each of these families.
fn each(families: &[Vec<Vec<f64>>], sums: &[f64], take: &mut dyn FnMut(&[f64])) {
    let Some((tasks, rest)) = families.split_first() else { return take(sums) };
    let mut with = sums.to_vec();
    for task in tasks {
        with.iter_mut().zip(sums.iter().zip(task)).for_each(|(with, (sum, s))| *with = sum + s);
        each(rest, &with, take);
    }
}

impl Counts {
    fn add(&mut self, sums: &[f64], direction: Direction, tolerance: f64) {
        let (mut tied, mut in_order) = (false, true);
        for (m, sum) in sums.iter().enumerate() {
            let (mut before, mut like) = (0, 0);
            for other in sums {
                let ahead = direction.ahead(*other, *sum);
                if ahead.abs() <= tolerance {
                    like += 1;
                } else if ahead > 0.0 {
                    before += 1;
                }
            }
            tied |= like > 1;
            in_order &= before == m;
            self.by_rank[m][before..before + like].iter_mut().for_each(|c| *c += 1.0 / like as f64);
        }
        self.tied += f64::from(u8::from(tied));
        self.in_order += f64::from(u8::from(in_order && !tied));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn family(scores: &[&[f64]]) -> Vec<Vec<f64>> {
        scores.iter().map(|s| s.to_vec()).collect()
    }

    #[test]
    fn two_families_of_two_tasks_by_hand() {
        // Sums: (1+1, 2+4), (1+5, 2+1), (3+1, 1+4), (3+6, 1+1).
        let families = [family(&[&[1.0, 2.0], &[3.0, 1.0]]), family(&[&[1.0, 4.0], &[5.0, 1.0]])];
        let found = rank_shares(&families, Direction::Lower).unwrap();
        assert_eq!(found.shares, [[0.5, 0.5], [0.5, 0.5]]);
        assert_eq!((found.combinations, found.tied, found.in_order), (4, 0.0, 0.5));
        let found = rank_shares(&families[..1], Direction::Higher).unwrap();
        assert_eq!((found.shares[0][0], found.in_order), (0.5, 0.5));
    }

    #[test]
    fn methods_that_tie_share_their_ranks() {
        // 0.1 + 0.2 and 0.3 + 0 differ in the last bit as floating-point numbers.
        let families = [family(&[&[0.1, 0.3, 9.0]]), family(&[&[0.2, 0.0, 9.0]])];
        let found = rank_shares(&families, Direction::Lower).unwrap();
        assert_eq!(found.shares, [[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!((found.tied, found.in_order), (1.0, 0.0));
    }
}
