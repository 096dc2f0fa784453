//! `run.jsonl.xz`: a published run in one file, read as it is.
//!
//! Its first line has the documents of the run, the others are its records in the order of the tasks, without checksums and
//! numbers of tasks: a record is found by method, point MDP and replicate. Of training it has [`Trained`], and of a training
//! without validation every tenth episode.
//!
//! It counts where there is no folder `done/`: a folder is newer than what was packed of it. Commands that write records
//! unpack it first.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Layout;
use super::manifest::{Manifest, Task};
use super::opaque::Opaque;
use super::record::{Metrics, Outcome, Record, Row, RowKind, Summary, Trained, mean_metrics};
use super::wall::Wall;
use crate::store::error::{Remedy, StoreError};
use basics::files::{self, FileError, limits, make_folder_beneath, replace, write_atomically};

/// Most bytes that a run may have unpacked: what a machine holds in memory.
const MOST_BYTES: u64 = 1 << 33;

/// Level of compression.
const LEVEL: u32 = 9;

/// Episodes of training of which one is packed, where there is no validation.
const THINNED: u32 = 10;

/// Documents of a run that are packed, where they are there.
const DOCUMENTS: [&str; 4] = ["manifest.json", "design.json", "dropped.json", "places.json"];

/// A record without what follows from its task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PackedRecord {
    method: String,
    point: String,
    replicate: u32,
    outcome: Outcome,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// Those of the summary that are not means over the evaluation.
    metrics: Metrics,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    details: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "Opaque::is_empty")]
    programs: Opaque,
    #[serde(default, skip_serializing_if = "Opaque::is_empty")]
    parts: Opaque,
    training: Trained,
    rows: Vec<Row>,
    wall: Wall,
}

/// The records of a packed run, by method, point MDP and replicate.
#[derive(Debug)]
pub struct Packed {
    path: PathBuf,
    records: HashMap<(String, String, u32), PackedRecord>,
}

fn is_packed(layout: &Layout) -> bool {
    !layout.root().join("done").exists() && layout.packed().exists()
}

impl Layout {
    /// Returns a document of the run, from its own file or from the packed run; `None` where there is none.
    pub fn document(&self, name: &str) -> Result<Option<Vec<u8>>, StoreError> {
        let own = files::if_present(files::read(&self.root().join(name), limits::DOCUMENT))?;
        if own.is_some() || !is_packed(self) {
            return Ok(own);
        }
        let mut documents = documents(&self.packed(), &mut open(&self.packed())?)?;
        Ok(documents.remove(name).map(String::into_bytes))
    }
}

impl Packed {
    /// Returns the records of a packed run; `None` where it is not packed.
    ///
    /// # Errors
    ///
    /// [`StoreError::Damaged`] for a file that is damaged, or has other things.
    pub fn of(layout: &Layout) -> Result<Option<Self>, StoreError> {
        if !is_packed(layout) {
            return Ok(None);
        }
        let path = layout.packed();
        let mut file = open(&path)?;
        documents(&path, &mut file)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(|e| damaged(&path, &e))?;
        let lines: Vec<&str> = text.lines().collect();
        let read = |line: &&str| serde_json::from_str::<PackedRecord>(line);
        let read: Result<Vec<_>, _> = lines.par_iter().map(read).collect();
        let read = read.map_err(|e| damaged(&path, &e))?;
        let count = read.len();
        let key = |r: PackedRecord| ((r.method.clone(), r.point.clone(), r.replicate), r);
        let records: HashMap<_, _> = read.into_iter().map(key).collect();
        match records.len() == count {
            true => Ok(Some(Self { path, records })),
            false => Err(damaged(&path, &"it has a record twice")),
        }
    }

    /// Returns the record of a task; `None` where there is none.
    ///
    /// # Errors
    ///
    /// [`StoreError::Damaged`] for numbers that nothing can be computed with.
    pub fn record(&self, task: &Task, manifest: &str) -> Result<Option<Record>, StoreError> {
        let key = (task.method.clone(), task.point.clone(), task.replicate);
        let Some(packed) = self.records.get(&key) else { return Ok(None) };
        let record = packed.clone().unpacked(task, manifest);
        record.check().map_err(|reason| damaged(&self.path, &reason))?;
        Ok(Some(record))
    }
}

