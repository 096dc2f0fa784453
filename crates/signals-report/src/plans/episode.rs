//! A single episode for plain `sumo` and `sumo-gui`: what signals showed, second by second, with the vehicles.
//!
//! Each state that a signal showed becomes one phase of a program, which runs once. So `sumo-gui` shows an episode of any
//! method, and plain `sumo` repeats its delay. What the scenario's files write, and programs that change by the clock, are
//! left out of copies, as they are in a run.

use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use quick_xml::escape::escape;

use super::files::remove_earlier;
use super::program_xml::{additional, comment};
use basics::files::{self, FileError, limits, write_atomically};
use evaluation::store::manifest::{Identity, PointRow};
use signals::environment::{given, planned_demand};
use signals::error::TrafficError;
use signals::network_files::{GENERATED, NetworkFiles};
use signals::program::SignalProgram;
use signals::sim::SimError;
use signals::sim::intake::Intake;
use signals::sim::net_file::{Mutual, mutual, refused};
use signals::sim::sources::{copy, open};
use signals::sim::sumocfg::SumoConfig;

/// Name of the file with the programs.
const PROGRAMS: &str = "states.add.xml";

/// Name of the file with the vehicles, of a generated network.
const VEHICLES: &str = "vehicles.rou.xml";

/// Name of the folder with copies of a scenario's files.
const COPIES: &str = "scenario";

/// Name of the copy of the network that has the programs.
const NETWORK: &str = "programs.net.xml";

/// Option of the network.
const NET_FILE: &str = "net-file";

/// Where a program ends in a network.
const PROGRAM_END: &[u8] = b"</tlLogic>";

/// How a program begins in any file.
const PROGRAM_BEGIN: &[u8] = b"<tlLogic";

/// Option of the files that programs are added to.
const ADDITIONAL: &str = "additional-files";

/// Name of the configuration.
pub const CONFIGURATION: &str = "episode.sumocfg";

/// An episode that was played.
#[derive(Debug, Clone, Copy)]
pub struct Episode<'a> {
    /// What the run was.
    pub identity: &'a Identity,
    /// Its point MDP.
    pub point: &'a PointRow,
    /// The folder of the run's networks.
    pub networks: &'a Path,
    /// The method.
    pub method: &'a str,
    /// Its seed.
    pub seed: u64,
    /// What each signal showed.
    pub programs: &'a [SignalProgram],
}

impl Episode<'_> {
    /// Returns names and texts of the files that show it, for a folder that exists. Copies of the scenario's files are
    /// written into it, where they are needed.
    ///
    /// # Errors
    ///
    /// A file of the scenario that cannot be read, a copy that cannot be written.
    pub fn files(&self, folder: &Path) -> Result<Vec<(&'static str, String)>, TrafficError> {
        let Self { identity, point, networks, method, seed, programs } = *self;
        let about = [
            format!("{method} on {}, seed {seed}", point.point),
            "every state of one episode; open it with: sumo-gui -c episode.sumocfg".to_owned(),
        ];
        let own = match point.environment.as_str() {
            GENERATED => NetworkFiles::new(networks, &point.point, point.sha256.clone()).sumocfg,
            environment => environment.into(),
        };
        let way = way_to(&own, folder)?;
        let wrong = |reason| SimError::Config { path: own.clone(), reason };
        let mut written = Vec::new();
        let mut replaced = set_by_run(identity, point, seed)?;
        let mut program = additional(method, programs, false, &about);
        if point.environment == GENERATED {
            let demand = planned_demand(point, networks)?;
            written.push((VEHICLES, demand.routes(seed).1));
            replaced.push(("route-files".to_owned(), VEHICLES.to_owned()));
        } else {
            let mutual = mutual(&SumoConfig::read(&own)?)?;
            let refused = program.as_deref().filter(|_| is_refused(&mutual, programs));
            let (beside, is_inside) = beside(&own, point, folder, refused)?;
            replaced.extend(beside);
            program = program.filter(|_| !is_inside);
        }
        let has_programs = program.is_some();
        written.extend(program.map(|text| (PROGRAMS, text)));
        let text = files::read_text(&own, limits::NETWORK)?;
        let programs = has_programs.then_some(PROGRAMS);
        let text = configuration((&text, &way), programs, &replaced, &about).map_err(wrong)?;
        written.push((CONFIGURATION, text));
        Ok(written)
    }
}

