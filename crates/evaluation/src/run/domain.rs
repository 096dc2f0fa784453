//! The seam between evaluation and what is evaluated.
//!
//! A [`Domain`] knows its methods and makes [`Trial`]s of them; a [`Problem`] is a scenario of a domain,
//! read, with its family. What an observation or an action is stays behind the two, so that sampling,
//! plan, executors, records, statistics and reports serve every domain.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::error::RunError;
use super::fault::{Cause, CheckpointError, TrialError};
use super::method::Method;
use crate::family::MdpFamily;
use crate::stats::{Direction, Limit};
use crate::store::Layout;
use crate::store::manifest::{Identity, PointRow};
use crate::store::opaque::Opaque;
use crate::store::own::OwnMethod;
use crate::store::record::{Metrics, Row};
use basics::files::FileError;
use learners::nn::archive::{Archive, ArchiveError};

/// What scores compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Objective {
    /// Name of the metric, with the unit as a suffix where it has one: `delay_s`.
    pub metric: &'static str,
    /// What people call it: `delay`.
    pub title: &'static str,
    /// Unit, empty where it has none.
    pub unit: &'static str,
    /// Whether less of it is better.
    pub direction: Direction,
    /// The most that it can be, where there is such a bound.
    pub most: Option<f64>,
}

impl Objective {
    /// Returns an objective without a bound.
    pub const fn new(
        metric: &'static str,
        title: &'static str,
        unit: &'static str,
        direction: Direction,
    ) -> Self {
        Self { metric, title, unit, direction, most: None }
    }
}

/// A kind of task, such as traffic signals or CartPole, with the methods that can be evaluated on it.
pub trait Domain: Sync {
    /// Stable name, as in manifests.
    fn name(&self) -> &'static str;

    /// What scores compare.
    fn objective(&self) -> Objective;

    /// Name of the method that scores are divided by, which every run has; `None` where the objective
    /// itself is the score.
    fn baseline(&self) -> Option<&'static str>;

    /// What people call a row of training in the records, and a sentence on what it is, if it is no single episode.
    fn training_row(&self) -> (&'static str, &'static str) {
        ("episode", "")
    }

    /// Returns beyond which value of a metric a method counts as failed on a point MDP; `None` where nobody has
    /// said.
    fn failure(&self) -> Option<Limit> {
        None
    }

    /// Returns the context feature that says how much there is of a point MDP, by which people may weigh it beside
    /// its importance.
    fn volume(&self) -> Option<&'static str> {
        None
    }

    /// Returns the sections of settings that decide what every method meets in an episode of a seed: with others, episodes of
    /// one seed are not the same.
    fn episode_sections(&self) -> &'static [&'static str] {
        &["environment"]
    }

    /// All methods, the baseline first.
    fn methods(&self) -> &[Method];

    /// Returns what a method consists of that somebody added to the domain; `None` for those that it has itself.
    fn own(&self, method: &str) -> Result<Option<OwnMethod>, FileError> {
        let _ = method;
        Ok(None)
    }

    /// Returns a method on a point MDP, untrained.
    ///
    /// # Arguments
    ///
    /// * `seed` — of everything random in the method.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when a file is not the one that was planned, or the simulator is missing.
    fn trial(&self, site: &Site<'_>, method: &str, seed: u64)
    -> Result<Box<dyn Trial>, TrialError>;

    /// Says why trials cannot work in a results directory or with prepared files of this path; `Ok` where they can.
    fn check_path(&self, path: &Path) -> Result<(), String> {
        let _ = path;
        Ok(())
    }

    /// Returns the prepared files of a point MDP that are not as planned.
    ///
    /// # Arguments
    ///
    /// * `prepared` — folder of what [`Problem::prepare`] made.
    fn spoilt(&self, point: &PointRow, prepared: &Path) -> Vec<Spoilt> {
        let _ = (point, prepared);
        Vec::new()
    }

    /// Returns what every episode of a seed has on a point MDP, whatever method acts there, as a metric with its value, such as
    /// the number of vehicles; `None` where nothing follows from the seed alone.
    ///
    /// # Arguments
    ///
    /// * `prepared` — folder of what [`Problem::prepare`] made.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when a file is missing or not the one that was planned.
    fn episode_extent(
        &self,
        point: &PointRow,
        prepared: &Path,
        seed: u64,
    ) -> Result<Option<(&'static str, f64)>, TrialError> {
        let _ = (point, prepared, seed);
        Ok(None)
    }

    /// Returns how many agents act on a point MDP of a run, at least one; methods that are tuned take
    /// episodes for each.
    fn agents(&self, point: &PointRow) -> u32 {
        let _ = point;
        1
    }

    /// Returns what tells how much work a task is, of a method on a point MDP with these context features.
    ///
    /// # Arguments
    ///
    /// * `settings` — the scenario's, as in the manifest.
    fn efforts(&self, settings: &Value) -> Result<Box<EffortOf>, String>;

    /// Returns what the card of a model says beside what evaluation knows: the settings that it takes
    /// to set the method up again.
    ///
    /// # Errors
    ///
    /// What is missing, in words.
    fn card(&self, settings: &Value, method: &str) -> Result<Map<String, Value>, String>;
}

