//! A SUMO scenario before it is simulated: its configuration, its files, what the command line says in place of them, and
//! what is in the way.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::SimError;
use super::obstacle::{Accept, Given, Obstacle, Way, in_words};
use super::sources::{Sources, open};
use super::sumocfg::SumoConfig;

/// How far the steps of a second may be from a whole number.
const STEPS_TOLERANCE: f64 = 1e-6;

/// Most steps per second: SUMO counts milliseconds.
const MOST_STEPS: f64 = 1000.0;

/// Seconds to which an end is rounded that is proposed.
const ROUND_S: f64 = 60.0;

/// End that is proposed where nothing departs at a known time, seconds after the begin.
const USUAL_S: f64 = 3600.0;

/// Bytes at the beginning of a file among which whoever wrote it says its version.
const HEADER: u64 = 1 << 14;

/// A SUMO scenario before it is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Intake {
    /// Its configuration's file.
    pub path: PathBuf,
    /// Its configuration.
    pub config: SumoConfig,
    /// Its other files.
    pub sources: Sources,
    /// What the command line says in place of them.
    pub given: Given,
    /// Start, seconds.
    pub begin_s: f64,
    /// End, seconds; of one without an end that is in the way, the begin.
    pub end_s: f64,
    /// Steps of the simulation per second.
    pub steps_per_second: u32,
    /// What is in the way and was not accepted.
    pub obstacles: Vec<Obstacle>,
    /// What counts in place of what the scenario says, in words.
    pub notes: Vec<String>,
}

impl Intake {
    /// Reads a scenario.
    ///
    /// # Errors
    ///
    /// [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is no configuration.
    pub fn read(path: &Path, given: &Given) -> Result<Self, SimError> {
        let config = SumoConfig::read(path)?;
        let sources = Sources::of(&config, &given.accept);
        let (mut obstacles, mut notes) = (Vec::new(), config.notes.clone());
        for obstacle in config.obstacles.iter().chain(&sources.obstacles) {
            match &obstacle.way {
                Way::Accept(accept) if given.accept.contains(accept) => {
                    notes.push(format!("accepted: {}: {}", obstacle.place, obstacle.reason));
                }
                _ => obstacles.push(obstacle.clone()),
            }
        }
        notes.extend(sources.notes());
        notes.extend(config.time_to_teleport.as_ref().filter(|s| s.trim() != "-1").map(|s| {
            format!("time-to-teleport = {s} gives way to simulation.time_to_teleport_s, by default never")
        }));
        let shown = path.display().to_string();
        let mut blocked = |reason: String, option: String| {
            let (place, way) = (shown.clone(), Way::Option(option));
            obstacles.push(Obstacle { place, reason, way });
        };
        let begin_s = given.begin_s.unwrap_or(config.begin_s);
        if begin_s < 0.0 {
            let reason = format!("the begin ({begin_s} s) is negative, which SUMO refuses");
            blocked(reason, "--begin 0".to_owned());
        }
        let begin_s = begin_s.max(0.0);
        let proposed = || proposed_end_s(begin_s, sources.last_departure_s());
        let end_s = given.end_s.or(config.end_s).unwrap_or_else(|| {
            let until = sources.last_departure_s().map_or_else(String::new, |last_s| {
                format!("; the last vehicle or flow that is known departs at {last_s} s")
            });
            blocked(format!("no end{until}"), format!("--end {}", proposed()));
            begin_s
        });
        if end_s <= begin_s && given.end_s.or(config.end_s).is_some() {
            let reason = format!("the end ({end_s} s) is not after the begin ({begin_s} s)");
            blocked(reason, format!("--end {}", proposed()));
        }
        let step_s = given.step_length_s.unwrap_or(config.step_length_s);
        let steps = 1.0 / step_s;
        let divides = (steps - steps.round()).abs() < STEPS_TOLERANCE;
        let fits = (1.0 - STEPS_TOLERANCE..=MOST_STEPS).contains(&steps) && divides;
        if !fits {
            let reason = format!(
                "a step-length of {step_s} s does not divide a second, at which signals are decided"
            );
            blocked(reason, "--step-length 1".to_owned());
        }
        let steps_per_second = if fits { steps.round() as u32 } else { 1 };
        let departures = sources.first_departure_s().zip(sources.last_departure_s());
        notes.extend(
            departures.filter(|(first_s, last_s)| {
                begin_s < end_s && (*first_s >= end_s || *last_s < begin_s)
            })
            .map(|(first_s, last_s)| {
                format!(
                    "no vehicle or flow that is known departs in it: they depart from {first_s} s to {last_s} s, and it lasts \
                     from {begin_s} s to {end_s} s; see --begin and --end"
                )
            }),
        );
        notes.extend(said("begin", given.begin_s, Some(config.begin_s)));
        notes.extend(said("end", given.end_s, config.end_s));
        notes.extend(said("step-length", given.step_length_s, Some(config.step_length_s)));
        let (path, given) = (path.to_path_buf(), given.clone());
        Ok(Self {
            path,
            config,
            sources,
            given,
            begin_s,
            end_s,
            steps_per_second,
            obstacles,
            notes,
        })
    }

