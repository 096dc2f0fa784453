//! SUMO configurations, read as SUMO reads them.
//!
//! An option is an element; its value stands in the attribute `value` or `v`, or between the tags. Its
//! name may be one of SUMO's short ones, and nesting means nothing. Times are seconds or clock times,
//! `HH:MM:SS` or `D:HH:MM:SS`, of which every part may have decimals.
//!
//! SUMO itself never gets the configuration: it is started with the options that are [used](Kind), one
//! by one, so that nothing counts that was not read here.
//!
//! Source: SUMO 1.15, `OptionsLoader` and `string2time`, and what its `sumo` accepts.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use super::error::SimError;
use super::obstacle::{Accept, Obstacle};
use super::options::{Kind, kind, long, replaced};
use basics::files::{self, limits};

/// Step length of a configuration that has none, seconds.
const DEFAULT_STEP_LENGTH_S: f64 = 1.0;

/// Latest time, seconds: 31 years.
const LATEST_S: f64 = 1e9;

/// Attributes that hold an option's value.
const VALUE: [&str; 2] = ["value", "v"];

/// Seconds of the parts of a clock time, the last one first.
const CLOCK_S: [f64; 4] = [1.0, 60.0, 3600.0, 86_400.0];

/// What is read of a SUMO configuration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SumoConfig {
    /// Start, seconds.
    pub begin_s: f64,
    /// End, seconds.
    pub end_s: Option<f64>,
    /// Length of a step, seconds.
    pub step_length_s: f64,
    /// Files that define the scenario (network, routes, additional files): name as written, path.
    pub files: Vec<(String, PathBuf)>,
    /// What stands in its way; an option among them is not passed on.
    pub obstacles: Vec<Obstacle>,
    /// What counts in place of what it says, in words.
    pub notes: Vec<String>,
    /// Its folder.
    pub folder: Option<PathBuf>,
    /// The options that SUMO is started with, in order: long name, value.
    pub options: Vec<(String, String)>,
}

impl SumoConfig {
    /// Reads a SUMO configuration; paths are relative to its folder.
    /// Fails with [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is not XML or names no network.
    pub fn read(config: &Path) -> Result<Self, SimError> {
        if !config.is_file() {
            return Err(SimError::NoConfig(config.to_path_buf()));
        }
        let wrong = |reason: String| SimError::Config { path: config.to_path_buf(), reason };
        // Names of files stand in it, which are the same wherever they are read.
        let text =
            files::read_text(config, limits::NETWORK).map_err(|e| match e.reason.kind() {
                ErrorKind::InvalidData => wrong(format!("{}; save it as UTF-8", e.reason)),
                _ => e.into(),
            })?;
        Self::parse(&text, config).map_err(wrong)
    }

    /// Returns the paths of its networks.
    pub fn networks(&self) -> impl Iterator<Item = &Path> {
        self.paths("net-file")
    }

    /// Whether a file is one of routes, which SUMO reads as time goes on.
    pub fn has_routes(&self, path: &Path) -> bool {
        self.paths("route-files").any(|routes| routes == path)
    }

    fn paths(&self, option: &str) -> impl Iterator<Item = &Path> {
        let lists = self.options.iter().filter(move |(name, _)| name == option);
        lists.flat_map(|(_, paths)| paths.split(',')).map(Path::new)
    }

    /// Whether an option, given its long name, is a list of files.
    pub fn is_list(option: &str) -> bool {
        kind(option) == Kind::Files
    }

    /// Returns what is read of the text of a configuration at a path.
    /// The error is what is wrong with it, in words, where it cannot be read any further.
    pub fn parse(text: &str, path: &Path) -> Result<Self, String> {
        let folder = path.parent().map(Path::to_path_buf);
        let mut config = Self { step_length_s: DEFAULT_STEP_LENGTH_S, folder, ..Self::default() };
        // SUMO takes an empty value for none.
        for (written, value) in options(text)?.into_iter().filter(|(_, value)| !value.is_empty()) {
            if let Err((reason, accept)) = config.add(&written, value) {
                let reason = format!("option <{written}>: {reason}");
                let place = path.display().to_string();
                config.obstacles.push(Obstacle::new(place, reason, accept));
            }
        }
        if config.networks().next().is_none() && config.obstacles.is_empty() {
            return Err("no `<net-file>`; is it a SUMO configuration?".into());
        }
        Ok(config)
    }

