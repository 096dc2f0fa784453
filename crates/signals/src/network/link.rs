//! Links that lead people from the name of a point MDP to its network; nothing that is simulated goes by them.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use crate::network_files::{BY_HASH, TEMPORARY};
use basics::files::FileError;

/// Lets the link of a point MDP lead to a network's folder.
///
/// # Arguments
///
/// * `networks` — the folder of networks.
/// * `folder` — of the network, within it.
///
/// # Errors
///
/// [`FileError`] when the link cannot be made, or its name is that of something else.
pub(super) fn link(networks: &Path, point: &str, folder: &Path) -> Result<(), FileError> {
    let link = networks.join(point);
    let target = Path::new(BY_HASH).join(folder.file_name().expect("a hash is a name"));
    if fs::read_link(&link).is_ok_and(|now| now == target) {
        return Ok(());
    }
    let failed = |e| FileError::at("write the link", &link)(e);
    let temporary = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(networks);
    let temporary = temporary.map_err(FileError::at("create a folder in", networks))?;
    let draft = temporary.path().join(point);
    symlink(&target, &draft).map_err(failed)?;
    fs::rename(&draft, &link).map_err(|e| FileError::at("write the link", &link)(e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_follows_the_network_that_was_asked_for_last() {
        let networks = tempfile::tempdir().unwrap();
        for hash in ["aa", "bb", "bb"] {
            let folder = networks.path().join(BY_HASH).join(hash);
            fs::create_dir_all(&folder).unwrap();
            link(networks.path(), "p", &folder).unwrap();
            let target = fs::canonicalize(networks.path().join("p")).unwrap();
            assert_eq!(target, fs::canonicalize(&folder).unwrap());
        }
        assert_eq!(fs::read_dir(networks.path()).unwrap().count(), 2);
    }
}
