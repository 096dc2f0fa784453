//! Scores that were measured elsewhere: a table with a row per point MDP and evaluation episode.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use sheet::Sheet;

use basics::files::numbers::is_usable;
use basics::files::{self, limits};
use basics::suggest::did_you_mean;
use evaluation::family::MdpFamily;
use evaluation::run::domain::Course;
use evaluation::run::domain::Trial;
use evaluation::run::fault::TrialError;
use evaluation::store::own::SAME_VEHICLES;
use evaluation::store::record::Metrics;

/// Column of the point MDP.
const POINT: &str = "point";
/// Column of the seed of the evaluation episode.
const SEED: &str = "seed";
/// Column of the number of the evaluation episode, from 0, in place of its seed.
const EPISODE: &str = "episode";
/// Column of the sha256 of an episode's vehicles, as `tsc-family routes` says it.
const VEHICLES: &str = "vehicles";
/// Column of the objective.
const DELAY: &str = "delay_s";

/// Returns the sha256 of the vehicles that an episode of a seed has.
pub type VehiclesOf = Box<dyn Fn(u64) -> String + Send>;

/// Which episode a row is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Which {
    /// That of a seed: the vehicles are ours.
    Seed(u64),
    /// That of a number: vehicles may be others.
    Episode(u64),
}

/// What was measured in an episode, and the sha256 of its vehicles where the table has it.
#[derive(Debug, Clone, PartialEq)]
struct Measured {
    metrics: Metrics,
    vehicles: Option<String>,
}

/// A table of scores.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scores {
    rows: BTreeMap<String, BTreeMap<Which, Measured>>,
    /// Line on which each point MDP is first.
    lines: BTreeMap<String, u64>,
    has_seeds: bool,
    has_vehicles: bool,
}

