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

use super::Chosen;
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

/// Returns the representatives of `k` clusters, in the order of the rows: index, importance of the cluster, size of the cluster.
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
fn plus_plus(rows: &[Vec<f64>], k: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut centroids = vec![rows[rng.random_range(0..rows.len())].clone()];
    let mut distances = vec![f64::INFINITY; rows.len()];
    while centroids.len() < k {
        let last = centroids.last().expect("there is a first centroid");
        for (distance, row) in distances.iter_mut().zip(rows) {
            *distance = distance.min(squared_distance(row, last));
        }
        // All rows coincide with a centroid when there are fewer distinct rows than clusters.
        let next = match WeightedIndex::new(&distances) {
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
        let mut next: Vec<usize> = rows.iter().map(|row| nearest(row, &centroids)).collect();
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

/// Returns the nearest centroid, of equally near ones the first.
fn nearest(row: &[f64], centroids: &[Vec<f64>]) -> usize {
    let (mut least, mut found) = (f64::INFINITY, 0);
    for (c, centroid) in centroids.iter().enumerate() {
        let distance = squared_distance(row, centroid);
        if distance < least {
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

/// Returns the squared Euclidean distance of two rows.
pub(super) fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum()
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
    fn of_equally_near_centroids_the_first_counts() {
        let centroids = [[5.0], [1.0], [3.0], [1.0]].map(|c| c.to_vec());
        assert_eq!(nearest(&[2.0], &centroids), 1);
        assert_eq!(nearest(&[2.5], &centroids), 2);
    }
}
