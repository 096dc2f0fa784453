//! All files of a scenario: those that its configuration names, and those that they name in turn ([`super::scan`]); and private
//! copies of them for one simulation, without what SUMO would write, and where it is asked for without programs that change by
//! the clock. Of files without either SUMO reads the originals.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::obstacle::{Accept, Obstacle};
use super::scan::{Edit, Scanned, scan};
use super::sumocfg::SumoConfig;
use basics::files::{self, FileError, make_folder};

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
    /// * `accept` — what the user accepts: files that lie in none of the folders that the configuration names, and networks
    ///   without classes of vehicles that only a newer SUMO knows.
    pub fn of(config: &SumoConfig, accept: &BTreeSet<Accept>) -> Self {
        let mut all = Self::default();
        let mut known: BTreeMap<PathBuf, usize> = BTreeMap::new();
        for (name, path) in &config.files {
            all.add(&mut known, name.clone(), path.clone());
        }
        let folders = config.files.iter().map(|(_, path)| beside(path, "."));
        let folders = folders.chain(config.folder.iter().map(|folder| folder.join(".")));
        let folders: Vec<PathBuf> = folders.filter_map(|f| f.canonicalize().ok()).collect();
        let is_outside = |file: &Path| {
            // Of what is not there, that is what is said.
            let real = file.canonicalize().ok();
            real.is_some_and(|real| !folders.iter().any(|folder| real.starts_with(folder)))
        };
        let mut next = 0;
        while let Some(Source { name, path, .. }) = all.files.get(next).cloned() {
            let blocked =
                |reason: String, accept| Obstacle::new(path.display().to_string(), reason, accept);
            let mut scanned = Scanned::default();
            match open(&path) {
                Ok(opened) => scanned = scan(&path, opened),
                Err(e) if path.exists() => all.obstacles.push(blocked(e.reason.to_string(), None)),
                Err(_) => {
                    let slashes = if name.contains('\\') { ", with slashes" } else { "" };
                    let reason = format!(
                        "the scenario names it, but it cannot be read; add it, or correct its name{slashes}"
                    );
                    all.obstacles.push(blocked(reason, None));
                }
            }
            all.obstacles.append(&mut scanned.obstacles);
            if accept.contains(&Accept::NewerClasses) {
                scanned.edits.extend(scanned.newer_classes.iter().cloned());
            }
            let mut names = Vec::new();
            for (named, _) in &scanned.named {
                let file = beside(&path, named);
                let refused = is_outside(&file) && !accept.contains(&Accept::OutsideFiles);
                if refused {
                    let reason =
                        format!("it draws in {}, which lies outside the scenario", file.display());
                    all.obstacles.push(blocked(reason, Some(Accept::OutsideFiles)));
                }
                let name = beside(Path::new(&name), named).display().to_string();
                names.push((!refused).then(|| all.add(&mut known, name, file)));
            }
            (all.files[next].scanned, all.files[next].names) = (scanned, names);
            next += 1;
            if all.files.len() > MOST {
                all.obstacles.push(blocked(format!("it draws in more than {MOST} files"), None));
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

    /// Whether programs change by the clock.
    pub fn has_day_plan(&self) -> bool {
        self.files.iter().any(|file| !file.scanned.day_plan.is_empty())
    }

    /// Says what counts in place of what the files say.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let outputs = || self.files.iter().filter_map(|file| file.scanned.outputs.as_ref());
        if let Some((_, first)) = outputs().next() {
            let count: u32 = outputs().map(|(count, _)| count).sum();
            notes.push(format!("outputs are not written: {count}, the first in {first}"));
        }
        if self.has_day_plan() {
            notes.push(
                "signals change their programs by the clock (<WAUT>): so they do under `program`; the other methods take \
                 the greens of the program that is active at the beginning"
                    .to_owned(),
            );
        }
        notes
    }

    /// Returns by file whether a copy of it is needed: of those that have something otherwise, of those that draw such a
    /// file in, and of all that a copy draws in, so that they lie side by side.
    fn needed(&self, day_plan: bool) -> Vec<bool> {
        let differs = |Source { scanned, .. }: &Source| {
            !scanned.edits.is_empty() || !day_plan && !scanned.day_plan.is_empty()
        };
        let mut copied: Vec<bool> = self.files.iter().map(differs).collect();
        loop {
            let before = copied.clone();
            for (file, source) in self.files.iter().enumerate() {
                for named in source.names.iter().flatten().copied() {
                    let either = copied[file] || copied[named];
                    (copied[file], copied[named]) = (either, either);
                }
            }
            if copied == before {
                return copied;
            }
        }
    }
}

/// Returns where a name leads that stands in a file.
fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}

