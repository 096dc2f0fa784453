//! The manifest: what a run is, and so its tasks, written before anything runs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::own::OwnMethod;
use super::{Layout, SCHEMA_VERSION, most};
use crate::family::Feature;
use crate::sample::{Draw, Look, SamplePlan, Sampling};
use crate::stats::Direction;
use crate::store::error::{Remedy, StoreError};
use basics::hash::sha256;
use basics::seed;

/// Git revision of this build, or `unknown`.
pub const GIT: &str = env!("TSC_FAMILY_GIT");

/// Compiler of this build.
pub const RUSTC: &str = env!("TSC_FAMILY_RUSTC");

/// One task of a plan: a method on a point MDP, once.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Row of the plan.
    pub task: usize,
    /// Name of the method.
    pub method: String,
    /// Id of the point MDP.
    pub point: String,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// Seed of everything random in the task but its evaluation episodes.
    pub seed: u64,
}

/// A point MDP as the manifest keeps it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointRow {
    /// Id of the point MDP.
    pub point: String,
    /// What people call it; empty where that is its id.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Probability in the family.
    pub importance: f64,
    /// Real instances (intersections) that it stands for.
    pub instances: u32,
    /// Context features, in the order of [`Identity::features`].
    pub features: Vec<f64>,
    /// Latitude and longitude, degrees, of the real instances; empty when unknown.
    #[serde(default)]
    pub places: Vec<[f64; 2]>,
    /// sha256 of what the point MDP is, whatever it is called: its seeds follow from it. Empty in
    /// manifests from before it, where they follow from the id.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub content: String,
    /// Where its environment comes from: for traffic the folder's network files or a sumocfg.
    pub environment: String,
    /// sha256 of every file that defines its environment, by file name.
    pub sha256: BTreeMap<String, String>,
    /// What the command line said in place of what these files say, in the domain's words.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub given: BTreeMap<String, serde_json::Value>,
}

/// Everything that decides the records: two runs with equal identity give equal records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Version of the files.
    pub schema_version: u32,
    /// Kind of task; left out where it is traffic, which the first manifests do not say.
    #[serde(default = "first_domain", skip_serializing_if = "is_first_domain")]
    pub domain: String,
    /// Version of tsc-family.
    pub tsc_family: String,
    /// Version of the simulator.
    pub simulator: String,
    /// Name of the scenario.
    pub scenario: String,
    /// The scenario's settings, all of them, defaults included.
    pub settings: serde_json::Value,
    /// Names and units of the context features.
    pub features: Vec<Feature>,
    /// Which point MDPs were chosen, and their weights.
    pub sample: SamplePlan,
    /// The chosen point MDPs.
    pub points: Vec<PointRow>,
    /// Methods, the baseline first.
    pub methods: Vec<String>,
    /// Those of them that are not the domain's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub controllers: Vec<OwnMethod>,
    /// Name of the method that every score is divided by; empty where the objective is the score.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub baseline: String,
    /// Name of the metric that scores compare.
    pub objective: String,
    /// Whether less of it is better; left out where it is.
    #[serde(default, skip_serializing_if = "Direction::is_lower")]
    pub direction: Direction,
    /// Independent trainings per replicated method and point MDP.
    pub replicates: u32,
    /// Methods that have `replicates` tasks per point MDP; the others, which would only repeat
    /// themselves, have one. Empty when `replicates` is 1.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replicated: Vec<String>,
    /// Seed from which all others are derived.
    pub base_seed: u64,
    /// Seeds of the evaluation episodes, shared by all methods, before the point MDP is mixed in; the
    /// rows of the records have the seeds that vehicles and simulator got, see
    /// [`PointRow::evaluation_seeds`].
    pub evaluation_seeds: Vec<u64>,
}

/// Domain of a manifest that says none.
const FIRST_DOMAIN: &str = "traffic";

fn first_domain() -> String {
    FIRST_DOMAIN.to_owned()
}

fn is_first_domain(domain: &str) -> bool {
    domain == FIRST_DOMAIN
}

impl PointRow {
    /// Returns what people call the point MDP.
    pub fn name(&self) -> &str {
        if self.title.is_empty() { &self.point } else { &self.title }
    }

    /// Returns what the seeds of the point MDP follow from.
    fn seed_label(&self) -> &str {
        if self.content.is_empty() { &self.point } else { &self.content }
    }

