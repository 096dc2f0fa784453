//! Scores that were measured elsewhere: a table with a row per point MDP and evaluation episode.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use sheet::Sheet;

use basics::files::numbers::is_usable;
use basics::files::{self, limits};
use evaluation::run::domain::{Course, Trial};
use evaluation::run::fault::TrialError;
use evaluation::store::own::SAME_VEHICLES;
use evaluation::store::record::Metrics;

/// Column of the sha256 of an episode's vehicles, as `tsc-family routes` says it; only beside a column of seeds.
const VEHICLES: &str = "vehicles";

/// Column of the objective.
const DELAY: &str = "delay_s";

/// Returns the sha256 of the vehicles that an episode of a seed has.
pub type VehiclesOf = Box<dyn Fn(u64) -> String + Send>;

/// A table of scores.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scores {
    /// By point MDP, and by seed or number of the episode: what was measured, and the sha256 of the vehicles where it is there.
    rows: BTreeMap<(String, u64), (Metrics, Option<String>)>,
    /// Whether episodes are told by their seeds, so that the vehicles are ours.
    has_seeds: bool,
    has_vehicles: bool,
}

impl Scores {
    /// Reads a table with the columns `point`, `delay_s` and either `seed` or `episode`, from 0; beside `seed`, `vehicles` may
    /// have the sha256 of the vehicles. Further columns are metrics, with names like ours where they mean the same.
    /// The error is what is wrong, with the line.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::parse(&files::read(path, limits::TABLE).map_err(|e| e.reason.to_string())?)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let at = |line: u64, what: String| format!("line {line}: {what}");
        let mut sheet = Sheet::open(bytes).map_err(|fault| at(fault.line, fault.message))?;
        let headers: Vec<String> = sheet.headers.iter().map(|h| h.trim().to_lowercase()).collect();
        let column = |name: &str| headers.iter().position(|h| h == name);
        let once: BTreeSet<&String> = headers.iter().collect();
        let columns = (column("point"), column(DELAY), column("seed"), column("episode"));
        let (point, delay, which, has_seeds) = match columns {
            (Some(point), Some(delay), Some(seed), None) => (point, delay, seed, true),
            (Some(point), Some(delay), None, Some(episode)) => (point, delay, episode, false),
            _ => (0, 0, usize::MAX, false),
        };
        let vehicles = column(VEHICLES);
        if which == usize::MAX || once.len() < headers.len() || vehicles.is_some() && !has_seeds {
            return Err(at(
                sheet.header_line,
                format!(
                    "expected the columns point, {DELAY} and either seed (and {VEHICLES}) or episode, each once; found {}",
                    headers.join(", ")
                ),
            ));
        }
        let mut rows = BTreeMap::new();
        while let Some(row) = sheet.next_row().map_err(|fault| at(fault.line, fault.message))? {
            let wrong = |i: usize, expected: &str| {
                at(row.line, format!("{} is {:?}; expected {expected}", headers[i], row.text(i)))
            };
            let mut metrics = Metrics::new();
            let is_metric = |i: usize| ![Some(point), Some(which), vehicles].contains(&Some(i));
            for (i, name) in headers.iter().enumerate().filter(|(i, _)| is_metric(*i)) {
                match row.number(i) {
                    Ok(Some(value)) if is_usable(value) && (i != delay || value >= 0.0) => {
                        metrics.insert(name.clone(), value);
                    }
                    Ok(None) if i != delay => {}
                    _ => return Err(wrong(i, "a number to 1e100, and for a delay none below 0")),
                }
            }
            let number = row.text(which).parse().map_err(|_| wrong(which, "a whole number"))?;
            let hash = vehicles.map(|i| row.text(i).to_lowercase());
            let is_hash = |t: &String| t.len() == 64 && t.bytes().all(|b| b.is_ascii_hexdigit());
            if let Some(i) = vehicles.filter(|_| !hash.as_ref().is_some_and(is_hash)) {
                return Err(wrong(i, "a sha256 as `tsc-family routes` says it"));
            }
            if rows.insert((row.text(point).to_owned(), number), (metrics, hash)).is_some() {
                return Err(wrong(which, "each episode of a point MDP once"));
            }
        }
        Ok(Self { rows, has_seeds, has_vehicles: vehicles.is_some() })
    }

    /// Whether the table has the vehicles of every episode.
    pub fn has_vehicles(&self) -> bool {
        self.has_vehicles
    }

    /// Returns the scores on a point MDP as a trial.
    /// * `vehicles` — those of the run, which those of the table have to be; `None` compares nothing.
    pub fn trial(self: &Arc<Self>, point: &str, vehicles: Option<VehiclesOf>) -> ExternalTrial {
        ExternalTrial { scores: Arc::clone(self), point: point.to_owned(), vehicles, episode: 0 }
    }
}

