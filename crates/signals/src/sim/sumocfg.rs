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
use super::obstacle::{Obstacle, Way};
use super::options::{Kind, kind, long, replaced, to_accept, validates};
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
#[derive(Debug, Clone, PartialEq)]
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
    /// Time after which it has vehicles teleported, as it is written there; the run has a setting of its own.
    pub time_to_teleport: Option<String>,
    /// Its folder.
    pub folder: Option<PathBuf>,
    /// What it is called in messages.
    shown: String,
    networks: Vec<PathBuf>,
    routes: Vec<PathBuf>,
    options: Vec<(String, String)>,
}

impl SumoConfig {
    /// Reads a SUMO configuration; paths are relative to its folder.
    ///
    /// # Errors
    ///
    /// [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is not XML or names no network.
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
        self.networks.iter().map(PathBuf::as_path)
    }

    /// Whether a file is one of routes, which SUMO reads as time goes on.
    pub fn has_routes(&self, path: &Path) -> bool {
        self.routes.iter().any(|routes| routes == path)
    }

    /// Whether an option, given its long name, is a list of files.
    pub fn is_list(option: &str) -> bool {
        matches!(kind(option), Kind::Files)
    }

    /// Returns the options that SUMO is started with, in order: long name, value.
    pub fn options(&self) -> &[(String, String)] {
        &self.options
    }

    /// Returns what is read of the text of a configuration at a path.
    ///
    /// # Errors
    ///
    /// What is wrong with it, in words, where it cannot be read any further.
    pub fn parse(text: &str, path: &Path) -> Result<Self, String> {
        let mut settings = Self {
            begin_s: 0.0,
            end_s: None,
            step_length_s: DEFAULT_STEP_LENGTH_S,
            files: Vec::new(),
            obstacles: Vec::new(),
            notes: Vec::new(),
            time_to_teleport: None,
            folder: path.parent().map(Path::to_path_buf),
            shown: path.display().to_string(),
            networks: Vec::new(),
            routes: Vec::new(),
            options: Vec::new(),
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        // SUMO takes an empty value for none.
        for (written, value) in options(text)?.into_iter().filter(|(_, value)| !value.is_empty()) {
            let reasons = settings.add(&written, value, folder);
            if let Err(reason) = reasons {
                settings.blocked(format!("option <{written}>: {reason}"), Way::Change(""));
            }
        }
        if settings.networks.is_empty() && settings.obstacles.is_empty() {
            return Err("no `<net-file>`; is it a SUMO configuration?".into());
        }
        Ok(settings)
    }

    fn blocked(&mut self, reason: String, way: Way) {
        self.obstacles.push(Obstacle { place: self.shown.clone(), reason, way });
    }

    /// Adds an option.
    ///
    /// # Errors
    ///
    /// Why its value cannot be used, and the way out.
    fn add(&mut self, written: &str, value: String, folder: &Path) -> Result<(), String> {
        let option = long(written);
        let value = match kind(option) {
            Kind::LeftOut => {
                if validates(option, &value) {
                    self.notes.push(format!(
                        "{written} = {value} is taken as never: nothing is validated"
                    ));
                }
                return Ok(());
            }
            Kind::Dropped(why) => {
                self.notes.push(format!("{written} = {value} is left out: {why}"));
                return Ok(());
            }
            Kind::Refused(why, accept) => {
                self.blocked(format!("option <{written}>: {why}"), Way::Accept(accept));
                return Ok(());
            }
            Kind::Used => match replaced(option, &value) {
                Some((other, why)) => {
                    let note = format!("{written} = {value} is taken as {other}: {why}");
                    match to_accept(option) {
                        Some(accept) => self.blocked(note, Way::Accept(accept)),
                        None => self.notes.push(note),
                    }
                    other.to_owned()
                }
                None => value,
            },
            Kind::Files => self.add_files(option, &value, folder)?,
        };
        if value.contains("${") {
            return Err(format!("write out the variable in {value:?}"));
        }
        if self.options.iter().any(|(known, _)| known == option) {
            return Err("it is given twice; give it once".to_owned());
        }
        match option {
            "begin" => self.begin_s = seconds(&value)?,
            "end" => self.end_s = Some(seconds(&value)?).filter(|e| *e >= 0.0),
            "step-length" => self.step_length_s = seconds(&value)?,
            "time-to-teleport" => self.time_to_teleport = Some(value.clone()),
            _ => {}
        }
        self.options.push((option.to_owned(), value));
        Ok(())
    }

    /// Adds the files of an option and returns their paths as SUMO gets them.
    fn add_files(&mut self, option: &str, value: &str, folder: &Path) -> Result<String, String> {
        let mut paths = Vec::new();
        for name in file_names(value)? {
            let path = folder.join(&name);
            let shown = path.display().to_string();
            if shown.contains(',') {
                return Err(format!("{shown}: SUMO reads a comma as two files; rename it"));
            }
            // Its place in a manifest is a variable of somebody's environment.
            if name.contains("${") {
                return Err(format!("write out the variable in {name:?}"));
            }
            match option {
                "net-file" => self.networks.push(path.clone()),
                "route-files" => self.routes.push(path.clone()),
                _ => {}
            }
            self.files.push((name, path));
            paths.push(shown);
        }
        Ok(paths.join(","))
    }
}

/// Returns the names in a list of files; SUMO writes a space as `%20`.
///
/// # Errors
///
/// What is wrong with one.
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
///
/// # Errors
///
/// What is wrong with it, and the way out.
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