impl Scores {
    /// Reads a table with the columns `point`, `delay_s` and either `seed` or `episode`; beside `seed`, `vehicles` may have
    /// the sha256 of the vehicles. Further columns are metrics, with names like ours where they mean the same.
    ///
    /// # Errors
    ///
    /// What is wrong, with the line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = files::read(path, limits::TABLE).map_err(|e| e.reason.to_string())?;
        Self::parse(&bytes)
    }

    /// Reads a table from its bytes.
    ///
    /// # Errors
    ///
    /// What is wrong, with the line.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let at = |line: u64, what: String| format!("line {line}: {what}");
        let mut sheet = Sheet::open(bytes).map_err(|fault| at(fault.line, fault.message))?;
        let headers: Vec<String> =
            sheet.headers().iter().map(|h| h.trim().to_lowercase()).collect();
        let line = sheet.header_line();
        let column = |name: &str| headers.iter().position(|h| h == name);
        let needed = |name: &str| {
            column(name).ok_or_else(|| {
                let columns = headers.join(", ");
                at(line, format!("there is no column {name}; the columns are {columns}"))
            })
        };
        let (point, delay) = (needed(POINT)?, needed(DELAY)?);
        let (which, has_seeds) = match (column(SEED), column(EPISODE)) {
            (Some(seed), None) => (seed, true),
            (None, Some(episode)) => (episode, false),
            _ => return Err(at(line, format!("give one column of {SEED} and {EPISODE}"))),
        };
        let vehicles = column(VEHICLES);
        if vehicles.is_some() && !has_seeds {
            return Err(at(
                line,
                format!("{VEHICLES} needs the column {SEED}: they are those of a seed"),
            ));
        }
        let mut twice = BTreeSet::new();
        if let Some(name) = headers.iter().find(|name| !twice.insert(*name)) {
            return Err(at(line, format!("the column {name:?} is there twice")));
        }
        let mut rows: BTreeMap<String, BTreeMap<Which, Measured>> = BTreeMap::new();
        let mut lines = BTreeMap::new();
        while let Some(row) = sheet.next_row().map_err(|fault| at(fault.line, fault.message))? {
            let line = row.line;
            let mut metrics = Metrics::new();
            let is_metric = |i: usize| ![Some(point), Some(which), vehicles].contains(&Some(i));
            for (i, name) in headers.iter().enumerate().filter(|(i, _)| is_metric(*i)) {
                match row.number(i) {
                    Ok(Some(value)) if is_usable(value) => {
                        metrics.insert(name.clone(), value);
                    }
                    Ok(None) if i != delay => {}
                    _ => {
                        let is = format!("{name} is {:?}, which is no number", row.text(i));
                        return Err(at(line, format!("{is} from -1e100 to 1e100")));
                    }
                }
            }
            if metrics[DELAY] < 0.0 {
                return Err(at(
                    line,
                    format!("{DELAY} is {}, and nothing is below 0", metrics[DELAY]),
                ));
            }
            let text = row.text(which);
            let number: u64 = text.parse().map_err(|_| {
                at(line, format!("{} is {text:?}, which is no whole number", headers[which]))
            })?;
            let vehicles = vehicles.map(|i| row.text(i).to_lowercase());
            let is_hash =
                |text: &String| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
            if let Some(text) = vehicles.as_ref().filter(|text| !is_hash(text)) {
                return Err(at(
                    line,
                    format!(
                        "{VEHICLES} is {text:?}, which is no sha256; `tsc-family routes` says it"
                    ),
                ));
            }
            let episode = if has_seeds { Which::Seed(number) } else { Which::Episode(number) };
            lines.entry(row.text(point).to_owned()).or_insert(line);
            let of_point = rows.entry(row.text(point).to_owned()).or_default();
            if of_point.insert(episode, Measured { metrics, vehicles }).is_some() {
                let (point, name) = (row.text(point), &headers[which]);
                return Err(at(line, format!("{point} has {name} {number} already")));
            }
        }
        if rows.is_empty() {
            return Err("it has no rows".to_owned());
        }
        Ok(Self { rows, lines, has_seeds, has_vehicles: vehicles.is_some() })
    }

    /// Checks that all point MDPs of the table are of a family, and returns those of a sample that lack rows.
    ///
    /// # Arguments
    ///
    /// * `episodes` — evaluation episodes of a task.
    ///
    /// # Errors
    ///
    /// Which is not, with its line.
    pub fn lacking<'a>(
        &self,
        family: &MdpFamily,
        chosen: &BTreeSet<&'a str>,
        episodes: u32,
    ) -> Result<Vec<&'a str>, String> {
        let is_known = |name: &str| {
            family.position(name).is_some_and(|position| family.points[position].id == name)
        };
        let unknown = self.lines.iter().filter(|(point, _)| !is_known(point));
        if let Some((point, line)) = unknown.min_by_key(|(_, line)| **line) {
            let meant = match family.position(point) {
                // What it is called is there in its place.
                Some(position) => format!("; did you mean {}?", family.points[position].id),
                None => did_you_mean(point, family.points.iter().map(|p| p.id.as_str())),
            };
            return Err(format!("line {line}: the family has no point MDP {point:?}{meant}"));
        }
        let has_all = |point: &str| {
            let Some(rows) = self.rows.get(point) else { return false };
            match self.has_seeds {
                // Which seeds it takes is known when the point MDP is prepared.
                true => rows.len() >= episodes as usize,
                false => (0..episodes.into()).all(|k| rows.contains_key(&Which::Episode(k))),
            }
        };
        Ok(chosen.iter().copied().filter(|point| !has_all(point)).collect())
    }

    /// Whether the table has the vehicles of every episode.
    pub fn has_vehicles(&self) -> bool {
        self.has_vehicles
    }

    /// Returns the scores on a point MDP as a trial.
    ///
    /// # Arguments
    ///
    /// * `vehicles` — those of the run, which those of the table have to be; `None` compares nothing.
    pub fn trial(&self, point: &str, vehicles: Option<VehiclesOf>) -> ExternalTrial {
        let rows = self.rows.get(point).cloned().unwrap_or_default();
        let (point, has_seeds) = (point.to_owned(), self.has_seeds);
        ExternalTrial { point, rows, has_seeds, vehicles, episode: 0 }
    }
}

