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
use crate::seed::derive;

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
    let start = |restart: usize| {
        let seed = derive(seed, &["sample", "k-means", &restart.to_string()]);
        lloyd(rows, plus_plus(rows, k, &mut ChaCha8Rng::seed_from_u64(seed)))
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

/// Returns the squared Euclidean distance of two rows.
pub(super) fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum()
}

fn plus_plus(rows: &[Vec<f64>], k: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut centroids = vec![rows[rng.random_range(0..rows.len())].clone()];
    let mut nearest = vec![f64::INFINITY; rows.len()];
    while centroids.len() < k {
        let latest = centroids.last().expect("there is a first centroid");
        for (d, row) in nearest.iter_mut().zip(rows) {
            *d = d.min(squared_distance(row, latest));
        }
        // All rows coincide with a centroid when there are fewer distinct rows than clusters.
        let next = match WeightedIndex::new(&nearest) {
            Ok(weights) => weights.sample(rng),
            Err(_) => rng.random_range(0..rows.len()),
        };
        centroids.push(rows[next].clone());
    }
    centroids
}

fn lloyd(rows: &[Vec<f64>], mut centroids: Vec<Vec<f64>>) -> Clustering {
    let mut labels = vec![usize::MAX; rows.len()];
    for _ in 0..MAX_ITERATIONS {
        let between = between(&centroids);
        let of = |(row, label): (&Vec<f64>, &usize)| nearest(row, *label, &centroids, &between);
        let mut next: Vec<usize> = rows.iter().zip(&labels).map(of).collect();
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

/// Most centroids of which all distances are kept: 32 MB.
const MOST_KEPT: usize = 2000;

/// Returns a quarter of the squared distances of the centroids from one another, a row per centroid, less what rounding may
/// add; rows are empty where centroids are too many.
fn between(centroids: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let others = if centroids.len() > MOST_KEPT { &[] } else { centroids };
    let quarter = |a: &[f64], b: &[f64]| squared_distance(a, b) / 4.0 * (1.0 - ROUNDING);
    centroids.iter().map(|a| others.iter().map(|b| quarter(a, b)).collect()).collect()
}

/// Returns the nearest centroid, of equally near ones the first.
///
/// # Arguments
///
/// * `last` — which it was the last time, if any; one that is twice as far from that one as the row is cannot be it.
/// * `between` — see [`between`].
fn nearest(row: &[f64], last: usize, centroids: &[Vec<f64>], between: &[Vec<f64>]) -> usize {
    let guess = if last < centroids.len() { last } else { 0 };
    let mut least = squared_distance(row, &centroids[guess]);
    let (from_guess, excludes) = (&between[guess], least);
    let mut found = guess;
    for (c, centroid) in centroids.iter().enumerate() {
        if c == guess || from_guess.get(c).is_some_and(|quarter| *quarter > excludes) {
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
    for c in 0..centroids.len() {
        if sizes[c] > 0 {
            continue;
        }
        let farthest = (0..rows.len())
            .filter(|i| sizes[labels[*i]] > 1)
            .max_by(|a, b| {
                let d = |i: usize| squared_distance(&rows[i], &centroids[labels[i]]);
                d(*a).total_cmp(&d(*b))
            })
            .expect("there are at least as many rows as clusters");
        sizes[labels[farthest]] -= 1;
        sizes[c] = 1;
        labels[farthest] = c;
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
    fn more_restarts_never_make_it_worse() {
        let rows: Vec<_> = (0..40).map(|i| vec![f64::from(i * i % 17), f64::from(i % 7)]).collect();
        let best = cluster(&rows, 6, 0).inertia;
        for restart in 0..RESTARTS {
            let seed = derive(0, &["sample", "k-means", &restart.to_string()]);
            let one = lloyd(&rows, plus_plus(&rows, 6, &mut ChaCha8Rng::seed_from_u64(seed)));
            assert!(best <= one.inertia);
        }
    }
}
