//! Derives the family of a city, builds its networks and says what to think of it.
//!
//! # Examples
//!
//! ```no_run
//! use tsc_family_signals::city::derive::{Event, Request, derive};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (extract, out) = ("my-city.osm.pbf".into(), "networks/my-city".into());
//! let request = Request { extract, out, ..Request::default() };
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

use geo::Rect;
use geojson::JsonValue;
use osm_signals::intersections::Skip;
use osm_signals::listing::RowNote;
use osm_signals::{Boundary, Counts, DrivingSide, Extract, Inputs, SignalList, Survey, read};
use serde_json::json;
use toml::{Table, Value};

use super::config::CityConfig;
use super::quality::{Quality, quality};
use super::sites::{City, Reason};
use super::surroundings::{around, write_places, write_streets};
use super::{
    APPROACHES_FILE, CityError, InputFile, SCENARIO_FILE, hours, networks_folder, scenario_name,
    stem,
};
use crate::family::approaches::{gathered, to_csv};
use crate::family::features::six_features;
use crate::family::load::{LoadedScenario, from_text};
use crate::network::build::{BuildOptions, build_all, one_green};
use crate::network::intersection::intersections;
use crate::settings::check::check as check_settings;
use crate::settings::{Detail, InflowSources, NORTH_EAST_DEG, Scenario, SixFeatures};
use crate::turning::{Period, TurningCounts, without_zero_pedestrians};
use basics::files::{FileError, beneath, lines, write_atomically};
use basics::hash::sha256;
use evaluation::family::MdpFamily;
use evaluation::family::error::FamilyError;
use evaluation::settings::overrides::Override;
use evaluation::settings::wording::explain;

/// Share of the day's traffic in the hour (K), and of that in the peak direction of a two-way street (D), where counts are
/// totals of both directions.
///
/// Source: a design hour on urban streets, Highway Capacity Manual; FDOT's standard K factor of urban arterials.
const HOURLY_SHARE: f64 = 0.09;
const DIRECTIONAL_SPLIT: f64 = 0.55;

/// What a scenario file says of its demand.
const DEMAND_NOTE: &str = "\
# Demand is a design hour: hourly_share is the share of the day's traffic in it (1/24 is the mean hour),
# directional_split the share of a two-way street's hour in its peak direction, which is the one within
# 90 degrees of peak_heading_deg (45: north- and eastbound). [family.inflows] says what the inflows of
# approaches.csv rest on, shares of the approaches; pages of results quote it, and it decides nothing.
";

/// What a city is derived from.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// Six features per intersection, or its real arms, which it has by default.
    pub detail: Option<Detail>,
    /// Settings of the scenario; the last of several values of one counts.
    pub overrides: Vec<Override>,
    /// Folder to write to.
    pub out: PathBuf,
    /// Whether what is there is replaced, also where it was edited, and all networks are built again.
    pub force: bool,
}

impl Request {
    /// Returns where an extract's city is written by default.
    pub fn default_out(extract: &Path) -> PathBuf {
        Path::new("networks").join(stem(extract))
    }

    fn files(&self) -> Result<Vec<InputFile>, FileError> {
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
        files.chain(turning).map(|(role, path)| InputFile::read(role, path)).collect()
    }
}

/// Everything that was read.
struct Input {
    config: CityConfig,
    signals: Option<SignalList>,
    counts: Option<Counts>,
    boundary: Option<Boundary>,
    side: DrivingSide,
    extract: Extract,
    turning: Option<TurningCounts>,
}

