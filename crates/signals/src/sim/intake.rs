//! A SUMO scenario before it is simulated: its configuration, its files, what the command line says in place of them, and
//! what is in the way.

use std::path::{Path, PathBuf};

use super::SimError;
use super::obstacle::{Accept, Given, Obstacle, in_words};
use super::sources::Sources;
use super::sumocfg::SumoConfig;

/// How far the steps of a second may be from a whole number.
const STEPS_TOLERANCE: f64 = 1e-6;

/// Most steps per second: SUMO counts milliseconds.
const MOST_STEPS: f64 = 1000.0;

/// End that is proposed where nothing departs at a known time, seconds after the begin.
const USUAL_S: f64 = 3600.0;

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
    /// Fails with [`SimError::NoConfig`] when there is no such file, [`SimError::Config`] when it is no configuration.
    pub fn read(path: &Path, given: &Given) -> Result<Self, SimError> {
        let config = SumoConfig::read(path)?;
        let sources = Sources::of(&config, &given.accept);
        let found = config.obstacles.iter().chain(&sources.obstacles).cloned();
        let (accepted, mut obstacles): (Vec<Obstacle>, Vec<Obstacle>) =
            found.partition(|obstacle| obstacle.goes_with(&given.accept));
        let mut notes = config.notes.clone();
        notes.extend(accepted.iter().map(|o| format!("accepted: {}: {}", o.place, o.reason)));
        notes.extend(sources.notes());
        let mut blocked = |reason: String, option: &'static str, value: f64| {
            let way = Some((option, value.to_string()));
            obstacles.push(Obstacle { place: path.display().to_string(), reason, way });
        };
        let begin_s = given.begin_s.unwrap_or(config.begin_s);
        if begin_s < 0.0 {
            let reason = format!("the begin ({begin_s} s) is negative, which SUMO refuses");
            blocked(reason, "--begin", 0.0);
        }
        let begin_s = begin_s.max(0.0);
        let proposed_s = begin_s + USUAL_S;
        let end_s = given.end_s.or(config.end_s);
        match end_s {
            None => blocked("no end".to_owned(), "--end", proposed_s),
            Some(end_s) if end_s <= begin_s => {
                let reason = format!("the end ({end_s} s) is not after the begin ({begin_s} s)");
                blocked(reason, "--end", proposed_s);
            }
            Some(_) => {}
        }
        let step_s = given.step_length_s.unwrap_or(config.step_length_s);
        let steps = 1.0 / step_s;
        let divides = (steps - steps.round()).abs() < STEPS_TOLERANCE;
        let fits = (1.0 - STEPS_TOLERANCE..=MOST_STEPS).contains(&steps) && divides;
        if !fits {
            let reason = format!(
                "a step-length of {step_s} s does not divide a second, at which signals are decided"
            );
            blocked(reason, "--step-length", 1.0);
        }
        for (what, given, own) in [
            ("begin", given.begin_s, Some(config.begin_s)),
            ("end", given.end_s, config.end_s),
            ("step-length", given.step_length_s, Some(config.step_length_s)),
        ] {
            let own_s = own.map_or_else(|| "none".to_owned(), |own_s| format!("{own_s} s"));
            let given_s = given.filter(|_| given != own);
            notes.extend(
                given_s.map(|s| format!("--{what} {s} in place of the scenario's own, {own_s}")),
            );
        }
        Ok(Self {
            path: path.to_path_buf(),
            given: given.clone(),
            begin_s,
            end_s: end_s.unwrap_or(begin_s),
            steps_per_second: if fits { steps.round() as u32 } else { 1 },
            config,
            sources,
            obstacles,
            notes,
        })
    }

    /// Returns it, if nothing is in the way.
    /// Fails with [`SimError::Obstacles`] with all that is.
    pub fn passed(self) -> Result<Self, SimError> {
        match self.obstacles.is_empty() {
            true => Ok(self),
            false => Err(SimError::Obstacles(in_words(&self.obstacles))),
        }
    }

    /// Whether SUMO may load it to see what else is in the way: everything that is has an option that passes it, and no file
    /// lies outside.
    pub fn may_load(&self) -> bool {
        let is_harmless = |o: &Obstacle| o.way.is_some() && !o.goes_with(&[Accept::OutsideFiles]);
        self.obstacles.iter().all(is_harmless)
    }

    /// Returns that it has no vehicle, which is in the way of a run, but not of whoever looks at its signals; `None` where it
    /// has one, and where its files could not all be read.
    pub fn lacks_vehicles(&self) -> Option<Obstacle> {
        let has_vehicles = self.sources.files.iter().any(|file| file.scanned.has_vehicles);
        let reason = "none of its files has a vehicle, trip or flow, whose delay a run compares";
        let lacks = self.may_load() && !has_vehicles;
        lacks.then(|| Obstacle::new(self.path.display().to_string(), reason.to_owned(), None))
    }
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
        let way = |o: &Obstacle| o.way.as_ref().map(|(option, value)| format!("{option} {value}"));
        intake.obstacles.iter().filter_map(way).collect()
    }

    #[test]
    fn what_is_in_the_way_has_an_option_and_is_gone_with_it() {
        let routes = "<r><flow id='f' begin='0' end='1790'/><calibrator id='c'/></r>";
        let options = "<step-length v='0.3'/><mesosim v='1'/><b v='-10'/>";
        let before = read(options, routes, &Given::default());
        let expected = [
            "--accept microscopic", "--accept calibrators", "--begin 0", "--end 3600",
            "--step-length 1",
        ];
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
    fn a_scenario_of_people_alone_has_nothing_to_run() {
        let lacks = |routes: &str| {
            let intake = read("<e v='9'/>", routes, &Given::default());
            assert_eq!(intake.obstacles, [], "its signals can be looked at");
            intake.lacks_vehicles().is_some()
        };
        let person = "<person id='p' depart='0'><walk edges='a b'/></person>";
        assert!(lacks(&format!("<r>{person}</r>")));
        assert!(!lacks(&format!("<r>{person}<trip id='t' depart='900'/></r>")));
        assert!(!lacks("<r><person/><personTrip modes='public car'/></r>"));
        let missing = read("<e v='9'/><a v='gone.xml'/>", "<r/>", &Given::default());
        assert_eq!(missing.lacks_vehicles(), None, "the vehicles may be there");
    }
}
