//! What a run consists of, decided completely before the first task.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::family::{Feature, MdpFamily, PointMdp};
use crate::files::write_atomically;
use crate::run::error::EvalError;
use crate::run::method::Training;
use crate::sample::{SamplePlan, Sampling, choose};
use crate::seed;
use crate::stats::Direction;
use crate::store::error::StoreError;
use crate::store::manifest::{FeatureColumn, Identity, Manifest, PointRow, Provenance, Task};
use crate::store::{Layout, SCHEMA_VERSION, difference};
use crate::traffic::control::baseline;
use crate::traffic::control::registry::training;
use crate::traffic::controllers::create;
use crate::traffic::env::World;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::network::error::NetworkError;
use crate::traffic::network::index::INDEX_FILE;

use crate::traffic::content;
use crate::traffic::environment::hash_scenario;

/// Environment of a point MDP whose network lies in the networks folder.
pub const GENERATED: &str = "network";

/// Metric that scores compare.
pub const OBJECTIVE: &str = "delay_s";

/// What a run is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The scenario: settings, and the family unless `sumocfgs` are given.
    pub scenario: LoadedScenario,
    /// Imported SUMO scenarios that make up the family instead.
    pub sumocfgs: Vec<PathBuf>,
    /// Number of point MDPs; `None` takes all.
    pub budget: Option<usize>,
    /// How they are chosen.
    pub sampling: Sampling,
    /// Methods by name; the baseline is added.
    pub methods: Vec<String>,
    /// Seed from which all others are derived.
    pub base_seed: u64,
    /// Number of evaluation episodes.
    pub evaluation_seeds: u32,
    /// Independent trainings of the methods that tune or learn.
    pub replicates: u32,
}

/// A plan before its networks are known: who is evaluated where.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// The family that was sampled.
    pub family: MdpFamily,
    /// Imported scenario per point MDP; empty for generated networks.
    pub imported: BTreeMap<String, PathBuf>,
    /// The chosen point MDPs.
    pub sample: SamplePlan,
    /// Methods, the baseline first.
    pub methods: Vec<String>,
    /// Those of them that have more than one task per point MDP.
    pub replicated: Vec<String>,
}

/// Chooses point MDPs and methods.
///
/// # Errors
///
/// [`EvalError`] for an unknown method, an impossible budget, or a SUMO configuration that cannot
/// be used.
pub fn draft(request: &Request) -> Result<Draft, EvalError> {
    let mut methods = vec![baseline::METHOD.name.to_owned()];
    for method in &request.methods {
        create(method, &request.scenario.scenario, false, 0)?;
        if !methods.contains(method) {
            methods.push(method.clone());
        }
    }
    let (family, imported) = if request.sumocfgs.is_empty() {
        (request.scenario.family.clone(), BTreeMap::new())
    } else {
        imported_family(&request.sumocfgs)?
    };
    let size = family.points.len();
    let budget = request.budget.unwrap_or(size);
    let sampling = if request.budget.is_none() { Sampling::All } else { request.sampling };
    let sample = choose(&family, sampling, budget, request.base_seed)?;
    let repeats = |m: &&String| request.replicates > 1 && training(m) != Training::None;
    let replicated = methods.iter().filter(repeats).cloned().collect();
    Ok(Draft { family, imported, sample, methods, replicated })
}

fn imported_family(
    configs: &[PathBuf],
) -> Result<(MdpFamily, BTreeMap<String, PathBuf>), EvalError> {
    let mut imported = BTreeMap::new();
    for config in configs {
        World::from_sumocfg(config)?;
        let id = imported_id(config);
        if imported.insert(id.clone(), config.clone()).is_some() {
            return Err(EvalError::DoubledPoint(id));
        }
    }
    let share = 1.0 / imported.len() as f64;
    let point = |id: &String| PointMdp {
        id: id.clone(),
        title: id.clone(),
        features: vec![],
        importance: share,
        instances: 1,
    };
    let points = imported.keys().map(point).collect();
    let family = MdpFamily::new("imported", Vec::<Feature>::new(), points, "--sumocfg")?;
    Ok((family, imported))
}

/// Returns the seeds of so many evaluation episodes, before a point MDP is mixed in.
pub fn evaluation_seeds(base: u64, count: u32) -> Vec<u64> {
    (0..count).map(|k| seed::evaluation(base, k)).collect()
}

/// Returns the id that an imported scenario has as a point MDP.
pub fn imported_id(config: &Path) -> String {
    let stem = config.file_stem().unwrap_or_default().to_string_lossy();
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    stem.chars().map(safe).collect()
}

