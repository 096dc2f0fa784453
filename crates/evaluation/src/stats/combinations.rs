//! In which share of all combinations of one task from each family every method takes every rank.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Do Point MDP-based Evaluations Affect Standard DRL
//! Evaluations Across Tasks?". Every combination is looked at: nothing is drawn.

use rayon::prelude::*;

use super::Direction;

/// Most combinations that are looked at.
pub const MOST_COMBINATIONS: u128 = 10_000_000_000;

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
pub fn rank_shares(families: &[Vec<Vec<f64>>], direction: Direction) -> Option<RankShares> {
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
