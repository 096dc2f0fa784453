//! Folders that are written into: one with something else in it is refused without `--force`.

use crate::cli::exit::refuse;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use rustix::fs::{Access, access};

use crate::files::{FileError, beneath};
use crate::traffic::city::networks_folder;
use crate::traffic::network_files::BY_HASH;
use crate::traffic::settings::Preset;

/// Files that are no one's work.
const NOTHING: [&str; 3] = [".gitkeep", ".gitignore", ".DS_Store"];

/// Most files that a message names.
const NAMED: usize = 3;

/// What a folder is for: what messages call it, and how to tell by its files that it is one already.
pub(super) struct Kind {
    what: &'static str,
    own: fn(&str) -> bool,
}

const fn kind(what: &'static str, own: fn(&str) -> bool) -> Kind {
    Kind { what, own }
}

/// What `run` writes.
pub(super) const RESULTS: Kind = kind("results directory", |name| {
    ["manifest.json", "lock.json", "run.jsonl.xz"].contains(&name)
});

/// What `build-networks` writes.
pub(super) const NETWORKS: Kind = kind("folder of networks", |name| name == BY_HASH);

/// What `build-networks --osm` writes: networks are there first, and alone if it was interrupted.
pub(super) const CITY: Kind = kind("folder that build-networks --osm wrote", |name| {
    ["scenario.toml", "approaches.csv", "quality.json"].contains(&name)
        || Preset::value_variants().iter().any(|preset| networks_folder(*preset) == name)
});

/// What `routes` writes of an episode.
pub(super) const EPISODE: Kind = kind("folder that routes wrote", |name| name == "episode.sumocfg");

/// What `report` writes; with `--against`, all of it is in a folder of it.
pub(super) const REPORT: Kind =
    kind("folder that report wrote", |name| name == "scores.csv" || name.starts_with("against-"));

/// What `estimate` writes.
pub(super) const ESTIMATE: Kind = kind("folder that estimate wrote", |name| name == "errors.csv");

/// What `sensitivity` writes.
pub(super) const SENSITIVITY: Kind =
    kind("folder that sensitivity wrote", |name| name == "distributions.csv");

impl Kind {
    /// Checks that a folder is missing, empty or of the kind, or that it is to be written in spite of
    /// that.
    pub(super) fn check(&self, path: &Path, flag: &str, force: Option<bool>) -> anyhow::Result<()> {
        if path.exists() && !path.is_dir() {
            let path = path.display();
            return refuse(format!("{flag} {path} is a file; give the path of a folder"));
        }
        if !path.exists() || force == Some(true) {
            return Ok(());
        }
        let entries = fs::read_dir(path).map_err(FileError::at("read", path))?;
        let names = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = names.collect();
        names.retain(|name| !NOTHING.contains(&name.as_str()));
        names.sort();
        let own = |name: &String| (self.own)(name);
        if names.is_empty() || names.iter().any(own) {
            return Ok(());
        }
        let mut others = names.into_iter().filter(|name| !own(name));
        let mut named = others.by_ref().take(NAMED).collect::<Vec<_>>().join(", ");
        let more = others.count();
        if more > 0 {
            named.push_str(&format!(" and {more} more"));
        }
        let way_out = if force.is_some() { ", or --force to write into it anyway" } else { "" };
        refuse(format!(
            "{flag} {} is not empty and no {} (it holds {named}); give another folder{way_out}",
            path.display(),
            self.what
        ))
    }
}

/// Refuses to replace a file that is not what this command writes.
pub(super) fn check_file(
    path: &Path,
    flag: &str,
    begins: &[&[u8]],
    what: &str,
) -> anyhow::Result<()> {
    let shown = path.display();
    let about = match fs::symlink_metadata(path) {
        Ok(about) => about,
        // Whoever writes will say what is wrong with the folder.
        Err(_) => return Ok(()),
    };
    let wrong = |why: String| refuse(format!("{flag} {shown} {why}"));
    if about.is_dir() {
        return wrong("is a folder; give the path of a file".to_owned());
    }
    let longest = begins.iter().map(|begin| begin.len()).max().unwrap_or_default();
    let mut head = Vec::new();
    let read =
        fs::File::open(path).and_then(|file| file.take(longest as u64).read_to_end(&mut head));
    if about.is_file()
        && read.is_ok()
        && (head.is_empty() || begins.iter().any(|b| head.starts_with(b)))
    {
        return Ok(());
    }
    wrong(format!("is there and is no {what}; give another path, or remove it first"))
}