/// Returns the domain of a manifest.
///
/// # Arguments
///
/// * `domains` — those that it may be of.
pub fn domain_of<'a>(
    domains: &[&'a dyn Domain],
    layout: &Layout,
    identity: &Identity,
) -> Result<&'a dyn Domain, RunError> {
    let domain = domains.iter().find(|domain| domain.name() == identity.domain).copied();
    let unknown = || RunError::Domain { path: layout.manifest(), domain: identity.domain.clone() };
    domain.ok_or_else(unknown)
}

/// A prepared file that is not as planned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spoilt {
    /// The file.
    pub path: PathBuf,
    /// Whether it is there at all.
    pub is_there: bool,
    /// Whether [`Problem::prepare`] makes it again.
    pub is_made: bool,
}

/// Where a trial takes place.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// The scenario's settings, as in the manifest.
    pub settings: &'a Value,
    /// The point MDP.
    pub point: &'a PointRow,
    /// Folder of what [`Problem::prepare`] made.
    pub prepared: &'a Path,
    /// Folder for files of the running episode.
    pub scratch: &'a Path,
}

/// A method on a point MDP. Environment and method are one object here: nothing outside needs to know
/// what passes between them.
pub trait Trial {
    /// Trains or tunes the method; one without training does nothing.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when an episode fails, the training diverges or a checkpoint does not fit.
    fn train(&mut self, course: &mut dyn Course) -> Result<(), TrialError>;

    /// Runs one episode without learning and returns its metrics by name, the objective among them.
    ///
    /// # Arguments
    ///
    /// * `seed` — of everything random in the episode; the same for every method.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when it fails.
    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError>;

    /// Runs one episode to judge a policy while or after it is trained: as [`Self::episode`], but it leaves
    /// what evaluation draws at random as it is.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when it fails.
    fn validate(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        self.episode(seed)
    }

    /// Returns what has been learned; `None` for methods that do not learn.
    fn model(&self) -> Option<Archive> {
        None
    }

    /// Takes over what [`Self::model`] returned of this trial earlier in its training.
    ///
    /// # Errors
    ///
    /// [`TrialError::Model`] when it does not fit.
    fn load(&mut self, model: &Archive) -> Result<(), TrialError> {
        let _ = model;
        Err(TrialError::Model(ArchiveError::Card("method that learns".to_owned())))
    }

    /// Returns what a record's summary says of the training, from its rows.
    fn training_metrics(&self, rows: &[Row]) -> Metrics {
        let _ = rows;
        Metrics::new()
    }

    /// Returns what the method wants recorded of itself, such as the plan that tuning found.
    fn details(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    /// Returns what ran in the last episode, in the domain's own form.
    fn programs(&self) -> Opaque {
        Opaque::default()
    }

    /// Returns what the evaluation episodes are made of, in the domain's own form, such as results by movement.
    fn parts(&self) -> Opaque {
        Opaque::default()
    }

    /// Wall-clock time within the simulator so far, seconds.
    fn simulator_s(&self) -> f64 {
        0.0
    }

    /// Checks that what was read is still what was planned; asked for when the task is over, before anything of
    /// it counts.
    fn verify(&self) -> Result<(), TrialError> {
        Ok(())
    }
}

/// What a training has learned so far, as validation sees it.
pub trait Policy {
    /// Runs one episode without exploring and without learning; training goes on afterwards as if it had not been.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when it fails.
    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError>;

    /// Returns what has been learned; `None` where it cannot be kept, so that no earlier policy can be chosen.
    fn model(&self) -> Option<Archive>;
}

/// A trial as its own policy: for domains whose episodes change nothing that training depends on.
pub struct Played<'a, T>(pub &'a mut T);

impl<T: Trial> Policy for Played<'_, T> {
    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        self.0.validate(seed)
    }

    fn model(&self) -> Option<Archive> {
        self.0.model()
    }
}

/// A training as the task keeps it: its seeds, its rows and how far it has come.
pub trait Course {
    /// Returns the `index`-th training seed.
    fn seed(&self, index: u32) -> u64;

    /// Adds the row of a training episode.
    fn episode(&mut self, seed: u64, metrics: Metrics);

    /// Returns the state that an earlier attempt at this training left; `None` starts anew.
    fn saved(&mut self) -> Option<Archive>;

