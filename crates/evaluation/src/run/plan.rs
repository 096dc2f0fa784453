//! What a run consists of, decided completely before the first task.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::add;
use super::domain::{Domain, Prepared, Problem};
use super::error::RunError;
use super::method::{Method, Training, find};
use crate::sample::looks::{halves, looks};
use crate::sample::{Choice, Design, Growth, SampleError, SamplePlan, Until};
use crate::store::manifest::{Identity, Manifest, PointRow, Provenance, Task};
use crate::store::results::Results;
use crate::store::{Layout, Remedy, SCHEMA_VERSION, StoreError, most};
use basics::files::write_atomically;
use basics::seed;

/// What a run is asked to do.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// What is evaluated.
    pub domain: &'a dyn Domain,
    /// The scenario.
    pub problem: &'a dyn Problem,
    /// Which point MDPs.
    pub choice: &'a Choice,
    /// Methods by name; the baseline is added.
    pub methods: &'a [String],
    /// Seed from which all others are derived.
    pub base_seed: u64,
    /// Number of evaluation episodes.
    pub evaluation_seeds: u32,
    /// Their seeds, before a point MDP is mixed in; `None` derives them from [`Self::base_seed`].
    pub seeds: Option<&'a [u64]>,
    /// Independent trainings of the methods that tune or learn.
    pub replicates: u32,
    /// Methods whose records are computed again, in a results directory that has them.
    pub replace: &'a [String],
}

/// Evaluation episodes of every task, where nothing else is asked for.
pub const EVALUATION_SEEDS: u32 = 5;

impl<'a> Request<'a> {
    /// Returns a request for all point MDPs, with seed 0, [`EVALUATION_SEEDS`] episodes and one training
    /// per learner; its fields say otherwise.
    pub fn new(domain: &'a dyn Domain, problem: &'a dyn Problem, methods: &'a [String]) -> Self {
        Self {
            domain,
            problem,
            choice: &Choice::All,
            methods,
            base_seed: 0,
            evaluation_seeds: EVALUATION_SEEDS,
            seeds: None,
            replicates: 1,
            replace: &[],
        }
    }
}

/// A plan before anything is prepared: who is evaluated where.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// The chosen point MDPs.
    pub sample: SamplePlan,
    /// Methods, the baseline first.
    pub methods: Vec<String>,
    /// Those of them that have more than one task per point MDP.
    pub replicated: Vec<String>,
    /// What a sample was spread over, of those that need it later.
    pub design: Option<Design>,
    /// Memory that a worker may use, MB, for the provenance; `None` where nothing limits it, or another machine does.
    pub memory_per_worker_mb: Option<u64>,
}

impl Draft {
    /// Lets the sample grow look by look: what is chosen is then its largest extent.
    ///
    /// # Arguments
    ///
    /// * `budgets` — of the looks, ascending to the budget of the sample; empty for the budget and its halves
    ///   ([`halves`]).
    ///
    /// # Errors
    ///
    /// [`SampleError::Unfit`] for a sample that is not over a design, or budgets that do not lead to its own.
    pub fn grow(&mut self, until: Until, budgets: &[usize]) -> Result<(), SampleError> {
        let Some(design) = &self.design else {
            let reason =
                "only samples over a design grow: balanced ones and those by Bayesian quadrature";
            return Err(SampleError::Unfit(reason.to_owned()));
        };
        let usual = halves(self.sample.budget);
        let budgets = if budgets.is_empty() { &usual } else { budgets };
        let looks = looks(&self.sample, design, budgets)?;
        self.sample.growth = Some(Growth { until, looks });
        Ok(())
    }

    /// Returns the ids of the chosen point MDPs.
    pub fn chosen(&self) -> BTreeSet<&str> {
        self.sample.draws.iter().map(|draw| draw.point.as_str()).collect()
    }
}

