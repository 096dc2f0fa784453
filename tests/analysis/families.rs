//! Made-up families of any task: what every method achieves on every point MDP.

use std::fs;
use std::path::Path;

use serde_json::json;
use tsc_family::family::Feature;
use tsc_family::stats::Direction;
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Identity, Manifest, PointRow, Provenance};
use tsc_family::store::record::{Metrics, Record, Row, RowKind, TaskResult};

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
        let point = |(id, importance, size, _): &(String, f64, f64, Vec<Option<f64>>)| PointRow {
            point: id.clone(),
            title: String::new(),
            importance: *importance,
            instances: 1,
            features: vec![*size],
            places: Vec::new(),
            content: String::new(),
            environment: id.clone(),
            sha256: Default::default(),
            given: Default::default(),
        };
        let draws = self.points.iter();
        let draws =
            draws.map(|(id, weight, _, _)| json!({"point": id, "weight": weight, "count": 1}));
        let sample = json!({
            "sampling": "all",
            "budget": self.points.len(),
            "family_size": self.points.len(),
            "seed": 0,
            "draws": draws.collect::<Vec<_>>(),
        });
        Manifest {
            identity: Identity {
                domain: "river".into(),
                direction: self.direction,
                schema_version: 1,
                tsc_family: "0.1.0".into(),
                simulator: "water".into(),
                scenario: "swimmer".into(),
                settings: json!({}),
                features: vec![Feature { name: "size_m".into(), unit: "m".into() }],
                // As in a file, in which what was added later has a default.
                sample: serde_json::from_value(sample).unwrap(),
                points: self.points.iter().map(point).collect(),
                methods: self.methods.iter().map(|m| (*m).to_owned()).collect(),
                controllers: vec![],
                baseline: self.baseline.into(),
                objective: self.objective.into(),
                replicates: 1,
                replicated: vec![],
                base_seed: 0,
                evaluation_seeds: vec![1_073_741_825],
            },
            provenance: Provenance {
                command: "tsc-family run swimmer".into(),
                git: "abc1234".into(),
                rustc: "rustc 1.95.0".into(),
                host: "Linux x86_64".into(),
                started: "2026-01-01T00:00:00Z".into(),
                networks: String::new(),
                warnings: vec![],
                memory_per_worker_mb: None,
                assisting: None,
            },
        }
    }

    pub(crate) fn write(&self, root: &Path) -> Layout {
        self.write_with(root, &self.manifest())
    }

    pub(crate) fn write_with(&self, root: &Path, manifest: &Manifest) -> Layout {
        fs::create_dir_all(root).unwrap();
        let layout = Layout::new(root);
        fs::write(layout.manifest(), serde_json::to_string(manifest).unwrap()).unwrap();
        let sha256 = manifest.sha256();
        for task in manifest.identity.tasks() {
            let point = self.points.iter().find(|p| p.0 == task.point).unwrap();
            let method = self.methods.iter().position(|m| *m == task.method).unwrap();
            if let Some(value) = point.3[method] {
                let values =
                    [(self.objective.to_owned(), value), ("effort_j".to_owned(), 10.0 * value)];
                let (kind, metrics) = (RowKind::Evaluation, Metrics::from(values));
                let rows = vec![Row { kind, episode: 0, seed: 1_073_741_825, metrics }];
                let result = TaskResult { rows, ..TaskResult::default() };
                Record::finished(&task, &sha256, result).commit(&layout).unwrap();
            }
        }
        layout
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
