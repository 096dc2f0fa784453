//! The side of the street that traffic keeps to in an extract: what decides it, and what speaks for it.
//!
//! Unless it is set, the country decides in which the signals lie. The streets have the last word where
//! they say the contrary with many votes, such as in data that somebody moved or mirrored, and that is
//! told. Extracts that reach over a border between the two are refused: no city drives on both sides.
//!
//! Tags `driving_side` mark exceptions, such as the crossed carriageways of a diverging diamond, so they
//! count only if a tenth of the ways has one.

pub mod countries;
pub mod evidence;

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::boundary::Boundary;
use super::extract::{Extract, Place};
use crate::traffic::side::DrivingSide;
use countries::{Country, countries};
use evidence::Votes;

/// Least votes of streets that outweigh the country.
const MANY_VOTES: usize = 12;

/// Least votes of streets of which a contradiction is told.
const SOME_VOTES: usize = 3;

/// Votes of a way of a roundabout: that it is drawn against its traffic is rare.
const ROUNDABOUT_VOTES: usize = 3;

/// Least share of the votes that is a clear word.
const CLEAR: f64 = 0.8;

/// Least share of ways with a tag `driving_side` for which these are no exceptions.
const TAGGED: f64 = 0.1;

/// Least share of the signals beyond a border, and least number of them, with which an extract lies on
/// both sides of it; fewer may be due to how exactly the border is known.
const BEYOND: (f64, usize) = (0.02, 2);

/// Most places without signals of which countries are looked up.
const MOST_PLACES: usize = 10_000;

/// What `--driving-side` says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SideSetting {
    /// Decided by country and streets
    #[default]
    Auto,
    /// Traffic keeps to the right
    Right,
    /// Traffic keeps to the left
    Left,
}

/// What decided the side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DecidedBy {
    /// A setting.
    Setting,
    /// The country in which the signals lie.
    Country,
    /// The streets of the extract.
    Streets,
    /// Nothing: right is assumed.
    #[default]
    Nothing,
}

/// The side of the street that traffic keeps to in an extract, and why.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct SideDecision {
    /// The side.
    pub driving_side: DrivingSide,
    /// What decided.
    pub decided_by: DecidedBy,
    /// Countries of the signals, or of the streets of an extract without signals.
    pub countries: Vec<Country>,
    /// What the senses of roundabouts say, by way.
    pub roundabouts: Votes,
    /// What the places of opposite carriageways say, by way.
    pub carriageways: Votes,
    /// What tags say, by way.
    pub tags: Votes,
    /// What does not fit the decision.
    pub warning: Option<String>,
}

/// Decides the side of an extract.
///
/// # Arguments
///
/// * `boundary` — what lies outside says nothing.
///
/// # Errors
///
/// What to do where the extract lies on both sides of a border and nothing is set.
pub fn decide(
    extract: &Extract,
    setting: SideSetting,
    boundary: Option<&Boundary>,
) -> Result<SideDecision, String> {
    let inside = |place: Place| boundary.is_none_or(|b| b.contains(place));
    let ways = extract.ways.len();
    let mut decision = SideDecision {
        countries: countries(places(extract, &inside).into_iter()),
        roundabouts: evidence::roundabouts(extract, &inside),
        carriageways: evidence::carriageways(extract, &inside),
        tags: evidence::tags(extract, &inside),
        ..SideDecision::default()
    };
    let streets = decision.streets(ways, MANY_VOTES);
    let set = match setting {
        SideSetting::Auto => None,
        SideSetting::Right => Some(DrivingSide::Right),
        SideSetting::Left => Some(DrivingSide::Left),
    };
    if set.is_none() {
        decision.one_side_of_the_border()?;
    }
    let country = decision.countries.first().map(|c| c.driving_side);
    let (side, by) = match (set, streets, country) {
        (Some(side), _, _) => (side, DecidedBy::Setting),
        (None, Some(side), country) if country != Some(side) => (side, DecidedBy::Streets),
        (None, _, Some(side)) => (side, DecidedBy::Country),
        (None, _, None) => (DrivingSide::Right, DecidedBy::Nothing),
    };
    (decision.driving_side, decision.decided_by) = (side, by);
    decision.warning = decision.doubt(decision.streets(ways, SOME_VOTES), country);
    Ok(decision)
}

/// Returns the places whose country counts: signals, or without any some nodes of streets.
fn places(extract: &Extract, inside: &dyn Fn(Place) -> bool) -> Vec<Place> {
    let signals = extract.signals.iter().map(|s| s.place).filter(|p| inside(*p));
    let signals: Vec<Place> = signals.collect();
    if !signals.is_empty() {
        return signals;
    }
    let step = extract.nodes.len().div_ceil(MOST_PLACES).max(1);
    let nodes = (0..extract.nodes.len()).step_by(step);
    nodes.filter_map(|n| extract.nodes.place(n)).filter(|p| inside(*p)).collect()
}

