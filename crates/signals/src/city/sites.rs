//! A city: what a survey of its map found, less the intersections that cannot be in the family; and its table of
//! approaches.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use osm_signals::intersections::Skip;
use osm_signals::listing::ListMatch;
use osm_signals::settings::IntersectionSettings;
use osm_signals::traffic::{ArmTraffic, InflowSource};
use osm_signals::{DrivingSide, Intersection, Place, Survey, Turns};
use serde::Serialize;

use crate::family::approaches::Approach;
use crate::settings::InflowSources;

/// Digits after the point of a share, as a power of ten.
const SHARE: f64 = 10_000.0;

/// Why a signal is no intersection of the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// No two streams need green at different times, so there is nothing to control.
    OneGreen,
    /// No sound network can be built for it.
    NoNetwork,
    /// It is none on the map, or not one that was asked for.
    #[serde(untagged)]
    Map(Skip),
}

impl Reason {
    /// Returns the reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Map(skip) => skip.reason(),
            Self::OneGreen => "a single green",
            Self::NoNetwork => "no sound network can be built",
        }
    }
}

/// An intersection of a city.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// How it was found.
    pub found: &'a Intersection,
    /// Its traffic by arm.
    pub traffic: &'a [ArmTraffic],
}

impl Site<'_> {
    /// Returns what is worth a look in words, the most doubtful first.
    pub fn flags(&self) -> Vec<&'static str> {
        self.found.all_flags().into_iter().map(|flag| flag.words()).collect()
    }

    fn approaches(&self, settings: &IntersectionSettings) -> Vec<Approach> {
        let i = self.found;
        let (shortest_m, longest_m) = (settings.min_length_m, settings.max_length_m);
        let tenths = |value: f64| (value * 10.0).round() / 10.0;
        let arms = i.arms.iter().zip(&i.turns).zip(self.traffic).zip('A'..);
        arms.map(|(((arm, turns), traffic), name)| Approach {
            intersection: i.id.clone(),
            arm: name.to_string(),
            latitude: i.centre.latitude(),
            longitude: i.centre.longitude(),
            bearing_deg: tenths(arm.bearing_deg).rem_euclid(360.0),
            lanes_in: arm.lanes_in,
            lanes_out: arm.lanes_out,
            left_turn_lanes: arm.left_turn_lanes,
            right_turn_lanes: arm.right_turn_lanes,
            speed_mph: tenths(arm.speed_mph),
            length_m: tenths(arm.length_m.clamp(shortest_m, longest_m)),
            aadt_veh_per_day_per_lane: traffic.aadt_per_lane.round(),
            movements: turns.map_or_else(String::new, letters),
            ..Approach::default()
        })
        .collect()
    }
}

fn letters(turns: Turns) -> String {
    let letters = [(turns.left, 'l'), (turns.through, 's'), (turns.right, 'r')];
    letters.iter().filter(|(exists, _)| *exists).map(|(_, letter)| *letter).collect()
}

/// The intersections of a city.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct City {
    /// What was found, with the intersections that are left out.
    pub survey: Survey,
    /// Side of the street that traffic keeps to.
    pub side: DrivingSide,
    /// By intersection of the survey why it is left out.
    reasons: Vec<Option<Reason>>,
    /// Those that are left out, in the order in which they were.
    out: Vec<usize>,
    /// Intersections without a sound network, and why.
    pub left_out: BTreeMap<String, String>,
}

impl City {
    /// Returns the city of a survey.
    pub fn new(survey: Survey, side: DrivingSide) -> Self {
        let reasons = vec![None; survey.found.intersections.len()];
        Self { survey, side, reasons, ..Self::default() }
    }

    /// Says that the turns of intersections were counted, so that their inflows rest on that.
    pub(super) fn count_by_turn(&mut self, ids: &BTreeSet<String>) {
        let all = self.survey.found.intersections.iter().zip(&mut self.survey.traffic);
        for (intersection, traffic) in all.filter(|(i, _)| ids.contains(&i.id)) {
            for (arm, traffic) in intersection.arms.iter().zip(traffic) {
                if arm.lanes_in > 0 {
                    (traffic.source, traffic.count_distance_m) = (InflowSource::Counted, None);
                }
            }
        }
    }

