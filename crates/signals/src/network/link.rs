//! Links that lead people from the name of a point MDP to its network; nothing that is simulated goes by them.

use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::path::Path;

use crate::network_files::{BY_HASH, FILE_ENDINGS, TEMPORARY, file_name};
use basics::files::FileError;

/// Lets the link of a point MDP lead to a network's folder; a folder of that name in which an earlier version
/// kept the network makes room.
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
    if fs::symlink_metadata(&link).is_ok_and(|m| m.is_dir()) {
        remove_earlier(&link, point).map_err(FileError::at("replace", &link))?;
    }
    fs::rename(&draft, &link).map_err(|e| FileError::at("write the link", &link)(e))
}

/// Removes a folder that holds the files of a network and nothing else.
fn remove_earlier(folder: &Path, point: &str) -> io::Result<()> {
    let own = FILE_ENDINGS.map(|ending| file_name(point, ending));
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        if !own.iter().any(|own| name == own.as_str()) {
            let reason = format!("it holds {}, which is no part of a network", name.display());
            return Err(io::Error::other(reason));
        }
    }
    fs::remove_dir_all(folder)
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

    #[test]
    fn a_folder_of_an_earlier_version_makes_room_and_one_of_other_things_does_not() {
        let networks = tempfile::tempdir().unwrap();
        let folder = networks.path().join(BY_HASH).join("aa");
        fs::create_dir_all(&folder).unwrap();
        let (earlier, other) = (networks.path().join("p"), networks.path().join("q"));
        fs::create_dir(&earlier).unwrap();
        fs::write(earlier.join("p.net.xml"), "<net/>").unwrap();
        link(networks.path(), "p", &folder).unwrap();
        assert!(earlier.is_symlink());
        fs::create_dir(&other).unwrap();
        fs::write(other.join("thesis.tex"), "").unwrap();
        let e = link(networks.path(), "q", &folder).unwrap_err().to_string();
        assert!(e.contains("it holds thesis.tex, which is no part of a network"), "{e}");
        assert!(other.join("thesis.tex").exists());
    }
}
