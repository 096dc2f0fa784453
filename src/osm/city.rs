//! A city: the intersections of an extract with their traffic, as the approaches of a family.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use geo::{BoundingRect, Coord, LineString, Rect};

use super::OsmError;
use super::boundary::Boundary;
use super::config::OsmConfig;
use super::counts::Counts;
use super::extract::Extract;
use super::flags::Flag;
use super::graph::Graph;
use super::intersections::{Found, Intersection, Skip, Skipped};
use super::listing::{ListMatch, keep_listed};
use super::mirror;
use super::side::SideDecision;
use super::signals::SignalList;
use super::spread::Spread;
use super::traffic::{ArmTraffic, InflowSource, traffic};
use crate::traffic::family::approaches::Approach;
use crate::traffic::network::intersection::Turns;
use crate::traffic::settings::inflow::InflowSources;

/// What decides beside the extract.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inputs<'a> {
    /// Which intersections count.
    pub signals: Option<&'a SignalList>,
    /// Traffic counts.
    pub counts: Option<&'a Counts>,
    /// Where intersections must lie.
    pub boundary: Option<&'a Boundary>,
    /// Side of the street that traffic keeps to; `None` for the right.
    pub side: Option<&'a SideDecision>,
}

/// The intersections of a city.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct City {
    /// Intersections and what is none.
    pub found: Found,
    /// Traffic by intersection and arm.
    pub traffic: Vec<Vec<ArmTraffic>>,
    /// What became of the rows of the signal list.
    pub listed: Vec<ListMatch>,
    /// Intersections without a sound network, and why.
    pub left_out: BTreeMap<String, String>,
    /// The smallest box around the streets of the extract, degrees: x is the longitude and y the
    /// latitude; nothing without any street.
    pub covered: Option<Rect<f64>>,
    /// Side of the street that traffic keeps to, and why.
    pub side: SideDecision,
}

impl City {
    /// Returns the city of an extract.
    pub fn new(extract: &Extract, config: &OsmConfig, inputs: &Inputs<'_>) -> Self {
        let match_m = config.intersections.list_match_m;
        let rows = inputs.signals.map_or(&[][..], |list| &list.signals[..]);
        let graph = Graph::new(extract);
        let side = inputs.side.cloned().unwrap_or_default();
        let (mut found, named) = mirror::found(&graph, config, rows, side.driving_side);
        // A junction outside the boundary ends the reach of a count as well.
        let limit_m = config.counts.spread_m;
        let spread = inputs
            .counts
            .map(|counts| (counts, Spread::new(&graph, &found.intersections, limit_m)));
        if let Some(boundary) = inputs.boundary {
            let (inside, outside) =
                found.intersections.into_iter().partition(|i| boundary.contains(i.centre));
            found.intersections = inside;
            for skipped in found.skipped.iter_mut().filter(|s| !boundary.contains(s.place)) {
                skipped.reason = Skip::OutsideBoundary;
            }
            found.skipped.extend(Vec::into_iter(outside).map(|i| Skipped {
                signals: i.signals,
                place: i.centre,
                reason: Skip::OutsideBoundary,
            }));
        }
        let listed = match inputs.signals {
            Some(list) => keep_listed(&mut found, &list.signals, &named, match_m),
            None => Vec::new(),
        };
        let counts = spread.as_ref().map(|(counts, spread)| (*counts, spread));
        let traffic = traffic(&found.intersections, counts, &config.traffic);
        let (left_out, covered) = (BTreeMap::new(), covered(extract));
        Self { found, traffic, listed, left_out, covered, side }
    }

    /// Takes intersections out for which no sound network can be built, each with the reason.
    pub fn leave_out(&mut self, reasons: BTreeMap<String, String>) {
        self.take_out(&|id| reasons.contains_key(id), Skip::NoNetwork);
        self.left_out.extend(reasons);
    }

    fn take_out(&mut self, which: &dyn Fn(&str) -> bool, reason: Skip) {
        let all = std::mem::take(&mut self.found.intersections);
        let traffic = std::mem::take(&mut self.traffic);
        for (intersection, traffic) in all.into_iter().zip(traffic) {
            if which(&intersection.id) {
                self.found.skipped.push(Skipped {
                    signals: intersection.signals,
                    place: intersection.centre,
                    reason,
                });
            } else {
                self.found.intersections.push(intersection);
                self.traffic.push(traffic);
            }
        }
        for row in &mut self.listed {
            if row.intersection.as_ref().is_some_and(|id| which(id)) {
                row.intersection = None;
                row.reason = Some(reason.reason());
            }
        }
    }

    /// Takes intersections out at which nothing is to decide, and returns how many.
    ///
    /// As six features they stand for an intersection that has more than one green; built with their own arms
    /// they have a score without any meaning.
    ///
    /// # Arguments
    ///
    /// * `built` — by id those whose network turned out to have one green.
    pub fn leave_out_one_green(&mut self, built: &BTreeMap<String, String>) -> usize {
        let one_green =
            |i: &&Intersection| i.flags.contains(&Flag::OneGreen) || built.contains_key(&i.id);
        let ids: BTreeSet<String> =
            self.found.intersections.iter().filter(one_green).map(|i| i.id.clone()).collect();
        self.take_out(&|id| ids.contains(id), Skip::OneGreen);
        ids.len()
    }