impl PackedRecord {
    fn of(record: &Record, manifest: &Manifest) -> Self {
        let (Record { summary, rows }, identity) = (record.clone(), &manifest.identity);
        let training = record.trained(&identity.objective, identity.direction);
        let is_validated = rows.iter().any(|row| row.kind == RowKind::Validation);
        let is_thin = |row: &Row| row.episode % THINNED == THINNED - 1;
        let is_kept = |row: &Row| match row.kind {
            RowKind::Training => training.learns && !is_validated && is_thin(row),
            _ => true,
        };
        let means = mean_metrics(&rows);
        let metrics = summary.metrics.into_iter();
        Self {
            method: summary.method,
            point: summary.point,
            replicate: summary.replicate,
            outcome: summary.outcome,
            reason: summary.reason,
            metrics: metrics.filter(|(name, _)| !means.contains_key(name)).collect(),
            details: summary.details,
            programs: summary.programs,
            parts: summary.parts,
            training,
            rows: rows.into_iter().filter(is_kept).collect(),
            wall: Wall { checksum: String::new(), ..summary.wall },
        }
    }

    fn unpacked(self, task: &Task, manifest: &str) -> Record {
        let mut summary = Summary::new(task, manifest, self.outcome, self.wall);
        summary.reason = self.reason;
        summary.metrics = self.metrics;
        summary.metrics.extend(mean_metrics(&self.rows));
        summary.details = self.details;
        summary.programs = self.programs;
        summary.parts = self.parts;
        summary.training = Some(self.training);
        Record { summary, rows: self.rows }.sealed()
    }
}

/// Packs a run into a file, which is either as before or complete; returns how many episodes it has.
pub fn pack<'a>(
    layout: &Layout,
    manifest: &Manifest,
    records: impl Iterator<Item = &'a Record>,
    to: &Path,
) -> Result<usize, StoreError> {
    let mut documents = BTreeMap::new();
    for name in DOCUMENTS {
        let text = layout.document(name)?.map(String::from_utf8).transpose();
        let text = text.map_err(|e| damaged(&layout.root().join(name), &e))?;
        documents.extend(text.map(|text| (name, text)));
    }
    let mut lines = vec![serde_json::to_string(&documents)];
    let mut episodes = 0;
    for record in records {
        let packed = PackedRecord::of(record, manifest);
        episodes += packed.rows.len();
        lines.push(serde_json::to_string(&packed));
    }
    let mut writer = liblzma::write::XzEncoder::new(Vec::new(), LEVEL);
    let written = lines.into_iter().try_for_each(|line| writeln!(writer, "{}", line?));
    let bytes = written.and_then(|()| writer.finish()).map_err(FileError::at("write", to))?;
    write_atomically(to, &bytes)?;
    Ok(episodes)
}

/// Turns a packed run into one that can go on, its records last; does nothing where it is not packed.
pub fn unpack(layout: &Layout) -> Result<(), StoreError> {
    let Some(packed) = Packed::of(layout)? else { return Ok(()) };
    let manifest = Manifest::read(layout)?;
    let sha256 = manifest.sha256();
    let draft = Layout::new(layout.tmp().join("unpacked"));
    for task in manifest.identity.tasks() {
        if let Some(record) = packed.record(&task, &sha256)? {
            let text = record.to_text();
            replace(layout.root(), &draft.record(task.task), &layout.tmp(), text.as_bytes())?;
        }
    }
    for (name, text) in documents(&packed.path, &mut open(&packed.path)?)? {
        replace(layout.root(), &layout.root().join(name), &layout.tmp(), text.as_bytes())?;
    }
    let (from, to) = (draft.root().join("done"), layout.root().join("done"));
    make_folder_beneath(layout.root(), &from)?;
    Ok(fs::rename(&from, &to).map_err(FileError::at("write", &to))?)
}

fn open(path: &Path) -> Result<impl BufRead + use<>, StoreError> {
    Ok(BufReader::new(liblzma::read::XzDecoder::new(files::open(path)?).take(MOST_BYTES)))
}

