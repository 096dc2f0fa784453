//! One finished task: one immutable file.
//!
//! The first line is the [`Summary`], then follows one [`Row`] per episode of training, validation and
//! evaluation. Wall-clock values stand apart: the checksum and every comparison leave them out.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::figures::{LAST_EPISODES, LAST_PREFIX, RETURN, STEPS};
use super::manifest::Task;
use super::opaque::Opaque;
use super::{Layout, SCHEMA_VERSION};
use crate::stats::Direction;
use crate::stats::score::mean;
use crate::store::error::{Remedy, StoreError};
use crate::store::wall::Wall;
use basics::files::{self, limits};
use basics::hash::hex;

/// Why a record is refused that is whole, and of another run.
pub(super) const OTHER_MANIFEST: &str = "it belongs to another manifest";

/// Named metrics; the unit is the suffix of the name.
pub type Metrics = BTreeMap<String, f64>;

/// How a task ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// All evaluations are there.
    Ok,
    /// The task failed twice; there is a reason and no metric.
    Failed,
}

/// What an episode was for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowKind {
    /// A held-out episode, the same for all methods.
    Evaluation,
    /// An episode of training or tuning.
    Training,
    /// An episode that judged a policy during or after training; its number is that of the row of training after
    /// which the policy was taken.
    Validation,
    /// A held-out episode of the last policy of a training, where an earlier one is evaluated in its place.
    Last,
}

impl RowKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Evaluation, Self::Training, Self::Validation, Self::Last];

    /// Returns its name, as in records and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Evaluation => "evaluation",
            Self::Training => "training",
            Self::Validation => "validation",
            Self::Last => "last",
        }
    }
}

/// One episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// What the episode was for.
    pub kind: RowKind,
    /// Number within its kind, from 0; of validation the row of training after which the policy was taken, from 1.
    pub episode: u32,
    /// Seed of the episode, as vehicles and simulator got it.
    pub seed: u64,
    /// What was measured.
    pub metrics: Metrics,
}

/// First line of a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// Version of the file.
    pub schema_version: u32,
    /// The task, as in the plan.
    pub task: usize,
    /// Name of the method.
    pub method: String,
    /// Id of the point MDP.
    pub point: String,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// Seed of the task.
    pub seed: u64,
    /// sha256 of the manifest's identity.
    pub manifest: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Means over the evaluation episodes, and figures of the whole training.
    pub metrics: Metrics,
    /// What the method says of itself, such as the signal plan that tuning found.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub details: BTreeMap<String, String>,
    /// What the signals ran, where that is a program; empty for methods that decide while they run, and
    /// in records from before it was kept.
    #[serde(default, skip_serializing_if = "Opaque::is_empty")]
    pub programs: Opaque,
    /// What the evaluation episodes are made of, in the domain's own form: of signals, results by movement. Empty where
    /// intersections do not have their own arms, and in records from before it was kept.
    #[serde(default, skip_serializing_if = "Opaque::is_empty")]
    pub parts: Opaque,
    /// What the training was, where its rows are kept elsewhere: in what is published.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<Trained>,
    /// Number of rows that follow.
    pub rows: usize,
    /// sha256 over the summary without `checksum` and `wall`, and over the rows.
    pub checksum: String,
    /// Wall-clock values.
    pub wall: Wall,
}

/// A training in a few figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trained {
    /// Rows of training.
    pub rows: usize,
    /// Steps of training, where a row is not an episode.
    pub steps: Option<f64>,
    /// The objective in the best row.
    pub best: Option<f64>,
    /// Its mean over the last [`LAST_EPISODES`] rows that have it.
    pub last: Option<f64>,
    /// Whether a row has a return, as only those of learners do.
    pub learns: bool,
}

/// A record: its summary and its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// First line.
    pub summary: Summary,
    /// Episodes: training first, then validation, the last policy's where another is evaluated, evaluation.
    pub rows: Vec<Row>,
}