/// Returns a file that may be compressed, opened; more than 16 GiB are not read of it.
/// Fails with [`FileError`] when it cannot be read or is no regular file.
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

/// Writes the copies that are needed into a folder, and returns the options that SUMO gets in place of the
/// configuration's: long name, value.
/// * `day_plan` — whether programs change by the clock as they do in the scenario.
///
/// Fails with [`FileError`] when a file cannot be read or the folder cannot be written.
pub fn copy(
    config: &SumoConfig,
    sources: &Sources,
    folder: &Path,
    day_plan: bool,
) -> Result<Vec<(String, String)>, FileError> {
    let copied = sources.needed(day_plan);
    if !copied.contains(&true) {
        return Ok(Vec::new());
    }
    make_folder(folder)?;
    for (file, source) in sources.files.iter().enumerate().filter(|(file, _)| copied[*file]) {
        let path = folder.join(of_copy(file));
        write(source, &edits(source, day_plan), &path)?;
    }
    let now = |path: &str| {
        let file = sources.files.iter().position(|source| source.path == Path::new(path));
        let copy = file.filter(|file| copied[*file]).map(|file| folder.join(of_copy(file)));
        copy.map_or_else(|| path.to_owned(), |copy| copy.display().to_string())
    };
    let lists = config.options.iter().filter(|(name, _)| SumoConfig::is_list(name));
    let lists = lists.map(|(name, paths)| {
        (name.clone(), paths.split(',').map(now).collect::<Vec<_>>().join(","))
    });
    Ok(lists.collect())
}

fn of_copy(file: usize) -> String {
    format!("{file}.xml")
}

/// Returns what a copy has otherwise, in order.
fn edits(source: &Source, day_plan: bool) -> Vec<Edit> {
    let scanned = &source.scanned;
    let gone = scanned.day_plan.iter().filter(|_| !day_plan);
    let gone = gone.map(|at| Edit { at: at.clone(), with: String::new() });
    let names = scanned.named.iter().zip(&source.names);
    let names =
        names.filter_map(|((_, at), file)| Some(Edit { at: at.clone(), with: of_copy((*file)?) }));
    let mut edits: Vec<Edit> = scanned.edits.iter().cloned().chain(gone).chain(names).collect();
    edits.sort_by_key(|edit| (edit.at.start, std::cmp::Reverse(edit.at.end)));
    edits
}

fn write(source: &Source, edits: &[Edit], path: &Path) -> Result<(), FileError> {
    let mut from = open(&source.path)?;
    let file = File::create_new(path).map_err(FileError::at("create", path))?;
    let mut to = BufWriter::new(file);
    let mut pass = |count: u64, to: &mut dyn Write| {
        let passed = io::copy(&mut (&mut from).take(count), to);
        let passed = passed.and_then(|passed| match passed < count && count < u64::MAX {
            true => Err(io::Error::new(ErrorKind::UnexpectedEof, "it became shorter meanwhile")),
            false => Ok(()),
        });
        passed.map_err(FileError::at("copy", &source.path))
    };
    let mut at = 0;
    for Edit { at: bytes, with } in edits {
        // What lies in an element that is gone is gone with it.
        let Some(before) = bytes.start.checked_sub(at) else { continue };
        pass(before, &mut to)?;
        to.write_all(with.as_bytes()).map_err(FileError::at("write", path))?;
        pass(bytes.end - bytes.start, &mut io::sink())?;
        at = bytes.end;
    }
    pass(u64::MAX, &mut to)?;
    to.flush().map_err(FileError::at("write", path))
}

#[cfg(test)]
mod tests;