/// Reads the first line.
fn documents(path: &Path, file: &mut impl BufRead) -> Result<BTreeMap<String, String>, StoreError> {
    let mut line = String::new();
    file.read_line(&mut line).map_err(|e| damaged(path, &e))?;
    let documents: BTreeMap<String, String> =
        serde_json::from_str(&line).map_err(|e| damaged(path, &e))?;
    match documents.keys().find(|name| !DOCUMENTS.contains(&name.as_str())) {
        None => Ok(documents),
        Some(name) => Err(damaged(path, &format!("it has {name:?}, which no packed run has"))),
    }
}

fn damaged(path: &Path, reason: &dyn std::fmt::Display) -> StoreError {
    StoreError::damaged(path, reason, Remedy::Restore)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::testing::with_request;
    use crate::stats::Direction;
    use crate::store::record::TaskResult;
    use crate::store::results::Results;

    fn row(kind: RowKind, episode: u32) -> Row {
        let metrics = Metrics::from([("score".to_owned(), 0.5), ("return".to_owned(), 1.25)]);
        Row { kind, episode, seed: 7, metrics }
    }

    fn repack(results: &Results, layout: &Layout) {
        let records = results.done().map(|row| row.1);
        pack(layout, &results.manifest, records, &layout.packed()).unwrap();
    }

    /// Packs a run with a record per task, whose last task failed, into a folder of its own.
    fn packed(folder: &Path, kinds: &[RowKind]) -> (Layout, Results, Vec<u8>) {
        let layout = Layout::new(folder.join("r"));
        layout.make().unwrap();
        let (manifest, tasks) = with_request(&["tuner".to_owned()], 2, 1);
        let sha256 = manifest.sha256();
        fs::write(layout.manifest(), manifest.to_json()).unwrap();
        let training = (0..20).map(|episode| row(RowKind::Training, episode));
        let rows: Vec<Row> = training.chain(kinds.iter().map(|kind| row(*kind, 1))).collect();
        let (last, others) = tasks.split_last().unwrap();
        for task in others {
            let result = TaskResult { rows: rows.clone(), ..TaskResult::default() };
            Record::finished(task, &sha256, result).commit(&layout).unwrap();
        }
        Record::failed(last, &sha256, "it fell".into(), Wall::default()).commit(&layout).unwrap();
        let before = Results::load(&layout).unwrap();
        repack(&before, &layout);
        fs::remove_dir_all(layout.root().join("done")).unwrap();
        fs::remove_file(layout.manifest()).unwrap();
        let bytes = fs::read(layout.packed()).unwrap();
        (layout, before, bytes)
    }

    #[test]
    fn all_but_episodes_of_training_comes_back_packed_and_unpacked() {
        let dir = tempfile::tempdir().unwrap();
        let (layout, before, bytes) =
            packed(dir.path(), &[RowKind::Validation, RowKind::Evaluation]);
        let read = || Results::load(&layout).unwrap();
        let after = read();
        assert_eq!(after.manifest, before.manifest);
        for ((task, before), (other, after)) in before.done().zip(after.done()) {
            assert_eq!(task, other);
            let rows = before.rows.iter().filter(|row| row.kind != RowKind::Training);
            assert!(rows.eq(&after.rows) && before.summary.metrics == after.summary.metrics);
            assert_eq!(before.summary.reason, after.summary.reason);
            let trained = |record: &Record| record.trained("score", Direction::Lower);
            assert_eq!(trained(before), trained(after));
        }
        unpack(&layout).unwrap();
        assert!(!is_packed(&layout) && read() == after);
        repack(&read(), &layout);
        assert!(fs::read(layout.packed()).unwrap() == bytes);
    }

    #[test]
    fn every_tenth_episode_is_left_of_a_training_without_validation() {
        let dir = tempfile::tempdir().unwrap();
        let (layout, ..) = packed(dir.path(), &[RowKind::Evaluation]);
        let results = Results::load(&layout).unwrap();
        let record = results.done().next().unwrap().1;
        let episodes: Vec<u32> = record.training().map(|row| row.episode).collect();
        assert_eq!(episodes, [9, 19]);
    }

    #[test]
    fn a_damaged_file_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let (layout, _, bytes) = packed(dir.path(), &[]);
        fs::write(layout.packed(), &bytes[..bytes.len() / 2]).unwrap();
        let e = Packed::of(&layout).unwrap_err();
        assert!(matches!(&e, StoreError::Damaged(all) if all[0].path == layout.packed()), "{e}");
    }
}