/// Chooses point MDPs and methods.
///
/// # Errors
///
/// [`RunError::Method`] for an unknown method, [`RunError::Choice`] for an impossible budget or a plan of another
/// family.
pub fn draft(request: &Request<'_>) -> Result<Draft, RunError> {
    let known = request.domain.methods();
    let mut methods: Vec<&Method> = Vec::new();
    let baseline = request.domain.baseline();
    for name in baseline.into_iter().chain(request.methods.iter().map(String::as_str)) {
        let method = find(known, name)?;
        if !methods.iter().any(|m| m.name == method.name) {
            methods.push(method);
        }
    }
    let family = request.problem.family();
    let (sample, design) = request.choice.sample(family, request.base_seed)?;
    let repeats = |m: &&&Method| request.replicates > 1 && m.training != Training::None;
    let of_method = |m: &&Method| if repeats(&m) { u64::from(request.replicates) } else { 1 };
    let per_point = methods.iter().map(of_method).sum();
    most::check(sample.draws.len(), per_point, request.evaluation_seeds as usize)
        .map_err(RunError::Refused)?;
    let names = |m: &&Method| m.name.to_owned();
    let replicated = methods.iter().filter(repeats).map(names).collect();
    Ok(Draft {
        sample,
        methods: methods.iter().map(names).collect(),
        replicated,
        design,
        memory_per_worker_mb: None,
    })
}

/// Returns the seeds of so many evaluation episodes, before a point MDP is mixed in.
pub fn evaluation_seeds(base: u64, count: u32) -> Vec<u64> {
    (0..count).map(|k| seed::evaluation(base, k)).collect()
}

/// Completes a draft to a manifest and its tasks.
///
/// # Arguments
///
/// * `prepared` — what [`Problem::prepare`] made for the chosen point MDPs.
///
/// # Errors
///
/// [`RunError::Unprepared`] when it lacks a point MDP.
pub fn complete(
    request: &Request<'_>,
    draft: &Draft,
    prepared: Prepared,
    provenance: Provenance,
) -> Result<(Manifest, Vec<Task>), RunError> {
    let family = request.problem.family();
    let chosen = draft.chosen();
    let Prepared { simulator, points: mut made, .. } = prepared;
    let mut points = Vec::new();
    for point in family.points.iter().filter(|p| chosen.contains(p.id.as_str())) {
        let made = made.remove(&point.id).ok_or_else(|| RunError::Unprepared(point.id.clone()))?;
        points.push(PointRow {
            point: point.id.clone(),
            title: if point.title == point.id { String::new() } else { point.title.clone() },
            importance: point.importance,
            instances: point.instances,
            features: point.features.clone(),
            places: made.places,
            content: made.content,
            environment: made.environment,
            sha256: made.sha256,
            given: made.given,
        });
    }
    let controllers: Result<Vec<_>, _> =
        draft.methods.iter().map(|method| request.domain.own(method)).collect();
    let controllers = controllers?;
    let objective = request.domain.objective();
    let derived = || evaluation_seeds(request.base_seed, request.evaluation_seeds);
    let identity = Identity {
        schema_version: SCHEMA_VERSION,
        domain: request.domain.name().to_owned(),
        tsc_family: env!("CARGO_PKG_VERSION").to_owned(),
        simulator,
        scenario: family.name.clone(),
        settings: request.problem.settings(),
        features: family.features.clone(),
        sample: draft.sample.clone(),
        points,
        methods: draft.methods.clone(),
        controllers: controllers.into_iter().flatten().collect(),
        baseline: request.domain.baseline().unwrap_or_default().to_owned(),
        objective: objective.metric.to_owned(),
        direction: objective.direction,
        replicates: if draft.replicated.is_empty() { 1 } else { request.replicates },
        replicated: draft.replicated.clone(),
        base_seed: request.base_seed,
        evaluation_seeds: request.seeds.map_or_else(derived, <[u64]>::to_vec),
    };
    let tasks = identity.tasks();
    Ok((Manifest { identity, provenance }, tasks))
}

