//! Derives the family of a city, builds its networks and says what to think of it.
//!
//! # Examples
//!
//! ```no_run
//! use tsc_family_signals::city::derive::{Event, derive};
//! use tsc_family_signals::city::input::Request;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let request = Request::new("my-city.osm.pbf", "networks/my-city");
//! let derived = derive(&request, &|event| {
//!     if let Event::LeftOut(reason) = event {
//!         eprintln!("left out: {reason}");
//!     }
//! })?;
//! derived.write(&request.out)?;
//! println!("{} point MDPs", derived.loaded.family.points.len());
//! # Ok(())
//! # }
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use osm_signals::Survey;
use osm_signals::intersections::Skip;

use super::drawing::Drawing;
use super::error::CityError;
use super::facts::family_facts;
use super::folder::{APPROACHES_FILE, SCENARIO_FILE, networks_folder};
use super::input::{Input, Request};
use super::quality::{Quality, quality};
use super::reason::Reason;
use super::scenario::scenario_text;
use super::sites::City;
use super::surroundings::write_streets;
use super::table;
use super::write::{write_family, write_geojson, write_matches};
use crate::family::approaches::{gathered, to_csv};
use crate::family::load::{LoadedScenario, from_text};
use crate::network::build::one_green;
use crate::network::build::{BuildOptions, BuildSummary, build_all};
use crate::network::intersection::{IntersectionSpec, intersections};
use crate::settings::Detail;
use basics::files::{beneath, write_atomically};
use basics::hash::sha256;

