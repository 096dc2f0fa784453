//! The side that traffic keeps to in a city, as its page and its scenario say it.

use std::fmt::Write;

use osm_signals::DrivingSide;
use osm_signals::side::countries::Country;
use osm_signals::side::evidence::Votes;
use osm_signals::side::{DecidedBy, Doubt, SideDecision};
use serde::Serialize;

/// The side of the street that traffic keeps to in a city, and why.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct CitySide {
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
    /// What does not fit the decision, and the way out.
    pub warning: Option<String>,
}

impl From<SideDecision> for CitySide {
    fn from(decision: SideDecision) -> Self {
        let warning = decision.doubt.map(|doubt| warning(doubt, &decision));
        let SideDecision {
            driving_side,
            decided_by,
            countries,
            roundabouts,
            carriageways,
            tags,
            ..
        } = decision;
        Self { driving_side, decided_by, countries, roundabouts, carriageways, tags, warning }
    }
}

impl CitySide {
    /// Puts the side into the settings of a scenario, unless they say one.
    pub(super) fn put_into(&self, scenario: &mut toml::Table) {
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

/// Says what does not fit a decision, and the way out.
fn warning(doubt: Doubt, decision: &SideDecision) -> String {
    let (side, other) = (decision.driving_side, decision.driving_side.other());
    let code = decision.countries.first().map_or("", |c| c.code.as_str());
    match doubt {
        Doubt::Nothing => format!(
            "neither country nor streets say on which side traffic drives; {side} is assumed; say \
             --driving-side {side} or {other}"
        ),
        Doubt::StreetsNotCountry => format!(
            "the streets are those of traffic that keeps to the {side}, but it lies in {code}, where it \
             keeps to the {other}; check the coordinates, or say --driving-side {side} or {other}"
        ),
        Doubt::CountryNotStreets => format!(
            "it lies in {code}, where traffic keeps to the {side}, but the few streets that tell are those \
             of traffic that keeps to the {other}; if it does, say --driving-side {other}"
        ),
        Doubt::SettingNotStreets => format!(
            "--driving-side {side}, but the streets are those of traffic that keeps to the {other}; \
             if it does, say --driving-side {other}"
        ),
        Doubt::SettingNotCountry => format!(
            "--driving-side {side}, but it lies in {code}, where traffic keeps to the {other}"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn london(decided_by: DecidedBy, driving_side: DrivingSide, doubt: Option<Doubt>) -> CitySide {
        let country =
            Country { code: "GB".to_owned(), driving_side: DrivingSide::Left, places: 16 };
        let carriageways = Votes { right: 0, left: 16 };
        let countries = vec![country];
        let decision = SideDecision {
            driving_side,
            decided_by,
            countries,
            carriageways,
            doubt,
            ..Default::default()
        };
        decision.into()
    }

    #[test]
    fn what_decided_is_said_with_what_speaks_for_it() {
        assert_eq!(
            london(DecidedBy::Country, DrivingSide::Left, None).text(),
            "traffic keeps to the left: lies in GB; 16 of 16 ways with an opposite carriageway say so"
        );
    }

    #[test]
    fn what_does_not_fit_is_told_with_the_way_out() {
        let streets = Some(Doubt::StreetsNotCountry);
        assert_eq!(
            london(DecidedBy::Streets, DrivingSide::Right, streets).warning.unwrap(),
            "the streets are those of traffic that keeps to the right, but it lies in GB, where it keeps to \
             the left; check the coordinates, or say --driving-side right or left"
        );
        for (doubt, end) in [
            (Doubt::Nothing, "right is assumed; say --driving-side right or left"),
            (Doubt::CountryNotStreets, "if it does, say --driving-side left"),
            (Doubt::SettingNotStreets, "if it does, say --driving-side left"),
            (Doubt::SettingNotCountry, "lies in GB, where traffic keeps to the left"),
        ] {
            let text = london(DecidedBy::Setting, DrivingSide::Right, Some(doubt)).warning.unwrap();
            assert!(text.ends_with(end), "{text}");
        }
    }
}