    /// Adds an option.
    /// The error is why its value cannot be used as it is, and what has to be accepted.
    fn add(&mut self, written: &str, mut value: String) -> Result<(), (String, Option<Accept>)> {
        let option = long(written);
        let mut accept = Ok(());
        match kind(option) {
            Kind::LeftOut => return Ok(()),
            Kind::Dropped => {
                self.notes.push(format!(
                    "{written} = {value} is left out: nothing connects, and nothing else is read or written"
                ));
                return Ok(());
            }
            Kind::Refused(why, accept) => return Err((why.to_owned(), Some(accept))),
            Kind::Used => {
                if let Some((_, _, other, why, accepted)) = replaced(option, &value) {
                    let note = format!("{value} is taken as {other}: {why}");
                    match accepted {
                        Some(_) => accept = Err((note, *accepted)),
                        None => self.notes.push(format!("{written} = {note}")),
                    }
                    (*other).clone_into(&mut value);
                }
            }
            Kind::Files => value = self.add_files(&value).map_err(|reason| (reason, None))?,
        }
        let wrong = |reason: String| (reason, None);
        if value.contains("${") {
            return Err(wrong(format!("write out the variable in {value:?}")));
        }
        if self.options.iter().any(|(known, _)| known == option) {
            return Err(wrong("it is given twice; give it once".to_owned()));
        }
        match option {
            "begin" => self.begin_s = seconds(&value).map_err(wrong)?,
            "end" => self.end_s = Some(seconds(&value).map_err(wrong)?).filter(|e| *e >= 0.0),
            "step-length" => self.step_length_s = seconds(&value).map_err(wrong)?,
            "time-to-teleport" if value.trim() != "-1" => self.notes.push(format!(
                "time-to-teleport = {value} gives way to simulation.time_to_teleport_s, by default never"
            )),
            _ => {}
        }
        self.options.push((option.to_owned(), value));
        accept
    }

    /// Adds the files of an option and returns their paths as SUMO gets them.
    fn add_files(&mut self, value: &str) -> Result<String, String> {
        let folder = self.folder.clone().unwrap_or_default();
        let mut paths = Vec::new();
        for name in file_names(value)? {
            let path = folder.join(&name);
            let shown = path.display().to_string();
            // A variable in a manifest would be of somebody's environment.
            if shown.contains(',') || name.contains("${") {
                return Err(format!("{shown}: SUMO reads a comma or a variable in it; rename it"));
            }
            self.files.push((name, path));
            paths.push(shown);
        }
        Ok(paths.join(","))
    }
}

/// Returns the names in a list of files; SUMO writes a space as `%20`.
/// The error is what is wrong with one.
fn file_names(value: &str) -> Result<Vec<String>, String> {
    let names = value.split(',').map(str::trim).filter(|name| !name.is_empty());
    names.map(decoded).collect()
}

/// Returns a name without percent signs and the digits that follow them.
fn decoded(name: &str) -> Result<String, String> {
    let mut pieces = name.split('%');
    let mut bytes = pieces.next().unwrap_or_default().as_bytes().to_vec();
    for piece in pieces {
        let digits = piece.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        let byte = digits.filter(|byte| *byte != 0);
        bytes.push(byte.ok_or_else(|| format!("{name:?} has a percent sign; rename it"))?);
        bytes.extend_from_slice(&piece.as_bytes()[2..]);
    }
    String::from_utf8(bytes).map_err(|_| format!("{name:?} is no name in UTF-8; rename it"))
}

/// Returns the options of a configuration: names as written, values.
fn options(text: &str) -> Result<Vec<(String, String)>, String> {
    let document = Document::parse(text).map_err(|e| format!("it is no XML: {e}"))?;
    let mut options = Vec::new();
    for element in document.descendants().filter(Node::is_element) {
        let values = element.attributes().filter(|a| VALUE.contains(&a.name()));
        let values = values.map(|attribute| attribute.value());
        let between = element.text().filter(|text| !text.trim().is_empty());
        let name = element.tag_name().name();
        options.extend(values.chain(between).map(|value| (name.to_owned(), value.to_owned())));
    }
    Ok(options)
}

/// Returns a time, seconds, from seconds or a clock time.
/// The error is what is wrong with it, and the way out.
pub fn seconds(text: &str) -> Result<f64, String> {
    let parts: Option<Vec<f64>> = text.split(':').map(|part| part.parse().ok()).collect();
    let time_s = match parts.as_deref() {
        Some(parts @ ([_] | [_, _, _] | [_, _, _, _])) => {
            parts.iter().rev().zip(CLOCK_S).map(|(part, unit_s)| part * unit_s).sum()
        }
        _ => f64::NAN,
    };
    if time_s.abs() <= LATEST_S {
        return Ok(time_s);
    }
    let way_out = "give seconds, HH:MM:SS or D:HH:MM:SS";
    Err(match time_s.is_finite() {
        true => format!("{text:?} is more than {LATEST_S} s; {way_out}"),
        false => format!("{text:?} is not a time; {way_out}"),
    })
}

#[cfg(test)]
mod tests;