    /// Returns the table of approaches, one row per arm.
    pub fn approaches(&self, config: &OsmConfig) -> Vec<Approach> {
        let mut rows = Vec::new();
        let (shortest_m, longest_m) =
            (config.intersections.min_length_m, config.intersections.max_length_m);
        for (i, traffic) in self.found.intersections.iter().zip(&self.traffic) {
            for (index, ((arm, turns), traffic)) in
                i.arms.iter().zip(&i.turns).zip(traffic).enumerate()
            {
                rows.push(Approach {
                    intersection: i.id.clone(),
                    arm: arm_name(index),
                    latitude: i.centre.latitude(),
                    longitude: i.centre.longitude(),
                    bearing_deg: rounded(arm.bearing_deg, 10.0).rem_euclid(360.0),
                    lanes_in: arm.lanes_in,
                    lanes_out: arm.lanes_out,
                    left_turn_lanes: arm.left_turn_lanes,
                    right_turn_lanes: arm.right_turn_lanes,
                    speed_mph: rounded(arm.speed_mph, 10.0),
                    length_m: rounded(arm.length_m.clamp(shortest_m, longest_m), 10.0),
                    aadt_veh_per_day_per_lane: traffic.aadt_per_lane.round(),
                    movements: turns.map_or_else(String::new, letters),
                });
            }
        }
        rows
    }

    /// Returns the table of approaches as CSV.
    ///
    /// # Errors
    ///
    /// [`OsmError::Nothing`] if there is no intersection.
    pub fn table(&self, config: &OsmConfig, extract: &Path) -> Result<Vec<u8>, OsmError> {
        if self.found.intersections.is_empty() {
            let path = extract.to_path_buf();
            return Err(OsmError::Nothing { path, reason: self.why_none() });
        }
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in self.approaches(config) {
            writer.serialize(row).expect("a row is plain data");
        }
        Ok(writer.into_inner().expect("memory takes every row"))
    }

    /// Says why no signal became an intersection, most frequent reason first.
    fn why_none(&self) -> String {
        let counts = self.skips();
        if counts.is_empty() {
            return "no signal (highway=traffic_signals) on a drivable street; give a larger \
                    extract, or list the signals with --signals"
                .to_owned();
        }
        let reasons: Vec<String> =
            counts.iter().map(|(skip, n)| format!("{n} {}", skip.reason())).collect();
        let way_out = match counts[0].0 {
            Skip::Border => "give an extract that reaches some hundred metres beyond the signals",
            Skip::OutsideBoundary => &match self.covered {
                Some(bounds) => {
                    format!("give another --boundary: the extract covers {}", extent(bounds))
                }
                None => "give another --boundary".to_owned(),
            },
            Skip::NotListed => "check the places in the signal list",
            Skip::NoNetwork => "see the reasons above",
            Skip::ManyArms | Skip::ManyLanes | Skip::FewArms | Skip::FewApproaches => {
                "look at them on the map, and correct the map or [intersections] in the settings"
            }
            _ => "see which nodes have highway=traffic_signals",
        };
        format!("no signalised intersection; signals: {}; {way_out}", reasons.join(", "))
    }

    /// Returns whether a traffic count was found for any arm.
    pub fn is_counted(&self) -> bool {
        self.traffic.iter().flatten().any(|t| t.count.is_some())
    }

    /// Returns what the inflows rest on, shares of the approaches with four digits.
    pub fn inflow_sources(&self) -> InflowSources {
        let arms = self.found.intersections.iter().flat_map(|i| &i.arms);
        let approaches =
            arms.zip(self.traffic.iter().flatten()).filter(|(arm, _)| arm.lanes_in > 0);
        let sources: Vec<InflowSource> = approaches.map(|(_, traffic)| traffic.source).collect();
        let [counted, spread, imputed, default] = InflowSource::ALL.map(|source| {
            let n = sources.iter().filter(|s| **s == source).count();
            rounded(n as f64 / sources.len().max(1) as f64, 10_000.0)
        });
        InflowSources { counted, spread, imputed, default }
    }

    /// Returns how many signals are no intersection, by reason, most frequent first.
    pub fn skips(&self) -> Vec<(Skip, usize)> {
        let mut counts = BTreeMap::new();
        for skipped in &self.found.skipped {
            *counts.entry(skipped.reason).or_default() += skipped.signals.len().max(1);
        }
        let mut counts: Vec<(Skip, usize)> = counts.into_iter().collect();
        counts.sort_by_key(|(skip, n)| (std::cmp::Reverse(*n), *skip));
        counts
    }
}

/// Returns the smallest box around the streets of an extract, degrees.
fn covered(extract: &Extract) -> Option<Rect<f64>> {
    let places = (0..extract.nodes.len()).filter_map(|node| extract.nodes.place(node));
    let line: LineString<f64> =
        places.map(|p| Coord { x: p.longitude(), y: p.latitude() }).collect();
    line.bounding_rect()
}

/// Says where a box lies whose x is the longitude and y the latitude, degrees.
pub fn extent(bounds: Rect<f64>) -> String {
    let (low, high) = (bounds.min(), bounds.max());
    format!("longitudes {:.3} to {:.3} and latitudes {:.3} to {:.3}", low.x, high.x, low.y, high.y)
}

/// Returns the name of an arm: A, B, C clockwise from north.
pub(super) fn arm_name(index: usize) -> String {
    char::from(b'A' + index as u8).to_string()
}

fn letters(turns: Turns) -> String {
    let letters = [(turns.left, 'l'), (turns.through, 's'), (turns.right, 'r')];
    letters.iter().filter(|(exists, _)| *exists).map(|(_, letter)| *letter).collect()
}

fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}
