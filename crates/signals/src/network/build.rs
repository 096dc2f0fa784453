//! Builds the networks of a family into a folder, in parallel, and only those that are missing.
//!
//! A network is made and checked in a temporary folder and moved as a whole to where its hash says
//! ([`NetworkFiles`]); one that is there is never written again, so that a build with other settings
//! changes nothing for those who simulate meanwhile. For people, a link called like the point MDP leads to
//! the one that was asked for last.
//!
//! A network is up to date if its files are as its `network.json` says and the hash of intersection and
//! settings is the same. The version of netconvert is not part of that: networks that another one
//! built stay as they are, and `network.json` says which.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::Mutex;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::default_program::buttons;
use super::demand::DemandSpec;
use super::intersection::IntersectionSpec;
use super::netconvert::Netconvert;
use super::plain::DEFAULT_PROGRAM;
use super::validate::validate;
use crate::network::error::NetworkError;
use crate::network_files::{BY_HASH, FILE_ENDINGS, NetworkFiles, TEMPORARY, address, file_name};
use crate::settings::{Actions, DemandSettings, NetworkSettings, Scenario, SignalSettings};
use crate::sim::net_file::NetFile;
use basics::files::{self, FileError, limits, make_folder_beneath, write_atomically};
use basics::hash::sha256;

/// Number of the rules by which networks are made; a change to them raises it, and all networks
/// are built again.
const GENERATOR: u32 = 4;

/// Seed of the vehicles in the `.rou.xml`.
const ROUTES_SEED: u64 = 0;

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