/// Scores on a point MDP; nothing is simulated.
pub struct ExternalTrial {
    scores: Arc<Scores>,
    point: String,
    vehicles: Option<VehiclesOf>,
    episode: u64,
}

impl Trial for ExternalTrial {
    fn train(&mut self, _: &mut dyn Course) -> Result<(), TrialError> {
        Ok(())
    }

    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        let (what, which) =
            if self.scores.has_seeds { ("seed", seed) } else { ("episode", self.episode) };
        self.episode += 1;
        let point = &self.point;
        let (metrics, theirs) =
            self.scores.rows.get(&(point.clone(), which)).cloned().ok_or_else(|| {
                let reason = format!("the table has no row of {point} with {what} {which}");
                TrialError::Input(reason.into())
            })?;
        let ours = self.vehicles.as_ref().map(|of| of(seed));
        if let Some((theirs, ours)) = theirs.zip(ours).filter(|(theirs, ours)| theirs != ours) {
            let reason = format!(
                "the vehicles of {point} with {what} {which} have the sha256 {theirs} in the table, but those of the run \
                 {ours}; simulate what `tsc-family routes` writes with the settings of the run"
            );
            return Err(TrialError::Input(reason.into()));
        }
        Ok(metrics)
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

    #[test]
    fn rows_are_found_by_seed_or_by_the_number_of_the_episode() {
        let scores = Arc::new(
            Scores::parse(b"point,seed,delay_s,waiting_s\na,7,12.5,3\na,9,13,\n").unwrap(),
        );
        let mut trial = scores.trial("a", None);
        let first = trial.episode(7).unwrap();
        assert_eq!((first["delay_s"], first["waiting_s"]), (12.5, 3.0));
        assert!(!trial.episode(9).unwrap().contains_key("waiting_s"), "an empty cell is no 0");
        let e = trial.episode(8).unwrap_err().to_string();
        assert_eq!(e, "the table has no row of a with seed 8");
        let scores = Arc::new(Scores::parse(b"point;episode;delay_s\na;0;12,5\na;1;13\n").unwrap());
        let mut trial = scores.trial("a", None);
        assert_eq!([71, 72].map(|seed| trial.episode(seed).unwrap()["delay_s"]), [12.5, 13.0]);
        assert!(scores.trial("b", None).episode(71).is_err());
    }

    #[test]
    fn what_is_wrong_with_a_table_is_said_with_its_line() {
        for (text, expected) in [
            ("point,delay_s\na,1\n", "line 1: expected the columns point, delay_s and either seed"),
            ("point,seed,delay_s\na,1,\n", "line 2: delay_s is \"\"; expected a number"),
            ("point,seed,delay_s\na,1,-2\n", "line 2: delay_s is \"-2\"; expected a number"),
            ("point,seed,delay_s\na,1.5,2\n", "line 2: seed is \"1.5\"; expected a whole number"),
            ("point,seed,delay_s\na,1,2\na,1,3\n", "line 3: seed is \"1\"; expected each episode"),
            ("point,seed,delay_s,vehicles\na,1,2,abc\n", "line 2: vehicles is \"abc\"; expected a"),
        ] {
            let e = Scores::parse(text.as_bytes()).unwrap_err();
            assert!(e.starts_with(expected), "{text}: {e}");
        }
    }
}