impl Input {
    /// Reads the small files first, so that a mistake in one is known before the extract is read.
    fn read(request: &Request, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<Self, CityError> {
        if !request.force {
            super::check(&request.out)?;
        }
        let config = request.config.as_deref().map(CityConfig::read).transpose()?;
        let config = config.unwrap_or_default();
        let settings = &config.settings;
        scenario_text(request, &config, (None, None))?;
        let boundary = request.boundary.as_deref().map(Boundary::parse).transpose()?;
        let mut columns = settings.signals.clone();
        columns.keep.extend(request.signals_where.iter().cloned());
        let signals = request.signals.as_deref();
        let signals = signals.map(|p| SignalList::read(p, &columns)).transpose()?;
        let counts = request.counts.as_deref();
        let counts = counts.map(|p| Counts::read(p, &settings.counts)).transpose()?;
        let turning = (!request.turning_counts.is_empty())
            .then(|| TurningCounts::read(&request.turning_counts, request.counts_layout.as_deref()))
            .transpose()?;
        let mut extract = read(&request.extract, progress)?;
        let said = request.driving_side.or(settings.streets.driving_side);
        let side = DrivingSide::of(&extract, said).ok_or_else(|| {
            let reason = "there are countries of left-hand and of right-hand traffic in this region; give \
                          --driving-side left or right";
            CityError::unfit(&request.extract, reason)
        })?;
        extract.ways.retain(|way| settings.streets.is_street(way.street.highway));
        Ok(Self { config, signals, counts, boundary, side, extract, turning })
    }
}

/// What happens while a city is derived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<'a> {
    /// So much is done of something: bytes of the extract, which is read twice, or networks.
    Progress {
        /// What is counted; nothing for bytes.
        what: Option<&'static str>,
        /// Done.
        done: u64,
        /// All.
        total: u64,
        /// Point MDP whose network was built last.
        point: &'a str,
    },
    /// Something that a user has to know.
    Warning(&'a str),
    /// What was found in files beside the extract.
    Found(&'a str),
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
    /// The streets around its intersections, by rank.
    streets: Vec<(usize, Vec<(f64, f64)>)>,
    /// Folder of its networks.
    pub networks: PathBuf,
    /// How many networks were built; the others were up to date.
    pub built: usize,
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
    let input = Input::read(request, &|done, total| {
        events(Event::Progress { what: None, done, total, point: "" });
    })?;
    let warn = |text: String| events(Event::Warning(&text));
    if let (Some(path), Some(list)) = (&request.signals, &input.signals) {
        list.doubts.iter().for_each(|doubt| warn(format!("{}: {doubt}", path.display())));
        if list.left_out > 0 {
            let rows = format!("{} rows are not as asked for and left out", list.left_out);
            warn(format!("{}: {rows}", path.display()));
        }
    }
    let inputs = Inputs {
        signals: input.signals.as_ref(),
        counts: input.counts.as_ref(),
        boundary: input.boundary.as_ref(),
        driving_side: input.side,
    };
    let survey = Survey::new(&input.extract, &input.config.settings, &inputs);
    check(request, &input, &survey)?;
    let mut city = City::new(survey, input.side);
    let (loaded, networks, built) = with_networks(request, &input, &mut city, events)?;
    loaded.doubts.iter().for_each(|d| warn(format!("{APPROACHES_FILE}: {}", d.brief())));
    city.survey.count_doubt().into_iter().for_each(warn);
    let written = tables(&loaded).map(|(name, text)| (name.to_owned(), sha256(text.as_bytes())));
    let quality = quality(
        &loaded,
        (request.files()?, written.into()),
        (&input.extract, input.config.settings.streets.time_of_day),
        &city,
        input.counts.as_ref(),
    );
    let streets = around(&input.extract, &city);
    Ok(Derived { city, loaded, quality, streets, networks, built })
}

/// Refuses counts and signal lists of another place.
fn check(request: &Request, input: &Input, survey: &Survey) -> Result<(), CityError> {
    let elsewhere = |path: &Path, what: String, bounds: Rect<f64>, option: &str| {
        let covered = survey
            .covered
            .map_or_else(String::new, |covered| format!(", the extract {}", extent(covered)));
        let bounds = extent(bounds);
        let reason = format!(
            "none of its {what}; they cover {bounds}{covered}; give those of this city, or leave out {option}"
        );
        Err(CityError::unfit(path, reason))
    };
    if let (Some(path), Some(counts), false) = (&request.counts, &input.counts, survey.is_counted())
    {
        let what = format!("{} counts lies along a street of an intersection", counts.count);
        return elsewhere(path, what, counts.bounds, "--aadt");
    }
    let nowhere = survey.found.intersections.is_empty() && !survey.found.skipped.is_empty();
    if let (Some(path), Some(list), true) = (&request.signals, &input.signals, nowhere) {
        let what = format!("{} signals is at an intersection of the extract", list.signals.len());
        return elsewhere(path, what, list.bounds(), "--signals");
    }
    Ok(())
}

/// Says where a box lies whose x is the longitude and y the latitude, degrees.
fn extent(bounds: Rect<f64>) -> String {
    let (low, high) = (bounds.min(), bounds.max());
    format!("longitudes {:.3} to {:.3} and latitudes {:.3} to {:.3}", low.x, high.x, low.y, high.y)
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
        let mut rows = city.approaches(&input.config.settings.intersections);
        if rows.is_empty() {
            return Err(no_intersection(request, city));
        }
        let (mut found, mut doubts) = (Vec::new(), Vec::new());
        if let Some(counts) = &input.turning {
            let mut joined =
                counts.into_approaches(&gathered(rows), &request.periods, city.side)?;
            let written = scenario_text(request, &input.config, (None, None))?;
            if toml::from_str(&written).is_ok_and(|s: Scenario| !s.family.zero_pedestrians) {
                joined.doubts.extend(without_zero_pedestrians(joined.approaches.iter_mut()));
            }
            city.count_by_turn(&joined.counted);
            (rows, found, doubts) = (joined.approaches, joined.found, joined.doubts);
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
        let (total, done) = (specs.len() as u64, AtomicU64::new(0));
        let progress = |done, point: &str| {
            events(Event::Progress { what: Some("networks"), done, total, point });
        };
        progress(0, "");
        let options = BuildOptions { force, leave_out: true };
        let summary = build_all(&specs, &loaded.scenario, &folder, options, &|point| {
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, point);
        })?;
        built += summary.built;
        if !summary.failed.is_empty() {
            // The family is derived again without them.
            summary.failed.iter().for_each(|(_, reason)| events(Event::LeftOut(reason)));
            let failed = members(&loaded, &summary.failed);
            city.leave_out(&failed, Reason::NoNetwork);
            city.left_out.extend(failed);
            continue;
        }
        if loaded.scenario.family.detail == Detail::PerApproach {
            let one_green = members(&loaded, &one_green(&summary.files)?);
            if city.leave_out(&one_green, Reason::OneGreen) > 0 {
                continue;
            }
        }
        found.iter().for_each(|text| events(Event::Found(text)));
        doubts.iter().for_each(|doubt| events(Event::Warning(&doubt.brief())));
        return Ok((loaded, folder, built));
    }
}

/// Returns why no signal became an intersection, with the file that is to blame.
fn no_intersection(request: &Request, city: &City) -> CityError {
    let reasons = city.skips();
    let mut file = &request.extract;
    let boundary = request.boundary.as_ref().map(PathBuf::from);
    let mut way_out = "see which nodes have highway=traffic_signals, and whether the extract reaches some hundred metres \
                       beyond them"
        .to_owned();
    match reasons.first() {
        None => {
            let reason = "no signal (highway=traffic_signals) on a drivable street; give a larger extract, or list the \
                          signals with --signals";
            return CityError::unfit(file, reason);
        }
        Some((Reason::Map(Skip::OutsideBoundary), _)) => {
            file = boundary.as_ref().unwrap_or(file);
            let covered = city.survey.covered.map_or_else(String::new, extent);
            way_out = format!("give another --boundary: the extract covers {covered}");
        }
        Some(_) => {}
    }
    let counts: Vec<String> = reasons.iter().map(|(r, n)| format!("{n} {}", r.words())).collect();
    let counts = counts.join(", ");
    CityError::unfit(file, format!("no signalised intersection; signals: {counts}; {way_out}"))
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
            write_matches(folder, &self.city)?;
        }
        Ok(write_streets(folder, &self.streets)?)
    }
}