/// Scores on a point MDP; nothing is simulated.
pub struct ExternalTrial {
    point: String,
    rows: BTreeMap<Which, Measured>,
    has_seeds: bool,
    vehicles: Option<VehiclesOf>,
    episode: u64,
}

impl Trial for ExternalTrial {
    fn train(&mut self, _: &mut dyn Course) -> Result<(), TrialError> {
        Ok(())
    }

    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        let (which, words) = match self.has_seeds {
            true => (Which::Seed(seed), format!("seed {seed}")),
            false => (Which::Episode(self.episode), format!("episode {}", self.episode)),
        };
        self.episode += 1;
        let point = &self.point;
        let found = self.rows.get(&which).cloned().ok_or_else(|| {
            TrialError::Input(format!("the table has no row of {point} with {words}").into())
        })?;
        if let (Some(of), Some(theirs)) = (&self.vehicles, &found.vehicles) {
            let ours = of(seed);
            if ours != *theirs {
                return Err(TrialError::Input(
                    format!(
                        "the vehicles of {point} with {words} have the sha256 {theirs} in the table, but those of the run \
                         {ours}; simulate what `tsc-family routes` writes with the settings of the run"
                    )
                    .into(),
                ));
            }
        }
        Ok(found.metrics)
    }

    fn details(&self) -> BTreeMap<String, String> {
        let vehicles = if self.vehicles.is_some() { SAME_VEHICLES } else { "not known" };
        BTreeMap::from([
            ("measured".to_owned(), "elsewhere, not by this run".to_owned()),
            (VEHICLES.to_owned(), vehicles.to_owned()),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::family::PointMdp;

    #[test]
    fn rows_are_found_by_seed_or_by_the_number_of_the_episode() {
        let scores = Scores::parse(b"point,seed,delay_s,waiting_s\na,7,12.5,3\na,9,13,\n").unwrap();
        let mut trial = scores.trial("a", None);
        let first = trial.episode(7).unwrap();
        assert_eq!((first["delay_s"], first["waiting_s"]), (12.5, 3.0));
        assert!(!trial.episode(9).unwrap().contains_key("waiting_s"), "an empty cell is no 0");
        let e = trial.episode(8).unwrap_err().to_string();
        assert_eq!(e, "the table has no row of a with seed 8");
        let scores = Scores::parse(b"point;episode;delay_s\na;0;12,5\na;1;13\n").unwrap();
        let mut trial = scores.trial("a", None);
        assert_eq!(trial.episode(71).unwrap()["delay_s"], 12.5);
        assert_eq!(trial.episode(72).unwrap()["delay_s"], 13.0);
        let e = trial.episode(73).unwrap_err().to_string();
        assert_eq!(e, "the table has no row of a with episode 2");
        assert!(scores.trial("b", None).episode(71).is_err());
    }

    #[test]
    fn vehicles_are_those_of_the_run_or_the_task_fails() {
        let (ours, others) = ("ab".repeat(32), "cd".repeat(32));
        let table = format!(
            "point,seed,delay_s,vehicles\na,7,12.5,{ours}\na,9,13,{}\n",
            others.to_uppercase()
        );
        let scores = Scores::parse(table.as_bytes()).unwrap();
        assert!(scores.has_vehicles());
        let of = ours.clone();
        let mut trial = scores.trial("a", Some(Box::new(move |_| of.clone())));
        assert_eq!(trial.details()["vehicles"], SAME_VEHICLES);
        let first = trial.episode(7).unwrap();
        assert!(first.contains_key("delay_s") && !first.contains_key("vehicles"));
        let e = trial.episode(9).unwrap_err().to_string();
        assert!(
            e.starts_with(&format!("the vehicles of a with seed 9 have the sha256 {others}")),
            "{e}"
        );
        assert_eq!(scores.trial("a", None).details()["vehicles"], "not known");
    }

    #[test]
    fn a_table_is_of_the_family_and_what_it_lacks_is_known_before_the_run() {
        let point = |id: &str| PointMdp {
            id: id.to_owned(),
            title: format!("the {id} one"),
            importance: 1.0 / 3.0,
            instances: 1,
            features: vec![],
        };
        let points = ["quiet", "busy", "full"].map(point).to_vec();
        let family = MdpFamily::new("toy", vec![], points, "toy").unwrap();
        let chosen = BTreeSet::from(["quiet", "busy"]);
        let lacking = |text: &str, episodes: u32| {
            let scores = Scores::parse(text.as_bytes()).unwrap();
            scores.lacking(&family, &chosen, episodes)
        };
        let table = "point,episode,delay_s\nquiet,0,1\nquiet,1,1\nfull,0,1\nbusy,1,1\n";
        assert_eq!(lacking(table, 2).unwrap(), ["busy"], "it has the second episode alone");
        assert_eq!(lacking(table, 3).unwrap(), ["busy", "quiet"]);
        let table = "point,seed,delay_s\nquiet,7,1\nquiet,9,1\nbusy,7,1\n";
        assert_eq!(lacking(table, 1).unwrap(), [""; 0]);
        assert_eq!(lacking(table, 2).unwrap(), ["busy"]);
        for (name, expected) in [
            ("bsuy", "line 3: the family has no point MDP \"bsuy\"; did you mean busy?"),
            (
                "the busy one",
                "line 3: the family has no point MDP \"the busy one\"; did you mean busy?",
            ),
            ("Z", "line 3: the family has no point MDP \"Z\""),
        ] {
            let table = format!("point,seed,delay_s\nquiet,7,1\n{name},7,1\nA,7,1\n");
            let e = lacking(&table, 1).unwrap_err();
            assert_eq!(e, expected);
        }
    }

    #[test]
    fn what_is_wrong_with_a_table_is_said_with_its_line() {
        for (text, expected) in [
            ("point,delay_s\na,1\n", "line 1: give one column of seed and episode"),
            (
                "point,seed,episode,delay_s\na,1,1,1\n",
                "line 1: give one column of seed and episode",
            ),
            (
                "seed,delay_s\n1,1\n",
                "line 1: there is no column point; the columns are seed, delay_s",
            ),
            (
                "point,seed,delay_s\na,1,x\n",
                "line 2: delay_s is \"x\", which is no number from -1e100 to 1e100",
            ),
            (
                "point,seed,delay_s\na,1,\n",
                "line 2: delay_s is \"\", which is no number from -1e100 to 1e100",
            ),
            (
                "point,seed,delay_s\na,1,NaN\n",
                "line 2: delay_s is \"NaN\", which is no number from -1e100 to 1e100",
            ),
            (
                "point,seed,delay_s,loss\na,1,2,1e150\n",
                "line 2: loss is \"1e150\", which is no number from -1e100 to 1e100",
            ),
            ("point,seed,delay_s\na,1,-2\n", "line 2: delay_s is -2, and nothing is below 0"),
            ("point,seed,delay_s\na,1.5,2\n", "line 2: seed is \"1.5\", which is no whole number"),
            ("point,seed,delay_s\na,1,2\na,1,3\n", "line 3: a has seed 1 already"),
            (
                "point,seed,delay_s,delay_s\na,1,2,3\n",
                "line 1: the column \"delay_s\" is there twice",
            ),
            (
                "point,seed,delay_s,vehicles\na,1,2,abc\n",
                "line 2: vehicles is \"abc\", which is no sha256; `tsc-family routes` says it",
            ),
            (
                "point,episode,delay_s,vehicles\na,1,2,abc\n",
                "line 1: vehicles needs the column seed: they are those of a seed",
            ),
            ("point,seed,delay_s\n", "it has no rows"),
        ] {
            assert_eq!(Scores::parse(text.as_bytes()).unwrap_err(), expected, "{text}");
        }
    }
}
