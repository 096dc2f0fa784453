//! In which share of all combinations of one task from each family every method takes every rank.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, "Do Point MDP-based Evaluations Affect Standard DRL
//! Evaluations Across Tasks?". Every combination is looked at: nothing is drawn.
//!
//! Scores become whole numbers of a 2^-44th of the largest, so that sums do not depend on the order of the
//! families. Ranks follow from differences between methods alone: tasks of a family with equal differences are
//! one task that counts more, which leaves fewer combinations.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Direction;

/// Most methods: their number has five bits beside the sum.
pub const MOST_METHODS: usize = 32;

/// Most families: a sum has ten bits more than a score.
pub const MOST_FAMILIES: usize = 1024;

/// Most distinct combinations that are looked at, about an hour on one core.
pub const MOST_COMBINATIONS: u128 = 50_000_000_000;

/// Bits of a score.
const SCORE_BITS: i32 = 44;

/// Bits that hold the number of a method.
const METHOD_BITS: u32 = 5;

/// Parts of the work; more than processors, and always as many, so that sums have one order.
const PARTS: u64 = 512;

/// Why ranks cannot be counted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CombinationsError {
    /// More combinations than can be looked at.
    #[error(
        "{distinct} combinations, more than the {MOST_COMBINATIONS} that are looked at one by one; give fewer \
         families, or evaluate some on a sample (run --budget)"
    )]
    TooMany {
        /// How many there are.
        distinct: u128,
    },
    /// More methods or families than sums have room for.
    #[error(
        "{methods} methods of {families} families; at most {MOST_METHODS} methods and {MOST_FAMILIES} families can \
         be compared, so give fewer"
    )]
    TooWide {
        /// Number of methods.
        methods: usize,
        /// Number of families.
        families: usize,
    },
}

/// A task of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Score of every method, in one order for all families.
    pub scores: Vec<f64>,
    /// Weight, above 0; a combination weighs the product.
    pub weight: f64,
}

/// How often every method takes every rank.
#[derive(Debug, Clone, PartialEq)]
pub struct RankShares {
    /// Share of the combinations, shape `[methods, ranks]`; rows and columns sum to 1. Of methods that tie over
    /// some ranks each has an equal share of these.
    pub shares: Vec<Vec<f64>>,
    /// Share of the combinations whose ranking is that of the expected sum, without a tie.
    pub as_expected: f64,
    /// Share of the combinations in which some methods tie.
    pub tied: f64,
    /// Number of combinations.
    pub combinations: u128,
    /// Number of those that differ in what decides ranks.
    pub distinct: u128,
}

/// Tasks of a family that decide ranks alike: differences to the first method, and what they weigh together.
struct Column {
    differences: Vec<Vec<i64>>,
    weights: Vec<f64>,
}

/// What was counted in a part of the combinations.
struct Counts {
    by_rank: Vec<f64>,
    as_expected: f64,
    tied: f64,
}