    /// Returns the intersections.
    pub fn sites(&self) -> impl Iterator<Item = Site<'_>> {
        let found = self.survey.found.intersections.iter().zip(&self.survey.traffic);
        let kept = found.zip(&self.reasons).filter(|(_, reason)| reason.is_none());
        kept.map(|((found, traffic), _)| Site { found, traffic })
    }

    /// Returns the table of approaches, one row per arm: A, B, C clockwise from north.
    pub fn approaches(&self, settings: &IntersectionSettings) -> Vec<Approach> {
        self.sites().flat_map(|site| site.approaches(settings)).collect()
    }

    /// Returns the signals that are no intersection: nodes of one junction, the place of the first, and why.
    pub(super) fn skipped(&self) -> impl Iterator<Item = (&[i64], Place, Reason)> {
        let map = self.survey.found.skipped.iter();
        let map = map.map(|s| (s.signals.as_slice(), s.place, Reason::Map(s.reason)));
        let out = self.out.iter().filter_map(|index| {
            let i = &self.survey.found.intersections[*index];
            Some((i.signals.as_slice(), i.centre, self.reasons[*index]?))
        });
        map.chain(out)
    }

    /// Returns the rows of the signal list, with the reason why the intersection of one is left out.
    pub fn listed(&self) -> impl Iterator<Item = (&ListMatch, Option<Reason>)> {
        let all = self.survey.found.intersections.iter().zip(&self.reasons);
        let left_out: BTreeMap<&str, Reason> =
            all.filter_map(|(i, reason)| Some((i.id.as_str(), (*reason)?))).collect();
        self.survey.listed.iter().map(move |row| {
            let id = row.intersection.as_deref();
            (row, id.and_then(|id| left_out.get(id).copied()))
        })
    }

    /// Takes intersections out, by their ids, and returns how many: no sound network can be built for them, or nothing is to
    /// decide there. Built with their own arms the latter have a score without any meaning; as six features they stand for an
    /// intersection that has more than one green.
    pub fn leave_out(&mut self, ids: &BTreeMap<String, String>, reason: Reason) -> usize {
        let before = self.out.len();
        for (index, i) in self.survey.found.intersections.iter().enumerate() {
            if self.reasons[index].is_none() && ids.contains_key(&i.id) {
                self.reasons[index] = Some(reason);
                self.out.push(index);
            }
        }
        self.out.len() - before
    }

    /// Returns what the inflows rest on, shares of the approaches with four digits.
    pub(super) fn inflow_sources(&self) -> InflowSources {
        let arms = self.sites().flat_map(|site| site.found.arms.iter().zip(site.traffic));
        let approaches = arms.filter(|(arm, _)| arm.lanes_in > 0);
        let sources: Vec<InflowSource> = approaches.map(|(_, traffic)| traffic.source).collect();
        let [counted, spread, imputed, default] = InflowSource::ALL.map(|source| {
            let n = sources.iter().filter(|s| **s == source).count();
            (n as f64 / sources.len().max(1) as f64 * SHARE).round() / SHARE
        });
        InflowSources { counted, spread, imputed, default, by_turn: 0.0 }
    }

    /// Returns how many signals are no intersection, by reason, most frequent first.
    pub fn skips(&self) -> Vec<(Reason, usize)> {
        let mut counts: BTreeMap<&str, (Reason, usize)> = BTreeMap::new();
        for (signals, _, reason) in self.skipped() {
            counts.entry(reason.words()).or_insert((reason, 0)).1 += signals.len().max(1);
        }
        let mut counts: Vec<(Reason, usize)> = counts.into_values().collect();
        counts.sort_by_key(|(_, n)| Reverse(*n));
        counts
    }
}