/// What a task brought forth, before it becomes a record.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskResult {
    /// Episodes: training first, then evaluation.
    pub rows: Vec<Row>,
    /// Figures of the whole training, such as its best episode.
    pub training: Metrics,
    /// What the method says of itself.
    pub details: BTreeMap<String, String>,
    /// What the signals ran, where that is a program.
    pub programs: Opaque,
    /// What the evaluation episodes are made of.
    pub parts: Opaque,
    /// Wall-clock values.
    pub wall: Wall,
}

impl Record {
    /// Returns the record of a finished task; metrics are means over the evaluation rows, and the
    /// figures of its training.
    pub fn finished(task: &Task, manifest: &str, result: TaskResult) -> Self {
        let mut summary = Summary::new(task, manifest, Outcome::Ok, result.wall);
        summary.metrics = result.training;
        summary.metrics.extend(mean_metrics(&result.rows));
        summary.details = result.details;
        summary.programs = result.programs;
        summary.parts = result.parts;
        Self { summary, rows: result.rows }.sealed()
    }

    /// Returns the record of a task that failed.
    pub fn failed(task: &Task, manifest: &str, reason: String, wall: Wall) -> Self {
        let mut summary = Summary::new(task, manifest, Outcome::Failed, wall);
        summary.reason = Some(reason);
        Self { summary, rows: Vec::new() }.sealed()
    }

