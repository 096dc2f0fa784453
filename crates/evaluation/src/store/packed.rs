//! `records.tar.xz`: the records of a published run in one file, read as they are.
//!
//! It counts where there is no folder `done/`: a folder is newer than what was packed of it. Commands that write records
//! refuse such a run ([`is_packed`]); those that read it take its records from the archive.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use super::Layout;
use super::manifest::Task;
use super::record::Record;
use crate::store::error::StoreError;
use basics::files::{self, limits};

/// Most bytes that the records of an archive may have together: what a machine holds in memory.
const MOST_BYTES: u64 = 1 << 33;

/// The records of an archive.
#[derive(Debug)]
pub struct Packed {
    path: PathBuf,
    /// The text of every record, by task.
    texts: HashMap<usize, String>,
}

/// Whether the records of a run are packed.
pub fn is_packed(layout: &Layout) -> bool {
    !layout.root().join("done").exists() && layout.packed().exists()
}

impl Packed {
    /// Returns the records of an archive; `None` where they are not packed.
    ///
    /// # Errors
    ///
    /// [`StoreError::Malformed`] for an archive that is damaged, or has other things than records.
    pub fn of(layout: &Layout) -> Result<Option<Self>, StoreError> {
        if !is_packed(layout) {
            return Ok(None);
        }
        Ok(Some(Self::unpacked(layout.packed())?))
    }

    /// Unpacks an archive.
    fn unpacked(path: PathBuf) -> Result<Self, StoreError> {
        let malformed = |reason: String| StoreError::Malformed { path: path.clone(), reason };
        let unpacked = liblzma::read::XzDecoder::new(files::open(&path)?).take(MOST_BYTES);
        let mut archive = tar::Archive::new(unpacked);
        let mut texts = HashMap::new();
        let damaged = |e: std::io::Error| {
            malformed(format!("the archive is damaged: {e}; restore it from a copy"))
        };
        for entry in archive.entries().map_err(damaged)? {
            let mut entry = entry.map_err(damaged)?;
            if entry.header().entry_type().is_dir() {
                continue;
            }
            let name = entry.path().map_err(damaged)?.into_owned();
            let task = task_of(&name).filter(|_| entry.header().entry_type().is_file());
            let task = task.ok_or_else(|| {
                malformed(format!("it holds {}, which is no record", name.display()))
            })?;
            if entry.size() > limits::RECORD {
                return Err(malformed(format!("{} is too large for a record", name.display())));
            }
            let mut text = String::new();
            entry.read_to_string(&mut text).map_err(damaged)?;
            if texts.insert(task, text).is_some() {
                return Err(malformed(format!("it holds {} twice", name.display())));
            }
        }
        Ok(Self { path, texts })
    }

    /// Returns the record of a task; `None` where there is none.
    ///
    /// # Errors
    ///
    /// Those of [`Record::read`].
    pub fn record(&self, task: &Task, manifest: &str) -> Result<Option<Record>, StoreError> {
        let Some(text) = self.texts.get(&task.task) else { return Ok(None) };
        Record::of_text(text, &self.path, task, manifest).map(Some)
    }
}

/// Returns the task whose record an archive calls so, such as `done/001/1005.jsonl`.
fn task_of(name: &Path) -> Option<usize> {
    let parts: Vec<Component<'_>> =
        name.components().filter(|part| *part != Component::CurDir).collect();
    let [Component::Normal(done), Component::Normal(_), Component::Normal(file)] = parts[..] else {
        return None;
    };
    let file = Path::new(file);
    let task = file.file_stem().and_then(number)?;
    let is_record = done == "done" && file.extension().is_some_and(|e| e == "jsonl");
    is_record.then_some(task)
}

/// Returns the number that a file is called by; `01` is none, as no task's file is called so.
pub(super) fn number(stem: &OsStr) -> Option<usize> {
    let text = stem.to_str()?;
    text.parse().ok().filter(|number: &usize| number.to_string() == text)
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;
    use crate::store::record::TaskResult;

    fn task(task: usize) -> Task {
        Task { task, method: "m".into(), point: "p".into(), replicate: 0, seed: 1 }
    }

    fn packed(layout: &Layout, files: &[(&str, &str)]) {
        let file = File::create(layout.packed()).unwrap();
        let mut archive = tar::Builder::new(liblzma::write::XzEncoder::new(file, 1));
        for (name, text) in files {
            let mut header = tar::Header::new_gnu();
            header.set_size(text.len() as u64);
            header.set_mode(0o644);
            archive.append_data(&mut header, name, text.as_bytes()).unwrap();
        }
        archive.into_inner().unwrap().finish().unwrap();
    }

    #[test]
    fn records_are_read_from_the_archive_until_there_is_a_folder() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        assert!(Packed::of(&layout).unwrap().is_none());
        let record = Record::finished(&task(1005), "abc", TaskResult::default());
        packed(&layout, &[("done/001/1005.jsonl", &record.to_text())]);
        let all = Packed::of(&layout).unwrap().unwrap();
        assert_eq!(all.record(&task(1005), "abc").unwrap().unwrap(), record);
        assert!(all.record(&task(7), "abc").unwrap().is_none());
        let e = all.record(&task(1005), "xyz").unwrap_err().to_string();
        assert!(e.contains("records.tar.xz") && e.contains("another manifest"), "{e}");
        std::fs::create_dir(dir.path().join("done")).unwrap();
        assert!(Packed::of(&layout).unwrap().is_none());
    }

    #[test]
    fn an_archive_of_other_things_or_a_damaged_one_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let said = || Packed::of(&layout).unwrap_err().to_string();
        packed(&layout, &[("done/000/readme.txt", "")]);
        assert!(said().contains("it holds done/000/readme.txt, which is no record"), "{}", said());
        packed(&layout, &[("done/000/1.jsonl", ""), ("done/000/1.jsonl", "")]);
        assert!(said().contains("done/000/1.jsonl twice"), "{}", said());
        let bytes = std::fs::read(layout.packed()).unwrap();
        std::fs::write(layout.packed(), &bytes[..bytes.len() / 2]).unwrap();
        assert!(said().contains("the archive is damaged"), "{}", said());
    }
}