/// Returns how often every method takes every rank by the sum of its scores.
///
/// # Arguments
///
/// * `families` — per family its tasks, at least one; every score finite.
/// * `direction` — whether less or more of a sum is better.
///
/// # Errors
///
/// [`CombinationsError`].
pub fn rank_shares(
    families: &[Vec<Candidate>],
    direction: Direction,
) -> Result<RankShares, CombinationsError> {
    let methods = families.iter().flatten().map(|task| task.scores.len()).max().unwrap_or(0);
    if methods > MOST_METHODS || families.len() > MOST_FAMILIES {
        return Err(CombinationsError::TooWide { methods, families: families.len() });
    }
    let product = |counts: &mut dyn Iterator<Item = usize>| {
        counts.fold(1u128, |all, count| all.saturating_mul(count as u128))
    };
    let expected = expected_order(families, methods, direction);
    let mut columns: Vec<Column> = columns(families, direction);
    // The longest is the innermost loop.
    columns.sort_by_key(|column| column.weights.len());
    let distinct = product(&mut columns.iter().map(|column| column.weights.len()));
    if distinct > MOST_COMBINATIONS {
        return Err(CombinationsError::TooMany { distinct });
    }
    let Some((inner, outer)) = columns.split_last() else {
        return Ok(RankShares {
            shares: Vec::new(),
            as_expected: 0.0,
            tied: 0.0,
            combinations: 0,
            distinct: 0,
        });
    };
    let tasks = product(&mut outer.iter().map(|column| column.weights.len())) as u64;
    let parts = PARTS.min(tasks);
    let counted: Vec<Counts> = (0..parts)
        .into_par_iter()
        .map(|part| {
            let range = tasks * part / parts..tasks * (part + 1) / parts;
            count(range, outer, inner, &expected)
        })
        .collect();
    let total: f64 = columns.iter().map(|column| column.weights.iter().sum::<f64>()).product();
    let sum = |of: &dyn Fn(&Counts) -> f64| counted.iter().map(of).sum::<f64>() / total;
    let share = |m: usize, r: usize| sum(&|counts| counts.by_rank[m * methods + r]);
    Ok(RankShares {
        shares: (0..methods).map(|m| (0..methods).map(|r| share(m, r)).collect()).collect(),
        as_expected: sum(&|counts| counts.as_expected),
        tied: sum(&|counts| counts.tied),
        combinations: product(&mut families.iter().map(Vec::len)),
        distinct,
    })
}

/// Returns what a method achieves on average over all combinations: the mean over the families of its mean there.
pub fn expected_score(families: &[Vec<Candidate>], method: usize) -> f64 {
    let of = |tasks: &Vec<Candidate>| {
        let weight: f64 = tasks.iter().map(|task| task.weight).sum();
        tasks.iter().map(|task| task.weight * task.scores[method]).sum::<f64>() / weight
    };
    families.iter().map(of).sum::<f64>() / families.len() as f64
}

fn expected_order(families: &[Vec<Candidate>], methods: usize, direction: Direction) -> Vec<usize> {
    let expected: Vec<f64> = (0..methods).map(|m| expected_score(families, m)).collect();
    let mut order: Vec<usize> = (0..methods).collect();
    order.sort_by(|a, b| direction.compare(expected[*a], expected[*b]));
    order
}

/// Returns the distinct tasks of every family, with smaller numbers for what is better.
fn columns(families: &[Vec<Candidate>], direction: Direction) -> Vec<Column> {
    let scores = families.iter().flatten().flat_map(|task| &task.scores);
    let largest = scores.fold(0.0f64, |most, score| most.max(score.abs()));
    let exponent = if largest > 0.0 { SCORE_BITS - largest.log2().ceil() as i32 } else { 0 };
    let sign = if direction.is_lower() { 1.0 } else { -1.0 };
    // In two steps, since a power of 2 that a tiny score takes is beyond the numbers there are.
    let halves = (exponent / 2, exponent - exponent / 2);
    let whole =
        |score: f64| (sign * score * 2f64.powi(halves.0) * 2f64.powi(halves.1)).round() as i64;
    families
        .iter()
        .map(|tasks| {
            let mut distinct: BTreeMap<Vec<i64>, f64> = BTreeMap::new();
            for task in tasks {
                let of_first = task.scores.first().map_or(0, |score| whole(*score));
                let differences = task.scores.iter().map(|s| whole(*s) - of_first).collect();
                *distinct.entry(differences).or_default() += task.weight;
            }
            let (differences, weights) = distinct.into_iter().unzip();
            Column { differences, weights }
        })
        .collect()
}