    /// Returns the evaluation episodes, in order.
    pub fn evaluations(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|r| r.kind == RowKind::Evaluation)
    }

    /// Returns the episodes of training or tuning, in order.
    pub fn training(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|r| r.kind == RowKind::Training)
    }

    /// Returns what the training was.
    pub fn trained(&self, objective: &str, direction: Direction) -> Trained {
        if let Some(trained) = self.summary.training {
            return trained;
        }
        let values: Vec<f64> =
            self.training().filter_map(|row| row.metrics.get(objective)).copied().collect();
        Trained {
            rows: self.training().count(),
            steps: self.training().last().and_then(|row| row.metrics.get(STEPS)).copied(),
            best: direction.best(values.iter().copied()),
            last: mean(&values[values.len().saturating_sub(LAST_EPISODES)..]),
            learns: self.training().any(|row| row.metrics.contains_key(RETURN)),
        }
    }

    /// Returns the record as that of a task of another plan.
    pub(crate) fn moved(&self, task: &Task, manifest: &str) -> Self {
        let mut moved = self.clone();
        moved.summary.task = task.task;
        manifest.clone_into(&mut moved.summary.manifest);
        moved.sealed()
    }

    /// Returns the record as that of a task of a comparison, with the evaluation episodes of some seeds alone.
    pub(crate) fn on_seeds(&self, task: &Task, seeds: &BTreeSet<u64>) -> Self {
        let mut record = self.clone();
        (record.summary.task, record.summary.method) = (task.task, task.method.to_string());
        let of_evaluation = |row: &Row| matches!(row.kind, RowKind::Evaluation | RowKind::Last);
        record.rows.retain(|row| !of_evaluation(row) || seeds.contains(&row.seed));
        if record.rows.len() < self.rows.len() {
            let means = mean_metrics(&record.rows);
            // Where the last policy is the evaluated one, its rows are those of the evaluation.
            let last = Some(means_of(&record.rows, RowKind::Last)).filter(|last| !last.is_empty());
            for (name, mean) in last.as_ref().unwrap_or(&means).iter() {
                let name = format!("{LAST_PREFIX}{name}");
                if record.summary.metrics.contains_key(&name) {
                    record.summary.metrics.insert(name, *mean);
                }
            }
            record.summary.metrics.extend(means);
            record.summary.parts = Opaque::default();
        }
        record.sealed()
    }

    pub(super) fn sealed(mut self) -> Self {
        self.summary.rows = self.rows.len();
        self.summary.checksum = self.checksum();
        self.summary.wall.checksum = self.summary.wall.sum(&self.summary.checksum);
        self
    }

    fn checksum(&self) -> String {
        let mut hash = self.summary.hash();
        for row in &self.rows {
            hash.update(b"\n");
            hash.update(serde_json::to_vec(row).expect("a row is plain data"));
        }
        hex(&hash.finalize())
    }

    /// Reads the record of a task; `None` when there is none.
    pub fn read(layout: &Layout, task: &Task, manifest: &str) -> Result<Option<Self>, StoreError> {
        Self::read_at(layout.record(task.task), task, manifest)
    }

    /// Reads the record of a task from a file, as [`Self::read`] does.
    pub(crate) fn read_at(
        path: PathBuf,
        task: &Task,
        manifest: &str,
    ) -> Result<Option<Self>, StoreError> {
        let text = match files::read_text(&path, limits::RECORD) {
            Ok(text) => text,
            Err(e) if e.reason.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) if e.reason.kind() == ErrorKind::InvalidData => {
                return Err(StoreError::damaged(path, "not UTF-8 text", Remedy::Repeat));
            }
            // A folder, a pipe or a device in its place.
            Err(e)
                if [ErrorKind::InvalidInput, ErrorKind::IsADirectory]
                    .contains(&e.reason.kind()) =>
            {
                return Err(StoreError::damaged(path, e.reason, Remedy::Repeat));
            }
            Err(e) => return Err(e.into()),
        };
        Self::of_text(&text, &path, task, manifest).map(Some)
    }

    fn of_text(text: &str, path: &Path, task: &Task, manifest: &str) -> Result<Self, StoreError> {
        let fail = |reason: String| StoreError::damaged(path, reason, Remedy::Repeat);
        let record = Self::parse(text).map_err(&fail)?;
        let s = &record.summary;
        if s.schema_version != SCHEMA_VERSION {
            let reason = format!("schema version {}, expected {SCHEMA_VERSION}", s.schema_version);
            return Err(fail(reason));
        }
        if s.manifest != manifest {
            return Err(fail(OTHER_MANIFEST.into()));
        }
        if (s.task, &*s.method, &*s.point, s.replicate, s.seed)
            != (task.task, &*task.method, &*task.point, task.replicate, task.seed)
        {
            return Err(fail(format!("it is of task {} ({} on {})", s.task, s.method, s.point)));
        }
        Ok(record)
    }

    /// Checks that its numbers can be computed with.
    pub(super) fn check(&self) -> Result<(), String> {
        let mut all = self.rows.iter().map(|row| &row.metrics).chain([&self.summary.metrics]);
        all.try_for_each(files::numbers::check_all)
    }

    /// Returns the text of the record's file.
    pub fn to_text(&self) -> String {
        let line = |json: serde_json::Result<String>| json.expect("a record is plain data") + "\n";
        let rows = self.rows.iter().map(|row| line(serde_json::to_string(row)));
        std::iter::once(line(serde_json::to_string(&self.summary))).chain(rows).collect()
    }

    /// Returns the record that a text is, whosever it is.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut lines = text.lines();
        let first = lines.next().ok_or("empty file")?;
        let summary: Summary = serde_json::from_str(first).map_err(|e| format!("line 1: {e}"))?;
        let rows = lines
            .enumerate()
            .map(|(i, line)| serde_json::from_str(line).map_err(|e| format!("line {}: {e}", i + 2)))
            .collect::<Result<Vec<Row>, _>>()?;
        match rows.len().cmp(&summary.rows) {
            Ordering::Equal => {}
            Ordering::Less => {
                return Err(format!("truncated: {} of {} rows", rows.len(), summary.rows));
            }
            Ordering::Greater => {
                let (has, says) = (rows.len(), summary.rows);
                return Err(format!("altered: it has {has} rows, more than the {says} of line 1"));
            }
        }
        let record = Self { summary, rows };
        record.check()?;
        // As it was written, else as whoever wrote it otherwise means it.
        let rows = text[first.len()..].strip_suffix('\n').unwrap_or_default();
        let is_as_written =
            hex(&record.summary.hash().chain_update(rows).finalize()) == record.summary.checksum;
        if !is_as_written && record.checksum() != record.summary.checksum {
            return Err("altered: the checksum does not match".into());
        }
        let Summary { checksum, wall, .. } = &record.summary;
        if !wall.checksum.is_empty() && wall.checksum != wall.sum(checksum) {
            return Err("altered: the checksum of its wall-clock values does not match".into());
        }
        Ok(record)
    }
}

