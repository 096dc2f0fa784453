//! A run from its plan to its records, as the command does it and as programs can.
//!
//! [`open`] prepares what is missing, writes the plan and takes the lock of the results directory; [`Session::local`] does
//! tasks.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

use super::checkpoint::CHECKPOINT_EVERY_S;
use super::domain::{Domain, Problem, domain_of};
use super::error::RunError;
use super::executor::local::GRACE;
use super::executor::{Launcher, Local};
use super::plan::{Draft, Request, complete, establish, take_along};
use super::progress::{Failure, Fault};
use super::stop::Stop;
use super::watchdog::STALL_TIMEOUT_S;
use super::work::{Workplace, do_task};
use crate::sample::{SamplePlan, stands};
use crate::store::Layout;
use crate::store::lock;
use crate::store::manifest::{GIT, Identity, Manifest, Provenance, Task};
use crate::store::packed::unpack;
use crate::store::record::Record;
use crate::store::results::Results;
use crate::store::scratch::{Scratch, tidy_up};
use crate::store::wall::Wall;
use basics::files::{FileError, beneath};
use basics::machine::memory_per_worker_mb;

/// A run whose plan is written, in a results directory that is locked for it.
pub struct Session<'a> {
    domain: &'a dyn Domain,
    /// The results directory.
    pub layout: Layout,
    /// What the run is.
    pub manifest: Arc<Manifest>,
    /// Folder of what was prepared.
    pub prepared: PathBuf,
    /// Where something was added to a run that was there, how many of its records stay.
    pub kept: Option<usize>,
    _lock: File,
}

/// Opens a run: a new one, or one that was begun in the same folder before.
///
/// # Arguments
///
/// * `draft` — who is evaluated where, from [`super::plan::draft`].
/// * `out` — the results directory.
/// * `done` — called with the id of each point MDP that something was made for.
///
/// # Errors
///
/// [`RunError`] when something cannot be prepared, or when the folder holds another run or is in use.
pub fn open<'a>(
    request: &Request<'a>,
    draft: &Draft,
    out: &Path,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Session<'a>, RunError> {
    request.domain.check_path(out).map_err(RunError::Refused)?;
    let prepared = request.problem.prepare(&draft.chosen(), done).map_err(RunError::Prepare)?;
    let folder = PathBuf::from(&prepared.folder);
    let mut provenance = provenance(&prepared.folder, draft.memory_per_worker_mb);
    let started = provenance.started.clone();
    provenance.warnings = request.problem.warnings().map_err(RunError::Prepare)?;
    provenance.assisting = request.choice.assisting().cloned();
    let (manifest, tasks) = complete(request, draft, prepared, provenance)?;
    let layout = Layout::new(out);
    layout.make()?;
    let lock = lock(&layout, &started)?;
    let design = draft.design.as_ref();
    let change = (request.replace, request.domain.methods());
    let (manifest, kept) = establish(&layout, manifest, &tasks, design, change)?;
    let (domain, manifest) = (request.domain, Arc::new(manifest));
    let session = Session { domain, layout, manifest, prepared: folder, kept, _lock: lock };
    session.stand_in(request.problem, &draft.sample)?;
    tidy_up(&session.layout)?;
    Ok(session)
}

/// Opens a run that was begun before, without its scenario: what it is stands in its manifest.
///
/// # Arguments
///
/// * `domains` — those that it may be of.
/// * `manifest` — that of the directory.
/// * `prepared` — folder of what was prepared; it is not looked at.
///
/// # Errors
///
/// [`RunError`] when the folder holds no run, is in use, or is of none of the domains.
pub fn reopen<'a>(
    domains: &[&'a dyn Domain],
    layout: &Layout,
    manifest: Arc<Manifest>,
    prepared: PathBuf,
) -> Result<Session<'a>, RunError> {
    let domain = domain_of(domains, layout, &manifest.identity)?;
    for path in [layout.root(), &prepared] {
        domain.check_path(path).map_err(RunError::Refused)?;
    }
    let lock = lock(layout, &now())?;
    Ok(Session { domain, layout: layout.clone(), manifest, prepared, kept: None, _lock: lock })
}

/// Opens a run that follows from another one: the records of it that are of the new one's tasks too are taken along, so that
/// nothing is simulated or trained for them again. A folder that has the new run already is gone on with.
///
/// # Arguments
///
/// * `from` — the other run; packed records are read as they are.
/// * `identity` — what the new run is; its methods may be known to `domain` alone.
/// * `out` — its results directory.
pub fn open_after<'a>(
    domain: &'a dyn Domain,
    from: &Results,
    identity: Identity,
    out: &Path,
    prepared: PathBuf,
) -> Result<Session<'a>, RunError> {
    for path in [out, &prepared] {
        domain.check_path(path).map_err(RunError::Refused)?;
    }
    let provenance = provenance(&prepared.display().to_string(), None);
    let (started, tasks) = (provenance.started.clone(), identity.tasks());
    let layout = Layout::new(out);
    layout.make()?;
    let lock = lock(&layout, &started)?;
    let manifest = Manifest { identity, provenance };
    let (manifest, kept) = establish(&layout, manifest, &tasks, from.design.as_ref(), (&[], &[]))?;
    take_along(from, &layout, &manifest)?;
    tidy_up(&layout)?;
    let manifest = Arc::new(manifest);
    Ok(Session { domain, layout, manifest, prepared, kept, _lock: lock })
}