    /// Returns the seeds that a run's evaluation episodes have here, which vehicles and simulator get.
    pub fn evaluation_seeds(&self, seeds: &[u64]) -> Vec<u64> {
        seeds.iter().map(|seed| seed::at_point(*seed, self.seed_label())).collect()
    }
}

/// What helps to understand a run but does not decide its records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Command line.
    pub command: String,
    /// Git revision of the build, or `unknown`.
    pub git: String,
    /// Compiler of the build.
    pub rustc: String,
    /// Operating system, architecture, processors.
    pub host: String,
    /// Start of the first run, ISO 8601, UTC.
    pub started: String,
    /// Folder of the generated networks.
    pub networks: String,
    /// What a reader of the results should know of what was evaluated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Memory that a worker may use, MB; `None` where nothing limits it, and in manifests that are older than this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_per_worker_mb: Option<u64>,
    /// What is kept of the settings of the run whose scores assist the sample, from [`super::assisting::kept`]; `None` where
    /// no run assists, and in manifests that are older than this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assisting: Option<serde_json::Value>,
}

/// `manifest.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// What decides the records; compared on resuming.
    pub identity: Identity,
    /// What does not; kept from the first run.
    pub provenance: Provenance,
}

impl Manifest {
    /// Returns the sha256 of the identity, which every record carries.
    pub fn sha256(&self) -> String {
        let json = serde_json::to_vec(&self.identity).expect("an identity is plain data");
        sha256(&json)
    }

    /// Returns the smaller budgets that the sample had before it grew by commands that added to the run, ascending; empty
    /// for a whole family, which no sampling can miss, and for looks that were planned.
    pub fn smaller_budgets(&self) -> Vec<usize> {
        let sample = &self.identity.sample;
        if sample.sampling == Sampling::All || sample.growth.is_some() {
            return Vec::new();
        }
        let words = shlex::split(&self.provenance.command).unwrap_or_default();
        let of_pair = |pair: &[String]| -> Option<usize> {
            match pair[0].strip_prefix("--budget=") {
                Some(value) => value.parse().ok(),
                None if pair[0] == "--budget" => pair[1].parse().ok(),
                None => None,
            }
        };
        // The last word of all has no value behind it.
        let padded = [words, vec![String::new()]].concat();
        let budgets: BTreeSet<usize> = padded.windows(2).filter_map(of_pair).collect();
        budgets.into_iter().filter(|budget| *budget < sample.budget).collect()
    }

    /// Returns the text of its file.
    pub fn to_json(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec_pretty(self).expect("a manifest is plain data");
        json.push(b'\n');
        json
    }

    /// Reads `manifest.json`.
    ///
    /// # Errors
    ///
    /// [`StoreError::NotResults`] when there is none, nor records beside it, [`StoreError::Version`] for another schema,
    /// [`StoreError::Adding`] where a command that adds to the run was interrupted, [`StoreError::Damaged`] for anything else.
    pub fn read(layout: &Layout) -> Result<Self, StoreError> {
        if Layout::new(layout.adding()).manifest().exists() {
            return Err(StoreError::Adding(layout.root().to_path_buf()));
        }
        let path = layout.manifest();
        let bytes = layout.document("manifest.json")?;
        let has_records = || layout.root().join("done").exists();
        let bytes = bytes.ok_or_else(|| match has_records() {
            true => StoreError::damaged(&path, "it is missing", Remedy::Begin),
            false => StoreError::NotResults(layout.root().to_path_buf()),
        })?;
        Self::parse(&bytes, &path)
    }

    /// Returns the manifest that bytes are; the path is for messages.
    ///
    /// # Errors
    ///
    /// [`StoreError::Version`] for another schema, [`StoreError::Damaged`] for anything else.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, StoreError> {
        let malformed = |reason: String| StoreError::damaged(path, reason, Remedy::Begin);
        let parsed = |e: serde_json::Error| malformed(e.to_string());
        let any: serde_json::Value = serde_json::from_slice(bytes).map_err(parsed)?;
        let Some(found) = any.pointer("/identity/schema_version").and_then(|v| v.as_u64()) else {
            return Err(malformed("it has no schema version".to_owned()));
        };
        if found != u64::from(SCHEMA_VERSION) {
            return Err(StoreError::Version {
                path: path.to_path_buf(),
                found,
                expected: SCHEMA_VERSION,
            });
        }
        let manifest: Self = serde_json::from_slice(bytes).map_err(parsed)?;
        manifest.identity.check().map_err(malformed)?;
        Ok(manifest)
    }
}