/// Builds the networks of intersections into a folder, with the settings of a scenario.
/// * `progress` — called with the id of each point MDP that was built.
///
/// Fails with [`NetworkError::Altered`] without [`BuildOptions::force`] if a file is not as it was built, otherwise what
/// building or checking the first failing network reports. Networks built until then are kept.
pub fn build_all(
    specs: &[IntersectionSpec],
    scenario: &Scenario,
    out: &Path,
    options: BuildOptions,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<BuildSummary, NetworkError> {
    fs::create_dir_all(out).map_err(FileError::at("create", out))?;
    // Another build of the same folder waits until this one is done.
    let folder = File::open(out).map_err(FileError::at("open", out))?;
    folder.lock().map_err(FileError::at("lock", out))?;
    let built: BTreeMap<(String, String), Built> = Built::all(out)?
        .into_iter()
        .map(|built| ((built.point.clone(), built.spec_sha256.clone()), built))
        .collect();
    let mut missing = Vec::new();
    let mut files = BTreeMap::new();
    for spec in specs {
        let spec_sha256 = spec_hash(spec, scenario);
        let known = built.get(&(spec.point.clone(), spec_sha256.clone()));
        match known.filter(|_| !options.force) {
            Some(built) => drop(files.insert(spec.point.clone(), built.verify(out)?)),
            None => missing.push((spec, spec_sha256)),
        }
    }
    let mut summary =
        BuildSummary { built: missing.len(), up_to_date: files.len(), ..BuildSummary::default() };
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
    make_folder_beneath(out, &out.join(BY_HASH))?;
    let failed = Mutex::new(Vec::new());
    let files = Mutex::new(files);
    let done = missing.par_iter().try_for_each(|(spec, spec_sha256)| {
        let built = match build_one(spec, scenario, spec_sha256, &netconvert, out) {
            Err(e) if options.leave_out && is_of_the_intersection(&e) => {
                let mut failed = failed.lock().expect("no thread panics with the list");
                failed.push((spec.point.clone(), e.to_string()));
                return Ok(());
            }
            built => built?,
        };
        let built = NetworkFiles::new(out, &built.point, built.sha256);
        files.lock().expect("no thread panics with the files").insert(spec.point.clone(), built);
        progress(&spec.point);
        Ok::<_, NetworkError>(())
    });
    done?;
    summary.files = files.into_inner().expect("no thread panics with the files");
    show(out, &summary.files)?;
    summary.netconvert = Some(netconvert.version.clone());
    summary.failed = failed.into_inner().expect("no thread panics with the list");
    summary.failed.sort();
    summary.built -= summary.failed.len();
    Ok(summary)
}

/// Lets links that are called like point MDPs lead people to their networks; nothing that is simulated goes by them.
fn show(out: &Path, files: &BTreeMap<String, NetworkFiles>) -> Result<(), FileError> {
    for (point, NetworkFiles { folder, .. }) in files {
        let link = out.join(point);
        let target = Path::new(BY_HASH).join(folder.file_name().expect("a hash is a name"));
        if fs::read_link(&link).is_ok_and(|now| now == target) {
            continue;
        }
        let temporary = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(out);
        let temporary = temporary.map_err(FileError::at("create a folder in", out))?;
        let draft = temporary.path().join(point);
        let linked = symlink(&target, &draft).and_then(|()| fs::rename(&draft, &link));
        linked.map_err(FileError::at("write the link", &link))?;
    }
    Ok(())
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

/// Builds and checks one network and moves it into place.
fn build_one(
    spec: &IntersectionSpec,
    scenario: &Scenario,
    spec_sha256: &str,
    netconvert: &Netconvert,
    out: &Path,
) -> Result<Built, NetworkError> {
    let temporary = tempfile::Builder::new()
        .prefix(TEMPORARY)
        .tempdir_in(out)
        .map_err(FileError::at("create a folder in", out))?;
    let point = &spec.point;
    let (text, layout, phases) = netconvert.build(spec, scenario, temporary.path())?;
    let net = NetFile::parse(&text)
        .map_err(|reason| NetworkError::Unsound { point: point.clone(), reason })?;
    validate(spec, &net, scenario.network.exit_length_m)?;
    let vehicles = DemandSpec::from_intersection(spec, &scenario.demand)?;

    let made = temporary.path().join(MADE);
    fs::create_dir(&made).map_err(FileError::at("create", &made))?;
    let path = |ending| made.join(file_name(point, ending));
    vehicles.write_routes(ROUTES_SEED, &path("rou.xml"))?;
    let texts = [
        ("net.xml", text),
        ("demand.json", vehicles.to_json()),
        ("sumocfg", configuration(point, scenario.demand.horizon_s)),
    ];
    for (ending, text) in texts {
        fs::write(path(ending), text).map_err(FileError::at("write", &path(ending)))?;
    }
    let mut hashes = BTreeMap::new();
    for ending in FILE_ENDINGS {
        let bytes = fs::read(path(ending)).map_err(FileError::at("read", &path(ending)))?;
        hashes.insert(file_name(point, ending), sha256(&bytes));
    }
    let built = Built {
        point: point.clone(),
        netconvert: netconvert.version.clone(),
        arms: spec.arms.len(),
        links: layout.connections.len(),
        phases: phases.len(),
        spec_sha256: spec_sha256.to_owned(),
        sha256: hashes,
    };
    let path = made.join(BUILT_FILE);
    fs::write(&path, built.to_json()).map_err(FileError::at("write", &path))?;
    settle(temporary.path(), &built, out)?;
    Ok(built)
}

/// Moves a network that was made to where its hash says; one that is there already stays, unless it is not
/// as it was.
fn settle(temporary: &Path, built: &Built, out: &Path) -> Result<(), NetworkError> {
    let made = temporary.join(MADE);
    let folder = NetworkFiles::new(out, &built.point, built.sha256.clone()).folder;
    make_folder_beneath(out, &out.join(BY_HASH))?;
    let Err(first) = fs::rename(&made, &folder) else { return Ok(()) };
    if !folder.exists() {
        return Err(FileError::at("write", &folder)(first).into());
    }
    if built.verify(out).is_ok() {
        // The same network from other settings: what it was built from is the last.
        return Ok(write_atomically(&folder.join(BUILT_FILE), built.to_json().as_bytes())?);
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
fn spec_hash(spec: &IntersectionSpec, scenario: &Scenario) -> String {
    let Scenario { network, demand, signal, .. } = scenario;
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

/// Name of the file that says what a network was built from.
pub const BUILT_FILE: &str = "network.json";

/// A network that was built.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Built {
    /// Id of the point MDP.
    pub point: String,
    /// Version of the netconvert that built it.
    pub netconvert: String,
    /// Arms of the intersection.
    pub arms: usize,
    /// Links of the signal.
    pub links: usize,
    /// Green phases to choose from.
    pub phases: usize,
    /// Hash of intersection and settings.
    pub spec_sha256: String,
    /// Hash of each file by its name.
    pub sha256: BTreeMap<String, String>,
}

impl Built {
    /// Returns the networks of a folder, without those whose `network.json` is damaged: they are built again.
    /// Fails with [`FileError`] if the folder cannot be read.
    pub fn all(networks: &Path) -> Result<Vec<Self>, FileError> {
        let folder = networks.join(BY_HASH);
        let entries = match std::fs::read_dir(&folder) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(FileError::at("read", &folder))?,
        };
        let mut all = Vec::new();
        for entry in entries {
            let entry = entry.map_err(FileError::at("read", &folder))?;
            let bytes = files::read(&entry.path().join(BUILT_FILE), limits::DOCUMENT);
            let built = bytes.ok().and_then(|bytes| serde_json::from_slice::<Self>(&bytes).ok());
            let is_own = |built: &Self| *address(&built.sha256) == *entry.file_name();
            all.extend(built.filter(is_own));
        }
        Ok(all)
    }

    /// Returns its files after comparing each with its hash.
    /// Fails with [`NetworkError::Altered`] for the first file that was deleted or altered.
    pub fn verify(&self, networks: &Path) -> Result<NetworkFiles, NetworkError> {
        let network = NetworkFiles::new(networks, &self.point, self.sha256.clone());
        for (name, expected) in &network.sha256 {
            let path = network.folder.join(name);
            let bytes = files::if_present(files::read(&path, limits::NETWORK))?;
            let Some(bytes) = bytes else {
                return Err(NetworkError::Altered { path, what: "was deleted" });
            };
            if sha256(&bytes) != *expected {
                return Err(NetworkError::Altered { path, what: "was altered" });
            }
        }
        Ok(network)
    }

    /// Returns the text of its file.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("hashes are plain data") + "\n"
    }
}

/// Returns the point MDPs with one green, by id, with the reason in words.
/// Fails if a network cannot be read.
pub fn one_green(
    networks: &BTreeMap<String, NetworkFiles>,
) -> Result<Vec<(String, String)>, FileError> {
    let found: Result<Vec<_>, FileError> = networks
        .par_iter()
        .map(|(point, network)| {
            let text = files::read_text(&network.net, limits::NETWORK)?;
            // What a build has checked can be parsed.
            let one = NetFile::parse(&text).is_ok_and(|net| net.has_one_green(DEFAULT_PROGRAM));
            Ok(one.then(|| (point.clone(), "a single green".to_owned())))
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::movements::shapes::{cross, star};
    use super::*;
    use crate::settings::defaults;

    #[test]
    fn the_hash_of_a_spec_depends_on_what_decides_its_files_alone() {
        let hash = |spec: &IntersectionSpec, change: &dyn Fn(&mut Scenario)| {
            let mut scenario = defaults();
            change(&mut scenario);
            spec_hash(spec, &scenario)
        };
        let same = hash(&cross(), &|_| ());
        let mut other = cross();
        other.arms[3].inflow_vph += 1e-9;
        assert_ne!(hash(&other, &|_| ()), same);
        assert_ne!(hash(&cross(), &|s| s.network.phase_green_s = 3.5), same);
        assert_ne!(hash(&cross(), &|s| s.demand.horizon_s = 61.0), same);
        assert_ne!(hash(&cross(), &|s| s.demand.peak_hour_factor = 0.9), same);
        assert_ne!(hash(&cross(), &|s| s.signal.yellow_time_s = 4), same);
        assert_eq!(hash(&cross(), &|s| s.signal.delta_time_s = 5), same);
        // Push buttons time the default program only where an approach has no opposite one.
        let pushed = |spec: &IntersectionSpec, calls| {
            hash(spec, &|s| {
                (s.signal.pedestrians, s.signal.pedestrian_calls_per_h) = (true, calls);
            })
        };
        assert_eq!(pushed(&cross(), None), pushed(&cross(), Some(20.0)));
        assert_ne!(pushed(&star(5), None), pushed(&star(5), Some(20.0)));
        assert_eq!(pushed(&star(5), Some(10.0)), pushed(&star(5), Some(20.0)));
    }

    #[test]
    fn a_network_is_listed_unless_what_says_so_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let built = Built {
            point: "p".into(),
            netconvert: "1".into(),
            arms: 4,
            links: 12,
            phases: 4,
            spec_sha256: "s".into(),
            sha256: [("p.net.xml".to_owned(), sha256(b"net"))].into(),
        };
        assert_eq!(Built::all(folder.path()).unwrap(), []);
        let files = NetworkFiles::new(folder.path(), "p", built.sha256.clone());
        fs::create_dir_all(&files.folder).unwrap();
        fs::write(files.folder.join("p.net.xml"), "net").unwrap();
        let path = files.folder.join(BUILT_FILE);
        fs::write(&path, built.to_json()).unwrap();
        assert_eq!(Built::all(folder.path()).unwrap(), std::slice::from_ref(&built));
        assert_eq!(built.verify(folder.path()).unwrap(), files);
        fs::write(&path, built.to_json().replace("p.net", "q.net")).unwrap();
        assert_eq!(Built::all(folder.path()).unwrap(), []);
        fs::write(&path, "{").unwrap();
        assert_eq!(Built::all(folder.path()).unwrap(), []);
    }

    #[test]
    fn a_link_follows_the_network_that_was_asked_for_last() {
        let networks = tempfile::tempdir().unwrap();
        for hash in ["aa", "bb", "bb"] {
            let folder = networks.path().join(BY_HASH).join(hash);
            fs::create_dir_all(&folder).unwrap();
            let hashes = BTreeMap::new();
            let mut files = NetworkFiles::new(networks.path(), "p", hashes);
            files.folder = folder.clone();
            show(networks.path(), &BTreeMap::from([("p".to_owned(), files)])).unwrap();
            let target = fs::canonicalize(networks.path().join("p")).unwrap();
            assert_eq!(target, fs::canonicalize(&folder).unwrap());
        }
        assert_eq!(fs::read_dir(networks.path()).unwrap().count(), 2);
    }
}
