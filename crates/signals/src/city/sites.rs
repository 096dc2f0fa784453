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
use crate::junction::Conflicts;
use crate::network::intersection::{Arm, IntersectionSpec};
use crate::network::lanes::layout;
use crate::network::phases::phases;
use crate::settings::InflowSources;
use basics::units::mph_to_mps;

/// Digits after the point of a share, as a power of ten.
const SHARE: f64 = 10_000.0;

const ONE_GREEN: &str = "a single green";

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
            Self::OneGreen => ONE_GREEN,
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
    /// Whether all its streams can have green at the same time.
    one_green: bool,
}

impl Site<'_> {
    /// Returns what is worth a look in words, the most doubtful first.
    pub fn flags(&self) -> Vec<&'static str> {
        let map = self.found.all_flags().into_iter().map(|flag| flag.words());
        self.one_green.then_some(ONE_GREEN).into_iter().chain(map).collect()
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

/// A signal, or several of one junction, that is no intersection of the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkippedSite<'a> {
    /// Ids of the signal nodes.
    pub signals: &'a [i64],
    /// Where the first of them is.
    pub place: Place,
    /// Why.
    pub reason: Reason,
}

/// The intersections of a city.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct City {
    survey: Survey,
    /// Side of the street that traffic keeps to.
    pub side: DrivingSide,
    /// By intersection of the survey whether all its streams can have green at the same time.
    one_green: Vec<bool>,
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
        let all = &survey.found.intersections;
        let one_green = all.iter().map(|i| has_one_green(i, side)).collect();
        let reasons = vec![None; all.len()];
        Self { survey, side, one_green, reasons, out: Vec::new(), left_out: BTreeMap::new() }
    }

    /// Says that the turns of intersections were counted, so that their inflows rest on that.
    pub(super) fn count_by_turn(&mut self, ids: &BTreeSet<String>) {
        let all = self.survey.found.intersections.iter().zip(&mut self.survey.traffic);
        for (intersection, traffic) in all.filter(|(i, _)| ids.contains(&i.id)) {
            for (arm, traffic) in intersection.arms.iter().zip(traffic) {
                if arm.lanes_in > 0 {
                    (traffic.source, traffic.count) = (InflowSource::Counted, None);
                }
            }
        }
    }

    /// Returns what was found, with the intersections that are left out.
    pub fn survey(&self) -> &Survey {
        &self.survey
    }

    /// Returns the intersections.
    pub fn sites(&self) -> impl Iterator<Item = Site<'_>> {
        let found = self.survey.found.intersections.iter().zip(&self.survey.traffic);
        let all = found.zip(&self.one_green).zip(&self.reasons);
        all.filter(|(_, reason)| reason.is_none()).map(|(((found, traffic), one_green), _)| Site {
            found,
            traffic,
            one_green: *one_green,
        })
    }

    /// Returns the table of approaches, one row per arm: A, B, C clockwise from north.
    pub fn approaches(&self, settings: &IntersectionSettings) -> Vec<Approach> {
        self.sites().flat_map(|site| site.approaches(settings)).collect()
    }

    /// Returns the signals that are no intersection.
    pub(super) fn skipped(&self) -> impl Iterator<Item = SkippedSite<'_>> {
        let map = self.survey.found.skipped.iter().map(|s| SkippedSite {
            signals: &s.signals,
            place: s.place,
            reason: Reason::Map(s.reason),
        });
        let out = self.out.iter().filter_map(|index| {
            let (i, reason) = (&self.survey.found.intersections[*index], self.reasons[*index]?);
            Some(SkippedSite { signals: &i.signals, place: i.centre, reason })
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

    /// Takes intersections out for which no sound network can be built, each with the reason.
    pub fn leave_out(&mut self, reasons: BTreeMap<String, String>) {
        self.take_out(|i, _| reasons.contains_key(&i.id), Reason::NoNetwork);
        self.left_out.extend(reasons);
    }

    /// Takes intersections out at which nothing is to decide, and returns how many.
    ///
    /// As six features they stand for an intersection that has more than one green; built with their own arms
    /// they have a score without any meaning.
    ///
    /// # Arguments
    ///
    /// * `built` — ids of those whose network turned out to have one green.
    pub fn leave_out_one_green(&mut self, built: &BTreeSet<String>) -> usize {
        self.take_out(|i, one_green| one_green || built.contains(&i.id), Reason::OneGreen)
    }

    fn take_out(&mut self, which: impl Fn(&Intersection, bool) -> bool, reason: Reason) -> usize {
        let before = self.out.len();
        for (index, i) in self.survey.found.intersections.iter().enumerate() {
            if self.reasons[index].is_none() && which(i, self.one_green[index]) {
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
        for skipped in self.skipped() {
            let count = counts.entry(skipped.reason.words()).or_insert((skipped.reason, 0));
            count.1 += skipped.signals.len().max(1);
        }
        let mut counts: Vec<(Reason, usize)> = counts.into_values().collect();
        counts.sort_by_key(|(_, n)| Reverse(*n));
        counts
    }
}

/// Returns whether all streams of an intersection can have green at the same time.
fn has_one_green(intersection: &Intersection, side: DrivingSide) -> bool {
    let arm = |(arm, turns): (&osm_signals::Arm, &Option<Turns>)| {
        let (left_turn_lanes, right_turn_lanes) =
            side.swapped((arm.left_turn_lanes, arm.right_turn_lanes));
        Arm {
            bearing_deg: side.bearing_deg(arm.bearing_deg),
            lanes_in: arm.lanes_in,
            lanes_out: arm.lanes_out,
            left_turn_lanes,
            right_turn_lanes,
            left_storage_m: None,
            right_storage_m: None,
            speed_mps: mph_to_mps(arm.speed_mph),
            length_m: arm.length_m,
            inflow_vph: 0.0,
            counted: None,
            turns: turns.map(|turns| if side.is_right() { turns } else { turns.mirrored() }),
        }
    };
    let mut arms: Vec<Arm> = intersection.arms.iter().zip(&intersection.turns).map(arm).collect();
    arms.sort_by(|a, b| a.bearing_deg.total_cmp(&b.bearing_deg));
    let spec = IntersectionSpec { point: intersection.id.clone(), arms, side };
    let greens = layout(&spec).map(|l| phases(&spec, &l, &Conflicts::of(&l.movements), None).len());
    greens.is_ok_and(|greens| greens == 1)
}