    /// Returns it, if nothing is in the way.
    ///
    /// # Errors
    ///
    /// [`SimError::Obstacles`] with all that is.
    pub fn passed(self) -> Result<Self, SimError> {
        match self.obstacles.is_empty() {
            true => Ok(self),
            false => Err(SimError::Obstacles(in_words(&self.obstacles))),
        }
    }

    /// Whether SUMO may load it to see what else is in the way: everything that is has an option that passes it, and no file
    /// lies outside.
    pub fn may_load(&self) -> bool {
        let hinders = |way: &Way| matches!(way, Way::Change(_) | Way::Accept(Accept::OutsideFiles));
        self.obstacles.iter().all(|obstacle| !hinders(&obstacle.way))
    }

    /// Returns that it has no vehicle, which is in the way of a run, but not of whoever looks at its signals; `None` where it
    /// has one, and where its files could not all be read.
    pub fn lacks_vehicles(&self) -> Option<Obstacle> {
        let files = &self.sources.files;
        if !self.may_load() || files.iter().any(|file| file.scanned.has_vehicles) {
            return None;
        }
        let others = files.iter().any(|file| file.scanned.has_others);
        let others = if others { ", only people or containers" } else { "" };
        let reason = format!("none of its files has a vehicle{others}");
        let way = Way::Change("add vehicles, trips or flows, whose delay a run compares");
        Some(Obstacle { place: self.path.display().to_string(), reason, way })
    }

    /// Says which of its networks a newer SUMO has written than the one that is installed, such as `SUMO 1.15.0`.
    pub fn newer_than(&self, installed: &str) -> Option<String> {
        let own = version_in(installed)?;
        self.config.networks().find_map(|network| {
            let mut start = Vec::new();
            open(network).ok()?.take(HEADER).read_to_end(&mut start).ok()?;
            let start = String::from_utf8_lossy(&start);
            let (_, net) = start.split_once("<net ")?;
            let (major, minor) = version_in(net.split_once("version=\"")?.1)?;
            ((major, minor) > own).then(|| {
                format!(
                    "{} is of SUMO {major}.{minor}, and {installed} is installed, which may not read all of it; \
                     docs/install.md says how to use another SUMO",
                    network.display()
                )
            })
        })
    }
}

/// Returns the first version in a text: two numbers.
fn version_in(text: &str) -> Option<(u32, u32)> {
    let begin = text.find(|c: char| c.is_ascii_digit())?;
    let mut numbers = text[begin..].split(|c: char| !c.is_ascii_digit());
    Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
}

/// Returns the end that is proposed, seconds.
fn proposed_end_s(begin_s: f64, last_s: Option<f64>) -> f64 {
    let last_s = last_s.filter(|last_s| *last_s > begin_s);
    last_s.map_or(begin_s + USUAL_S, |last_s| (last_s / ROUND_S).ceil() * ROUND_S)
}