impl Summary {
    /// Returns the hash of what is under the checksum here, to which that of the rows is added.
    fn hash(&self) -> Sha256 {
        let bare = Self { checksum: String::new(), wall: Wall::default(), ..self.clone() };
        Sha256::new().chain_update(serde_json::to_vec(&bare).expect("a summary is plain data"))
    }

    pub(super) fn new(task: &Task, manifest: &str, outcome: Outcome, wall: Wall) -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            task: task.task,
            method: task.method.to_string(),
            point: task.point.to_string(),
            replicate: task.replicate,
            seed: task.seed,
            manifest: manifest.to_owned(),
            outcome,
            reason: None,
            metrics: Metrics::new(),
            details: BTreeMap::new(),
            programs: Opaque::default(),
            parts: Opaque::default(),
            training: None,
            rows: 0,
            checksum: String::new(),
            wall,
        }
    }
}

/// Returns the means over the evaluation rows of every metric that all of them have.
pub fn mean_metrics(rows: &[Row]) -> Metrics {
    means_of(rows, RowKind::Evaluation)
}

/// Returns the means over the rows of a kind of every metric that all of them have.
pub fn means_of(rows: &[Row], kind: RowKind) -> Metrics {
    means(rows.iter().filter(|row| row.kind == kind).map(|row| &row.metrics))
}

/// Returns the mean of every metric that all of some sets have.
pub fn means<'a>(all: impl IntoIterator<Item = &'a Metrics>) -> Metrics {
    let all: Vec<&Metrics> = all.into_iter().collect();
    let of = |name: &String| {
        let values: Option<Vec<f64>> = all.iter().map(|own| own.get(name).copied()).collect();
        Some((name.clone(), mean(&values?)?))
    };
    all.first().into_iter().flat_map(|first| first.keys()).filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn task() -> Task {
        Task { task: 7, method: "m".into(), point: "p".into(), replicate: 0, seed: 3 }
    }

    fn row(episode: u32, delay_s: f64) -> Row {
        let metrics = Metrics::from([("delay_s".to_owned(), delay_s)]);
        Row { kind: RowKind::Evaluation, episode, seed: 1, metrics }
    }

    fn record(wall_s: f64) -> Record {
        let wall = Wall { wall_s, ..Wall::default() };
        let rows = vec![row(0, 10.0), row(1, 20.1)];
        Record::finished(&task(), "abc", TaskResult { rows, wall, ..TaskResult::default() })
    }

    #[test]
    fn wall_clock_is_not_part_of_the_checksum() {
        assert_eq!(record(1.0).summary.checksum, record(2.0).summary.checksum);
    }

    #[test]
    fn a_truncated_or_altered_record_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        record(1.0).commit(&layout).unwrap();
        let path = layout.record(7);
        let text = fs::read_to_string(&path).unwrap();
        let (keep, _) = text.trim_end().rsplit_once('\n').unwrap();
        fs::write(&path, keep).unwrap();
        let e = Record::read(&layout, &task(), "abc").unwrap_err().to_string();
        assert!(e.contains("truncated: 1 of 2 rows"), "{e}");
        let last = text.lines().last().unwrap();
        fs::write(&path, format!("{text}{last}\n")).unwrap();
        let e = Record::read(&layout, &task(), "abc").unwrap_err().to_string();
        assert!(e.contains("altered: it has 3 rows, more than the 2 of line 1"), "{e}");
        fs::write(&path, text.replace("20.1", "2.1")).unwrap();
        let e = Record::read(&layout, &task(), "abc").unwrap_err().to_string();
        assert!(e.contains("altered"), "{e}");
    }

    #[test]
    fn a_flipped_bit_of_a_record_is_refused_or_changes_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        record(1.25).commit(&layout).unwrap();
        let path = layout.record(7);
        let bytes = fs::read(&path).unwrap();
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, &flipped).unwrap();
            match Record::read(&layout, &task(), "abc") {
                Err(StoreError::Damaged(_)) => {}
                read => assert_eq!(read.unwrap().unwrap(), record(1.25), "bit {bit}"),
            }
        }
    }
}
