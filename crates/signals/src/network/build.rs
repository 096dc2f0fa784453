//! Builds the networks of a family into a folder, in parallel, and only those that are missing.
//!
//! A network is made and checked in a temporary folder and moved as a whole to where its hash says
//! ([`NetworkFiles`]); one that is there is never written again, so that a build with other settings
//! changes nothing for those who simulate meanwhile. For people, a link called like the point MDP leads to
//! the one that was asked for last. Rows of the index are written at the latest a second later; an
//! interrupted build leaves networks that it does not list, which the next build makes again.
//!
//! A network is up to date if its files are as the index says and the hash of intersection and
//! settings is the same. The version of netconvert is not part of that: networks that another one
//! built stay as they are, and the index says which.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

use super::demand::DemandSpec;
use super::index::{Index, IndexRow};
use super::intersection::IntersectionSpec;
use super::link::link;
use super::net_file::NetFile;
use super::netconvert::Netconvert;
use super::retime::buttons;
use super::validate::validate;
use crate::network::error::NetworkError;
use crate::network_files::{FILE_ENDINGS, NetworkFiles, TEMPORARY, file_name};
use crate::settings::{Actions, DemandSettings, NetworkSettings, SignalSettings};
use basics::files::{FileError, make_folder_beneath};
use basics::hash::sha256;

/// Number of the rules by which networks are made; a change to them raises it, and all networks
/// are built again.
const GENERATOR: u32 = 4;

/// Seed of the vehicles in the `.rou.xml`.
const ROUTES_SEED: u64 = 0;

/// Time between two writings of the index while networks are built; a killed build repeats at most
/// that much.
const INDEX_INTERVAL: Duration = Duration::from_secs(1);

/// Folder within a temporary one that becomes the network's.
const MADE: &str = "made";

/// Where a network that is not as it was goes before one that is takes its place.
const SPOILT: &str = "spoilt";

/// Age after which a temporary folder is what a killed build left behind, seconds.
const ABANDONED_S: u64 = 3600;

/// What a build did.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BuildSummary {
    /// Point MDPs whose network was built.
    pub built: usize,
    /// Point MDPs whose network was up to date.
    pub up_to_date: usize,
    /// Networks in the folder that the family does not need with these settings; they are kept.
    pub other: usize,
    /// Version of the netconvert that built; `None` if nothing was to build.
    pub netconvert: Option<String>,
    /// Point MDPs without a sound network and why, by id; only with [`BuildOptions::leave_out`].
    pub failed: Vec<(String, String)>,
    /// Where the networks are that were built or were up to date, by id.
    pub files: BTreeMap<String, NetworkFiles>,
}

/// How to build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BuildOptions {
    /// Build all of them, whatever the folder holds.
    pub force: bool,
    /// Go on without the networks that cannot be built, instead of stopping at the first.
    pub leave_out: bool,
}