/// Completes a draft to a manifest and its tasks.
///
/// # Arguments
///
/// * `hashes` — sha256 by file name of the networks of the chosen point MDPs; unused for imported
///   scenarios, whose files are hashed here.
///
/// # Errors
///
/// [`EvalError`] when a network has no hashes or a file of an imported scenario cannot be read.
pub fn complete(
    request: &Request,
    draft: &Draft,
    hashes: &BTreeMap<String, BTreeMap<String, String>>,
    simulator: String,
    provenance: Provenance,
) -> Result<(Manifest, Vec<Task>), EvalError> {
    let chosen: BTreeSet<&str> = draft.sample.draws.iter().map(|d| d.point.as_str()).collect();
    let mut points = Vec::new();
    for (i, point) in draft.family.points.iter().enumerate() {
        if !chosen.contains(point.id.as_str()) {
            continue;
        }
        let loaded = &request.scenario;
        let (environment, sha256, content) = match draft.imported.get(&point.id) {
            Some(config) => {
                let environment = config.display().to_string();
                (environment, hash_scenario(config)?, content::of_imported(config)?)
            }
            None => {
                let sha256 = hashes.get(&point.id).ok_or_else(|| NetworkError::Index {
                    path: Path::new(&provenance.networks).join(INDEX_FILE),
                    reason: format!("point {} is not listed", point.id),
                })?;
                (GENERATED.to_owned(), sha256.clone(), content::of_point(loaded, i))
            }
        };
        let members = if draft.imported.is_empty() { loaded.members[i].as_slice() } else { &[] };
        let place = |m: &usize| {
            let intersection = &loaded.intersections[*m];
            [intersection.latitude, intersection.longitude]
        };
        points.push(PointRow {
            point: point.id.clone(),
            title: if point.title == point.id { String::new() } else { point.title.clone() },
            importance: point.importance,
            instances: point.instances,
            features: point.features.clone(),
            places: members.iter().map(place).collect(),
            content,
            environment,
            sha256,
        });
    }
    let column = |f: &Feature| FeatureColumn { name: f.name.clone(), unit: f.unit.clone() };
    let identity = Identity {
        schema_version: SCHEMA_VERSION,
        domain: "traffic".to_owned(),
        tsc_family: env!("CARGO_PKG_VERSION").to_owned(),
        simulator,
        scenario: draft.family.name.clone(),
        settings: serde_json::to_value(&request.scenario.scenario)
            .expect("a scenario is plain data"),
        features: draft.family.features.iter().map(column).collect(),
        sample: draft.sample.clone(),
        points,
        methods: draft.methods.clone(),
        baseline: baseline::METHOD.name.to_owned(),
        objective: OBJECTIVE.to_owned(),
        direction: Direction::Lower,
        replicates: if draft.replicated.is_empty() { 1 } else { request.replicates },
        replicated: draft.replicated.clone(),
        base_seed: request.base_seed,
        evaluation_seeds: evaluation_seeds(request.base_seed, request.evaluation_seeds),
    };
    let tasks = identity.tasks();
    Ok((Manifest { identity, provenance }, tasks))
}

