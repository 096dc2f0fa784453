//! M3: k-means over standardised features.
//!
//! Choices where implementations differ:
//! - Features are standardised with the family's unweighted mean and standard deviation; a
//!   feature that never varies counts for nothing.
//! - k-means++ seeding and Lloyd's iterations, best of 20 starts by inertia.
//! - A cluster that runs empty is given the point farthest from its centroid.
//! - Each centroid is matched to the nearest point MDP **of its own cluster**, so that no point
//!   MDP stands for two clusters.
//!
//! Source: Jayawardana et al. (NeurIPS 2022), appendix, M3; D. Arthur and S. Vassilvitskii,
//! "k-means++: the advantages of careful seeding", SODA 2007.

use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::random::Chosen;
use super::tree::{Tree, squared_distance};
use basics::seed::derive;

/// Independent starts, of which the best is kept.
const RESTARTS: usize = 20;

/// Most iterations of one start; these sizes converge in about ten.
const MAX_ITERATIONS: usize = 300;

/// Clusters of rows: the cluster of each row and the sum of squared distances to the centroids.
#[derive(Debug, Clone, PartialEq)]
pub struct Clustering {
    /// Centroids, `k` rows.
    pub centroids: Vec<Vec<f64>>,
    /// Cluster of each row.
    pub labels: Vec<usize>,
    /// Sum over rows of the squared distance to their centroid.
    pub inertia: f64,
}

/// Returns the rows with every column shifted to mean 0 and scaled to standard deviation 1.
pub fn standardise(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = rows.first().map_or(0, Vec::len);
    let n = rows.len() as f64;
    let mut out = vec![vec![0.0; columns]; rows.len()];
    for c in 0..columns {
        let mean = rows.iter().map(|r| r[c]).sum::<f64>() / n;
        let sd = (rows.iter().map(|r| (r[c] - mean).powi(2)).sum::<f64>() / n).sqrt();
        if sd > 0.0 {
            for (o, r) in out.iter_mut().zip(rows) {
                o[c] = (r[c] - mean) / sd;
            }
        }
    }
    out
}

/// Clusters rows into `k` clusters, none of them empty.
///
/// `k` must be between 1 and the number of rows.
pub fn cluster(rows: &[Vec<f64>], k: usize, seed: u64) -> Clustering {
    let tree = Tree::of(rows, (0..rows.len()).collect());
    let start = |restart: usize| {
        let seed = derive(seed, &["sample", "k-means", &restart.to_string()]);
        lloyd(rows, plus_plus(rows, &tree, k, &mut ChaCha8Rng::seed_from_u64(seed)))
    };
    let starts: Vec<Clustering> = (0..RESTARTS).into_par_iter().map(start).collect();
    starts
        .into_iter()
        .min_by(|a, b| a.inertia.total_cmp(&b.inertia))
        .expect("there is at least one restart")
}

/// Returns the representatives of `k` clusters, in the order of the rows: index, importance of
/// the cluster, size of the cluster.
pub(super) fn representatives(
    features: &[Vec<f64>],
    importance: &[f64],
    k: usize,
    seed: u64,
) -> Vec<Chosen> {
    let rows = standardise(features);
    let clustering = cluster(&rows, k, seed);
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); k];
    clustering.labels.iter().enumerate().for_each(|(i, label)| members[*label].push(i));
    let of_cluster = |(c, members): (usize, &Vec<usize>)| {
        let distance = |i: usize| squared_distance(&rows[i], &clustering.centroids[c]);
        let nearest = members.iter().copied().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let nearest = nearest.expect("no cluster is empty");
        (nearest, members.iter().map(|i| importance[*i]).sum(), members.len() as u32)
    };
    let mut chosen: Vec<Chosen> = members.iter().enumerate().map(of_cluster).collect();
    chosen.sort_unstable_by_key(|c| c.0);
    chosen
}

/// Returns the cluster of each row, the same as [`representatives`] has.
pub(super) fn labels(features: &[Vec<f64>], k: usize, seed: u64) -> Vec<usize> {
    cluster(&standardise(features), k, seed).labels
}