impl SideDecision {
    /// Returns what the streets say, if they say it with that many votes and clearly, and if roundabouts
    /// and carriageways do not contradict each other.
    fn streets(&self, ways: usize, least_votes: usize) -> Option<DrivingSide> {
        [DrivingSide::Right, DrivingSide::Left].into_iter().find(|side| {
            let clear = |votes: Votes| votes.of(*side) as f64 >= CLEAR * votes.total() as f64;
            let votes = ROUNDABOUT_VOTES * self.roundabouts.of(*side) + self.carriageways.of(*side);
            let drawn = votes >= least_votes && clear(self.roundabouts) && clear(self.carriageways);
            let is_rule = self.tags.total() as f64 >= TAGGED * ways as f64;
            drawn || (is_rule && self.tags.total() > 0 && clear(self.tags))
        })
    }

    fn one_side_of_the_border(&self) -> Result<(), String> {
        let places = |side| self.countries.iter().filter(move |c| c.driving_side == side);
        let count = |side| places(side).map(|c| c.places).sum::<usize>();
        let (right, left) = (count(DrivingSide::Right), count(DrivingSide::Left));
        let fewer = right.min(left);
        if fewer < BEYOND.1 || (fewer as f64) < BEYOND.0 * (right + left) as f64 {
            return Ok(());
        }
        let codes = |side| places(side).map(|c| c.code.as_str()).collect::<Vec<_>>().join(", ");
        Err(format!(
            "{right} of its signals are where traffic keeps to the right ({}), {left} where it keeps to \
             the left ({}); give a --boundary around one side, or say --driving-side right or left",
            codes(DrivingSide::Right),
            codes(DrivingSide::Left)
        ))
    }

    /// Returns what does not fit the decision, and the way out.
    fn doubt(&self, streets: Option<DrivingSide>, country: Option<DrivingSide>) -> Option<String> {
        let side = self.driving_side;
        let other = side.other();
        let code = || self.countries.first().map_or("", |c| c.code.as_str());
        match self.decided_by {
            DecidedBy::Nothing => Some(format!(
                "neither country nor streets say on which side traffic drives; {side} is assumed; say \
                 --driving-side {side} or {other}"
            )),
            DecidedBy::Streets if country.is_some() => Some(format!(
                "the streets are those of traffic that keeps to the {side}, but it lies in {}, where it \
                 keeps to the {other}; check the coordinates, or say --driving-side {side} or {other}",
                code()
            )),
            DecidedBy::Country if streets == Some(other) => Some(format!(
                "it lies in {}, where traffic keeps to the {side}, but the few streets that tell are those \
                 of traffic that keeps to the {other}; if it does, say --driving-side {other}",
                code()
            )),
            DecidedBy::Setting if streets == Some(other) => Some(format!(
                "--driving-side {side}, but the streets are those of traffic that keeps to the {other}; \
                 if it does, say --driving-side {other}"
            )),
            DecidedBy::Setting if streets.is_none() && country == Some(other) => Some(format!(
                "--driving-side {side}, but it lies in {}, where traffic keeps to the {other}",
                code()
            )),
            _ => None,
        }
    }

    /// Puts the side into the settings of a scenario, unless they say one.
    pub fn put_into(&self, scenario: &mut toml::Table) {
        let network = scenario.entry("network").or_insert_with(|| toml::Table::new().into());
        if let toml::Value::Table(network) = network {
            network.entry("driving_side").or_insert_with(|| self.driving_side.name().into());
        }
    }

    /// Returns the side and what speaks for it, in a line without a full stop.
    pub fn text(&self) -> String {
        let side = self.driving_side;
        let mut reasons = Vec::new();
        match self.decided_by {
            DecidedBy::Setting => reasons.push("as --driving-side or the settings say".to_owned()),
            DecidedBy::Country | DecidedBy::Streets if !self.countries.is_empty() => {
                let codes: Vec<&str> = self.countries.iter().map(|c| c.code.as_str()).collect();
                reasons.push(format!("lies in {}", codes.join(", ")));
            }
            DecidedBy::Nothing => reasons.push("assumed".to_owned()),
            DecidedBy::Country | DecidedBy::Streets => {}
        }
        for (votes, what) in [
            (self.roundabouts, "ways of roundabouts"),
            (self.carriageways, "ways with an opposite carriageway"),
            (self.tags, "ways with a tag driving_side"),
        ] {
            if votes.total() > 0 {
                reasons.push(format!("{} of {} {what} say so", votes.of(side), votes.total()));
            }
        }
        let mut text = format!("traffic keeps to the {side}");
        if !reasons.is_empty() {
            write!(text, ": {}", reasons.join("; ")).expect("writing to a string cannot fail");
        }
        text
    }
}

#[cfg(test)]
mod tests;
