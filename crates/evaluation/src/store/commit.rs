//! Puts a record into its place, once and for all.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use super::Layout;
use super::record::{Outcome, Record};
use basics::files::{FileError, beneath, make_folder_beneath, readable};

impl Record {
    /// Writes the record so that it is either absent or complete, and never replaced: into `tmp/`,
    /// synced, then linked into place. Another attempt that was first wins.
    ///
    /// The task's checkpoint is of no use any more and is removed: after the record of a success, so
    /// that nothing is lost if this process is killed in between; before that of a failure, so that
    /// whoever removes the record to try again starts from the beginning.
    pub fn commit(&self, layout: &Layout) -> Result<(), FileError> {
        if self.summary.outcome == Outcome::Failed {
            remove_checkpoint(layout, self.summary.task)?;
        }
        self.link(layout)?;
        remove_checkpoint(layout, self.summary.task)
    }

    fn link(&self, layout: &Layout) -> Result<(), FileError> {
        let path = layout.record(self.summary.task);
        let folder = path.parent().expect("a record lies in a folder");
        let tmp = layout.tmp();
        for d in [folder, &tmp] {
            make_folder_beneath(layout.root(), d)?;
        }
        // A name that no other process has, on any host that shares the disk; the file is removed
        // when it is dropped, and is by then a second name of the record or of no use.
        let mut draft = tempfile::Builder::new()
            .prefix(&format!("{}.", self.summary.task))
            .permissions(readable())
            .tempfile_in(&tmp)
            .map_err(FileError::at("create", &tmp))?;
        self.write_to(draft.as_file_mut()).map_err(FileError::at("write", draft.path()))?;
        link_into_place(draft.path(), &path)?;
        sync_folder(folder)
    }

    fn write_to(&self, file: &mut File) -> std::io::Result<()> {
        file.write_all(self.to_text().as_bytes())?;
        file.sync_all()
    }
}

/// Removes what a training has left to go on from, if anything.
pub fn remove_checkpoint(layout: &Layout, task: usize) -> Result<(), FileError> {
    for path in [layout.checkpoint(task), layout.before(task)] {
        beneath(layout.root(), &path)?;
        match fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(FileError::at("remove", &path)(e));
            }
            _ => {}
        }
    }
    Ok(())
}

fn link_into_place(draft: &Path, path: &Path) -> Result<(), FileError> {
    match fs::hard_link(draft, path) {
        Ok(()) => Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => Ok(()),
        // Some file systems have no hard links; a rename is atomic but could replace an equal
        // record of another attempt, which does no harm.
        Err(_) if !path.exists() => fs::rename(draft, path).map_err(FileError::at("write", path)),
        Err(e) => Err(FileError::at("write", path)(e)),
    }
}

/// Makes a new name in a folder durable.
fn sync_folder(folder: &Path) -> Result<(), FileError> {
    File::open(folder).and_then(|f| f.sync_all()).map_err(FileError::at("sync", folder))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::manifest::Task;
    use crate::store::record::TaskResult;
    use crate::store::wall::Wall;

    fn task() -> Task {
        Task { task: 7, method: "m".into(), point: "p".into(), replicate: 0, seed: 3 }
    }

    fn record(wall_s: f64) -> Record {
        let wall = Wall { wall_s, ..Wall::default() };
        Record::finished(&task(), "abc", TaskResult { wall, ..TaskResult::default() })
    }

    #[test]
    fn the_first_of_two_attempts_wins() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        record(1.0).commit(&layout).unwrap();
        record(2.0).commit(&layout).unwrap();
        let read = Record::read(&layout, &task(), "abc").unwrap().unwrap();
        assert_eq!(read.summary.wall.wall_s, 1.0);
        assert_eq!(fs::read_dir(layout.tmp()).unwrap().count(), 0);
    }

    #[test]
    fn a_record_ends_its_task_s_checkpoint_whatever_the_outcome() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let checkpoint = layout.checkpoint(7);
        for record in
            [record(1.0), Record::failed(&task(), "abc", "no network".into(), Wall::default())]
        {
            fs::create_dir_all(checkpoint.parent().unwrap()).unwrap();
            fs::write(&checkpoint, "state").unwrap();
            record.commit(&layout).unwrap();
            assert!(!checkpoint.exists());
        }
    }
}
