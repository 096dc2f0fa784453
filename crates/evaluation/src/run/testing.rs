//! A domain without a simulator, for tests of whatever plans, trains and evaluates.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::{Map, Value, json};

use super::domain::{
    Course, Domain, Effort, EffortOf, Objective, Prepared, PreparedPoint, Problem, Site, Trial,
};
use super::fault::{Cause, TrialError};
use super::method::{Method, Training};
use super::plan::{Request, complete, draft};
use crate::family::{Feature, MdpFamily, PointMdp};
use crate::sample::Choice;
use crate::stats::Direction;
use crate::store::manifest::{Manifest, Provenance, Task};
use crate::store::record::Metrics;
use basics::files::FileError;
use learners::nn::archive::{Archive, ArchiveError};

/// A method that learns nothing, but is never twice the same: its scores follow a state that every episode changes.
#[derive(Debug, Clone, Default)]
pub(super) struct Counting {
    /// Episodes of training.
    pub(super) episodes: u32,
    pub(super) done: u32,
    pub(super) state: u32,
    /// Episode after which training fails as if the process had been killed.
    pub(super) dies_after: Option<u32>,
    /// Episode in which training diverges.
    pub(super) diverges_in: Option<u32>,
    /// Whether it refuses checkpoints.
    pub(super) stubborn: bool,
    /// Whether it learns.
    pub(super) learns: bool,
    /// Whether its episodes find the disk full.
    pub(super) disk_full: bool,
    /// Seeds of its episodes.
    pub(super) seeds: Vec<u64>,
}

impl Counting {
    /// Returns one that trains for so many episodes.
    pub(super) fn of(episodes: u32) -> Self {
        Self { episodes, learns: true, ..Self::default() }
    }

    fn archive(&self) -> Archive {
        let mut archive = Archive::default();
        archive.put("kind", "whatever the method likes");
        archive.put("done", self.done);
        archive.put_u32("state", &[2], &[self.done, self.state]);
        archive
    }
}

impl Trial for Counting {
    fn train(&mut self, course: &mut dyn Course) -> Result<(), TrialError> {
        if let Some(saved) = course.saved() {
            let wanted: &[usize] = if self.stubborn { &[9] } else { &[2] };
            let fail = |e: ArchiveError| TrialError::Model(e);
            self.done = saved.get("done").map_err(fail)?;
            self.state = saved.u32("state", wanted).map_err(fail)?[1];
        }
        while self.done < self.episodes {
            let seed = course.seed(self.done);
            let mut metrics = self.episode(seed)?;
            metrics.insert("loss".to_owned(), 0.5);
            course.episode(seed, metrics);
            if self.diverges_in == Some(self.done) {
                return Err(TrialError::Diverged(format!("it diverged in {}", self.done)));
            }
            self.done += 1;
            course.checkpoint(&|| self.archive(), 0.25)?;
            if self.dies_after == Some(self.done) {
                return Err(TrialError::Failed("killed".into()));
            }
        }
        Ok(())
    }

    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        if self.disk_full {
            let full = std::io::Error::other("no space is left");
            return Err(FileError::at("write", Path::new("x"))(full).into());
        }
        self.seeds.push(seed);
        self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let score = f64::from(self.state >> 16) + (seed % 7) as f64;
        Ok(Metrics::from([("score".to_owned(), score)]))
    }

    fn model(&self) -> Option<Archive> {
        self.learns.then(|| self.archive())
    }

    fn simulator_s(&self) -> f64 {
        0.25
    }
}

/// A domain of [`Counting`] methods.
pub(super) struct Toy {
    /// What trials of the method `learner` are.
    pub(super) learner: Counting,
}

const fn method(name: &'static str, training: Training) -> Method {
    Method { default: true, ..Method::new(name, "for tests", training) }
}

const METHODS: [Method; 4] = [
    method("zero", Training::None),
    method("tuner", Training::Tuned { episodes: "episodes" }),
    method("learner", Training::Learned),
    method("other", Training::None),
];