/// What happens while a city is derived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<'a> {
    /// The extract is being read: bytes that are done, and all of them; it is read twice.
    Reading {
        /// Done.
        done: u64,
        /// All.
        total: u64,
    },
    /// The extract has been read.
    Read,
    /// Something that a user has to know.
    Warning(&'a str),
    /// What was found in files beside the extract.
    Found(&'a str),
    /// Networks are being built.
    Building {
        /// Done.
        done: u64,
        /// All.
        total: u64,
        /// Point MDP whose network was built last; nothing at the start.
        point: &'a str,
    },
    /// The networks have been built.
    Built,
    /// Intersections are left out because no sound network can be built: the point MDP and why.
    LeftOut(&'a str),
}

/// A city with its family.
#[derive(Debug)]
pub struct Derived {
    /// Its intersections.
    pub city: City,
    /// Its scenario and family.
    pub loaded: LoadedScenario,
    /// What there is to say of it.
    pub quality: Quality,
    /// What its page draws.
    pub drawing: Drawing,
    /// Folder of its networks.
    pub networks: PathBuf,
    /// How many networks were built; the others were up to date.
    pub built: usize,
    /// Time that reading took.
    pub read_in: Duration,
    /// Time that it took to find intersections and traffic.
    pub surveyed_in: Duration,
}

/// Derives the family of a city and builds its networks; [`Derived::write`] writes the rest.
///
/// # Arguments
///
/// * `events` — told what happens.
///
/// # Errors
///
/// [`CityError`] with the file that is to blame. Networks that were built until then are kept.
pub fn derive(
    request: &Request,
    events: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Derived, CityError> {
    let start = Instant::now();
    let input = Input::read(request, &|done, total| events(Event::Reading { done, total }));
    events(Event::Read);
    let input = input?;
    let read_in = start.elapsed();
    if let (Some(path), Some(list)) = (&request.signals, &input.signals) {
        let said = list.doubts.iter().map(|doubt| format!("{}: {doubt}", path.display()));
        said.for_each(|text| events(Event::Warning(&text)));
        if list.left_out > 0 {
            let text = format!(
                "{}: {} rows are not as asked for and left out",
                path.display(),
                list.left_out
            );
            events(Event::Warning(&text));
        }
    }
    let survey = Survey::new(&input.extract, &input.config.settings, &input.inputs());
    check(request, &input, &survey)?;
    let mut city = City::new(survey, input.side);
    let surveyed_in = start.elapsed() - read_in;
    let (loaded, networks, built) = with_networks(request, &input, &mut city, events)?;
    for doubt in &loaded.doubts {
        events(Event::Warning(&format!("{APPROACHES_FILE}: {}", doubt.brief())));
    }
    if let Some(doubt) = city.survey().count_doubt() {
        events(Event::Warning(&doubt));
    }
    let written = tables(&loaded).map(|(name, text)| (name.to_owned(), sha256(text.as_bytes())));
    let quality = quality(
        family_facts(&loaded),
        (request.files()?, written.into()),
        (&input.extract, input.config.settings.streets.time_of_day),
        &city,
        input.counts.as_ref().map(|counts| (counts, input.config.settings.counts.spread_m)),
    );
    let drawing = Drawing::new(&input.extract, &city);
    Ok(Derived { city, loaded, quality, drawing, networks, built, read_in, surveyed_in })
}

/// Refuses counts and signal lists of another place.
fn check(request: &Request, input: &Input, survey: &Survey) -> Result<(), CityError> {
    let covered = survey.covered;
    if let (Some(path), Some(counts), false) = (&request.counts, &input.counts, survey.is_counted())
    {
        return Err(CityError::Elsewhere {
            path: path.clone(),
            what: format!("{} counts lies along a street of an intersection", counts.count),
            option: "--aadt",
            bounds: Box::new(counts.bounds),
            covered,
        });
    }
    let nowhere = survey.found.intersections.is_empty() && !survey.found.skipped.is_empty();
    if let (Some(path), Some(list), true) = (&request.signals, &input.signals, nowhere) {
        return Err(CityError::Elsewhere {
            path: path.clone(),
            what: format!("{} signals is at an intersection of the extract", list.signals.len()),
            option: "--signals",
            bounds: Box::new(list.bounds()),
            covered,
        });
    }
    Ok(())
}

/// Builds the networks of a city, leaves out the intersections for which that fails or which have nothing to
/// decide, and returns its family, the folder of the networks and how many were built.
fn with_networks(
    request: &Request,
    input: &Input,
    city: &mut City,
    events: &(dyn Fn(Event<'_>) + Sync),
) -> Result<(LoadedScenario, PathBuf, usize), CityError> {
    let mut built = 0;
    loop {
        let settings = &input.config.settings.intersections;
        let mut rows = table::approaches(city, settings);
        table::check(&rows, city, &culprit(request, city))?;
        let mut joined = None;
        if let Some(counts) = &input.turning {
            let with_counts =
                counts.into_approaches(&gathered(rows), &request.periods, city.side)?;
            city.count_by_turn(&with_counts.counted);
            rows = with_counts.approaches.clone();
            joined = Some(with_counts);
        }
        let table = to_csv(&rows);
        let own = |_: &str| Ok(table.clone());
        let file = request.out.join(SCENARIO_FILE).display().to_string();
        let known = (Some(city.inflow_sources()), Some(city.side));
        let loaded = from_text(&scenario_text(request, &input.config, known)?, &file, &[], &own)?;
        let specs = intersections(&loaded)?;
        let folder = request.out.join(networks_folder(loaded.scenario.preset));
        beneath(&request.out, &folder)?;
        let force = request.force && built == 0;
        let summary = build(&loaded, &specs, &folder, force, events)?;
        built += summary.built;
        if !summary.failed.is_empty() {
            // The family is derived again without them.
            for (_, reason) in &summary.failed {
                events(Event::LeftOut(reason));
            }
            city.leave_out(members(&loaded, &summary.failed));
            continue;
        }
        if loaded.scenario.family.detail == Detail::PerApproach {
            let one_green = members(&loaded, &one_green(&summary.files)?);
            if city.leave_out_one_green(&one_green.into_keys().collect()) > 0 {
                continue;
            }
        }
        for text in joined.iter().flat_map(|joined| &joined.found) {
            events(Event::Found(text));
        }
        for doubt in joined.iter().flat_map(|joined| &joined.doubts) {
            events(Event::Warning(&doubt.brief()));
        }
        return Ok((loaded, folder, built));
    }
}

fn build(
    loaded: &LoadedScenario,
    specs: &[IntersectionSpec],
    folder: &Path,
    force: bool,
    events: &(dyn Fn(Event<'_>) + Sync),
) -> Result<BuildSummary, CityError> {
    let (total, done) = (specs.len() as u64, AtomicU64::new(0));
    events(Event::Building { done: 0, total, point: "" });
    let scenario = &loaded.scenario;
    let (network, demand, signal) = (&scenario.network, &scenario.demand, &scenario.signal);
    let options = BuildOptions { force, leave_out: true };
    let summary = build_all(specs, network, demand, signal, folder, options, &|point| {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        events(Event::Building { done, total, point });
    });
    events(Event::Built);
    Ok(summary?)
}

/// Returns the file that is to blame when there is no intersection.
fn culprit(request: &Request, city: &City) -> PathBuf {
    let file = match city.skips().first() {
        Some((Reason::Map(Skip::OutsideBoundary), _)) => {
            request.boundary.as_ref().map(PathBuf::from)
        }
        _ => None,
    };
    file.unwrap_or_else(|| request.extract.clone())
}

/// Returns the intersections of point MDPs with what is said of these.
fn members(loaded: &LoadedScenario, points: &[(String, String)]) -> BTreeMap<String, String> {
    let mut members = BTreeMap::new();
    for (point, reason) in points {
        let position = loaded.family.position(point);
        let indices = position.map_or(&[][..], |p| &loaded.members[p]);
        let ids = indices.iter().map(|i| loaded.intersections[*i].id.clone());
        members.extend(ids.map(|id| (id, reason.clone())));
    }
    members
}

/// Returns the files that a family is loaded from.
fn tables(loaded: &LoadedScenario) -> [(&'static str, &str); 2] {
    [(APPROACHES_FILE, &loaded.table), (SCENARIO_FILE, &loaded.text)]
}

impl Derived {
    /// Writes everything but the networks and the page on quality.
    ///
    /// # Errors
    ///
    /// [`CityError::Io`].
    pub fn write(&self, folder: &Path) -> Result<(), CityError> {
        for (name, text) in tables(&self.loaded) {
            write_atomically(&folder.join(name), text.as_bytes())?;
        }
        write_family(folder, &self.loaded.family)?;
        write_geojson(folder, &self.city, &self.quality, &self.loaded)?;
        if !self.quality.listed.is_empty() {
            write_matches(folder, &self.quality.listed)?;
        }
        write_streets(folder, &self.drawing)
    }
}