/// Returns a configuration that simulates what a run did: the scenario's own, seen from another folder, with the options that a
/// run gives SUMO ([`signals::sim::options`]) and those that it sets itself.
///
/// # Arguments
///
/// * `way` — from the new configuration's folder to the scenario's.
/// * `additional` — name of an additional file beside the new configuration.
/// * `replaced` — options that take the place of the scenario's own: long name, value.
fn configuration(
    (text, way): (&str, &Path),
    additional: Option<&str>,
    replaced: &[(String, String)],
    about: &[String],
) -> Result<String, String> {
    // Read as if it lay where the new one does, so that its files are seen from there.
    let own = SumoConfig::parse(text, &way.join("own.sumocfg"))?;
    if let Some(other) = own.obstacles.iter().find(|o| o.way.is_none()) {
        return Err(other.reason.clone());
    }
    let is_kept = |option: &&(String, String)| !replaced.iter().any(|(name, _)| *name == option.0);
    let mut lines: Vec<(String, String)> =
        own.options.iter().filter(is_kept).chain(replaced).cloned().collect();
    if let Some(file) = additional {
        match lines.iter_mut().find(|(option, _)| option == ADDITIONAL) {
            Some((_, files)) => *files = format!("{files},{file}"),
            None => lines.push((ADDITIONAL.to_owned(), file.to_owned())),
        }
    }
    let mut text = comment(about) + "<configuration>\n";
    for (option, value) in lines {
        text += &format!("    <{option} value=\"{}\"/>\n", escape(value.as_str()));
    }
    Ok(text + "</configuration>\n")
}