/// Returns the first centroids.
///
/// # Arguments
///
/// * `tree` — of all rows.
fn plus_plus(rows: &[Vec<f64>], tree: &Tree<'_>, k: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut centroids = vec![rows[rng.random_range(0..rows.len())].clone()];
    let mut reach = Reach {
        tree,
        nearest: vec![f64::INFINITY; rows.len()],
        farthest: vec![f64::INFINITY; tree.len()],
    };
    while centroids.len() < k {
        reach.add(rows, Tree::ROOT, centroids.last().expect("there is a first centroid"));
        // All rows coincide with a centroid when there are fewer distinct rows than clusters.
        let next = match WeightedIndex::new(&reach.nearest) {
            Ok(weights) => weights.sample(rng),
            Err(_) => rng.random_range(0..rows.len()),
        };
        centroids.push(rows[next].clone());
    }
    centroids
}

/// How far rows are from the nearest centroid, and the farthest of every box of a tree.
struct Reach<'a> {
    tree: &'a Tree<'a>,
    nearest: Vec<f64>,
    farthest: Vec<f64>,
}

impl Reach<'_> {
    /// Adds a centroid, for the rows of a box: of most boxes all rows have a nearer one.
    fn add(&mut self, rows: &[Vec<f64>], node: usize, centroid: &[f64]) {
        if self.tree.distance(node, centroid) >= self.farthest[node] {
            return;
        }
        self.farthest[node] = match self.tree.halves(node) {
            Some(halves) => {
                halves.iter().for_each(|half| self.add(rows, *half, centroid));
                halves.iter().map(|half| self.farthest[*half]).fold(0.0, f64::max)
            }
            None => {
                let mut farthest: f64 = 0.0;
                for row in self.tree.rows(node) {
                    let nearest = &mut self.nearest[*row];
                    *nearest = nearest.min(squared_distance(&rows[*row], centroid));
                    farthest = farthest.max(*nearest);
                }
                farthest
            }
        };
    }
}

fn lloyd(rows: &[Vec<f64>], mut centroids: Vec<Vec<f64>>) -> Clustering {
    let mut labels = vec![usize::MAX; rows.len()];
    for _ in 0..MAX_ITERATIONS {
        let mut next = nearest_of_all(rows, &labels, &centroids);
        fill_empty(rows, &centroids, &mut next);
        if next == labels {
            break;
        }
        labels = next;
        let mut members = vec![0.0; centroids.len()];
        centroids.iter_mut().for_each(|centroid| centroid.fill(0.0));
        for (row, label) in rows.iter().zip(&labels) {
            members[*label] += 1.0;
            centroids[*label].iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        }
        for (centroid, members) in centroids.iter_mut().zip(members) {
            centroid.iter_mut().for_each(|sum| *sum /= members);
        }
    }
    let inertia = rows.iter().zip(&labels).map(|(r, l)| squared_distance(r, &centroids[*l])).sum();
    Clustering { centroids, labels, inertia }
}

/// Part of a distance that rounding may add or take, and far more.
const ROUNDING: f64 = 1e-9;

/// Most centroids of which all distances from one another are computed; a tree finds the nearest of more sooner.
const MOST_COMPARED: usize = 500;

/// Returns the nearest centroid of every row, of equally near ones the first.
///
/// # Arguments
///
/// * `labels` — which it was the last time, if any: most have the same again.
fn nearest_of_all(rows: &[Vec<f64>], labels: &[usize], centroids: &[Vec<f64>]) -> Vec<usize> {
    let guess = |label: usize| if label < centroids.len() { label } else { 0 };
    let all = rows.iter().zip(labels).map(|(row, label)| (row, guess(*label)));
    if centroids.len() > MOST_COMPARED {
        let tree = Tree::of(centroids, (0..centroids.len()).collect());
        return all.map(|(row, guess)| tree.nearest(row, guess)).collect();
    }
    let between = between(centroids);
    all.map(|(row, guess)| nearest(row, guess, centroids, &between[guess])).collect()
}

/// Returns a quarter of the squared distances of the centroids from one another, a row per centroid, less what rounding
/// may add.
fn between(centroids: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let quarter = |a: &[f64], b: &[f64]| squared_distance(a, b) / 4.0 * (1.0 - ROUNDING);
    centroids.iter().map(|a| centroids.iter().map(|b| quarter(a, b)).collect()).collect()
}