/// Says what an option of the command replaces; `None` where it says the same or nothing.
fn said(what: &str, given: Option<f64>, own: Option<f64>) -> Option<String> {
    let given = given.filter(|given| Some(*given) != own)?;
    let own = own.map_or_else(|| "no".to_owned(), |own| format!("its own {own} s as"));
    Some(format!("--{what} {given} in place of {own} {what}"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    use super::*;

    fn read(options: &str, routes: &str, given: &Given) -> Intake {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("a.sumocfg");
        let text = format!("<c><n v='n.xml'/><r v='r.xml'/>{options}</c>");
        fs::write(&config, text).unwrap();
        fs::write(folder.path().join("n.xml"), "<net/>").unwrap();
        fs::write(folder.path().join("r.xml"), routes).unwrap();
        Intake::read(&config, given).unwrap()
    }

    fn ways(intake: &Intake) -> Vec<String> {
        let option = |o: &Obstacle| match &o.way {
            Way::Option(option) => option.clone(),
            way => format!("{way:?}"),
        };
        intake.obstacles.iter().map(option).collect()
    }

    #[test]
    fn what_is_in_the_way_has_an_option_and_is_gone_with_it() {
        let routes = "<r><flow id='f' begin='0' end='1790'/><calibrator id='c'/></r>";
        let options = "<step-length v='0.3'/><mesosim v='1'/>";
        let before = read(options, routes, &Given::default());
        let expected =
            ["Accept(Microscopic)", "Accept(Calibrators)", "--end 1800", "--step-length 1"];
        assert_eq!(ways(&before), expected);
        assert!(before.may_load());
        let given = Given {
            end_s: Some(1800.0),
            begin_s: Some(60.0),
            step_length_s: Some(0.5),
            accept: BTreeSet::from([Accept::Calibrators, Accept::Microscopic]),
        };
        let after = read(options, routes, &given).passed().unwrap();
        assert_eq!((after.begin_s, after.end_s, after.steps_per_second), (60.0, 1800.0, 2));
        assert_eq!(after.notes.len(), 5, "{:?}", after.notes);
    }

    #[test]
    fn a_negative_begin_is_in_the_way_and_has_an_option() {
        let options = "<b v='-10'/><e v='9'/>";
        let before = read(options, "<r/>", &Given::default());
        assert_eq!((ways(&before), before.begin_s), (vec!["--begin 0".to_owned()], 0.0));
        assert!(before.may_load());
        let given = Given { begin_s: Some(0.0), ..Given::default() };
        assert!(read(options, "<r/>", &given).passed().is_ok());
    }

    #[test]
    fn a_step_length_has_to_divide_a_second() {
        let steps = |length: &str| {
            let options = format!("<e v='9'/><step-length v='{length}'/>");
            let read = read(&options, "<r/>", &Given::default());
            (read.steps_per_second, read.obstacles.len())
        };
        let divide = ["1", "0.5", "0.1", "0:00:00.2", "0.001"].map(steps);
        assert_eq!(divide, [(1, 0), (2, 0), (10, 0), (5, 0), (1000, 0)]);
        for length in ["0.3", "2", "1.5", "0", "-1"] {
            assert_eq!(steps(length).1, 1, "{length}");
        }
    }

    #[test]
    fn a_time_without_departures_is_told() {
        let routes = "<r><trip id='t' depart='900'/></r>";
        let told = |begin: &str, end: &str| {
            let options = format!("<begin v='{begin}'/><end v='{end}'/>");
            read(&options, routes, &Given::default()).notes.join("\n")
        };
        let expected = "no vehicle or flow that is known departs in it: they depart from 900 s to 900 s, and it lasts from 0 s \
                        to 900 s; see --begin and --end";
        assert_eq!((told("0", "900").as_str(), told("0", "901").as_str()), (expected, ""));
        assert!(told("901", "1800").starts_with("no vehicle"));
    }

    #[test]
    fn a_scenario_of_people_alone_has_nothing_to_run() {
        let lacks = |routes: &str| {
            let intake = read("<e v='9'/>", routes, &Given::default());
            assert_eq!(intake.obstacles, [], "its signals can be looked at");
            intake.lacks_vehicles().map(|obstacle| obstacle.to_string())
        };
        let person = "<person id='p' depart='0'><walk edges='a b'/></person>";
        let said = lacks(&format!("<r>{person}</r>")).unwrap();
        assert!(
            said.contains(
                "a.sumocfg: none of its files has a vehicle, only people or containers; add"
            ),
            "{said}"
        );
        let said = lacks("<r/>").unwrap();
        assert!(said.contains("a.sumocfg: none of its files has a vehicle; add"), "{said}");
        assert_eq!(lacks(&format!("<r>{person}<trip id='t' depart='900'/></r>")), None);
        let missing = read("<e v='9'/><a v='gone.xml'/>", "<r/>", &Given::default());
        assert_eq!(missing.lacks_vehicles(), None, "the vehicles may be there");
    }

    #[test]
    fn an_end_is_proposed_after_the_last_departure() {
        let end = |routes: &str| ways(&read("<b v='100'/>", routes, &Given::default()));
        assert_eq!(end("<r/>"), ["--end 3700"]);
        assert_eq!(end("<r><trip id='a' depart='1'/></r>"), ["--end 3700"]);
        assert_eq!(end("<r><trip id='a' depart='0:02:00'/></r>"), ["--end 120"]);
        let wrong = read("<b v='100'/><e v='100'/>", "<r/>", &Given::default());
        assert_eq!(ways(&wrong), ["--end 3700"]);
    }

    #[test]
    fn a_network_of_a_newer_sumo_is_named() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(
            folder.path().join("n.xml"),
            "<?xml version=\"1.0\"?>\n<net a='b' version=\"1.20\"/>",
        )
        .unwrap();
        let config = folder.path().join("a.sumocfg");
        fs::write(&config, "<c><n v='n.xml'/><e v='9'/></c>").unwrap();
        let intake = Intake::read(&config, &Given::default()).unwrap();
        let said = intake.newer_than("SUMO 1.15.0").unwrap();
        assert!(said.contains("n.xml is of SUMO 1.20, and SUMO 1.15.0 is installed"), "{said}");
        assert_eq!(intake.newer_than("SUMO 1.20.0"), None);
    }
}
