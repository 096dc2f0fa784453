//! A method as `--json` prints it.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::whole::{Report, Runs};
use crate::analysis::{Estimated, MethodSummary};
use crate::store::manifest::Manifest;

impl Report {
    /// Returns the methods as `--json` prints them, best first; `null` is what is not known.
    pub fn json_rows(&self) -> Vec<Map<String, Value>> {
        self.methods.iter().map(|m| json_row(self, m)).collect()
    }
}

impl Runs {
    /// Returns the runs that are compared as `--json` prints them.
    pub fn json(&self) -> Value {
        let run = |(name, path, manifest): &(String, String, Arc<Manifest>)| {
            let (i, p) = (&manifest.identity, &manifest.provenance);
            json!({
                "run": name,
                "path": path,
                "simulator": i.simulator,
                "tsc_family": i.tsc_family,
                "git": p.git,
                "manifest": manifest.sha256(),
            })
        };
        let runs: Vec<Value> = self.sources.iter().map(run).collect();
        json!({"event": "compare", "runs": runs, "differences": self.differences})
    }
}

fn json_row(data: &Report, m: &MethodSummary) -> Map<String, Value> {
    let objective = &data.manifest.identity.objective;
    let overall = m.overall.map(|value| Estimated { value, interval: m.interval });
    let against = (!data.reference.is_none()).then(|| data.reference.name.clone());
    let mut row: Vec<(String, Value)> = vec![
        ("method".to_owned(), m.method.clone().into()),
        ("against".to_owned(), against.into()),
    ];
    let estimated = |row: &mut Vec<(String, Value)>, name: &str, e: Option<Estimated>| {
        let interval = e.and_then(|e| e.interval);
        row.push((name.to_owned(), e.map(|e| e.value).into()));
        row.push((format!("{name}_low"), interval.map(|i| i.0).into()));
        row.push((format!("{name}_high"), interval.map(|i| i.1).into()));
    };
    estimated(&mut row, "overall", overall);
    row.push((objective.clone(), m.objective.into()));
    row.push(("points".to_owned(), m.points.into()));
    row.push(("failed".to_owned(), m.failed.into()));
    let s = &m.summaries;
    let relative = !data.reference.is_none();
    if relative {
        estimated(&mut row, "ratio_of_means", s.ratio_of_means);
        estimated(&mut row, "geometric_mean", s.geometric_mean);
    }
    estimated(&mut row, "median", s.median);
    for (regime, e) in data.regimes.iter().zip(&s.by_regime) {
        estimated(&mut row, regime.name, *e);
    }
    for (share, value) in data.shares.iter().zip(&m.episodes.shares) {
        row.push((share.name.to_owned(), (*value).into()));
    }
    let e = &m.episodes;
    row.push((format!("episode_median_{objective}"), e.median.into()));
    row.push((format!("episode_worst_{objective}"), e.worst.into()));
    if relative {
        row.push(("episode_median".to_owned(), e.median_relative.into()));
        row.push(("episode_worst".to_owned(), e.worst_relative.into()));
    }
    estimated(&mut row, "iqm", s.interquartile_mean);
    let place = data.methods.iter().position(|other| other.method == m.method);
    let ranks = data.comparison.ranks.as_ref().zip(place).and_then(|(ranks, i)| ranks.get(i));
    row.push(("rank_probabilities".to_owned(), ranks.cloned().into()));
    row.into_iter().collect()
}