/// Builds the networks of intersections into a folder.
///
/// # Arguments
///
/// * `progress` — called with the id of each point MDP that was built.
///
/// # Errors
///
/// [`NetworkError::Altered`] without [`BuildOptions::force`] if a file differs from the index, otherwise what
/// building or checking the first failing network reports. Networks built until then are kept.
pub fn build_all(
    specs: &[IntersectionSpec],
    network: &NetworkSettings,
    demand: &DemandSettings,
    signal: &SignalSettings,
    out: &Path,
    options: BuildOptions,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<BuildSummary, NetworkError> {
    fs::create_dir_all(out).map_err(FileError::at("create", out))?;
    // Another build of the same folder waits until this one is done.
    let folder = File::open(out).map_err(FileError::at("open", out))?;
    folder.lock().map_err(FileError::at("lock", out))?;
    let index = match Index::load_if_present(out) {
        Err(NetworkError::Index { .. }) if options.force => Index::empty(out),
        index => index?.unwrap_or_else(|| Index::empty(out)),
    };
    let mut missing = Vec::new();
    let mut files = BTreeMap::new();
    let mut wanted = BTreeSet::new();
    for spec in specs {
        let spec_sha256 = spec_hash(spec, network, demand, signal);
        wanted.insert((spec.point.as_str(), spec_sha256.clone()));
        // One that is gone as a whole, because somebody made room, is no damage.
        let is_there = |row: &&IndexRow| out.join(&row.folder).exists();
        let row = index.row(&spec.point, &spec_sha256).filter(|_| !options.force);
        match row.filter(is_there) {
            Some(row) => drop(files.insert(spec.point.clone(), index.verify(row)?)),
            None => missing.push((spec, spec_sha256)),
        }
    }
    let is_other =
        |row: &&IndexRow| !wanted.contains(&(row.point.as_str(), row.spec_sha256.clone()));
    let mut summary = BuildSummary {
        built: missing.len(),
        up_to_date: files.len(),
        other: index.rows().filter(is_other).count(),
        ..BuildSummary::default()
    };
    if missing.is_empty() {
        show(out, &files)?;
        summary.files = files;
        return Ok(summary);
    }
    let netconvert = Netconvert::find().inspect_err(|_| {
        // Leaves no folder behind that was only just made; one with files is not removed by this.
        let _ = fs::remove_dir(out);
    })?;
    remove_abandoned(out);
    // A folder that is being built into is one of networks from the beginning.
    index.write()?;
    let index = Mutex::new((index, Instant::now()));
    let failed = Mutex::new(Vec::new());
    let files = Mutex::new(files);
    let done = missing.par_iter().try_for_each(|(spec, spec_sha256)| {
        let mut row = match build_one(spec, network, demand, signal, &netconvert, out) {
            Err(e) if options.leave_out && is_of_the_intersection(&e) => {
                let mut failed = failed.lock().expect("no thread panics with the list");
                failed.push((spec.point.clone(), e.to_string()));
                return Ok(());
            }
            row => row?,
        };
        row.spec_sha256.clone_from(spec_sha256);
        let built = NetworkFiles::new(out, &row.point, row.sha256());
        files.lock().expect("no thread panics with the files").insert(row.point.clone(), built);
        let mut index = index.lock().expect("no thread panics with the index");
        index.0.insert(row);
        // Writing all rows after every network would take longer than building many thousands.
        if index.1.elapsed() >= INDEX_INTERVAL {
            index.0.write()?;
            index.1 = Instant::now();
        }
        drop(index);
        progress(&spec.point);
        Ok::<_, NetworkError>(())
    });
    index.into_inner().expect("no thread panics with the index").0.write()?;
    done?;
    summary.files = files.into_inner().expect("no thread panics with the files");
    show(out, &summary.files)?;
    summary.netconvert = Some(netconvert.version().to_owned());
    summary.failed = failed.into_inner().expect("no thread panics with the list");
    summary.failed.sort();
    summary.built -= summary.failed.len();
    Ok(summary)
}

/// Lets the links that are called like point MDPs lead to their networks.
fn show(out: &Path, files: &BTreeMap<String, NetworkFiles>) -> Result<(), NetworkError> {
    Ok(files.iter().try_for_each(|(point, files)| link(out, point, &files.folder))?)
}

/// Returns whether an error is about one intersection, so that others can still be built.
fn is_of_the_intersection(error: &NetworkError) -> bool {
    matches!(
        error,
        NetworkError::Netconvert { .. }
            | NetworkError::Intersection { .. }
            | NetworkError::Unsound { .. }
    )
}

/// Builds and checks one network and moves it into place; the row lacks the hash of the spec.
fn build_one(
    spec: &IntersectionSpec,
    network: &NetworkSettings,
    demand: &DemandSettings,
    signal: &SignalSettings,
    netconvert: &Netconvert,
    out: &Path,
) -> Result<IndexRow, NetworkError> {
    let temporary = tempfile::Builder::new()
        .prefix(TEMPORARY)
        .tempdir_in(out)
        .map_err(FileError::at("create a folder in", out))?;
    let point = &spec.point;
    let built = netconvert.build(spec, network, signal, demand, temporary.path())?;
    let net = NetFile::parse(&built.text)
        .map_err(|reason| NetworkError::Unsound { point: point.clone(), reason })?;
    validate(spec, &net, network.exit_length_m)?;
    let vehicles = DemandSpec::from_intersection(spec, demand)?;

    let made = temporary.path().join(MADE);
    fs::create_dir(&made).map_err(FileError::at("create", &made))?;
    let path = |ending| made.join(file_name(point, ending));
    vehicles.write_routes(ROUTES_SEED, &path("rou.xml"))?;
    let texts = [
        ("net.xml", built.text),
        ("demand.json", vehicles.to_json()),
        ("sumocfg", configuration(point, demand.horizon_s)),
    ];
    for (ending, text) in texts {
        fs::write(path(ending), text).map_err(FileError::at("write", &path(ending)))?;
    }
    let mut hashes = Vec::new();
    for ending in FILE_ENDINGS {
        let bytes = fs::read(path(ending)).map_err(FileError::at("read", &path(ending)))?;
        hashes.push(sha256(&bytes));
    }
    let [net_sha256, routes_sha256, demand_sha256, sumocfg_sha256] =
        hashes.try_into().expect("one hash per ending");
    let mut row = IndexRow {
        point: point.clone(),
        netconvert: netconvert.version().to_owned(),
        arms: spec.arms.len(),
        links: built.layout.connections.len(),
        phases: built.phases.len(),
        spec_sha256: String::new(),
        net_sha256,
        routes_sha256,
        demand_sha256,
        sumocfg_sha256,
        folder: String::new(),
    };
    row.folder = row.place();
    settle(temporary.path(), &row, out)?;
    Ok(row)
}

/// Moves a network that was made to where its hash says; one that is there already stays, unless it is not
/// as it was.
fn settle(temporary: &Path, row: &IndexRow, out: &Path) -> Result<(), NetworkError> {
    let made = temporary.join(MADE);
    let folder = out.join(&row.folder);
    let parent = folder.parent().expect("a network's folder lies in another");
    make_folder_beneath(out, parent)?;
    let Err(first) = fs::rename(&made, &folder) else { return Ok(()) };
    if !folder.exists() {
        return Err(FileError::at("write", &folder)(first).into());
    }
    if Index::empty(out).verify(row).is_ok() {
        return Ok(());
    }
    let spoilt = temporary.join(SPOILT);
    fs::rename(&folder, &spoilt).map_err(FileError::at("replace", &folder))?;
    Ok(fs::rename(&made, &folder).map_err(FileError::at("write", &folder))?)
}

/// Removes temporary folders of builds that were killed; what cannot be removed does no harm.
fn remove_abandoned(out: &Path) {
    for entry in fs::read_dir(out).into_iter().flatten().flatten() {
        let age = entry.metadata().and_then(|m| m.modified()).map(|m| m.elapsed());
        let old = matches!(age, Ok(Ok(age)) if age.as_secs() > ABANDONED_S);
        if old && entry.file_name().to_string_lossy().starts_with(TEMPORARY) {
            drop(fs::remove_dir_all(entry.path()));
        }
    }
}

/// Returns the text of a `.sumocfg`, whose paths are relative to itself.
///
/// Vehicles never teleport: at a saturated signal they wait, and the delay counts.
fn configuration(point: &str, horizon_s: f64) -> String {
    format!(
        "<configuration>\n    <input>\n        <net-file value=\"{point}.net.xml\"/>\n        \
         <route-files value=\"{point}.rou.xml\"/>\n    </input>\n    <time>\n        \
         <begin value=\"0\"/>\n        <end value=\"{horizon_s}\"/>\n    </time>\n    \
         <processing>\n        <time-to-teleport value=\"-1\"/>\n    </processing>\n\
         </configuration>\n"
    )
}

/// Returns the hash of everything that decides the files of a point MDP, apart from netconvert.
fn spec_hash(
    spec: &IntersectionSpec,
    network: &NetworkSettings,
    demand: &DemandSettings,
    signal: &SignalSettings,
) -> String {
    // Networks without pedestrians are timed as before consecutive greens counted together.
    let generator = if signal.pedestrians { GENERATOR + 1 } else { GENERATOR };
    #[derive(Serialize)]
    struct Inputs<'a> {
        generator: u32,
        spec: &'a IntersectionSpec,
        network: &'a NetworkSettings,
        demand: &'a DemandSettings,
        signal: SignalSettings,
    }
    // What does not time the default program does not change the network.
    let signal = SignalSettings {
        actions: Actions::OwnGreens,
        delta_time_s: 0,
        detection_m: 0.0,
        pedestrian_calls_per_h: buttons(spec, signal),
        ..signal.clone()
    };
    let inputs = Inputs { generator, spec, network, demand, signal };
    sha256(&serde_json::to_vec(&inputs).expect("a spec is plain data"))
}

