//! Removes networks that nobody needs any more: those that were made with other settings stay otherwise.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::path::Path;

use super::index::Index;
use crate::network::error::NetworkError;
use crate::network_files::{BY_HASH, NetworkFiles, TEMPORARY};
use basics::files::FileError;

/// What was removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Pruned {
    /// Networks that are gone.
    pub removed: usize,
    /// Networks that are not needed, but are simulated at the moment; they stay.
    pub in_use: usize,
    /// Size of what is gone, bytes.
    pub bytes: u64,
}

/// Removes all networks of a folder but some, and those that a task holds.
///
/// # Errors
///
/// [`NetworkError`] when the index cannot be read, or something cannot be removed.
pub fn prune(
    networks: &Path,
    needed: &BTreeMap<String, NetworkFiles>,
) -> Result<Pruned, NetworkError> {
    let folder = File::open(networks).map_err(FileError::at("open", networks))?;
    folder.lock().map_err(FileError::at("lock", networks))?;
    let Some(mut index) = Index::load_if_present(networks)? else { return Ok(Pruned::default()) };
    let needed: BTreeSet<&Path> = needed.values().map(|files| files.folder.as_path()).collect();
    let mut pruned = Pruned::default();
    let mut gone: BTreeMap<OsString, File> = BTreeMap::new();
    let by_hash = networks.join(BY_HASH);
    for entry in fs::read_dir(&by_hash).into_iter().flatten() {
        let entry = entry.map_err(FileError::at("read", &by_hash))?;
        let path = entry.path();
        if needed.contains(path.as_path()) || !path.is_dir() {
            continue;
        }
        let lock = File::open(&path).map_err(FileError::at("open", &path))?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => pruned.in_use += 1,
            // Without locks, a task that reads it notices that it has gone.
            Ok(()) | Err(TryLockError::Error(_)) => drop(gone.insert(entry.file_name(), lock)),
        }
    }
    let is_gone =
        |place: &str| Path::new(place).file_name().is_some_and(|name| gone.contains_key(name));
    index.retain(|row| !is_gone(&row.folder));
    index.write()?;
    let temporary = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(networks);
    let temporary = temporary.map_err(FileError::at("create a folder in", networks))?;
    for name in gone.keys() {
        let path = by_hash.join(name);
        pruned.bytes += bytes(&path);
        // First out of the way: half a network is not to be found there.
        fs::rename(&path, temporary.path().join(name)).map_err(FileError::at("remove", &path))?;
        pruned.removed += 1;
    }
    remove_dangling(networks)?;
    let path = temporary.path().to_path_buf();
    temporary.close().map_err(FileError::at("remove", &path))?;
    Ok(pruned)
}

/// Removes the links that lead to networks that have gone.
fn remove_dangling(networks: &Path) -> Result<(), FileError> {
    for entry in fs::read_dir(networks).map_err(FileError::at("read", networks))? {
        let path = entry.map_err(FileError::at("read", networks))?.path();
        let ours = fs::read_link(&path).is_ok_and(|target| target.starts_with(BY_HASH));
        if ours && !path.exists() {
            fs::remove_file(&path).map_err(FileError::at("remove", &path))?;
        }
    }
    Ok(())
}

fn bytes(folder: &Path) -> u64 {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    files.filter_map(|file| file.metadata().ok()).map(|m| m.len()).sum()
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::super::index::IndexRow;
    use super::*;
    use crate::network_files::{FILE_ENDINGS, file_name};

    /// Puts a network of a point MDP into a folder, with files that hold nothing but its name.
    fn put(networks: &Path, point: &str) -> NetworkFiles {
        let mut index = Index::load_if_present(networks).unwrap().unwrap_or(Index::empty(networks));
        let sha256 = || basics::hash::sha256(point.as_bytes());
        let mut row = IndexRow {
            point: point.into(),
            spec_sha256: point.into(),
            net_sha256: sha256(),
            routes_sha256: sha256(),
            demand_sha256: sha256(),
            sumocfg_sha256: sha256(),
            ..IndexRow::default()
        };
        row.folder = row.place();
        let files = NetworkFiles::new(networks, point, row.sha256());
        fs::create_dir_all(&files.folder).unwrap();
        for ending in FILE_ENDINGS {
            fs::write(files.folder.join(file_name(point, ending)), point).unwrap();
        }
        symlink(&row.folder, networks.join(point)).unwrap();
        index.insert(row);
        index.write().unwrap();
        files
    }

    #[test]
    fn what_is_neither_needed_nor_in_use_goes() {
        let networks = tempfile::tempdir().unwrap();
        let (kept, used) = (put(networks.path(), "kept"), put(networks.path(), "used"));
        let needed = BTreeMap::from([("kept".to_owned(), kept)]);
        let task = File::open(&used.folder).unwrap();
        task.lock_shared().unwrap();
        let in_use = Pruned { in_use: 1, ..Pruned::default() };
        assert_eq!(prune(networks.path(), &needed).unwrap(), in_use);
        assert!(networks.path().join("used/used.net.xml").exists());
        drop(task);
        let removed = Pruned { removed: 1, in_use: 0, bytes: 16 };
        assert_eq!(prune(networks.path(), &needed).unwrap(), removed);
        assert!(!networks.path().join("used").is_symlink() && !used.folder.exists());
        let index = Index::load_if_present(networks.path()).unwrap().unwrap();
        index.verify(index.row("kept", "kept").unwrap()).unwrap();
        assert_eq!((index.rows().count(), fs::read_dir(networks.path()).unwrap().count()), (1, 3));
    }
}