/// Writes the manifest into a new results directory. An existing one that holds the same run stays as it is, with
/// its own provenance; to one that holds a part of the run, the rest is added. The manifest comes last: with it the directory
/// is complete.
///
/// Returns the manifest that counts and, where something was added to a run, how many of its records stay.
///
/// # Arguments
///
/// * `replaced` — methods whose records are computed again.
/// * `untrained` — methods that do not learn, whose records do not depend on the settings of training.
///
/// # Errors
///
/// [`StoreError::Mismatch`] naming what differs.
pub fn establish(
    layout: &Layout,
    manifest: Manifest,
    tasks: &[Task],
    design: Option<&Design>,
    (replaced, untrained): (&[String], &[&str]),
) -> Result<(Manifest, Option<usize>), StoreError> {
    add::finish(layout)?;
    if !layout.manifest().exists() {
        write_design(layout, design, false)?;
        write_atomically(&layout.manifest(), &manifest.to_json())?;
        return Ok((manifest, None));
    }
    let existing = Manifest::read(layout)?;
    let (there, now) = (&existing.identity, &manifest.identity);
    if there == now && (replaced.is_empty() || add::is_replacing(layout, tasks, replaced)) {
        write_design(layout, design, true)?;
        return Ok((existing, None));
    }
    let Some(difference) = add::obstacle(there, now, (replaced, untrained)) else {
        // All commands together make the run.
        let Provenance { started, command: before, .. } = &existing.provenance;
        let command = match manifest.provenance.command {
            last if before.ends_with(&last) => before.clone(),
            last => format!("{before} && {last}"),
        };
        let provenance = Provenance { started: started.clone(), command, ..manifest.provenance };
        let manifest = Manifest { identity: manifest.identity, provenance };
        let kept = add::add(layout, &existing, (&manifest, tasks), design, replaced)?;
        return Ok((manifest, Some(kept)));
    };
    // Records of this very run: then what is of another one is the manifest beside them.
    let records = Results::inspect(layout, &Arc::new(manifest))?.0.done().count();
    if records > 0 {
        let reason = format!(
            "it is not the manifest of the records beside it, {records} of which are of this run"
        );
        return Err(StoreError::damaged(layout.manifest(), reason, Remedy::Begin));
    }
    let (path, command) = (layout.root().to_path_buf(), existing.provenance.command);
    Err(StoreError::Mismatch { path, difference, command })
}

/// Writes what the sample was spread over; `missing`: only where it is not there any more.
fn write_design(layout: &Layout, design: Option<&Design>, missing: bool) -> Result<(), StoreError> {
    if let Some(design) = design.filter(|_| !(missing && layout.design().exists())) {
        write_atomically(&layout.design(), &design.to_json())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::testing::{Counting, Pair, Toy, nowhere, request, with_request};

    fn names(methods: &[&str]) -> Vec<String> {
        methods.iter().map(|m| (*m).to_owned()).collect()
    }

    fn planned(methods: &[&str]) -> (Manifest, Vec<Task>) {
        with_request(&names(methods), 2, 1)
    }

    #[test]
    fn the_baseline_is_added_and_comes_first() {
        let (manifest, tasks) = planned(&["tuner", "zero", "tuner"]);
        assert_eq!(manifest.identity.methods, ["zero", "tuner"]);
        let rows: Vec<_> = tasks.iter().map(|t| (t.point.as_str(), t.method.as_str())).collect();
        let expected = [("quiet", "zero"), ("quiet", "tuner"), ("busy", "zero"), ("busy", "tuner")];
        assert_eq!(rows, expected);
    }

    #[test]
    fn a_point_mdp_for_which_nothing_was_prepared_is_refused() {
        let (toy, pair) = (Toy { learner: Counting::of(1) }, Pair::new());
        let request = request(&toy, &pair, &[], 2, 1);
        let draft = draft(&request).unwrap();
        let e = complete(&request, &draft, Prepared::default(), nowhere()).unwrap_err();
        assert!(e.to_string().starts_with("point quiet is not listed"), "{e}");
    }

    #[test]
    fn the_seed_of_a_task_does_not_depend_on_the_other_methods() {
        let of =
            |tasks: &[Task]| tasks.iter().find(|t| t.method == "learner").map(|t| t.seed).unwrap();
        assert_eq!(of(&planned(&["learner"]).1), of(&planned(&["tuner", "learner"]).1));
    }

    #[test]
    fn only_methods_that_tune_or_learn_are_replicated() {
        let (manifest, tasks) = with_request(&names(&["tuner", "other"]), 2, 3);
        assert_eq!(manifest.identity.replicated, ["tuner"]);
        assert_eq!(tasks.len(), 2 * (2 + 3));
        let seeds: BTreeSet<u64> =
            tasks.iter().filter(|t| t.method == "tuner").map(|t| t.seed).collect();
        assert_eq!(seeds.len(), 2 * 3);
    }

    #[test]
    fn a_run_without_anything_to_replicate_is_the_same_whatever_the_replicates() {
        let other = names(&["other"]);
        assert_eq!(with_request(&other, 2, 3), with_request(&other, 2, 1));
    }

    #[test]
    fn a_manifest_from_before_replicates_is_read_with_one_task_per_method() {
        let (manifest, tasks) = planned(&["tuner"]);
        let json = serde_json::to_value(&manifest).unwrap();
        assert_eq!(json["identity"].get("replicated"), None);
        let read: Manifest = serde_json::from_value(json).unwrap();
        assert_eq!((read.identity.tasks(), read.sha256()), (tasks, manifest.sha256()));
    }
}
