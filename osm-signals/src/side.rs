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

use serde::{Deserialize, Serialize};

use super::boundary::Boundary;
use super::driving_side::DrivingSide;
use super::extract::{Extract, Place};
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

/// Which side an extract is taken to be of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SideSetting {
    /// Decided by country and streets.
    #[default]
    Auto,
    /// Traffic keeps to the right.
    Right,
    /// Traffic keeps to the left.
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
#[derive(Debug, Clone, Default, PartialEq, Eq)]
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
    pub doubt: Option<Doubt>,
}

/// What does not fit the decision on a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doubt {
    /// Neither country nor streets say a side: right is assumed.
    Nothing,
    /// The streets are those of the side, but it is not that of the country.
    StreetsNotCountry,
    /// The country decided, but the few streets that tell are those of the other side.
    CountryNotStreets,
    /// The streets are those of the other side than was set.
    SettingNotStreets,
    /// No street tells, and the country's side is the other one than was set.
    SettingNotCountry,
}

/// An extract that lies on both sides of a border between right-hand and left-hand traffic.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{} of its signals are where traffic keeps to the right ({}), {} where it keeps to the left ({})",
    .right.places, .right.countries.join(", "), .left.places, .left.countries.join(", ")
)]
pub struct AcrossBorder {
    /// What keeps to the right.
    pub right: OnSide,
    /// What keeps to the left.
    pub left: OnSide,
}

/// What of an extract lies on one side of a border.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OnSide {
    /// Signals.
    pub places: usize,
    /// ISO 3166 codes of their countries, the one with most signals first.
    pub countries: Vec<String>,
}

/// Decides the side of an extract.
///
/// # Arguments
///
/// * `boundary` — what lies outside says nothing.
///
/// # Errors
///
/// [`AcrossBorder`] where the extract lies on both sides of a border and nothing is set.
pub fn decide(
    extract: &Extract,
    setting: SideSetting,
    boundary: Option<&Boundary>,
) -> Result<SideDecision, AcrossBorder> {
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
    decision.doubt = decision.doubt(decision.streets(ways, SOME_VOTES), country);
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

    fn one_side_of_the_border(&self) -> Result<(), AcrossBorder> {
        let places = |side| self.countries.iter().filter(move |c| c.driving_side == side);
        let of = |side| OnSide {
            places: places(side).map(|c| c.places).sum(),
            countries: places(side).map(|c| c.code.clone()).collect(),
        };
        let (right, left) = (of(DrivingSide::Right), of(DrivingSide::Left));
        let fewer = right.places.min(left.places);
        if fewer < BEYOND.1 || (fewer as f64) < BEYOND.0 * (right.places + left.places) as f64 {
            return Ok(());
        }
        Err(AcrossBorder { right, left })
    }

    /// Returns what does not fit the decision.
    fn doubt(&self, streets: Option<DrivingSide>, country: Option<DrivingSide>) -> Option<Doubt> {
        let other = Some(self.driving_side.other());
        match self.decided_by {
            DecidedBy::Nothing => Some(Doubt::Nothing),
            DecidedBy::Streets if country.is_some() => Some(Doubt::StreetsNotCountry),
            DecidedBy::Country if streets == other => Some(Doubt::CountryNotStreets),
            DecidedBy::Setting if streets == other => Some(Doubt::SettingNotStreets),
            DecidedBy::Setting if streets.is_none() && country == other => {
                Some(Doubt::SettingNotCountry)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests;