/// Takes the lock of a results directory, and unpacks it if it is packed.
fn lock(layout: &Layout, started: &str) -> Result<File, RunError> {
    let lock = lock::take(layout, started)?;
    unpack(layout)?;
    Ok(lock)
}

/// Returns the time, ISO 8601, UTC, to the second.
pub fn now() -> String {
    jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

impl Session<'_> {
    /// Removes the records of failed tasks, so that they are tried again.
    pub fn forget_failed(&self) -> Result<(), RunError> {
        let all = Results::load_known(&self.layout, &self.manifest)?;
        for (task, _) in all.failed() {
            let path = self.layout.record(task.task);
            beneath(self.layout.root(), &path)?;
            fs::remove_file(&path).map_err(FileError::at("remove", &path))?;
        }
        Ok(())
    }

    /// Writes for reports which point MDPs of a sample stand for those that are not in it; of a sample that grows, this is
    /// to be repeated at every look.
    pub fn stand_in(&self, problem: &dyn Problem, sample: &SamplePlan) -> Result<(), RunError> {
        let stands = stands(problem.family(), sample);
        problem.write_for_reports(&self.layout, &stands).map_err(RunError::Prepare)
    }

    /// Returns the executor that starts workers, so many at a time; each may use its share of the machine's memory.
    pub fn local(&self, launcher: Launcher, jobs: usize) -> Local {
        Local {
            layout: self.layout.clone(),
            manifest: self.manifest.sha256(),
            launcher,
            prepared: self.prepared.clone(),
            jobs,
            stall_timeout: Duration::from_secs(STALL_TIMEOUT_S),
            grace: GRACE,
            memory_per_worker_mb: memory_per_worker_mb(jobs),
        }
    }

    /// Does a task in this process. A simulator that ends the process takes the run with it, and nothing is tried twice.
    fn task(&self, task: &Task) -> Result<(), RunError> {
        let scratch = Scratch::new(&self.layout, task.task)?;
        let workplace = Workplace {
            layout: self.layout.clone(),
            prepared: self.prepared.clone(),
            scratch: scratch.path().to_path_buf(),
            attempt: 1,
            checkpoint_every: Duration::from_secs(CHECKPOINT_EVERY_S),
            stop: Stop::default(),
        };
        let start = Instant::now();
        let Err(error) = do_task(self.domain, &self.manifest, task, &workplace, &mut |_| {}) else {
            return Ok(());
        };
        let Failure { fault, reason } = Failure::of(&error);
        match fault {
            Fault::Machine | Fault::Simulator => return Err(error),
            Fault::Disturbed => return Ok(()),
            Fault::Input | Fault::Task | Fault::Own => {}
        }
        let wall_s = start.elapsed().as_secs_f64();
        let wall = Wall { wall_s, attempts: 1, git: GIT.to_owned(), ..Wall::default() };
        Ok(Record::failed(task, &self.manifest.sha256(), reason, wall).commit(&self.layout)?)
    }
}

/// Evaluates methods on a problem in this process, from the plan to the results.
///
/// A folder that has the same run already is gone on with: finished tasks are kept and not done again, failed ones
/// too ([`Session::forget_failed`]). What a run is does not say how a method of one's own is written, so one that has
/// changed needs a new folder. A task that fails is no error here: see [`Results::failed`].
///
/// # Errors
///
/// [`RunError`], as [`open`], and when a task shows that the machine is at fault or the simulator missing.
pub fn evaluate(request: &Request<'_>, out: &Path) -> Result<Results, RunError> {
    let draft = super::plan::draft(request)?;
    let session = open(request, &draft, out, &|_| {})?;
    let results = Results::load(&session.layout)?;
    results.missing().try_for_each(|task| session.task(task))?;
    Ok(Results::load(&session.layout)?)
}

fn provenance(prepared: &str, memory_per_worker_mb: Option<u64>) -> Provenance {
    let processors = available_parallelism().map_or(1, std::num::NonZero::get);
    let mut args = std::env::args_os();
    let program = args.next().unwrap_or_default();
    let program = Path::new(&program).file_name().unwrap_or_default().to_owned();
    let words = std::iter::once(program).chain(args);
    let words: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    Provenance {
        // As a shell takes it again.
        command: shlex::try_join(words.iter().map(String::as_str)).unwrap_or(words.join(" ")),
        git: GIT.to_owned(),
        rustc: env!("TSC_FAMILY_RUSTC").to_owned(),
        host: format!(
            "{} {}, {processors} processors",
            std::env::consts::OS,
            std::env::consts::ARCH
        ),
        started: now(),
        networks: prepared.to_owned(),
        warnings: Vec::new(),
        memory_per_worker_mb,
        assisting: None,
    }
}