/// Returns the text of the scenario file of a city, for a table of approaches beside it.
fn scenario_text(
    request: &Request,
    config: &CityConfig,
    (inflows, side): (Option<InflowSources>, Option<DrivingSide>),
) -> Result<String, FamilyError> {
    let detail = request.detail.unwrap_or(Detail::PerApproach);
    let (name, extract) = (scenario_name(&request.out), stem(&request.extract));
    let mut source =
        request.config.as_ref().map_or("settings".to_owned(), |c| c.display().to_string());
    source.extend(request.overrides.iter().map(|o| format!(" {}", o.flag())));
    let mut family = Table::new();
    family.insert("approaches".to_owned(), APPROACHES_FILE.into());
    family.insert("detail".to_owned(), Value::try_from(detail).expect("a detail is a word"));
    family.insert("hourly_share".to_owned(), HOURLY_SHARE.into());
    if config.settings.traffic.both_directions {
        family.insert("directional_split".to_owned(), DIRECTIONAL_SPLIT.into());
        family.insert("peak_heading_deg".to_owned(), NORTH_EAST_DEG.into());
    }
    if let Some(inflows) = inflows {
        family.insert("inflows".to_owned(), Value::try_from(inflows).expect("shares are numbers"));
    }
    family.extend(hours(&request.periods).map(|hours| ("periods".to_owned(), hours)));
    let title = format!("Signalised intersections of {extract} ((c) OpenStreetMap contributors)");
    let mut table = Table::from_iter([
        ("name".to_owned(), name.as_str().into()),
        ("title".to_owned(), title.into()),
        ("family".to_owned(), family.into()),
    ]);
    for (key, value) in &config.scenario {
        match (table.get_mut(key), value) {
            (Some(Value::Table(own)), Value::Table(more)) => own.extend(more.clone()),
            _ => drop(table.insert(key.clone(), value.clone())),
        }
    }
    let side = side.unwrap_or_default();
    if side == DrivingSide::Left
        && let Value::Table(network) = table.entry("network").or_insert_with(|| Table::new().into())
    {
        network.entry("driving_side").or_insert_with(|| side.name().into());
    }
    let own = table.clone().try_into::<Scenario>();
    let mut scenario = own.map_err(|e: toml::de::Error| FamilyError::Toml {
        file: format!("{source}, [scenario]"),
        message: explain::<Scenario>(e.message(), ""),
    })?;
    for setting in &request.overrides {
        scenario = setting.apply(&scenario)?;
        setting.put_into(&mut table)?;
    }
    check_settings(&scenario, &source)?;
    let of = &scenario.family;
    let decided = [
        ("name", scenario.name == name, "--out"),
        ("family.detail", of.detail == detail, "--detail"),
        ("network.driving_side", scenario.network.driving_side == side, "--driving-side"),
        ("family.points", of.points.is_none(), "the map"),
        ("family.approaches", of.approaches.as_deref() == Some(APPROACHES_FILE), "the map"),
    ];
    if let Some((field, _, by)) = decided.into_iter().find(|(_, same, _)| !same) {
        let expected = format!("with --osm {by} decides it; leave it out");
        return Err(FamilyError::setting(&source, field, "another value", expected));
    }
    let settings = toml::to_string(&table).expect("settings are plain data");
    Ok(format!(
        "# Made from {extract} by `tsc-family build-networks --osm`; what is not here has its \
         default.\n{DEMAND_NOTE}{settings}"
    ))
}

