//! Files that are either as before or complete: a draft, synced, then renamed.
//!
//! A process that is killed while it writes leaves its draft. Whoever writes into the same folder next
//! removes it: drafts have a name of their own and are locked by whoever writes them.

use std::collections::BTreeSet;
use std::fs::{self, File, Permissions, TryLockError};
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, SystemTime};

use tempfile::NamedTempFile;

use super::{FileError, make_folder_beneath};

/// How the names of drafts begin.
const DRAFT: &str = ".tsc-family-draft-";

/// Age from which on a draft that nobody has locked is what a killed process left behind: between making and
/// locking one nothing happens.
const ABANDONED: Duration = Duration::from_secs(5);

/// Age from which on it is so where files cannot be locked.
const LONG_ABANDONED: Duration = Duration::from_secs(3600);

/// Folders that this process has already tidied up.
static TIDIED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Returns the permissions of files that others may read, less the user's umask; drafts would be
/// private otherwise, which is of no use on a shared disk.
pub fn readable() -> Permissions {
    Permissions::from_mode(0o666)
}

/// Writes a file so that it is either as before or complete: a draft beside it, synced and renamed.
///
/// # Errors
///
/// [`FileError`] when the folder cannot be written; nothing is left behind.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    write_by_way_of(parent.unwrap_or(Path::new(".")), path, bytes)
}

/// Writes a file beneath a root so that it is either as before or complete, with the draft in another folder
/// beneath it. Both folders are made where they are missing, and neither may be reached through a link.
///
/// # Errors
///
/// [`FileError`] when a folder is a link or cannot be written; nothing is left behind.
pub fn replace(root: &Path, path: &Path, drafts: &Path, bytes: &[u8]) -> Result<(), FileError> {
    for folder in path.parent().into_iter().chain([drafts]) {
        make_folder_beneath(root, folder)?;
    }
    write_by_way_of(drafts, path, bytes)
}

fn write_by_way_of(drafts: &Path, path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    tidy_up_once(drafts);
    let mut draft = draft(drafts)?;
    draft
        .write_all(bytes)
        .and_then(|()| draft.as_file().sync_all())
        .map_err(FileError::at("write", path))?;
    draft.persist(path).map_err(|e| FileError::at("write", path)(e.error))?;
    Ok(())
}

/// Makes a file beneath a root, locked as drafts are and with this in it from the beginning, in place of what stands there:
/// that stays as it is under any other name that it has. The draft is made in another folder beneath the root, and neither may
/// be reached through a link.
///
/// # Errors
///
/// [`FileError`] when a folder or the file is a link, or cannot be written.
pub fn new_beneath(
    root: &Path,
    path: &Path,
    drafts: &Path,
    bytes: &[u8],
) -> Result<File, FileError> {
    for folder in path.parent().into_iter().chain([drafts]) {
        make_folder_beneath(root, folder)?;
    }
    super::beneath(root, path)?;
    let mut draft = draft(drafts)?;
    draft.write_all(bytes).map_err(FileError::at("write", path))?;
    draft.persist(path).map_err(|e| FileError::at("write", path)(e.error))
}

/// Makes a draft, locked where the file system knows locks.
fn draft(folder: &Path) -> Result<NamedTempFile, FileError> {
    let mut builder = tempfile::Builder::new();
    let draft = builder.prefix(DRAFT).permissions(readable()).tempfile_in(folder);
    let draft = draft.map_err(FileError::at("create", folder))?;
    // Without locks, age tells what was abandoned.
    let _ = draft.as_file().try_lock();
    Ok(draft)
}

/// Removes drafts that killed processes left in a folder, once per process and folder.
fn tidy_up_once(folder: &Path) {
    let is_new = TIDIED.lock().is_ok_and(|mut tidied| tidied.insert(folder.to_path_buf()));
    let entries = is_new.then(|| fs::read_dir(folder).ok()).flatten();
    for entry in entries.into_iter().flatten().flatten() {
        let is_draft = entry.file_name().to_string_lossy().starts_with(DRAFT);
        if is_draft && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let path = entry.path();
            if is_abandoned(&path) {
                // Another process may have been first.
                let _ = fs::remove_file(&path);
            }
        }
    }
}

fn is_abandoned(draft: &Path) -> bool {
    let Ok(file) = File::open(draft) else { return false };
    let written = file.metadata().and_then(|about| about.modified());
    let age = written.ok().and_then(|at| SystemTime::now().duration_since(at).ok());
    let older = |than: Duration| age.is_some_and(|age| age > than);
    match file.try_lock() {
        Ok(()) => older(ABANDONED),
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => older(LONG_ABANDONED),
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
        let long_ago = SystemTime::now() - 2 * ABANDONED;
        let left = at(&format!("{DRAFT}left"));
        let others = [at(".tmpA1b2C3"), at("notes.txt")];
        for path in others.iter().chain([&left]) {
            fs::write(path, "x").unwrap();
            File::options().write(true).open(path).unwrap().set_modified(long_ago).unwrap();
        }
        let used = draft(folder.path()).unwrap();
        used.as_file().set_modified(long_ago).unwrap();
        write_atomically(&at("new"), b"y").unwrap();
        assert!(!left.exists() && used.path().exists() && others.iter().all(|p| p.exists()));
        drop(used);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "no draft is left");
    }
}
