//! That clusters of intersections with their own arms are of one kind, over the embedded city.

use std::collections::BTreeMap;

use tsc_family::sample::kmeans::{cluster, standardise};
use tsc_family::sample::{Sampling, choose};
use tsc_family::traffic::family::load::load_with;

const BUDGET: usize = 40;

const MEANS: usize = 6;

fn purity(labels: &[usize], values: &[String]) -> f64 {
    let mut of_cluster: BTreeMap<usize, BTreeMap<&String, usize>> = BTreeMap::new();
    for (label, value) in labels.iter().zip(values) {
        *of_cluster.entry(*label).or_default().entry(value).or_default() += 1;
    }
    let most = of_cluster.values().map(|counts| counts.values().max().unwrap());
    most.sum::<usize>() as f64 / values.len() as f64
}

#[test]
fn clusters_of_real_intersections_differ_less_in_what_describes_them() {
    let detail = "family.detail=per-approach".parse().unwrap();
    let family = load_with("salt-lake-city", &[detail]).unwrap().family;
    let means: Vec<Vec<f64>> = family.points.iter().map(|p| p.features.clone()).collect();
    assert!(family.describing.iter().zip(&means).all(|(row, means)| row[..MEANS] == means[..]));
    // Arms, one-way arms, and from how many approaches each turn exists.
    let kinds = |columns: std::ops::Range<usize>| -> Vec<String> {
        family.describing.iter().map(|row| format!("{:.2?}", &row[columns.clone()])).collect()
    };
    for (name, columns) in [("arms", 6..7), ("one-way arms", 7..8), ("movements", 8..11)] {
        let kinds = kinds(columns);
        let [before, after] = [&means, &family.describing]
            .map(|rows| purity(&cluster(&standardise(rows), BUDGET, 0).labels, &kinds));
        println!("{name}: {:.1}% before, {:.1}% after", 100.0 * before, 100.0 * after);
        assert!(after > before, "{name}: {before} {after}");
    }
}

#[test]
fn the_whole_family_has_its_own_importance_whatever_describes_it() {
    let detail = "family.detail=per-approach".parse().unwrap();
    let family = load_with("salt-lake-city", &[detail]).unwrap().family;
    let mut plain = family.clone();
    plain.describing.clear();
    let all = |family| choose(family, Sampling::All, family.points.len(), 0).unwrap();
    assert_eq!(all(&family), all(&plain));
}
