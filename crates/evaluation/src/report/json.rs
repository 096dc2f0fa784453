//! Runs that are compared as `--json` prints them.

use std::sync::Arc;

use serde_json::{Value, json};

use super::whole::Runs;
use crate::store::manifest::Manifest;

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
        json!({"event": "compare", "runs": runs, "differences": self.differences, "repeated": self.repeated})
    }
}
