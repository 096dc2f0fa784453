//! The environment of a point MDP: its files, checked, and the signals they describe.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use osm_signals::Turn;

use crate::control::{existing, retime};
use crate::env::{SignalEnv, World};
use crate::error::TrafficError;
use crate::existing::ExistingPlan;
use crate::network::demand::{DemandSpec, RouteShare};
use crate::network_files::{FILE_ENDINGS, GENERATED, NetworkFiles, file_name};
use crate::settings::{Detail, Scenario};
use crate::sim::Sim;
use crate::sim::error::SimError;
use crate::sim::intake::Intake;
use crate::sim::obstacle::Given;
use basics::hash::sha256_file;
use evaluation::store::input_files::InputFiles;
use evaluation::store::manifest::PointRow;

/// Returns the environment of a world with a scenario's settings; `scratch` is a folder for the
/// files of the running episode.
pub fn environment<S: Sim>(
    sim: S,
    mut world: World,
    scenario: &Scenario,
    scratch: &Path,
) -> SignalEnv<S> {
    // The four equal arms of six features stand for other ones.
    if scenario.family.detail == Detail::SixFeatures {
        world.ways = None;
    }
    let (mut signal, simulation) = (scenario.signal.clone(), scenario.simulation.clone());
    // Who was counted pushes a button; a crosswalk where nobody was counted has what the settings say.
    if signal.pedestrians && !world.pedestrians.is_empty() {
        signal.pedestrian_calls_per_h.get_or_insert(0.0);
    }
    SignalEnv::new(sim, world, signal, simulation, scratch.to_path_buf())
}

/// Returns the world of a generated network.
/// Fails with [`TrafficError`] when a file is missing or cannot be understood, or would have SUMO read or write any other.
pub fn generated_world(files: &NetworkFiles) -> Result<World, TrafficError> {
    // Networks may come from a stranger, with an index or a manifest that has their hashes.
    let intake = Intake::read(&files.sumocfg, &Given::default())?;
    let fail = |reason: String| SimError::Config { path: files.sumocfg.clone(), reason };
    let others = intake.sources.named().map(|(_, file)| file);
    let others = others.filter(|file| *file != files.net && *file != files.routes);
    let others = others.map(|file| format!("it names {}", file.display()));
    let obstacles = intake.obstacles.iter().map(|o| format!("{}: {}", o.place, o.reason));
    if let Some(other) = others.chain(obstacles).chain(intake.notes.iter().cloned()).next() {
        return Err(fail(format!("it is not as networks are generated: {other}")).into());
    }
    let demand = DemandSpec::read(&files.demand)?;
    let mut world = World::of(intake)?;
    world.files = None;
    for stream in &demand.streams {
        let share = |route: &RouteShare| (stream.from.clone(), route.to.clone(), route.share);
        world.turn_shares.extend(stream.routes.iter().map(share));
        world
            .pedestrians
            .extend(stream.pedestrians_per_h.map(|per_h| (stream.from.clone(), per_h)));
        for turn in [Turn::Left, Turn::Right] {
            let length_m = stream.storage.and_then(|storage| storage.of_turn(turn));
            world.bays.extend(length_m.map(|m| (stream.from.clone(), turn, m)));
        }
    }
    let again = demand.clone();
    world.ways = Some(Box::new(move |seed| again.ways(seed)));
    world.routes = Some(Box::new(move |seed, path| demand.write_routes(seed, path).map(drop)));
    Ok(world)
}

/// Returns the folder that the planned files of a point MDP lie in.
pub fn folder_of(point: &PointRow, networks: &Path) -> PathBuf {
    if point.environment == GENERATED {
        return NetworkFiles::new(networks, &point.point, point.sha256.clone()).folder;
    }
    Path::new(&point.environment).parent().unwrap_or(Path::new("")).to_path_buf()
}

/// Returns what the command line of a run said of a point MDP's scenario.
/// Fails with [`SimError::Config`] when a manifest has something else.
pub fn given(point: &PointRow) -> Result<Given, SimError> {
    let fields: serde_json::Map<String, serde_json::Value> =
        point.given.clone().into_iter().collect();
    serde_json::from_value(fields.into()).map_err(|e| SimError::Config {
        path: PathBuf::from(&point.environment),
        reason: format!("the manifest says of it what no run writes: {e}"),
    })
}

/// Returns the plan of a generated point MDP that a method runs, as its manifest keeps it: `existing`, with which `retime`
/// begins unless it has one of its own, or one of `--plan-file`.
/// The error is what the manifest says instead.
pub fn existing_plan(point: &PointRow, method: &str) -> Result<Option<ExistingPlan>, String> {
    let today = (method == retime::METHOD.name).then_some(existing::METHOD.name);
    let plan = point.given.get(method).or_else(|| point.given.get(today?));
    let plan = plan.filter(|_| point.environment == GENERATED);
    let plan: Option<ExistingPlan> = plan
        .map(|plan| serde_json::from_value(plan.clone()))
        .transpose()
        .map_err(|e| format!("the manifest's existing plan is none: {e}"))?;
    // A manifest may come from a stranger.
    plan.as_ref().map_or(Ok(()), |plan| plan.check().map(drop))?;
    Ok(plan)
}

