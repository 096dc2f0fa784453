//! Links in a results directory that a run would write through.

use std::fs;
use std::path::Path;

use super::Layout;
use basics::files::{FileError, beneath, make_folder};

impl Layout {
    /// Makes the directory where it is missing, and checks that no folder which a run writes into is a link.
    ///
    /// Whoever writes checks the folders on the way once more; here everything is named before anything runs.
    ///
    /// # Errors
    ///
    /// [`FileError`] naming the link.
    pub fn make(&self) -> Result<(), FileError> {
        make_folder(self.root())?;
        let numbered = [self.record(0), self.log(0), self.model(0), self.checkpoint(0)];
        let folders = numbered.iter().filter_map(|file| file.parent()?.parent());
        for folder in folders.chain([&*self.tmp(), &*self.report(), &*self.jobs()]) {
            self.check(folder)?;
        }
        Ok(())
    }

    fn check(&self, folder: &Path) -> Result<(), FileError> {
        beneath(self.root(), folder)?;
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_symlink()) && entry.path().is_dir() {
                beneath(self.root(), &entry.path())?;
            }
        }
        Ok(())
    }
}
