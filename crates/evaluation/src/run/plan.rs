//! What a run consists of, decided completely before the first task.
//!
//! A results directory takes in more: further methods, point MDPs, trainings and evaluation seeds, and a controller that was
//! changed.
//!
//! A record depends on its own method and point MDP, not on what else is in the run. So the records that are there stay:
//! they get the number of their task in the new plan and the sha256 of the new manifest, and are then those that a run of
//! everything at once would have made. What is missing is then done as usual. With more evaluation seeds every task is to be
//! done again; of what was learned model and record are kept, so that only episodes of evaluation are.
//!
//! The new files are written into the folder `adding/`, its manifest last, and then take the places of the old ones. If that
//! is interrupted, [`finish_adding`] goes on with it; nobody reads the directory before.

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use super::checkpoint;
use super::domain::{Domain, Prepared, PreparedPoint, Problem};
use super::error::RunError;
use super::method::{Method, Training, find};
use crate::family::PointMdp;
use crate::sample::looks::{halves, looks};
use crate::sample::{Choice, Design, Growth, SampleError, SamplePlan, Until};
use crate::store::assisting::{TRAINING, section};
use crate::store::manifest::{Identity, Manifest, PointRow, Provenance, Task};
use crate::store::record::{Outcome, Record};
use crate::store::results::Results;
use crate::store::{Layout, Remedy, SCHEMA_VERSION, StoreError, difference, most};
use basics::files::{
    self, FileError, beneath, limits, make_folder_beneath, replace, write_atomically,
};
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
fn evaluation_seeds(base: u64, count: u32) -> Vec<u64> {
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
        points.push(row(point, made));
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

/// Returns the row of a point MDP.
pub(super) fn row(point: &PointMdp, made: PreparedPoint) -> PointRow {
    PointRow {
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
    }
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
/// * `known` — the methods of the domain, which say what records depend on.
///
/// # Errors
///
/// [`StoreError::Mismatch`] naming what differs.
pub fn establish(
    layout: &Layout,
    manifest: Manifest,
    tasks: &[Task],
    design: Option<&Design>,
    (replaced, known): (&[String], &[Method]),
) -> Result<(Manifest, Option<usize>), StoreError> {
    finish_adding(layout)?;
    if !layout.manifest().exists() {
        write_design(layout, design, false)?;
        write_atomically(&layout.manifest(), &manifest.to_json())?;
        return Ok((manifest, None));
    }
    let existing = Manifest::read(layout)?;
    let (there, now) = (&existing.identity, &manifest.identity);
    if there == now && (replaced.is_empty() || is_replacing(layout, tasks, replaced)) {
        write_design(layout, design, true)?;
        return Ok((existing, None));
    }
    let Some(difference) = obstacle(there, now, (replaced, known)) else {
        // All commands together make the run.
        let Provenance { started, command: before, .. } = &existing.provenance;
        let command = match manifest.provenance.command {
            last if before.ends_with(&last) => before.clone(),
            last => format!("{before} && {last}"),
        };
        let provenance = Provenance { started: started.clone(), command, ..manifest.provenance };
        let manifest = Manifest { identity: manifest.identity, provenance };
        let kept = add(layout, &existing, (&manifest, tasks), design, replaced)?;
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

/// Folders of results that take the place of the old ones.
const FOLDERS: [&str; 4] = ["done", "models", "ckpt", "before"];

/// Folders whose files are called by numbers of the old plan.
const NUMBERED: [&str; 2] = ["logs", "jobs"];

/// Returns what stands between an existing run and a larger one, in words; `None` if the existing one can be added to.
fn obstacle(
    there: &Identity,
    now: &Identity,
    (replaced, known): (&[String], &[Method]),
) -> Option<String> {
    let mut same = now.clone();
    let stays = |method: &String| there.methods.contains(method);
    if there.methods.iter().all(|m| now.methods.contains(m)) {
        same.methods.clone_from(&there.methods);
    }
    same.controllers.retain(|own| stays(&own.name));
    for own in &mut same.controllers {
        let before = there.controllers.iter().find(|before| before.name == own.name);
        if let Some(before) = before.filter(|_| replaced.contains(&own.name)) {
            own.clone_from(before);
        }
    }
    // A setting of a method that is new here has been read by nobody, unless by a learner that is built on that method.
    let of_learner =
        |method: &String| there.controllers.iter().any(|own| own.learner.as_ref() == Some(method));
    let of_there = || known.iter().filter(|m| there.methods.iter().any(|name| name == m.name));
    let limits = |m: &Method, of: &str| match m.training {
        Training::Tuned { episodes } => section(episodes) == of,
        _ => false,
    };
    let is_read =
        |of: &str| of_there().any(|m| m.section() == of || m.reads.contains(&of) || limits(m, of));
    for method in now.methods.iter().filter(|m| !stays(m) && !of_learner(m)) {
        let of = method.replace('-', "_");
        if let (Some(own), Some(before)) = (same.settings.get_mut(&of), there.settings.get(&of))
            && !is_read(&of)
        {
            own.clone_from(before);
        }
    }
    // Nor have settings of training been read where no method learns.
    let learns =
        |name: &String| known.iter().all(|m| m.name != name || m.training == Training::Learned);
    if !there.methods.iter().any(learns)
        && let (Some(own), Some(before)) =
            (same.settings.get_mut(TRAINING), there.settings.get(TRAINING))
    {
        own.clone_from(before);
    }
    // What was given to a method that is new, or whose records are computed again, is in no record that stays.
    for row in &mut same.points {
        let before = there.points.iter().find(|before| before.point == row.point);
        for method in now.methods.iter().filter(|m| !stays(m) || replaced.contains(m)) {
            match before.and_then(|before| before.given.get(method)) {
                Some(value) => drop(row.given.insert(method.clone(), value.clone())),
                None => drop(row.given.remove(method)),
            }
        }
    }
    if same.replicates >= there.replicates {
        same.replicates = there.replicates;
        same.replicated.clone_from(&there.replicated);
    }
    let grows = |sample: &SamplePlan| sample.growth.is_some();
    if now.evaluation_seeds.starts_with(&there.evaluation_seeds) && !grows(&there.sample) {
        same.evaluation_seeds.clone_from(&there.evaluation_seeds);
    }
    let has = |point: &str| now.points.iter().any(|row| row.point == point);
    let contains = there.points.iter().all(|row| has(&row.point));
    if contains && !grows(&there.sample) && !grows(&now.sample) {
        same.sample.clone_from(&there.sample);
        same.points.retain(|row| there.points.iter().any(|before| before.point == row.point));
    } else if !contains
        && !grows(&now.sample)
        && now.scenario == there.scenario
        && now.points.len() > there.points.len()
    {
        return Some(format!(
            "the sample of {} point MDPs does not contain all {} of the one there; a sample by Bayesian quadrature \
             (--assist) and --budget all do",
            now.points.len(),
            there.points.len()
        ));
    }
    let difference = difference::between(there, &same)?;
    let changed = there.controllers.iter().find(|before| {
        same.controllers.iter().any(|own| own.name == before.name && own != *before)
    });
    Some(match changed {
        Some(own) => format!("{difference}; --replace {} computes its records again", own.name),
        None => difference,
    })
}

/// Adds to a results directory, and returns how many of its records stay.
fn add(
    layout: &Layout,
    there: &Manifest,
    (manifest, tasks): (&Manifest, &[Task]),
    design: Option<&Design>,
    replaced: &[String],
) -> Result<usize, StoreError> {
    let before = Results::load_known(layout, &there.clone().into())?;
    if layout.jobs().exists() && before.missing().next().is_some() {
        return Err(StoreError::Submitted(layout.root().to_path_buf()));
    }
    let adding = Layout::new(layout.adding());
    remove(layout, layout.adding().as_path())?;
    let sha256 = manifest.sha256();
    let key = |task: &Task| (task.method.clone(), task.point.clone(), task.replicate, task.seed);
    let places: HashMap<_, &Task> = tasks.iter().map(|task| (key(task), task)).collect();
    let has_more_seeds =
        manifest.identity.evaluation_seeds.len() > there.identity.evaluation_seeds.len();
    let there = there.sha256();
    let mut kept = 0;
    for (task, record) in before.rows().filter(|(task, _)| !replaced.contains(&task.method)) {
        let Some(place) = places.get(&key(task)) else { continue };
        let model = files::if_present(files::read(&layout.model(task.task), limits::ARCHIVE))?;
        let is_ok = record.is_some_and(|record| record.summary.outcome == Outcome::Ok);
        let (stays, waits) = match record {
            Some(record) if has_more_seeds && is_ok => (None, Some(record.clone())),
            Some(record) => (Some(record), None),
            None => (None, Record::read_at(layout.before(task.task), task, &there).ok().flatten()),
        };
        if let Some(record) = stays {
            let text = record.moved(place, &sha256).to_text();
            put(layout, &adding.record(place.task), text.as_bytes())?;
            kept += 1;
        }
        // Only what was learned is worth it: other tasks play all seeds in any case.
        if let Some(record) = waits.filter(|_| model.is_some()) {
            let text = record.moved(place, &sha256).to_text();
            put(layout, &adding.before(place.task), text.as_bytes())?;
        }
        if let Some(model) = model {
            put(layout, &adding.model(place.task), &model)?;
        }
        if record.is_some() {
            continue;
        }
        let begun = checkpoint::moved(layout, (&there, task.task), (&sha256, place.task));
        if let Some(begun) = begun {
            put(layout, &adding.checkpoint(place.task), &begun)?;
        }
    }
    for name in FOLDERS {
        make_folder_beneath(layout.root(), &adding.root().join(name))?;
    }
    if let Some(design) = design {
        write_atomically(&adding.design(), &design.to_json())?;
    }
    if !replaced.is_empty() || layout.replaced().exists() {
        let text = serde_json::to_vec(replaced).expect("names are plain data");
        write_atomically(&adding.replaced(), &text)?;
    }
    write_atomically(&adding.manifest(), &manifest.to_json())?;
    finish_adding(layout)?;
    Ok(kept)
}

/// Whether the records of these methods are being computed again: the last command that added to the run asked for it, and
/// some have no record yet. The same command then goes on with it.
fn is_replacing(layout: &Layout, tasks: &[Task], replaced: &[String]) -> bool {
    let text = files::read(&layout.replaced(), limits::DOCUMENT).ok();
    let asked = text.and_then(|text| serde_json::from_slice::<BTreeSet<String>>(&text).ok());
    asked == Some(replaced.iter().cloned().collect())
        && tasks.iter().any(|t| replaced.contains(&t.method) && !layout.record(t.task).exists())
}

/// Takes the records of another run along that are of tasks of this one, where these have none yet.
pub(super) fn take_along(
    from: &Results,
    layout: &Layout,
    manifest: &Manifest,
) -> Result<(), StoreError> {
    let sha256 = manifest.sha256();
    let key = |task: &Task| (task.method.clone(), task.point.clone(), task.replicate, task.seed);
    let there: HashMap<_, _> = from.done().map(|(task, record)| (key(task), record)).collect();
    for task in manifest.identity.tasks() {
        if let Some(record) = there.get(&key(&task)).filter(|_| !layout.record(task.task).exists())
        {
            record.moved(&task, &sha256).commit(layout)?;
        }
    }
    Ok(())
}

/// Puts new files into the places of old ones, where that was begun; removes what was not complete.
fn finish_adding(layout: &Layout) -> Result<(), StoreError> {
    let adding = Layout::new(layout.adding());
    if !adding.root().exists() {
        return Ok(());
    }
    if adding.manifest().exists() {
        let root = layout.root();
        for name in NUMBERED {
            remove(layout, &root.join(name))?;
        }
        for name in FOLDERS {
            let (new, old) = (adding.root().join(name), root.join(name));
            // Where it is not there, it has its place already.
            if new.exists() {
                remove(layout, &old)?;
                rename(&new, &old)?;
            }
        }
        let files = [(adding.design(), layout.design()), (adding.replaced(), layout.replaced())];
        for (new, old) in files {
            if new.exists() {
                rename(&new, &old)?;
            }
        }
        layout.make()?;
        rename(&adding.manifest(), &layout.manifest())?;
    }
    remove(layout, adding.root())
}

fn put(layout: &Layout, path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    replace(layout.root(), path, &layout.tmp(), bytes)
}

fn rename(from: &Path, to: &Path) -> Result<(), StoreError> {
    Ok(fs::rename(from, to).map_err(FileError::at("replace", to))?)
}

/// Removes a folder of a results directory with all that is in it.
fn remove(layout: &Layout, path: &Path) -> Result<(), StoreError> {
    beneath(layout.root(), path)?;
    match fs::remove_dir_all(path) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(FileError::at("remove", path)(e).into()),
        _ => Ok(()),
    }
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

#[cfg(test)]
mod adding {
    use super::*;
    use crate::run::testing::with_request;
    use crate::store::record::TaskResult;
    use serde_json::json;

    fn names(methods: &[&str]) -> Vec<String> {
        methods.iter().map(|m| (*m).to_owned()).collect()
    }

    fn committed(layout: &Layout, manifest: &Manifest, tasks: &[Task]) {
        for task in tasks {
            Record::finished(task, &manifest.sha256(), TaskResult::default())
                .commit(layout)
                .unwrap();
        }
    }

    /// The text of every record, in the order of the plan.
    fn texts(layout: &Layout, tasks: &[Task]) -> Vec<Option<String>> {
        tasks.iter().map(|task| fs::read_to_string(layout.record(task.task)).ok()).collect()
    }

    #[test]
    fn records_stay_and_are_those_of_a_run_of_everything_at_once() {
        let dir = tempfile::tempdir().unwrap();
        let (small, large) = (Layout::new(dir.path().join("a")), Layout::new(dir.path().join("b")));
        [&small, &large].iter().for_each(|layout| layout.make().unwrap());
        let (before, tasks) = with_request(&names(&["tuner"]), 2, 1);
        establish(&small, before.clone(), &tasks, None, (&[], &[])).unwrap();
        committed(&small, &before, &tasks);
        fs::create_dir_all(small.model(1).parent().unwrap()).unwrap();
        fs::write(small.model(1), "a model").unwrap();

        let (now, tasks) = with_request(&names(&["other", "tuner"]), 2, 3);
        let mut now = now;
        // The order is that of the run that is there.
        now.identity.methods = names(&["zero", "tuner", "other"]);
        let tasks = {
            drop(tasks);
            now.identity.tasks()
        };
        let added = establish(&small, now.clone(), &tasks, None, (&[], &[])).unwrap();
        assert_eq!(added.1, Some(4));
        establish(&large, now.clone(), &tasks, None, (&[], &[])).unwrap();
        committed(&large, &now, &tasks);
        let (small_texts, large_texts) = (texts(&small, &tasks), texts(&large, &tasks));
        let missing = small_texts.iter().filter(|text| text.is_none()).count();
        assert_eq!(
            (tasks.len(), missing),
            (10, 6),
            "two trainings more of each, and the new method"
        );
        for (a, b) in small_texts.iter().zip(&large_texts).filter(|(a, _)| a.is_some()) {
            assert_eq!(a, b);
        }
        let place = tasks.iter().find(|t| t.method == "tuner" && t.replicate == 0).unwrap();
        assert_eq!(fs::read_to_string(small.model(place.task)).unwrap(), "a model");
        assert!(!small.adding().exists());
        assert_eq!(Results::load(&small).unwrap().missing().count(), 6);
        // Again it is the same run.
        assert_eq!(establish(&small, now, &tasks, None, (&[], &[])).unwrap().1, None);
    }

    #[test]
    fn the_same_command_goes_on_with_records_that_are_computed_again() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path().join("r"));
        layout.make().unwrap();
        let (manifest, tasks) = with_request(&names(&["tuner"]), 2, 1);
        let again = || {
            let replaced = names(&["tuner"]);
            establish(&layout, manifest.clone(), &tasks, None, (&replaced, &[])).unwrap().1
        };
        establish(&layout, manifest.clone(), &tasks, None, (&[], &[])).unwrap();
        committed(&layout, &manifest, &tasks);
        let of_others = tasks.iter().filter(|task| task.method != "tuner").count();
        assert_eq!(again(), Some(of_others));
        let of_tuner: Vec<Task> = tasks.iter().filter(|t| t.method == "tuner").cloned().collect();
        committed(&layout, &manifest, &of_tuner[..1]);
        assert_eq!(again(), None, "it was interrupted");
        assert!(layout.record(of_tuner[0].task).exists());
        committed(&layout, &manifest, &of_tuner[1..]);
        assert_eq!(again(), Some(of_others), "it was over");
    }

    #[test]
    fn what_was_interrupted_is_said_and_goes_on() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path().join("r"));
        layout.make().unwrap();
        let (before, tasks) = with_request(&names(&["tuner"]), 2, 1);
        establish(&layout, before.clone(), &tasks, None, (&[], &[])).unwrap();
        committed(&layout, &before, &tasks);
        let (mut now, _) = with_request(&names(&["tuner", "other"]), 2, 1);
        now.identity.methods = names(&["zero", "tuner", "other"]);
        let tasks = now.identity.tasks();
        // As after the records have their places and before the manifest has.
        establish(&layout, now.clone(), &tasks, None, (&[], &[])).unwrap();
        let adding = Layout::new(layout.adding());
        fs::create_dir(adding.root()).unwrap();
        fs::rename(layout.manifest(), adding.manifest()).unwrap();
        fs::write(layout.manifest(), before.to_json()).unwrap();
        let e = Results::load(&layout).unwrap_err();
        assert!(e.to_string().contains("nothing is lost: repeat that command"), "{e}");
        establish(&layout, now, &tasks, None, (&[], &[])).unwrap();
        assert_eq!(Results::load(&layout).unwrap().done().count(), 4);

        // What was not complete goes.
        fs::create_dir_all(adding.record(0).parent().unwrap()).unwrap();
        fs::write(adding.record(0), "half a rec").unwrap();
        finish_adding(&layout).unwrap();
        assert!(!adding.root().exists());
        assert_eq!(Results::load(&layout).unwrap().done().count(), 4);
    }

    #[test]
    fn settings_that_no_method_there_reads_may_change() {
        let (mut there, _) = with_request(&names(&["tuner"]), 2, 1);
        there.identity.settings =
            json!({"training": {"episodes": 100}, "demand": 1, "learner": {"rate": 1}});
        let (mut now, _) = with_request(&names(&["tuner", "learner"]), 2, 1);
        now.identity.methods = names(&["zero", "tuner", "learner"]);
        now.identity.settings =
            json!({"training": {"episodes": 6}, "demand": 1, "learner": {"rate": 2}});
        let zero = Method::new("zero", "", Training::None);
        let tuner = |training, reads| Method { reads, ..Method::new("tuner", "", training) };
        let differs = |tuner: Method, now: &Manifest| {
            obstacle(&there.identity, &now.identity, (&[], &[zero, tuner]))
        };
        let tuned = Training::Tuned { episodes: "" };
        assert_eq!(differs(tuner(tuned, &[]), &now), None);
        let learns = differs(tuner(Training::Learned, &[]), &now).unwrap();
        assert!(learns.contains("training.episodes is 100 there"));
        assert!(
            differs(tuner(tuned, &["learner"]), &now).unwrap().contains("learner.rate is 1 there")
        );
        now.identity.settings["demand"] = json!(2);
        assert!(differs(tuner(tuned, &[]), &now).unwrap().contains("demand is 1 there"));
    }
}