impl Identity {
    /// Checks what no run writes otherwise: a manifest that was edited would bring reports to write what it does not
    /// say, or where they must not.
    fn check(&self) -> Result<(), String> {
        most::check_replicates(self.replicates)?;
        let per_point = self.methods.iter().map(|m| u64::from(self.replicates_of(m))).sum();
        most::check(self.points.len(), per_point, self.evaluation_seeds.len())?;
        let looks = self.sample.growth.iter().flat_map(|growth| &growth.looks);
        for draws in looks.map(|look| &look.draws).chain([&self.sample.draws]) {
            most::check_draws(draws.iter().map(|d| d.count), self.sample.family_size)?;
        }
        for point in &self.points {
            let (own, all) = (point.features.len(), self.features.len());
            if own != all {
                return Err(format!("point {} has {own} features of {all}", point.point));
            }
        }
        let own = self.controllers.iter().flat_map(|own| {
            let versions = own.versions.iter().flat_map(|(name, version)| [name, version]);
            [&own.source, &own.summary].into_iter().chain(own.sha256.keys()).chain(versions)
        });
        let said = self.points.iter().map(|point| &point.title).chain([&self.scenario]).chain(own);
        if let Some(text) = said.into_iter().find(|text| text.chars().any(char::is_control)) {
            return Err(format!("{text:?} has control characters"));
        }
        // Files are called after them.
        let is_file = |name: &str| {
            let is_free = |c: char| c != '/' && !c.is_control();
            !name.is_empty() && !name.starts_with('.') && name.chars().all(is_free)
        };
        let safe = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        let points = self.points.iter().map(|p| ("point MDP", &p.point, is_file(&p.point)));
        let methods = self.methods.iter();
        let methods = methods.map(|m| ("method", m, is_file(m) && m.chars().all(safe)));
        let own = self.controllers.iter();
        let own = own.map(|own| ("controller", &own.name, self.methods.contains(&own.name)));
        let mut seen = BTreeSet::new();
        for (what, name, is_right) in points.chain(methods).chain(own) {
            if !is_right || !seen.insert((what, name)) {
                return Err(format!("a {what} cannot be called {name:?}, or is there twice"));
            }
        }
        if let Some(growth) = &self.sample.growth {
            let whole = growth.looks.last().is_some_and(|look| {
                look.budget == self.sample.budget && look.draws == self.sample.draws
            });
            let within = |pair: &[Look]| {
                let has = |d: &Draw| pair[1].draws.iter().any(|later| later.point == d.point);
                pair[0].budget < pair[1].budget && pair[0].draws.iter().all(has)
            };
            if !whole || !growth.looks.windows(2).all(within) {
                return Err("its looks do not lead to its sample".to_owned());
            }
        }
        Ok(())
    }

    /// Returns a method that is not the domain's.
    pub fn controller(&self, method: &str) -> Option<&OwnMethod> {
        self.controllers.iter().find(|own| own.name == method)
    }

    /// Returns how many tasks a method has per point MDP.
    pub fn replicates_of(&self, method: &str) -> u32 {
        if self.replicated.iter().any(|m| m == method) { self.replicates } else { 1 }
    }

    /// Returns all tasks, one point MDP after the other, so that a run that is cut short has whole
    /// point MDPs.
    pub fn tasks(&self) -> Vec<Task> {
        self.tasks_of(|_, _| true)
    }

    /// Returns the tasks whose row of the plan and point MDP are wanted. Seeds, which take longest, are derived for these
    /// only: a worker looks for one task of many.
    pub fn tasks_of(&self, wanted: impl Fn(usize, &str) -> bool) -> Vec<Task> {
        let (mut tasks, mut count) = (Vec::new(), 0);
        for row in &self.points {
            for method in &self.methods {
                for replicate in 0..self.replicates_of(method) {
                    if wanted(count, &row.point) {
                        tasks.push(Task {
                            task: count,
                            method: method.clone(),
                            point: row.point.clone(),
                            replicate,
                            seed: seed::task(self.base_seed, method, row.seed_label(), replicate),
                        });
                    }
                    count += 1;
                }
            }
        }
        tasks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_mdp_from_before_contents_has_the_seeds_of_its_time() {
        let json = r#"{"point":"p","importance":1.0,"instances":1,"features":[],"places":[],"environment":"network","sha256":{}}"#;
        let old: PointRow = serde_json::from_str(json).unwrap();
        assert_eq!(old.evaluation_seeds(&[7]), [seed::at_point(7, "p")]);
        assert_eq!(serde_json::to_string(&old).unwrap(), json, "the hash of a manifest stays");
    }
}
