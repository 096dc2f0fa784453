//! Files that are either as before or complete: a draft, synced, then renamed.
//! A process that is killed leaves its draft; whoever writes into the same folder next removes it after a while.

use std::collections::BTreeSet;
use std::fs::{self, File, Permissions};
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use super::{FileError, make_folder_beneath};

const DRAFT: &str = ".tsc-family-draft-";

/// Age from which on a draft is what a killed process left behind.
const ABANDONED: Duration = Duration::from_secs(3600);

static TIDIED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Returns the permissions of files that others may read, less the user's umask; drafts would be private otherwise.
pub fn readable() -> Permissions {
    Permissions::from_mode(0o666)
}

/// Writes a file so that it is either as before or complete: a draft beside it, synced and renamed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    by_way_of(parent.unwrap_or(Path::new(".")), path, bytes).map(drop)
}

/// Writes a file beneath a root so that it is either as before or complete, with the draft in another folder
/// beneath it. Both folders are made where they are missing, and neither may be reached through a link.
pub fn replace(root: &Path, path: &Path, drafts: &Path, bytes: &[u8]) -> Result<(), FileError> {
    for folder in path.parent().into_iter().chain([drafts]) {
        make_folder_beneath(root, folder)?;
    }
    by_way_of(drafts, path, bytes).map(drop)
}

/// The same, of a file that may not be a link either; returns it, locked. What stood there stays as it is under any other
/// name that it has.
pub fn new_beneath(
    root: &Path,
    path: &Path,
    drafts: &Path,
    bytes: &[u8],
) -> Result<File, FileError> {
    super::beneath(root, path)?;
    for folder in path.parent().into_iter().chain([drafts]) {
        make_folder_beneath(root, folder)?;
    }
    by_way_of(drafts, path, bytes)
}

fn by_way_of(drafts: &Path, path: &Path, bytes: &[u8]) -> Result<File, FileError> {
    tidy_up_once(drafts);
    let draft = tempfile::Builder::new().prefix(DRAFT).permissions(readable()).tempfile_in(drafts);
    let mut draft = draft.map_err(FileError::at("create", drafts))?;
    // Some file systems know no locks.
    let _ = draft.as_file().try_lock();
    let written = draft.write_all(bytes).and_then(|()| draft.as_file().sync_all());
    written.map_err(FileError::at("write", path))?;
    draft.persist(path).map_err(|e| FileError::at("write", path)(e.error))
}

fn tidy_up_once(folder: &Path) {
    let is_new = TIDIED.lock().is_ok_and(|mut tidied| tidied.insert(folder.to_path_buf()));
    let entries = is_new.then(|| fs::read_dir(folder).ok()).flatten();
    for entry in entries.into_iter().flatten().flatten() {
        let is_draft = entry.file_name().to_string_lossy().starts_with(DRAFT);
        let written = entry.metadata().and_then(|about| about.modified());
        let age = written.ok().and_then(|at| at.elapsed().ok());
        if is_draft && age.is_some_and(|age| age > ABANDONED) {
            // Another process may have been first.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_file_leaves_what_has_a_second_name_as_it_was() {
        let root = tempfile::tempdir().unwrap();
        let [path, other] = ["logs/0.log", "precious"].map(|name| root.path().join(name));
        fs::write(&other, "precious").unwrap();
        fs::create_dir(root.path().join("logs")).unwrap();
        fs::hard_link(&other, &path).unwrap();
        let mut new = new_beneath(root.path(), &path, &root.path().join("tmp"), b"").unwrap();
        new.write_all(b"mine").unwrap();
        assert_eq!(fs::read_to_string(&other).unwrap(), "precious");
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        assert_eq!(fs::read_dir(root.path().join("tmp")).unwrap().count(), 0, "no draft is left");
    }

    #[test]
    fn drafts_of_killed_processes_go_and_those_in_use_and_other_files_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let [left, used] = ["left", "used"].map(|name| at(&format!("{DRAFT}{name}")));
        for path in [&left, &used, &at("notes.txt")] {
            fs::write(path, "x").unwrap();
        }
        let long_ago = std::time::SystemTime::now() - 2 * ABANDONED;
        for path in [&left, &at("notes.txt")] {
            File::options().write(true).open(path).unwrap().set_modified(long_ago).unwrap();
        }
        write_atomically(&at("new"), b"y").unwrap();
        assert!(!left.exists() && used.exists() && at("notes.txt").exists());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "no draft is left");
    }
}
