//! Made-up families of any task: what every method achieves on every point MDP.

use std::fs;
use std::path::Path;

use crate::made_up;
use tsc_family::family::Feature;
use tsc_family::sample::Draw;
use tsc_family::stats::Direction;
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, PointRow};

/// A family: its methods, and per point MDP id, importance, size and what each method achieves; `None` has no record.
pub(crate) struct MadeUp<'a> {
    pub(crate) objective: &'a str,
    pub(crate) direction: Direction,
    pub(crate) baseline: &'a str,
    pub(crate) methods: &'a [&'a str],
    pub(crate) points: Vec<(String, f64, f64, Vec<Option<f64>>)>,
}

impl MadeUp<'_> {
    pub(crate) fn manifest(&self) -> Manifest {
        let mut manifest = made_up::manifest(self.methods);
        let (point, draw) = made_up::pattern(&manifest);
        let identity = &mut manifest.identity;
        let point = |(id, importance, size, _): &(String, f64, f64, Vec<Option<f64>>)| PointRow {
            point: id.clone(),
            importance: *importance,
            instances: 1,
            features: vec![*size],
            places: Vec::new(),
            environment: id.clone(),
            sha256: Default::default(),
            ..point.clone()
        };
        let draw = |(id, weight, ..): &(String, f64, f64, Vec<Option<f64>>)| Draw {
            point: id.clone(),
            weight: *weight,
            ..draw.clone()
        };
        identity.points = self.points.iter().map(point).collect();
        identity.sample.draws = self.points.iter().map(draw).collect();
        (identity.sample.budget, identity.sample.family_size) =
            (self.points.len(), self.points.len());
        (identity.domain, identity.scenario) = ("river".into(), "swimmer".into());
        (identity.simulator, identity.settings) = ("water".into(), serde_json::json!({}));
        identity.features = vec![Feature { name: "size_m".into(), unit: "m".into() }];
        (identity.direction, identity.objective) = (self.direction, self.objective.into());
        identity.baseline = self.baseline.into();
        identity.evaluation_seeds.truncate(1);
        manifest.provenance.command = "tsc-family run swimmer".into();
        manifest.provenance.networks = String::new();
        manifest
    }

    pub(crate) fn write(&self, root: &Path) -> Layout {
        self.write_with(root, &self.manifest())
    }

    pub(crate) fn write_with(&self, root: &Path, manifest: &Manifest) -> Layout {
        fs::create_dir_all(root).unwrap();
        made_up::write_results(root, manifest, |task| {
            let point = self.points.iter().find(|p| p.0 == task.point).unwrap();
            let method = self.methods.iter().position(|m| *m == task.method).unwrap();
            let value = point.3[method]?;
            let mut rows = made_up::evaluations(&[value]);
            let metrics =
                [(self.objective.to_owned(), value), ("effort_j".to_owned(), 10.0 * value)];
            rows[0].metrics = metrics.into();
            Some(made_up::done(rows))
        })
    }
}

/// Point MDPs of equal importance, called `p0`, `p1`, ..., of sizes 1, 2, ... m.
pub(crate) fn equal(values: &[&[f64]]) -> Vec<(String, f64, f64, Vec<Option<f64>>)> {
    let weight = 1.0 / values.len() as f64;
    let point = |(i, values): (usize, &&[f64])| {
        let values = values.iter().map(|v| Some(*v)).collect();
        (format!("p{i}"), weight, (i + 1) as f64, values)
    };
    values.iter().enumerate().map(point).collect()
}