    /// Offers the policy for validation; called after every row of training, before [`Self::checkpoint`].
    ///
    /// # Errors
    ///
    /// [`TrialError`] when an episode of validation fails.
    fn validate(&mut self, policy: &mut dyn Policy) -> Result<(), TrialError> {
        let _ = policy;
        Ok(())
    }

    /// Returns whether validation has found nothing better for so long that training ends here; asked before every row of
    /// training, the first after [`Self::saved`] included: the state that was kept may be that of the last row.
    fn stops(&self) -> bool {
        false
    }

    /// Returns how often the training has started again; the seed of everything random in the method follows from it.
    fn restarts(&self) -> u32 {
        0
    }

    /// Says after a row of training whether the network is alive. Returns whether training starts again from its first
    /// episode, with the next number of [`Self::restarts`]; the rows so far are discarded then.
    fn starts_again(&mut self, is_alive: bool) -> bool {
        let _ = is_alive;
        false
    }

    /// Offers the state of a training that can go on from here, at the end of an episode; it is only
    /// asked for when it is time to keep it, or when the task is asked to stop.
    ///
    /// # Arguments
    ///
    /// * `simulator_s` — wall-clock time within the simulator so far, seconds.
    fn checkpoint(
        &mut self,
        state: &dyn Fn() -> Archive,
        simulator_s: f64,
    ) -> Result<(), CheckpointError>;
}

/// A scenario of a domain, read: its family, and what its point MDPs are prepared from.
pub trait Problem: Sync {
    /// The point MDPs.
    fn family(&self) -> &MdpFamily;

    /// All settings, as manifests keep them.
    fn settings(&self) -> Value;

    /// Returns how many agents act on a point MDP of the family, as [`Domain::agents`] does once it is prepared.
    fn agents(&self, point: &str) -> u32 {
        let _ = point;
        1
    }

    /// Makes what trials on these point MDPs need, where it is missing.
    ///
    /// # Arguments
    ///
    /// * `chosen` — ids of point MDPs of the family.
    /// * `done` — called with the id of each that was made.
    ///
    /// # Errors
    ///
    /// What cannot be made, and why.
    fn prepare(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<Prepared, Cause>;

    /// Returns the method that does what is done today on every point MDP, where that is known.
    fn today(&self) -> Option<&'static str> {
        None
    }

    /// Whether a method can run on every point MDP, as far as that is known before anything is prepared.
    fn can_run(&self, method: &Method) -> bool {
        let _ = method;
        true
    }

    /// Says what a method lacks to run on some point MDPs; `None` where it can.
    fn lacking(&self, method: &str, chosen: &BTreeSet<&str>) -> Option<String> {
        let _ = (method, chosen);
        None
    }

    /// Looks at what is evaluated, and returns what a reader of the results should know of it.
    fn warnings(&self) -> Result<Vec<String>, Cause> {
        Ok(Vec::new())
    }

    /// Writes what reports show beside records; it decides no record.
    ///
    /// # Arguments
    ///
    /// * `stands` — per point MDP of the family the one that stands for it, if any.
    ///
    /// # Errors
    ///
    /// What cannot be read or written.
    fn write_for_reports(&self, layout: &Layout, stands: &[Option<usize>]) -> Result<(), Cause> {
        let _ = (layout, stands);
        Ok(())
    }
}

/// Tells how much work a task is, by method, by the number of agents and by the context features of the point
/// MDP.
pub type EffortOf = dyn Fn(&Method, u32, &dyn Fn(&str) -> Option<f64>) -> Effort + Sync;

/// How much work a task is: episodes of training or tuning at most, and processor time per episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Episodes of training or tuning, at most.
    pub training: u32,
    /// Processor time of one of them, seconds.
    pub training_s: f64,
    /// Episodes of validation and evaluation, at most; 0 as a domain says it.
    pub evaluation: u32,
    /// Processor time of one of them, seconds.
    pub evaluation_s: f64,
    /// Whether the times rest on what is known of the point MDP; else only their ratio is of use.
    pub is_informed: bool,
}

/// What was made for a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prepared {
    /// Name and version of the simulator.
    pub simulator: String,
    /// Folder of the files, empty where there are none.
    pub folder: String,
    /// By id of the point MDP.
    pub points: BTreeMap<String, PreparedPoint>,
}

/// What was made for a point MDP.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PreparedPoint {
    /// What trials take place in, in the domain's words.
    pub environment: String,
    /// Hash of what the point MDP is, from which its seeds follow; not of its name or path.
    pub content: String,
    /// sha256 by file name.
    pub sha256: BTreeMap<String, String>,
    /// Latitude and longitude of what it stands for, degrees; empty where that is nowhere.
    pub places: Vec<[f64; 2]>,
    /// What the command line said in place of what these files say, in the domain's words.
    pub given: BTreeMap<String, Value>,
}