impl Domain for Toy {
    fn name(&self) -> &'static str {
        "toy"
    }
    fn objective(&self) -> Objective {
        Objective::new("score", "score", "", Direction::Higher)
    }
    fn baseline(&self) -> Option<&'static str> {
        Some("zero")
    }
    fn methods(&self) -> &[Method] {
        &METHODS
    }
    fn trial(&self, _: &Site<'_>, method: &str, _: u64) -> Result<Box<dyn Trial>, TrialError> {
        Ok(Box::new(match method {
            "learner" => self.learner.clone(),
            _ => Counting::default(),
        }))
    }
    fn efforts(&self, _: &Value) -> Result<Box<EffortOf>, String> {
        Ok(Box::new(|_, _, _| Effort {
            training: 0,
            training_s: 0.0,
            evaluation: 0,
            evaluation_s: 1.0,
            is_informed: true,
        }))
    }
    fn card(&self, settings: &Value, _: &str) -> Result<Map<String, Value>, String> {
        Ok(Map::from_iter([("settings".to_owned(), settings["learner"].clone())]))
    }
}

/// Two point MDPs.
pub(super) struct Pair(MdpFamily);

impl Pair {
    /// Returns the problem.
    pub(super) fn new() -> Self {
        let point = |id: &str, importance: f64, x: f64| PointMdp {
            id: id.to_owned(),
            title: id.to_owned(),
            features: vec![x],
            importance,
            instances: 1,
        };
        let points = vec![point("quiet", 0.75, 1.0), point("busy", 0.25, 2.0)];
        let feature = Feature { name: "x".to_owned(), unit: String::new() };
        Self(MdpFamily::new("pair", vec![feature], points, "test").unwrap())
    }
}

impl Problem for Pair {
    fn family(&self) -> &MdpFamily {
        &self.0
    }
    fn settings(&self) -> Value {
        json!({"learner": {"hidden": 64}})
    }
    fn prepare(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<Prepared, Cause> {
        let mut points = BTreeMap::new();
        for point in chosen {
            done(point);
            let made = PreparedPoint { content: (*point).to_owned(), ..PreparedPoint::default() };
            points.insert((*point).to_owned(), made);
        }
        Ok(Prepared { simulator: "none".to_owned(), folder: String::new(), points })
    }
}

/// Returns the plan of all methods on the two point MDPs.
pub(crate) fn planned(evaluation_seeds: u32) -> (Manifest, Vec<Task>) {
    let methods = ["tuner", "learner"].map(str::to_owned);
    with_request(&methods, evaluation_seeds, 1)
}

/// Returns the plan of some methods.
pub(crate) fn with_request(
    methods: &[String],
    evaluation_seeds: u32,
    replicates: u32,
) -> (Manifest, Vec<Task>) {
    let (toy, pair) = (Toy { learner: Counting::of(2) }, Pair::new());
    let request = request(&toy, &pair, methods, evaluation_seeds, replicates);
    let draft = draft(&request).unwrap();
    let prepared = pair.prepare(&draft.chosen(), &|_| {}).unwrap();
    complete(&request, &draft, prepared, nowhere()).unwrap()
}

/// Returns a request for all point MDPs.
pub(super) fn request<'a>(
    toy: &'a Toy,
    pair: &'a Pair,
    methods: &'a [String],
    evaluation_seeds: u32,
    replicates: u32,
) -> Request<'a> {
    Request {
        domain: toy,
        problem: pair,
        choice: &Choice::All,
        methods,
        base_seed: 0,
        evaluation_seeds,
        seeds: None,
        replicates,
        replace: &[],
    }
}

/// Returns the provenance of a run that nobody began.
pub(super) fn nowhere() -> Provenance {
    Provenance {
        command: String::new(),
        git: String::new(),
        rustc: String::new(),
        host: String::new(),
        started: String::new(),
        networks: String::new(),
        warnings: Vec::new(),
        memory_per_worker_mb: None,
        assisting: None,
    }
}