/// Returns the world of a planned point MDP after checking that its files are those of the plan, and holds
/// on to them.
/// * `day_plan` — whether programs change by the clock as they do in the scenario.
/// * `method` — whose plan is taken, where it has one.
///
/// Fails with [`TrafficError::Changed`] when they are not, and whatever makes them unreadable.
pub fn planned_world(
    point: &PointRow,
    networks: &Path,
    day_plan: bool,
    method: &str,
) -> Result<(World, InputFiles), TrafficError> {
    let mut held = InputFiles::default();
    if point.environment != GENERATED {
        let config = PathBuf::from(&point.environment);
        let folder = folder_of(point, networks);
        for (name, sha256) in &point.sha256 {
            held.add(&folder.join(name), Some(sha256))?;
        }
        // Whoever planned has looked at what SUMO would read and write; but the plan may be a stranger's.
        let intake = Intake::read(&config, &given(point)?)?.passed()?;
        for (name, file) in intake.sources.named() {
            if !point.sha256.contains_key(name) {
                held.add(file, None)?;
            }
        }
        return Ok((World { day_plan, ..World::of(intake)? }, held));
    }
    let files = NetworkFiles::new(networks, &point.point, point.sha256.clone());
    for ending in FILE_ENDINGS {
        let name = file_name(&point.point, ending);
        held.add(&files.folder.join(&name), point.sha256.get(&name))?;
    }
    let existing = existing_plan(point, method)
        .map_err(|reason| SimError::Config { path: files.net.clone(), reason })?;
    Ok((World { existing, ..generated_world(&files)? }, held))
}

/// Returns the demand of a planned point MDP after checking that its file is that of the plan.
/// Fails with [`TrafficError::Changed`] when it is not, and whatever makes it unreadable.
pub fn planned_demand(point: &PointRow, networks: &Path) -> Result<DemandSpec, TrafficError> {
    let files = NetworkFiles::new(networks, &point.point, point.sha256.clone());
    let name = files.demand.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut held = InputFiles::default();
    held.add(&files.demand, point.sha256.get(&name))?;
    Ok(DemandSpec::read(&files.demand)?)
}

/// Returns the sha256 of a SUMO configuration and of every file that SUMO reads with it, by its name as seen from the
/// folder of the configuration.
/// Fails with [`TrafficError`] when one cannot be read.
pub fn hash_scenario(intake: &Intake) -> Result<BTreeMap<String, String>, TrafficError> {
    let name = intake.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let own = (name.as_str(), intake.path.as_path());
    let hash = |(name, file): (&str, &Path)| Ok((name.to_owned(), sha256_file(file)?));
    intake.sources.named().chain([own]).map(hash).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use basics::hash::sha256;
    use evaluation::store::input_files::Changed;

    #[test]
    fn a_file_whose_hash_the_plan_lacks_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let json = r#"{"point":"p","importance":1.0,"instances":1,"features":[],"environment":"network","sha256":{}}"#;
        let mut point: PointRow = serde_json::from_str(json).unwrap();
        for ending in FILE_ENDINGS {
            point.sha256.insert(file_name("p", ending), sha256(ending.as_bytes()));
        }
        point.sha256.remove("p.demand.json");
        let files = NetworkFiles::new(folder.path(), "p", point.sha256.clone());
        fs::create_dir_all(&files.folder).unwrap();
        for ending in FILE_ENDINGS {
            fs::write(files.folder.join(file_name("p", ending)), ending).unwrap();
        }
        let e = planned_world(&point, folder.path(), false, "").err().unwrap();
        assert!(
            matches!(&e, TrafficError::Changed(Changed::Altered { path, .. }) if path.ends_with("p.demand.json"))
        );
    }

    #[test]
    fn an_imported_scenario_is_refused_when_a_file_that_is_included_was_altered() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("n.xml", "<net/>");
        write("a.xml", "<routes><include href='b.xml'/></routes>");
        write("b.xml", "<routes/>");
        write("a.sumocfg", "<c><n v='n.xml'/><routes value='a.xml'/><end v='9'/></c>");
        let config = folder.path().join("a.sumocfg");
        let json = r#"{"point":"a","importance":1.0,"instances":1,"features":[],"environment":"","sha256":{}}"#;
        let mut point: PointRow = serde_json::from_str(json).unwrap();
        point.environment = config.display().to_string();
        point.sha256 = hash_scenario(&Intake::read(&config, &Given::default()).unwrap()).unwrap();
        assert_eq!(point.sha256.len(), 4);
        planned_world(&point, Path::new(""), false, "").unwrap();
        write("b.xml", "<routes> </routes>");
        let e = planned_world(&point, Path::new(""), false, "").err().unwrap();
        assert!(
            matches!(&e, TrafficError::Changed(Changed::Altered { path, .. }) if path.ends_with("b.xml")),
            "{e}"
        );
    }

    #[test]
    fn networks_are_built_with_the_program_that_environments_look_for() {
        assert_eq!(crate::network::phases::PHASES_PROGRAM, crate::env::derive::PHASES_PROGRAM);
    }

    #[test]
    fn a_file_that_is_held_is_missed_where_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xml");
        fs::write(&path, "<a/>").unwrap();
        let mut held = InputFiles::default();
        held.add(&path, Some(&sha256(b"<a/>"))).unwrap();
        held.verify().unwrap();
        for planned in [None, Some(&sha256(b"<b/>"))] {
            let e = held.add(&path, planned).unwrap_err();
            assert!(matches!(e, Changed::Altered { what: "was altered", .. }), "{e}");
        }
        fs::remove_file(&path).unwrap();
        let e = held.verify().unwrap_err().to_string();
        assert!(e.contains("a.xml: the file was deleted"), "{e}");
    }
}