#[cfg(test)]
mod tests {
    use super::super::movements::shapes::{cross, star};
    use super::*;

    #[test]
    fn the_hash_of_a_spec_depends_on_every_input() {
        let (spec, network, demand) =
            (cross(), NetworkSettings::default(), DemandSettings::default());
        let hash = |s: &IntersectionSpec, n: f64, d: f64| {
            let network = NetworkSettings { phase_green_s: n, ..network.clone() };
            let demand = DemandSettings { horizon_s: d, ..demand.clone() };
            spec_hash(s, &network, &demand, &SignalSettings::default())
        };
        let peak = DemandSettings { horizon_s: 60.0, peak_hour_factor: 0.9, ..demand.clone() };
        let mut other = spec.clone();
        other.arms[3].inflow_vph += 1e-9;
        let hashes = [
            hash(&spec, 3.0, 60.0),
            hash(&spec, 3.5, 60.0),
            hash(&spec, 3.0, 61.0),
            hash(&other, 3.0, 60.0),
            spec_hash(
                &spec,
                &NetworkSettings { phase_green_s: 3.0, ..network.clone() },
                &peak,
                &SignalSettings::default(),
            ),
        ];
        assert!((0..5).all(|i| (0..i).all(|j| hashes[i] != hashes[j])));
    }

