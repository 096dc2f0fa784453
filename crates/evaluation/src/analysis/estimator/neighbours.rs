//! Contrasts between neighbours: the spread that is left where samples are spread over what is known.

use super::contract::Chosen;
use crate::stats::resampling::Contrast;

/// Returns the contrasts of the local mean variance estimator: every point MDP against the mean of itself and its
/// nearest neighbours in the sample.
pub(super) fn local_means(
    points: &[Chosen],
    weights: &[f64],
    inclusion: &[f64],
    neighbours: usize,
) -> Vec<Contrast> {
    let total: f64 = weights.iter().sum();
    let n = points.len();
    let k = neighbours.min(n.saturating_sub(1));
    let mut contrasts = Vec::with_capacity(n);
    for i in 0..n {
        let scale = (1.0 - inclusion[i]).max(0.0);
        if scale == 0.0 || k == 0 {
            contrasts.push(Contrast::new());
            continue;
        }
        let scale = (scale * (k + 1) as f64 / k as f64).sqrt() / total;
        let group = nearest(points, i, k);
        let share = scale / (k + 1) as f64;
        let mut contrast: Contrast = group.iter().map(|j| (*j, -share * weights[*j])).collect();
        contrast.push((i, (scale - share) * weights[i]));
        contrasts.push(contrast);
    }
    contrasts
}

/// Returns the `k` nearest others, nearest first, of equally near ones the first.
pub(super) fn nearest(points: &[Chosen], i: usize, k: usize) -> Vec<usize> {
    let distance = |j: usize| -> f64 {
        points[i].at.iter().zip(&points[j].at).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let mut others: Vec<(f64, usize)> =
        (0..points.len()).filter(|j| *j != i).map(|j| (distance(j), j)).collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    others.into_iter().take(k).map(|(_, j)| j).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Resampling;

    fn points(at: &[f64]) -> Vec<Chosen> {
        at.iter().map(|x| Chosen { at: vec![*x], ..Chosen::default() }).collect()
    }

    fn standard_error(at: &[f64], values: &[f64], pi: f64, k: usize) -> f64 {
        let weights = vec![1.0; at.len()];
        let contrasts = local_means(&points(at), &weights, &vec![pi; at.len()], k);
        Resampling::of(contrasts, at.len() as f64 - 1.0).standard_error(&weights, values)
    }

    #[test]
    fn with_all_neighbours_it_is_that_of_independent_draws() {
        let values = [1.0, 2.0, 4.0, 9.0];
        let se = standard_error(&[0.0, 1.0, 2.0, 3.0], &values, 0.2, 3);
        let variance = values.iter().map(|y| (y - 4.0f64).powi(2)).sum::<f64>() / 3.0;
        assert!((se - (0.8 * variance / 4.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_follows_the_coordinates_adds_little() {
        let at: Vec<f64> = (0..20).map(f64::from).collect();
        let rough: Vec<f64> = (0..20).map(|i| f64::from(i * 7 % 20)).collect();
        assert!(4.0 * standard_error(&at, &at, 0.2, 2) < standard_error(&at, &rough, 0.2, 2));
    }

    #[test]
    fn a_sample_of_everything_has_empty_contrasts() {
        let of = |at: &[f64], pi: f64| {
            local_means(&points(at), &vec![1.0; at.len()], &vec![pi; at.len()], 4)
        };
        assert_eq!(of(&[0.0, 1.0], 1.0), vec![Contrast::new(); 2]);
        assert_eq!(of(&[0.0], 0.3), vec![Contrast::new()]);
    }
}
