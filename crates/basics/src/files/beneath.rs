//! Nothing is written out of a folder: links that lie within it are not followed.
//! A results directory may come from a stranger, and a link in it (`logs/`, `done/000/`, `lock.json`) would lead what is
//! written, replaced or tidied up to wherever the stranger liked. The folder itself may be a link, as people keep results
//! on other disks; what is beneath it may not. Every folder on the way is looked at before it is used. A file that lies
//! there may have a second name elsewhere too (a hard link, as archives and `cp -l` make them), so no file is opened for
//! writing: every one is made anew and renamed into its place ([`super::new_beneath`]). That keeps out what lies there; it
//! is no fence against a process that exchanges folders while we run, which could write by itself what it wants.

use std::fs;
use std::io::{Error, ErrorKind};
use std::path::{Component, Path};

use super::FileError;

/// Checks that no folder between a root and a path, and not the path itself, is a link.
/// Fails with [`FileError`] naming the link, or saying that the path is not beneath the root.
pub fn beneath(root: &Path, path: &Path) -> Result<(), FileError> {
    let wrong = |at: &Path, reason: String| {
        Err(FileError::at("write", at)(Error::new(ErrorKind::InvalidInput, reason)))
    };
    let outside = || wrong(path, format!("it is not beneath {}", root.display()));
    let Ok(below) = path.strip_prefix(root) else { return outside() };
    let mut part = root.to_path_buf();
    for name in below.components() {
        let Component::Normal(name) = name else { return outside() };
        part.push(name);
        if fs::symlink_metadata(&part).is_ok_and(|about| about.is_symlink()) {
            let reason = "it is a link, which would lead what is written out of the folder; replace it by what it \
                          points to, or remove it";
            return wrong(&part, reason.to_owned());
        }
    }
    Ok(())
}

/// Makes a folder and those above it.
pub fn make_folder(folder: &Path) -> Result<(), FileError> {
    fs::create_dir_all(folder).map_err(FileError::at("create", folder))
}

/// Makes a folder beneath a root, and the folders between; see [`beneath`].
pub fn make_folder_beneath(root: &Path, folder: &Path) -> Result<(), FileError> {
    beneath(root, folder)?;
    make_folder(folder)
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;
    use crate::files::new_beneath;

    #[test]
    fn links_beneath_a_folder_are_refused_and_the_folder_itself_may_be_one() {
        let place = tempfile::tempdir().unwrap();
        let [real, root, away] = ["real", "root", "away"].map(|name| place.path().join(name));
        for folder in [&real, &away] {
            fs::create_dir(folder).unwrap();
        }
        symlink(&real, &root).unwrap();
        make_folder_beneath(&root, &root.join("done/000")).unwrap();
        assert!(real.join("done/000").is_dir());
        symlink(&away, root.join("logs")).unwrap();
        symlink(away.join("new"), root.join("done/000/0.jsonl")).unwrap();
        for (path, link) in
            [("logs/000", "logs"), ("logs", "logs"), ("done/000/0.jsonl", "0.jsonl")]
        {
            let path = root.join(path);
            let messages = [
                make_folder_beneath(&root, &path).unwrap_err().to_string(),
                new_beneath(&root, &path, &root, b"").unwrap_err().to_string(),
            ];
            for e in messages {
                assert!(e.contains(&format!("{link}: it is a link")), "{e}");
            }
        }
        assert_eq!(fs::read_dir(&away).unwrap().count(), 0);
        for outside in [away.clone(), root.join("..").join("away")] {
            let e = beneath(&root, &outside).unwrap_err().to_string();
            assert!(e.contains("it is not beneath"), "{e}");
        }
    }
}
