//! All files of a scenario: those that its configuration names, and those that they name in turn.
//!
//! What is found in each is in [`super::scan`].

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::obstacle::{Accept, Obstacle, Way};
use super::scan::{Scanned, scan};
use super::sumocfg::SumoConfig;
use basics::files::{self, FileError};

/// First bytes of a compressed file.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Most bytes that are read of a file once it is unpacked.
const UNPACKED: u64 = 1 << 34;

/// Most files of a scenario.
const MOST: usize = 10_000;

/// A file of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Its name as seen from the folder of the configuration.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
    /// What was found in it.
    pub scanned: Scanned,
    /// Of the files that it names, in their order: positions in [`Sources::files`]; `None` where one is in the way.
    pub names: Vec<Option<usize>>,
}

/// The files of a scenario besides its configuration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sources {
    /// First those that the configuration names, then those that they name.
    pub files: Vec<Source>,
    /// What stands in the way.
    pub obstacles: Vec<Obstacle>,
}

impl Sources {
    /// Reads the files of a configuration.
    ///
    /// # Arguments
    ///
    /// * `accept` — what the user accepts: files that lie in none of the folders that the configuration names, and networks
    ///   without classes of vehicles that only a newer SUMO knows.
    pub fn of(config: &SumoConfig, accept: &BTreeSet<Accept>) -> Self {
        let mut all = Self::default();
        let mut known: BTreeMap<PathBuf, usize> = BTreeMap::new();
        let folder_of = |path: &Path| path.parent().unwrap_or(Path::new("")).join(".");
        let mut folders: Vec<PathBuf> =
            config.folder.iter().map(|folder| folder.join(".")).collect();
        for (name, path) in &config.files {
            folders.push(folder_of(path));
            all.add(&mut known, name.clone(), path.clone());
        }
        let folders: Vec<PathBuf> =
            folders.iter().filter_map(|folder| folder.canonicalize().ok()).collect();
        let mut next = 0;
        while let Some(Source { name, path, .. }) = all.files.get(next).cloned() {
            let blocked = |reason: String, way: Way| {
                let place = path.display().to_string();
                Obstacle { place, reason, way }
            };
            let mut scanned = match open(&path) {
                Ok(opened) => scan(&path, opened),
                Err(e) => {
                    let (reason, change) = match path.exists() {
                        true => (e.reason.to_string(), ""),
                        false if name.contains('\\') => (
                            "the scenario names it in the way of Windows".to_owned(),
                            "write slashes, and the way from the folder of the file that names it",
                        ),
                        false => {
                            ("the scenario names it, but it cannot be read".to_owned(), "add it")
                        }
                    };
                    all.obstacles.push(blocked(reason, Way::Change(change)));
                    Scanned::default()
                }
            };
            all.obstacles.append(&mut scanned.obstacles);
            if accept.contains(&Accept::NewerClasses) {
                scanned.edits.extend(scanned.newer_classes.iter().cloned());
            }
            let mut names = Vec::new();
            for (named, _) in &scanned.named {
                let beside = |of: &Path| of.parent().unwrap_or(Path::new("")).join(named);
                let file = beside(&path);
                // Of what is not there, that is what is said.
                let is_within =
                    |real: PathBuf| folders.iter().any(|folder| real.starts_with(folder));
                let inside = accept.contains(&Accept::OutsideFiles)
                    || file.canonicalize().map_or(true, is_within);
                if !inside {
                    let reason =
                        format!("it draws in {}, which lies outside the scenario", file.display());
                    all.obstacles.push(blocked(reason, Way::Accept(Accept::OutsideFiles)));
                }
                let name = beside(Path::new(&name)).display().to_string();
                names.push(inside.then(|| all.add(&mut known, name, file)));
            }
            (all.files[next].scanned, all.files[next].names) = (scanned, names);
            next += 1;
            if all.files.len() > MOST {
                let reason = format!("it draws in more than {MOST} files");
                all.obstacles.push(blocked(reason, Way::Change("")));
                break;
            }
        }
        all
    }

    /// Adds a file that is not known yet, and returns its position.
    fn add(&mut self, known: &mut BTreeMap<PathBuf, usize>, name: String, path: PathBuf) -> usize {
        *known.entry(path).or_insert_with_key(|path| {
            let (path, scanned) = (path.clone(), Scanned::default());
            self.files.push(Source { name, path, scanned, names: Vec::new() });
            self.files.len() - 1
        })
    }

    /// Returns name and path of every file.
    pub fn named(&self) -> impl Iterator<Item = (&str, &Path)> {
        self.files.iter().map(|file| (file.name.as_str(), file.path.as_path()))
    }

    /// Whether a network names classes of vehicles that only a newer SUMO knows.
    pub fn has_newer_classes(&self) -> bool {
        self.files.iter().any(|file| !file.scanned.newer_classes.is_empty())
    }

    /// Whether programs change by the clock.
    pub fn has_day_plan(&self) -> bool {
        self.files.iter().any(|file| !file.scanned.day_plan.is_empty())
    }

    /// Returns the earliest departure of a vehicle, seconds.
    pub fn first_departure_s(&self) -> Option<f64> {
        self.files.iter().filter_map(|file| file.scanned.first_s).reduce(f64::min)
    }

    /// Returns the latest departure of a vehicle or end of a flow, seconds.
    pub fn last_departure_s(&self) -> Option<f64> {
        self.files.iter().filter_map(|file| file.scanned.last_s).reduce(f64::max)
    }

    /// Says what counts in place of what the files say.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let outputs = || self.files.iter().filter_map(|file| file.scanned.outputs.as_ref());
        if let Some((_, first)) = outputs().next() {
            let count: u32 = outputs().map(|(count, _)| count).sum();
            notes.push(format!("outputs are not written: {count}, the first in {first}"));
        }
        for file in &self.files {
            notes.extend(file.scanned.notes.iter().cloned());
        }
        let drawn = |file: &Source| {
            Some((file.path.display().to_string(), file.scanned.first_drawn.clone()?))
        };
        notes.extend(self.files.iter().find_map(drawn).map(|(file, flow)| {
            format!(
                "SUMO draws the vehicles of flows with `probability` or `period=\"exp(...)\"` from the seed, so that episodes \
                 have other vehicles, the first flow in {file}: {flow}"
            )
        }));
        if self.has_day_plan() {
            notes.push(
                "signals change their programs by the clock (<WAUT>): so they do under `program`; the other methods take \
                 the greens of the program that is active at the beginning"
                    .to_owned(),
            );
        }
        notes
    }
}

/// Returns a file that may be compressed, opened; more than 16 GiB are not read of it.
///
/// # Errors
///
/// [`FileError`] when it cannot be read or is no regular file.
pub fn open(path: &Path) -> Result<Box<dyn BufRead>, FileError> {
    let mut start = Vec::new();
    let mut file = files::open(path)?;
    (&mut file)
        .take(GZIP.len() as u64)
        .read_to_end(&mut start)
        .and_then(|_| file.rewind())
        .map_err(FileError::at("read", path))?;
    Ok(if start == GZIP {
        Box::new(BufReader::new(MultiGzDecoder::new(file).take(UNPACKED)))
    } else {
        Box::new(BufReader::new(file.take(UNPACKED)))
    })
}

#[cfg(test)]
mod tests;