/// Writes the point MDPs as a table: id, importance, intersections and features.
fn write_family(folder: &Path, family: &MdpFamily) -> Result<(), FileError> {
    let names = family.features.iter().map(|f| f.name.clone());
    let head = ["point", "importance", "intersections"].map(str::to_owned);
    let mut rows: Vec<Vec<String>> = vec![head.into_iter().chain(names).collect()];
    rows.extend(family.points.iter().map(|p| {
        let fixed = [p.id.clone(), p.importance.to_string(), p.instances.to_string()];
        fixed.into_iter().chain(p.features.iter().map(f64::to_string)).collect::<Vec<String>>()
    }));
    write_atomically(&folder.join("family.csv"), &lines(&rows))
}

/// Writes what became of every row of the signal list: its intersection, the distance, the reason.
fn write_matches(folder: &Path, city: &City) -> Result<(), FileError> {
    let head = [
        "id", "row", "latitude", "longitude", "intersection", "distance_m", "signal_on_map",
        "duplicate_of_row", "reason",
    ];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(city.listed().map(|(row, left_out)| {
        let duplicate_of = match row.note {
            Some(RowNote::Duplicate(line)) => Some(line.to_string()),
            _ => None,
        };
        let why = left_out.map(Reason::words).or(row.note.map(RowNote::words)).unwrap_or_default();
        [
            row.id.clone(),
            row.line.to_string(),
            row.latitude.to_string(),
            row.longitude.to_string(),
            row.intersection.clone().filter(|_| left_out.is_none()).unwrap_or_default(),
            row.distance_m.map(|metres| format!("{metres:.1}")).unwrap_or_default(),
            row.on_map.to_string(),
            duplicate_of.clone().unwrap_or_default(),
            duplicate_of.map_or(why.to_owned(), |line| format!("duplicate of row {line}")),
        ]
    }));
    write_atomically(&folder.join("signal-list.csv"), &lines(&rows))
}

