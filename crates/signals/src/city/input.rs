//! What a city is derived from, and what of it is read.

use std::path::{Path, PathBuf};

use osm_signals::{Boundary, Counts, DrivingSide, Extract, Inputs, SignalList, read};

use super::config::CityConfig;
use super::error::CityError;
use super::folder;
use super::quality::InputFile;
use super::scenario::scenario_text;
use crate::settings::Detail;
use crate::turning::{Period, TurningCounts};
use basics::files::FileError;
use basics::hash::sha256_file;
use evaluation::settings::overrides::Override;

/// What a city is derived from.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Extract of OpenStreetMap.
    pub extract: PathBuf,
    /// Table of the signals that count; `None` for those of the map.
    pub signals: Option<PathBuf>,
    /// Rows of that table that count, as [`keep`](osm_signals::signals::SignalColumns::keep); added to those of the settings.
    pub signals_where: Vec<String>,
    /// Traffic counts; `None` for values by class of street.
    pub counts: Option<PathBuf>,
    /// Turning counts.
    pub turning_counts: Vec<PathBuf>,
    /// Layout of the turning counts, instead of those that are known.
    pub counts_layout: Option<PathBuf>,
    /// Periods of the day whose busiest hours are simulated; none for the busiest hour of all turning counts.
    pub periods: Vec<Period>,
    /// GeoJSON file or `WEST,SOUTH,EAST,NORTH` in degrees: only intersections within.
    pub boundary: Option<String>,
    /// Settings of the derivation, TOML.
    pub config: Option<PathBuf>,
    /// Side of the street that traffic keeps to; `None` as the settings say.
    pub driving_side: Option<DrivingSide>,
    /// Six features per intersection, or its real arms.
    pub detail: Detail,
    /// Settings of the scenario; the last of several values of one counts.
    pub overrides: Vec<Override>,
    /// Folder to write to.
    pub out: PathBuf,
    /// Whether what is there is replaced, also where it was edited, and all networks are built again.
    pub force: bool,
}

impl Request {
    /// Returns the request for an extract, without anything that says more of its city.
    pub fn new(extract: impl Into<PathBuf>, out: impl Into<PathBuf>) -> Self {
        Self {
            extract: extract.into(),
            signals: None,
            signals_where: Vec::new(),
            counts: None,
            turning_counts: Vec::new(),
            counts_layout: None,
            periods: Vec::new(),
            boundary: None,
            config: None,
            driving_side: None,
            detail: Detail::PerApproach,
            overrides: Vec::new(),
            out: out.into(),
            force: false,
        }
    }

    /// Returns where an extract's city is written by default.
    pub fn default_out(extract: &Path) -> PathBuf {
        Path::new("networks").join(folder::stem(extract))
    }

    /// Returns the files that are read, with their hashes.
    pub(super) fn files(&self) -> Result<Vec<InputFile>, FileError> {
        let boundary = self.boundary.as_ref().map(PathBuf::from).filter(|p| p.is_file());
        let files = [
            ("extract", Some(&self.extract)),
            ("signals", self.signals.as_ref()),
            ("aadt", self.counts.as_ref()),
            ("boundary", boundary.as_ref()),
            ("config", self.config.as_ref()),
            ("counts-layout", self.counts_layout.as_ref()),
        ];
        let files = files.into_iter().filter_map(|(role, path)| path.map(|path| (role, path)));
        let turning = self.turning_counts.iter().map(|path| ("turning-counts", path));
        files.chain(turning).map(|(role, path)| input_file(role, path)).collect()
    }
}

/// Returns a file that is read, with its hash.
pub(super) fn input_file(role: &'static str, path: &Path) -> Result<InputFile, FileError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(InputFile { role, name, sha256: sha256_file(path)? })
}

/// Everything that was read.
pub(super) struct Input {
    pub(super) config: CityConfig,
    pub(super) signals: Option<SignalList>,
    pub(super) counts: Option<Counts>,
    boundary: Option<Boundary>,
    pub(super) side: DrivingSide,
    pub(super) extract: Extract,
    pub(super) turning: Option<TurningCounts>,
}

impl Input {
    /// Reads the small files first, so that a mistake in one is known before the extract is read.
    ///
    /// # Arguments
    ///
    /// * `progress` — told how many bytes of the extract are done, of how many.
    pub(super) fn read(
        request: &Request,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Result<Self, CityError> {
        if !request.force {
            folder::check(&request.out)?;
        }
        let config = request.config.as_deref().map(CityConfig::read).transpose()?;
        let config = config.unwrap_or_default();
        let settings = &config.settings;
        // A mistake in the settings is known before the extract is read.
        scenario_text(request, &config, (None, None))?;
        let boundary = request.boundary.as_deref().map(Boundary::parse).transpose()?;
        let signals = request.signals.as_deref();
        let mut columns = settings.signals.clone();
        columns.keep.extend(request.signals_where.iter().cloned());
        let signals = signals.map(|p| SignalList::read(p, &columns)).transpose()?;
        let counts = request.counts.as_deref();
        let counts = counts.map(|p| Counts::read(p, &settings.counts)).transpose()?;
        let turning = (!request.turning_counts.is_empty())
            .then(|| TurningCounts::read(&request.turning_counts, request.counts_layout.as_deref()))
            .transpose()?;
        let mut extract = read(&request.extract, progress)?;
        let said = request.driving_side.or(settings.streets.driving_side);
        let side = DrivingSide::of(&extract, said)
            .ok_or_else(|| CityError::DrivingSide { path: request.extract.clone() })?;
        extract.ways.retain(|way| settings.streets.is_street(way.street.highway));
        Ok(Self { signals, counts, boundary, side, extract, config, turning })
    }

    /// Returns what decides beside the extract.
    pub(super) fn inputs(&self) -> Inputs<'_> {
        Inputs {
            signals: self.signals.as_ref(),
            counts: self.counts.as_ref(),
            boundary: self.boundary.as_ref(),
            driving_side: self.side,
        }
    }
}