/// A folder to write to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Target {
    /// The folder itself or one above it, beneath which nothing is written through links.
    pub(super) root: PathBuf,
    /// The folder.
    pub(super) folder: PathBuf,
    is_given: bool,
}

impl Target {
    /// Returns the usual folder in a results directory, or the one that `--out` gives.
    pub(super) fn new(root: &Path, usual: PathBuf, out: Option<&PathBuf>) -> Self {
        let is_given = out.is_some();
        let folder = out.cloned().unwrap_or(usual);
        let root = if is_given { folder.clone() } else { root.to_path_buf() };
        Self { root, folder, is_given }
    }

    /// Checks, before anything is computed, that the folder can be written, is not reached through a link and holds
    /// nothing else.
    pub(super) fn check(&self, kind: &Kind) -> anyhow::Result<()> {
        if self.is_given {
            kind.check(&self.folder, "--out", None)?;
        }
        beneath(&self.root, &self.folder)?;
        // A results directory that is not there is named by whoever reads it.
        if !self.is_given && !self.root.exists() {
            return Ok(());
        }
        let Err(e) = access(self.there(), Access::WRITE_OK) else {
            return Ok(());
        };
        let reason = std::io::Error::from(e);
        let way_out =
            if self.is_given { "give another folder" } else { "give a folder with --out" };
        let folder = self.folder.display();
        refuse(format!("cannot write to {folder}: {reason}; {way_out}"))
    }

    /// Returns the folder, or where it is to be made the nearest one above it that is there.
    fn there(&self) -> &Path {
        let there = self.folder.ancestors().find(|folder| folder.exists());
        there.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(files: &[&str], kind: &Kind, force: Option<bool>) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            fs::write(folder.path().join(file), "").unwrap();
        }
        let error = kind.check(folder.path(), "--out", force).err()?;
        Some(error.to_string().replace(&folder.path().display().to_string(), "DIR"))
    }

    #[test]
    fn a_folder_of_other_things_is_refused_unless_it_is_forced() {
        let files = ["thesis.tex", "a", "b", "c", ".gitkeep"];
        assert_eq!(
            check(&files, &RESULTS, Some(false)).unwrap(),
            "--out DIR is not empty and no results directory (it holds a, b, c and 1 more); give \
             another folder, or --force to write into it anyway"
        );
        assert_eq!(check(&files, &RESULTS, Some(true)), None);
        assert!(check(&files, &NETWORKS, None).unwrap().ends_with("give another folder"));
    }

    #[test]
    fn a_folder_of_the_kind_and_an_empty_one_are_taken() {
        assert_eq!(check(&[], &RESULTS, Some(false)), None);
        assert_eq!(check(&[".gitkeep"], &RESULTS, Some(false)), None);
        assert_eq!(check(&["manifest.json", "notes.md"], &RESULTS, Some(false)), None);
        assert_eq!(check(&["by-hash", "busy"], &NETWORKS, None), None);
    }

    #[test]
    fn a_file_is_no_folder() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let e = RESULTS.check(file.path(), "--out", Some(true)).unwrap_err().to_string();
        assert!(e.ends_with("is a file; give the path of a folder"), "{e}");
    }

    #[test]
    fn only_a_file_of_the_kind_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            check_file(&path, "--out", &[b"<routes"], "route file").err().map(|e| e.to_string())
        };
        assert_eq!(at("a.rou.xml", "<routes>\n</routes>\n"), None);
        assert_eq!(at("empty", ""), None);
        let refused = at("manifest.json", "{}").unwrap();
        assert!(refused.ends_with(
            "manifest.json is there and is no route file; give another path, or remove it first"
        ));
        let missing = check_file(&folder.path().join("new"), "--out", &[b"<routes"], "route file");
        assert!(missing.is_ok());
        let e = check_file(folder.path(), "--out", &[b"<routes"], "route file").unwrap_err();
        assert!(e.to_string().ends_with("is a folder; give the path of a file"), "{e}");
    }
}