/// Writes `intersections.geojson`: intersections with their point MDP, its importance and features,
/// and how well they are known; and the signals that are none, with the reason.
fn write_geojson(
    folder: &Path,
    city: &City,
    quality: &Quality,
    loaded: &LoadedScenario,
) -> Result<(), FileError> {
    // Of several periods the first.
    let mut first: BTreeMap<&str, usize> = BTreeMap::new();
    let mut point_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (i, intersection) in loaded.intersections.iter().enumerate() {
        first.entry(&intersection.id).or_insert(i);
    }
    for (point, members) in loaded.members.iter().enumerate() {
        point_of.extend(members.iter().map(|i| (*i, point)));
    }
    let intersections = quality.spots.iter().map(|spot| {
        let i = first.get(spot.id.as_str());
        let point = i.and_then(|i| Some(&loaded.family.points[*point_of.get(i)?]));
        let sources = spot.inflow_sources.iter().map(|source| json!(source));
        let sources: Vec<String> = sources.filter_map(|s| Some(s.as_str()?.to_owned())).collect();
        let mut properties = json!({
            "status": "intersection",
            "id": spot.id,
            "streets": spot.streets,
            "arms": spot.arms,
            "signal_nodes": spot.signals,
            "known_share": number(spot.known, 4),
            "inflow_sources": sources.join(", "),
            "flags": spot.flags.join("; "),
            "point": point.map(|p| &p.id),
            "importance": point.map(|p| p.importance),
        });
        if let Some(i) = i {
            let features = six_features(&loaded.intersections[*i], &loaded.scenario.family);
            for ((name, _), value) in SixFeatures::COLUMNS.iter().zip(features.to_array()) {
                properties[name] = number(value, 2);
            }
        }
        (spot.latitude, spot.longitude, properties)
    });
    let skipped = city.skipped().map(|(signals, place, reason)| {
        let id = signals.first().map(|id| format!("n{id}"));
        let properties = json!({ "status": "skipped", "reason": reason.words(), "id": id });
        (place.latitude(), place.longitude(), properties)
    });
    write_places(folder, intersections.chain(skipped))
}

/// Returns a number with so many digits after the point.
fn number(value: f64, digits: i32) -> JsonValue {
    let scale = 10f64.powi(digits);
    ((value * scale).round() / scale).into()
}