fn count(
    range: std::ops::Range<u64>,
    outer: &[Column],
    inner: &Column,
    expected: &[usize],
) -> Counts {
    let methods = expected.len();
    // A decimal is rounded once per family.
    let tolerance = outer.len() as i64 + 1;
    let mut counts = Counts { by_rank: vec![0.0; methods * methods], as_expected: 0.0, tied: 0.0 };
    let (mut sums, mut keys) = ([0i64; MOST_METHODS], [0i64; MOST_METHODS]);
    let keys = &mut keys[..methods];
    for task in range {
        sums[..methods].fill(0);
        let (mut rest, mut weight) = (task, 1.0);
        for column in outer {
            let i = (rest % column.weights.len() as u64) as usize;
            rest /= column.weights.len() as u64;
            weight *= column.weights[i];
            sums.iter_mut().zip(&column.differences[i]).for_each(|(sum, d)| *sum += d);
        }
        for (differences, own) in inner.differences.iter().zip(&inner.weights) {
            for (m, key) in keys.iter_mut().enumerate() {
                *key = ((sums[m] + differences[m]) << METHOD_BITS) | m as i64;
            }
            keys.sort_unstable();
            add(&mut counts, keys, weight * own, tolerance, expected);
        }
    }
    counts
}

/// Adds a combination whose methods are sorted, best first.
fn add(counts: &mut Counts, keys: &[i64], weight: f64, tolerance: i64, expected: &[usize]) {
    let methods = keys.len();
    let method = |key: i64| (key & ((1 << METHOD_BITS) - 1)) as usize;
    let (mut rank, mut tied) = (0, false);
    while rank < methods {
        let limit = (keys[rank] >> METHOD_BITS) + tolerance;
        let mut end = rank + 1;
        while end < methods && keys[end] >> METHOD_BITS <= limit {
            end += 1;
        }
        if end == rank + 1 {
            counts.by_rank[method(keys[rank]) * methods + rank] += weight;
        } else {
            tied = true;
            let share = weight / (end - rank) as f64;
            for key in &keys[rank..end] {
                let row = method(*key) * methods;
                counts.by_rank[row + rank..row + end].iter_mut().for_each(|c| *c += share);
            }
        }
        rank = end;
    }
    if tied {
        counts.tied += weight;
    } else if keys.iter().zip(expected).all(|(key, m)| method(*key) == *m) {
        counts.as_expected += weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn equal(scores: &[&[f64]]) -> Vec<Candidate> {
        scores.iter().map(|s| Candidate { scores: s.to_vec(), weight: 1.0 }).collect()
    }

    #[test]
    fn two_families_of_two_tasks_by_hand() {
        // Sums: (1+1, 2+4), (1+5, 2+1), (3+1, 1+4), (3+5, 1+1).
        let families = [equal(&[&[1.0, 2.0], &[3.0, 1.0]]), equal(&[&[1.0, 4.0], &[5.0, 1.0]])];
        let found = rank_shares(&families, Direction::Lower).unwrap();
        assert_eq!(found.shares, [[0.5, 0.5], [0.5, 0.5]]);
        assert_eq!((found.combinations, found.distinct, found.tied), (4, 4, 0.0));
        let weighted = [
            families[0].clone(),
            vec![
                Candidate { weight: 3.0, ..families[1][0].clone() },
                Candidate { weight: 1.0, ..families[1][1].clone() },
            ],
        ];
        assert_eq!(rank_shares(&weighted, Direction::Lower).unwrap().shares[0], [0.75, 0.25]);
        assert_eq!(rank_shares(&weighted, Direction::Higher).unwrap().shares[0], [0.25, 0.75]);
    }

    #[test]
    fn methods_that_tie_share_their_ranks() {
        // 0.1 + 0.2 and 0.3 + 0 differ in the last bit as floating-point numbers.
        let families = [equal(&[&[0.1, 0.3, 9.0]]), equal(&[&[0.2, 0.0, 9.0]])];
        let found = rank_shares(&families, Direction::Lower).unwrap();
        assert_eq!(found.shares, [[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!((found.tied, found.as_expected), (1.0, 0.0));
    }

    #[test]
    fn tasks_that_differ_by_a_constant_are_looked_at_once() {
        let families = [equal(&[&[1.0, 2.0], &[5.0, 6.0], &[2.0, 1.0]]), equal(&[&[0.0, 0.5]])];
        let found = rank_shares(&families, Direction::Lower).unwrap();
        assert_eq!((found.combinations, found.distinct), (3, 2));
        assert!((found.shares[0][0] - 2.0 / 3.0).abs() < 1e-15);
        assert!((found.as_expected - 2.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn tiny_and_huge_scores_are_told_apart() {
        for unit in [1e-300, 1.0, 1e300] {
            let families = [equal(&[&[unit, 2.0 * unit]]), equal(&[&[3.0 * unit, unit]])];
            let found = rank_shares(&families, Direction::Lower).unwrap();
            assert_eq!(found.shares[1], [1.0, 0.0], "{unit}");
        }
    }

    #[test]
    fn more_than_can_be_looked_at_is_refused() {
        let family: Vec<Candidate> =
            (0..60).map(|i| Candidate { scores: vec![0.0, f64::from(i)], weight: 1.0 }).collect();
        let e = rank_shares(&vec![family; 7], Direction::Lower).unwrap_err();
        assert_eq!(e, CombinationsError::TooMany { distinct: 60u128.pow(7) });
        let wide = [equal(&[&[0.0; 33]])];
        let e = rank_shares(&wide, Direction::Lower).unwrap_err();
        assert_eq!(e, CombinationsError::TooWide { methods: 33, families: 1 });
    }

    fn families() -> impl Strategy<Value = Vec<Vec<Candidate>>> {
        // Few different scores, so that there are ties.
        let scores = prop::collection::vec((0i32..8).prop_map(|n| f64::from(n) / 10.0), 3);
        let task = (scores, 0.1f64..2.0).prop_map(|(scores, weight)| Candidate { scores, weight });
        prop::collection::vec(prop::collection::vec(task, 1..6), 1..4)
    }

    /// Ranks every combination in the plainest way, with sums in tenths.
    fn by_hand(families: &[Vec<Candidate>], direction: Direction) -> Vec<Vec<f64>> {
        let mut all = vec![(vec![0i64; 3], 1.0)];
        for family in families {
            all = all
                .iter()
                .flat_map(|(sums, weight)| {
                    family.iter().map(move |task| {
                        let tenths = task.scores.iter().map(|s| (s * 10.0).round() as i64);
                        let sums = sums.iter().zip(tenths).map(|(a, b)| a + b).collect();
                        (sums, weight * task.weight)
                    })
                })
                .collect();
        }
        let total: f64 = all.iter().map(|(_, weight)| weight).sum();
        let mut shares = vec![vec![0.0; 3]; 3];
        for (sums, weight) in all {
            for m in 0..3 {
                let better = |n: &i64| match direction {
                    Direction::Lower => *n < sums[m],
                    Direction::Higher => *n > sums[m],
                };
                let first = sums.iter().filter(|n| better(n)).count();
                let like = sums.iter().filter(|n| **n == sums[m]).count();
                for share in &mut shares[m][first..first + like] {
                    *share += weight / total / like as f64;
                }
            }
        }
        shares
    }

    proptest! {
        #[test]
        fn it_is_what_ranking_every_combination_gives(families in families(), lower: bool) {
            let direction = if lower { Direction::Lower } else { Direction::Higher };
            let found = rank_shares(&families, direction).unwrap();
            for (a, b) in found.shares.iter().flatten().zip(by_hand(&families, direction).iter().flatten()) {
                prop_assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
        }

        #[test]
        fn neither_the_order_of_the_families_nor_a_scale_of_weights_matters(
            families in families(), scale in 0.1f64..9.0,
        ) {
            let mut other = families.clone();
            other.reverse();
            other[0].iter_mut().for_each(|task| task.weight *= scale);
            let (a, b) = (
                rank_shares(&families, Direction::Lower).unwrap(),
                rank_shares(&other, Direction::Lower).unwrap(),
            );
            for (a, b) in a.shares.iter().flatten().zip(b.shares.iter().flatten()) {
                prop_assert!((a - b).abs() < 1e-12);
            }
        }
    }
}
