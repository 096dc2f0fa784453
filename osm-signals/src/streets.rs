//! Lanes and speed of a street in one direction, with what they rest on: a tag, the rest of the
//! street's class in the extract, or a default.

use std::collections::BTreeMap;

use serde::Serialize;

use super::extract::Extract;
use super::settings::StreetSettings;
use super::tags::lanes::TurnLane;
use super::tags::{Direction, Highway, Street};

/// What a value rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A tag, or a count.
    Tagged,
    /// What is most frequent in its highway class in the extract.
    Imputed,
    /// A default.
    Default,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lanes {
    /// All of them, the centre lane included.
    pub(crate) lanes: u32,
    /// Those from which only left turns are marked, the centre lane included.
    pub(crate) left_only: u32,
    pub(crate) right_only: u32,
    /// Whether a lane between the directions is among the left-only ones.
    pub(crate) centre: bool,
    pub(crate) marked: bool,
    pub(crate) source: Source,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Streets {
    /// Most frequent total of lanes by class and one-wayness.
    lanes: BTreeMap<(Highway, bool), u32>,
    /// Most frequent speed limit by class, miles per hour.
    speed_mph: BTreeMap<Highway, f64>,
    settings: StreetSettings,
}

impl Streets {
    pub(crate) fn new(extract: &Extract, settings: &StreetSettings) -> Self {
        let mut lanes: BTreeMap<(Highway, bool), BTreeMap<u32, u32>> = BTreeMap::new();
        let mut speeds: BTreeMap<Highway, BTreeMap<u32, u32>> = BTreeMap::new();
        for street in extract.ways.iter().map(|w| &w.street) {
            if let Some(total) = street.lanes.total {
                let key = (street.highway, street.direction != Direction::Both);
                *lanes.entry(key).or_default().entry(u32::from(total)).or_default() += 1;
            }
            let directions = [true, false].map(|forward| street.speed.in_direction(forward));
            for mph in directions.into_iter().flatten() {
                // Speeds are positive, so that their bits are in their order.
                *speeds.entry(street.highway).or_default().entry(mph.to_bits()).or_default() += 1;
            }
        }
        // Of equally frequent numbers the smallest.
        let mode = |counts: BTreeMap<u32, u32>| {
            let most = counts.values().max().copied();
            counts.into_iter().find(|(_, n)| Some(*n) == most).map(|(value, _)| value)
        };
        // Of equally frequent limits the one nearest to the mean, so that a street of few tags is no extreme.
        let limit = |counts: BTreeMap<u32, u32>| {
            let mph = |bits: &u32| f64::from(f32::from_bits(*bits));
            let total: f64 = counts.values().copied().map(f64::from).sum();
            let mean =
                counts.iter().map(|(bits, n)| mph(bits) * f64::from(*n)).sum::<f64>() / total;
            let most = counts.values().max().copied();
            let frequent = counts.iter().filter(|(_, n)| Some(**n) == most).map(|(b, _)| mph(b));
            frequent.min_by(|a, b| (a - mean).abs().total_cmp(&(b - mean).abs()))
        };
        Self {
            lanes: lanes.into_iter().map(|(key, n)| (key, mode(n).unwrap_or(1))).collect(),
            // Deviation: OSMnx takes the mean, which is no limit that anybody signs, and yellow follows from it.
            speed_mph: speeds.into_iter().filter_map(|(c, n)| Some((c, limit(n)?))).collect(),
            settings: settings.clone(),
        }
    }

    pub(crate) fn speed_mph(&self, street: &Street, forward: bool) -> (f64, Source) {
        if let Some(mph) = street.speed.in_direction(forward) {
            return (f64::from(mph), Source::Tagged);
        }
        match self.speed_mph.get(&street.highway) {
            Some(mph) => (*mph, Source::Imputed),
            None => (self.settings.default_speed_mph, Source::Default),
        }
    }

    pub(crate) fn lanes(&self, street: &Street, forward: bool) -> Lanes {
        let (through, centre, source) = self.count(street, forward);
        let marks = marks(street, forward).filter(|marks| marks.len() == through as usize);
        let count = |is: fn(TurnLane) -> bool| {
            marks.map_or(0, |marks| marks.iter().filter(|m| is(**m)).count() as u32)
        };
        let (left_only, right_only) =
            (count(TurnLane::is_left_only), count(|turn| turn == TurnLane::RIGHT));
        let centre = centre && left_only == 0;
        Lanes {
            lanes: through + u32::from(centre),
            left_only: left_only + u32::from(centre),
            right_only,
            centre,
            marked: marks.is_some(),
            source,
        }
    }

    /// Returns the lanes that belong to a direction alone, whether there is a centre lane, and what the number rests on.
    fn count(&self, street: &Street, forward: bool) -> (u32, bool, Source) {
        let tags = &street.lanes;
        let own = |forward: bool| if forward { tags.forward } else { tags.backward };
        let marked = |forward: bool| marks(street, forward).map(|m| m.len() as u32);
        let one_way = street.direction != Direction::Both;
        let total = tags.total.map(u32::from);
        if one_way {
            let tagged = tags.one_way(forward).map(u32::from).or(marked(forward));
            return match tagged {
                Some(lanes) => (lanes, false, Source::Tagged),
                None => {
                    let (lanes, source) = self.typical(street, true);
                    (lanes, false, source)
                }
            };
        }
        let centre = tags.both_ways.map(|n| n > 0);
        let taken = u32::from(tags.both_ways.unwrap_or(0));
        let rest = |other: u32| total.and_then(|t| t.checked_sub(other + taken)).filter(|n| *n > 0);
        let tagged = own(forward)
            .map(u32::from)
            .or_else(|| rest(own(!forward).map(u32::from)?))
            .or_else(|| marked(forward))
            .or_else(|| rest(marked(!forward)?));
        if let Some(lanes) = tagged {
            return (lanes, centre.unwrap_or(false), Source::Tagged);
        }
        let (total, source) = match total {
            Some(total) => (total, Source::Tagged),
            None => self.typical(street, false),
        };
        let split = total.saturating_sub(taken);
        // An odd lane without any other word lies in the middle; a single one serves both ways.
        let odd = centre.is_none() && split % 2 == 1 && split > 1;
        ((split / 2).max(1), odd || centre.unwrap_or(false), source)
    }

    fn typical(&self, street: &Street, one_way: bool) -> (u32, Source) {
        if let Some(lanes) = self.lanes.get(&(street.highway, one_way)) {
            return (*lanes, Source::Imputed);
        }
        let lanes = self.settings.default_lanes.get(&street.highway).copied().unwrap_or(1);
        (u32::from(lanes) * if one_way { 1 } else { 2 }, Source::Default)
    }
}

/// Returns the marked turns of a direction, from left to right; `None` without marks.
fn marks(street: &Street, forward: bool) -> Option<&[TurnLane]> {
    let turns = street.turns.as_ref()?;
    let own = if forward { &turns.forward } else { &turns.backward };
    let one_way = street.direction != Direction::Both;
    let lanes = if own.is_empty() && one_way { &turns.plain } else { own };
    (!lanes.is_empty()).then_some(&**lanes)
}

#[cfg(test)]
mod tests {
    use super::super::oddities::Oddities;
    use super::super::tags::Tags;
    use super::*;

    fn lanes(tags: &Tags<'_>, forward: bool) -> (u32, u32, u32) {
        let mut all = vec![("highway", "primary")];
        all.extend(tags);
        let street = Street::parse(1, &all, &mut Oddities::default()).unwrap();
        let streets = Streets::new(&Extract::default(), &StreetSettings::default());
        let lanes = streets.lanes(&street, forward);
        (lanes.lanes, lanes.left_only, lanes.right_only)
    }

    #[test]
    fn an_odd_total_has_a_centre_lane_for_left_turns() {
        assert_eq!(lanes(&[("lanes", "5")], true), (3, 1, 0));
        assert_eq!(lanes(&[("lanes", "5")], false), (3, 1, 0));
        assert_eq!(lanes(&[("lanes", "1")], false), (1, 0, 0));
    }

    #[test]
    fn the_other_direction_gets_the_rest() {
        let tags = [("lanes", "5"), ("lanes:forward", "3")];
        assert_eq!(lanes(&tags, true), (3, 0, 0));
        assert_eq!(lanes(&tags, false), (2, 0, 0));
    }

    #[test]
    fn marks_count_lanes_where_no_number_does() {
        let tags = [("turn:lanes:forward", "left|through|through;right|right")];
        assert_eq!(lanes(&tags, true), (4, 1, 1));
    }

    #[test]
    fn marks_that_contradict_the_number_are_ignored() {
        let tags = [("oneway", "yes"), ("lanes", "2"), ("turn:lanes", "left|through|through")];
        assert_eq!(lanes(&tags, true), (2, 0, 0));
    }

    #[test]
    fn a_bus_lane_is_no_lane_and_leaves_the_arrows() {
        let tags = [
            ("oneway", "yes"),
            ("lanes", "4"),
            ("turn:lanes", "left|through|through;right|"),
            ("access:lanes", "yes|yes|yes|no"),
        ];
        assert_eq!(lanes(&tags, true), (3, 1, 0));
        let against = [
            ("oneway", "yes"),
            ("lanes", "3"),
            ("lanes:forward", "2"),
            ("lanes:backward", "1"),
            ("turn:lanes:forward", "left|through;right"),
        ];
        assert_eq!(lanes(&against, true), (2, 1, 0));
    }

    #[test]
    fn marks_against_the_nodes_are_those_of_backward() {
        let tags = [("oneway", "-1"), ("turn:lanes:backward", "left|through")];
        assert_eq!(lanes(&tags, false), (2, 1, 0));
    }
}