    #[test]
    fn the_hash_of_a_spec_depends_on_what_times_the_default_program_alone() {
        let hash = |signal: &SignalSettings| {
            spec_hash(&cross(), &NetworkSettings::default(), &DemandSettings::default(), signal)
        };
        let signal = SignalSettings::default();
        let faster = SignalSettings { delta_time_s: 5, ..signal.clone() };
        let longer = SignalSettings { yellow_time_s: 4, ..signal.clone() };
        assert_eq!(hash(&signal), hash(&faster));
        assert_ne!(hash(&signal), hash(&longer));
    }

    #[test]
    fn push_buttons_time_the_default_program_only_where_an_approach_has_no_opposite_one() {
        let hash = |spec: &IntersectionSpec, pedestrian_calls_per_h| {
            let signal = SignalSettings {
                pedestrians: true,
                pedestrian_calls_per_h,
                ..SignalSettings::default()
            };
            spec_hash(spec, &NetworkSettings::default(), &DemandSettings::default(), &signal)
        };
        assert_eq!(hash(&cross(), None), hash(&cross(), Some(20.0)));
        assert_ne!(hash(&star(5), None), hash(&star(5), Some(20.0)));
        assert_eq!(hash(&star(5), Some(10.0)), hash(&star(5), Some(20.0)));
    }

    #[test]
    fn a_configuration_names_files_beside_itself() {
        let text = configuration("p", 3600.0);
        assert!(text.contains("<net-file value=\"p.net.xml\"/>"), "{text}");
        assert!(text.contains("<end value=\"3600\"/>"), "{text}");
    }
}