/// Returns the nearest centroid, of equally near ones the first.
///
/// # Arguments
///
/// * `between` — of the guess: one that is twice as far from that as the row is cannot be it.
fn nearest(row: &[f64], guess: usize, centroids: &[Vec<f64>], between: &[f64]) -> usize {
    let mut least = squared_distance(row, &centroids[guess]);
    let excludes = least;
    let mut found = guess;
    for (c, (centroid, quarter)) in centroids.iter().zip(between).enumerate() {
        if c == guess || *quarter > excludes {
            continue;
        }
        let distance = squared_distance(row, centroid);
        if distance < least || (distance == least && c < found) {
            (least, found) = (distance, c);
        }
    }
    found
}

/// Gives every empty cluster the row farthest from its centroid among clusters of at least two.
fn fill_empty(rows: &[Vec<f64>], centroids: &[Vec<f64>], labels: &mut [usize]) {
    let mut sizes = vec![0usize; centroids.len()];
    for l in labels.iter() {
        sizes[*l] += 1;
    }
    let empty: Vec<usize> = (0..centroids.len()).filter(|c| sizes[*c] == 0).collect();
    if empty.is_empty() {
        return;
    }
    // Of equally far ones the last. Whoever is alone in a cluster stays so.
    let of = |(i, row): (usize, &Vec<f64>)| (squared_distance(row, &centroids[labels[i]]), i);
    let mut farthest: Vec<(f64, usize)> = rows.iter().enumerate().map(of).collect();
    farthest.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for c in empty {
        let row = loop {
            let (_, row) = farthest.pop().expect("there are at least as many rows as clusters");
            if sizes[labels[row]] > 1 {
                break row;
            }
        };
        sizes[labels[row]] -= 1;
        sizes[c] = 1;
        labels[row] = c;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_groups_are_found_and_weighted_by_their_importance() {
        let rows: Vec<_> = [0.0, 0.1, 0.2, 9.0, 9.1].iter().map(|x| vec![*x, 7.0]).collect();
        let chosen = representatives(&rows, &[0.2, 0.2, 0.2, 0.2, 0.2], 2, 0);
        assert_eq!(chosen[0].0, 1);
        assert_eq!((chosen[0].2, chosen[1].2), (3, 2));
        assert!((chosen[0].1 - 0.6).abs() < 1e-12);
    }

    #[test]
    fn equal_rows_still_make_k_clusters() {
        let rows = vec![vec![1.0]; 4];
        let clustering = cluster(&rows, 3, 0);
        let mut labels = clustering.labels;
        labels.sort_unstable();
        labels.dedup();
        assert_eq!(labels, [0, 1, 2]);
    }

    #[test]
    fn a_feature_that_never_varies_counts_for_nothing() {
        assert_eq!(standardise(&[vec![5.0, 1.0], vec![5.0, 3.0]]), [[0.0, -1.0], [0.0, 1.0]]);
    }

    #[test]
    fn whether_all_are_compared_or_a_tree_is_asked_the_nearest_is_the_same() {
        let row = |i: usize| vec![(i * i % 97) as f64, (i % 31) as f64, (i * 7 % 13) as f64];
        let rows: Vec<Vec<f64>> = (0..2000).map(row).collect();
        let centroids: Vec<Vec<f64>> = rows.iter().step_by(3).cloned().collect();
        assert!(centroids.len() > MOST_COMPARED);
        let labels: Vec<usize> = (0..rows.len()).map(|i| i * 11 % 700).collect();
        let between = between(&centroids);
        let guess = |label: usize| if label < centroids.len() { label } else { 0 };
        let compared = rows
            .iter()
            .zip(&labels)
            .map(|(row, label)| nearest(row, guess(*label), &centroids, &between[guess(*label)]));
        assert_eq!(nearest_of_all(&rows, &labels, &centroids), compared.collect::<Vec<_>>());
    }

    #[test]
    fn more_restarts_never_make_it_worse() {
        let rows: Vec<_> = (0..40).map(|i| vec![f64::from(i * i % 17), f64::from(i % 7)]).collect();
        let best = cluster(&rows, 6, 0).inertia;
        let tree = Tree::of(&rows, (0..rows.len()).collect());
        for restart in 0..RESTARTS {
            let seed = derive(0, &["sample", "k-means", &restart.to_string()]);
            let one =
                lloyd(&rows, plus_plus(&rows, &tree, 6, &mut ChaCha8Rng::seed_from_u64(seed)));
            assert!(best <= one.inertia);
        }
    }
}