/// Returns the options that a run sets itself in an episode: long name, value.
fn set_by_run(
    identity: &Identity,
    point: &PointRow,
    seed: u64,
) -> Result<Vec<(String, String)>, SimError> {
    let mut options = Vec::new();
    if point.environment != GENERATED {
        let given = given(point)?;
        let times =
            [("begin", given.begin_s), ("end", given.end_s), ("step-length", given.step_length_s)];
        options.extend(times.into_iter().filter_map(|(name, s)| Some((name, s?.to_string()))));
    }
    let set = identity.settings.pointer("/simulation/time_to_teleport_s");
    let time_to_teleport_s = set.and_then(serde_json::Value::as_f64).unwrap_or(-1.0);
    options.extend([
        ("seed", seed.to_string()),
        ("time-to-teleport", time_to_teleport_s.to_string()),
        ("xml-validation", "never".to_owned()),
        // Vehicles with a device for safety measures would each write a file.
        ("device.ssm.file", "NUL".to_owned()),
    ]);
    Ok(options.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
}

/// Writes the files for a configuration of a scenario that somebody brought. Returns the options that take the place of the
/// scenario's own, as long name and value, and whether the network has the programs, so that no additional file is needed.
///
/// # Arguments
///
/// * `own` — the scenario's own configuration.
/// * `folder` — of the new configuration.
/// * `refused` — the text of an additional file whose programs SUMO refuses there; see [`is_refused`].
fn beside(
    own: &Path,
    point: &PointRow,
    folder: &Path,
    refused: Option<&str>,
) -> Result<(Vec<(String, String)>, bool), TrafficError> {
    let copies = folder.join(COPIES);
    remove_earlier(&copies)?;
    let intake = Intake::read(own, &given(point)?)?;
    let mut lists = copy(&intake.config, &intake.sources, &copies, false)?;
    let network = match refused {
        Some(programs) => with_programs(own, &intake, &lists, programs, &copies)?,
        None => None,
    };
    let is_inside = network.is_some();
    if let Some(network) = network {
        lists.retain(|(option, _)| option != NET_FILE);
        lists.push((NET_FILE.to_owned(), network.display().to_string()));
    }
    if !lists.is_empty() && copies.display().to_string().contains(',') {
        let reason =
            "SUMO reads a comma in the name of a folder as two files; give --out without one";
        return Err(wrong(own, reason.to_owned()));
    }
    let (way, own_folder) = (way_to(own, folder)?, own.parent().unwrap_or(Path::new("")));
    let seen = |file: &str| {
        let file = Path::new(file);
        let copied = file.strip_prefix(folder).map(Path::to_path_buf);
        let found = copied.or_else(|_| file.strip_prefix(own_folder).map(|f| way.join(f)));
        found.unwrap_or_else(|_| file.to_path_buf()).display().to_string()
    };
    let replaced = lists
        .into_iter()
        .map(|(option, files)| (option, files.split(',').map(seen).collect::<Vec<_>>().join(",")));
    Ok((replaced.collect(), is_inside))
}

/// Writes a copy of the network with the programs of an additional file; returns its path, `None` where the scenario has
/// no network for them.
fn with_programs(
    own: &Path,
    intake: &Intake,
    lists: &[(String, String)],
    programs: &str,
    copies: &Path,
) -> Result<Option<PathBuf>, TrafficError> {
    let copied = lists.iter().find(|(option, _)| option == NET_FILE);
    let copied = copied.map(|(_, path)| Path::new(path));
    let Some(network) = copied.or_else(|| intake.config.networks().next()) else {
        return Ok(None);
    };
    // Programs of additional files are read later, and the last one that is read runs.
    for file in &intake.sources.files {
        let is_network = intake.config.networks().any(|network| network == file.path);
        let may_have = !is_network && !intake.config.has_routes(&file.path);
        if may_have && position(&read(&file.path)?, PROGRAM_BEGIN).is_some() {
            let reason = format!(
                "SUMO refuses the programs in an additional file, and in the network those of {} would run instead; move \
                 these into the network",
                file.path.display()
            );
            return Err(wrong(own, reason));
        }
    }
    let Some(with) = inside(&read(network)?, programs) else { return Ok(None) };
    fs::create_dir_all(copies).map_err(FileError::at("create", copies))?;
    let path = copies.join(NETWORK);
    write_atomically(&path, &with)?;
    Ok(Some(path))
}

fn wrong(own: &Path, reason: String) -> TrafficError {
    SimError::Config { path: own.to_path_buf(), reason }.into()
}

fn way_to(config: &Path, folder: &Path) -> Result<PathBuf, FileError> {
    let absolute = |path: &Path| fs::canonicalize(path).map_err(FileError::at("find", path));
    let parent = config.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(way(&absolute(folder)?, &absolute(parent)?))
}

/// Returns the way from one folder to another; both are absolute.
fn way(from: &Path, to: &Path) -> PathBuf {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (from.components().collect(), to.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let mut way: PathBuf = from[common..].iter().map(|_| Component::ParentDir).collect();
    way.extend(&to[common..]);
    way
}

/// Whether SUMO refuses programs in an additional file.
fn is_refused(mutual: &Mutual, programs: &[SignalProgram]) -> bool {
    programs.iter().any(|program| {
        let states = program.phases.iter().map(|phase| phase.state.as_str());
        !program.own && refused(mutual, &program.signal, states).is_some()
    })
}

/// Returns a network with the programs of an additional file behind its own; the last one of a signal runs.
fn inside(network: &[u8], additional: &str) -> Option<Vec<u8>> {
    let (_, programs) = additional.rsplit_once("<additional>\n")?;
    let programs = programs.strip_suffix("</additional>\n")?;
    let mut windows = network.windows(PROGRAM_END.len());
    let end = windows.rposition(|window| window == PROGRAM_END)? + PROGRAM_END.len();
    Some([&network[..end], &b"\n"[..], programs.as_bytes(), &network[end..]].concat())
}

fn position(text: &[u8], part: &[u8]) -> Option<usize> {
    text.windows(part.len()).position(|window| window == part)
}

/// Returns the bytes of a file, which may be compressed.
fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes).map_err(FileError::at("read", path))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_is_what_the_run_gave_sumo_with_a_program_more() {
        let text = "<configuration><n v='a.net.xml'/><r>a.rou.xml, /abs/b.rou.xml</r>\
            <a v='c.add.xml'/><begin value='0:10:00'/><tripinfo-output value='t.xml'/>\
            <seed value='3'/><step-length value='0.5'/><max-depart-delay value='30'/>\
            <time-to-teleport value='50'/><time-to-teleport.highways value='20'/>\
            <collision.action value='remove'/><mesosim value='1'/><tls.all-off value='true'/>\
            <remote-port value='8899'/><tripinfo v='t.xml'/><netstate-dump v='d.xml'/></configuration>";
        let replaced = [("seed", "42"), ("time-to-teleport", "-1")]
            .map(|(name, value)| (name.to_owned(), value.to_owned()));
        let from = (text, Path::new("../../net"));
        let shown = configuration(from, Some("p.add.xml"), &replaced, &["one".to_owned()]);
        insta::assert_snapshot!(shown.unwrap(), @r#"
        <!--
            one
        -->
        <configuration>
            <net-file value="../../net/a.net.xml"/>
            <route-files value="../../net/a.rou.xml,/abs/b.rou.xml"/>
            <additional-files value="../../net/c.add.xml,p.add.xml"/>
            <begin value="0:10:00"/>
            <step-length value="0.5"/>
            <max-depart-delay value="-1"/>
            <time-to-teleport.highways value="0"/>
            <collision.action value="warn"/>
            <mesosim value="false"/>
            <tls.all-off value="false"/>
            <seed value="42"/>
            <time-to-teleport value="-1"/>
        </configuration>
        "#);
        let replaced = [("route-files", "v.rou.xml"), ("end", "900")]
            .map(|(name, value)| (name.to_owned(), value.to_owned()));
        let other = configuration(from, None, &replaced, &[]).unwrap();
        assert!(other.contains("<route-files value=\"v.rou.xml\"/>"), "{other}");
        assert!(!other.contains("a.rou.xml") && other.contains("<end value=\"900\"/>"), "{other}");
        assert!(configuration(("<c", from.1), None, &[], &[]).is_err());
        let comma = configuration((text, Path::new("../a,b")), None, &[], &[]).unwrap_err();
        assert!(comma.contains("SUMO reads a comma"), "{comma}");
    }
    #[test]
    fn programs_come_behind_those_of_the_network() {
        let network = b"<net><tlLogic id='a'></tlLogic><tlLogic id='b'></tlLogic><junction/></net>";
        let additional =
            "<!--\n    <additional>\n-->\n<additional>\n    <tlLogic id=\"a\"/>\n</additional>\n";
        let with = String::from_utf8(inside(network, additional).unwrap()).unwrap();
        let expected = "<net><tlLogic id='a'></tlLogic><tlLogic id='b'></tlLogic>\n    <tlLogic id=\"a\"/>\n<junction/></net>";
        assert_eq!(with, expected);
        assert_eq!(inside(b"<net/>", additional), None);
    }
    #[test]
    fn the_way_leads_up_and_down() {
        let to = |to: &str| way(Path::new("/a/b/c"), Path::new(to));
        assert_eq!(to("/a/x/y"), Path::new("../../x/y"));
        assert_eq!(to("/a/b/c"), Path::new(""));
    }
}