/// Writes plan and manifest into a new results directory, or checks that an existing one holds
/// the same run. The manifest comes last: with it the directory is complete.
///
/// Returns the manifest that counts: of an existing directory its own, with the first run's
/// provenance.
///
/// # Errors
///
/// [`StoreError::Mismatch`] naming what differs.
pub fn establish(
    layout: &Layout,
    manifest: Manifest,
    tasks: &[Task],
) -> Result<Manifest, StoreError> {
    if layout.manifest().exists() {
        let existing = Manifest::read(layout)?;
        return match difference::between(&existing.identity, &manifest.identity) {
            None => Ok(existing),
            Some(difference) => {
                let (path, command) = (layout.root().to_path_buf(), existing.provenance.command);
                Err(StoreError::Mismatch { path, difference, command })
            }
        };
    }
    let mut plan = Vec::new();
    for task in tasks {
        serde_json::to_writer(&mut plan, task).expect("a task is plain data");
        plan.push(b'\n');
    }
    write_atomically(&layout.plan(), &plan)?;
    let mut json = serde_json::to_vec_pretty(&manifest).expect("a manifest is plain data");
    json.push(b'\n');
    write_atomically(&layout.manifest(), &json)?;
    Ok(manifest)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::traffic::family::load::load;

    fn request(methods: &[&str], budget: Option<usize>) -> Request {
        Request {
            scenario: load("smoke").unwrap(),
            sumocfgs: vec![],
            budget,
            sampling: Sampling::KMeans,
            methods: methods.iter().map(|m| (*m).to_owned()).collect(),
            base_seed: 0,
            evaluation_seeds: 2,
            replicates: 1,
        }
    }

    /// A planned run on the smoke scenario.
    pub(in crate::run) fn planned(methods: &[&str]) -> (Manifest, Vec<Task>) {
        completed(&request(methods, None))
    }

    fn completed(request: &Request) -> (Manifest, Vec<Task>) {
        let draft = draft(request).unwrap();
        let provenance = Provenance {
            command: String::new(),
            git: String::new(),
            rustc: String::new(),
            host: String::new(),
            started: String::new(),
            networks: String::new(),
        };
        let points = draft.family.points.iter();
        let hashes = points.map(|p| (p.id.clone(), BTreeMap::new())).collect();
        complete(request, &draft, &hashes, "mock".into(), provenance).unwrap()
    }

    #[test]
    fn the_baseline_is_added_and_comes_first() {
        let (manifest, tasks) = planned(&["max-pressure", "baseline", "max-pressure"]);
        assert_eq!(manifest.identity.methods, ["baseline", "max-pressure"]);
        let rows: Vec<_> = tasks.iter().map(|t| (t.point.as_str(), t.method.as_str())).collect();
        assert_eq!(
            rows,
            [
                ("quiet", "baseline"),
                ("quiet", "max-pressure"),
                ("busy", "baseline"),
                ("busy", "max-pressure")
            ]
        );
    }

    #[test]
    fn a_network_without_hashes_is_refused_because_it_could_not_be_checked() {
        let request = request(&[], None);
        let (draft, manifest) = (draft(&request).unwrap(), completed(&request).0);
        let (hashes, provenance) = (BTreeMap::new(), manifest.provenance);
        let e = complete(&request, &draft, &hashes, "mock".into(), provenance).unwrap_err();
        assert!(e.to_string().contains("INDEX.csv: point quiet is not listed"), "{e}");
    }

    #[test]
    fn an_unknown_method_names_those_that_exist() {
        let e = draft(&request(&["maxpressure"], None)).unwrap_err().to_string();
        assert_eq!(
            e,
            "unknown method \"maxpressure\"; known are baseline, fixed-time, max-pressure, \
             max-pressure-resco, actuated, idqn, ippo, mplight, mplight-star, mplight-star-resco, program; did you mean max-pressure?"
        );
    }

    #[test]
    fn the_seed_of_a_task_does_not_depend_on_the_other_methods() {
        let of = |tasks: &[Task]| {
            tasks.iter().find(|t| t.method == "max-pressure").map(|t| t.seed).unwrap()
        };
        assert_eq!(
            of(&planned(&["max-pressure"]).1),
            of(&planned(&["actuated", "max-pressure"]).1)
        );
    }

    #[test]
    fn only_methods_that_tune_or_learn_are_replicated() {
        let mut request = request(&["fixed-time", "max-pressure", "actuated", "program"], None);
        request.replicates = 3;
        let (manifest, tasks) = completed(&request);
        assert_eq!(manifest.identity.replicated, ["fixed-time"]);
        assert_eq!(tasks.len(), 2 * (4 + 3));
        let seeds: BTreeSet<u64> =
            tasks.iter().filter(|t| t.method == "fixed-time").map(|t| t.seed).collect();
        assert_eq!(seeds.len(), 2 * 3);
    }

    #[test]
    fn a_run_without_anything_to_replicate_is_the_same_whatever_the_replicates() {
        let mut request = request(&["max-pressure"], None);
        let once = completed(&request);
        request.replicates = 3;
        assert_eq!(completed(&request), once);
    }

    #[test]
    fn a_manifest_from_before_replicates_is_read_with_one_task_per_method() {
        let (manifest, tasks) = planned(&["fixed-time"]);
        let json = serde_json::to_value(&manifest).unwrap();
        assert_eq!(json["identity"].get("replicated"), None);
        let read: Manifest = serde_json::from_value(json).unwrap();
        assert_eq!((read.identity.tasks(), read.sha256()), (tasks, manifest.sha256()));
    }

    #[test]
    fn another_run_in_the_same_directory_is_refused_and_the_field_named() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let (manifest, tasks) = planned(&["max-pressure"]);
        establish(&layout, manifest.clone(), &tasks).unwrap();
        establish(&layout, manifest.clone(), &tasks).unwrap();
        let mut other = manifest;
        other.identity.base_seed = 9;
        let e = establish(&layout, other, &tasks).unwrap_err().to_string();
        assert!(e.contains("--seed is 0 there and 9 now"), "{e}");
    }
}
