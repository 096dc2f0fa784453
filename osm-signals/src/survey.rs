//! A survey: the signalised intersections of an extract with their arms, and what a city knows of them.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use geo::{BoundingRect, Coord, LineString, Rect};

use super::boundary::Boundary;
use super::counts::Counts;
use super::driving_side::DrivingSide;
use super::extract::Extract;
use super::graph::Graph;
use super::intersections::{Found, Skip, Skipped};
use super::listing::{ListMatch, keep_listed};
use super::mirror;
use super::settings::Settings;
use super::signals::SignalList;
use super::spread::Spread;
use super::tags::Highway;
use super::traffic::{ArmTraffic, InflowSource, traffic};

/// Vehicles per day and lane of main streets below which counts are in thousands, and of an hour: the ranges of
/// FHWA for collectors and arterials begin at 550 (Highway Functional Classification, 2013, tables 3-5 and 3-6).
const THOUSANDS: f64 = 50.0;
const HOURLY: f64 = 400.0;

/// What decides beside the extract.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inputs<'a> {
    /// Which intersections count.
    pub signals: Option<&'a SignalList>,
    /// Traffic counts.
    pub counts: Option<&'a Counts>,
    /// Where intersections must lie.
    pub boundary: Option<&'a Boundary>,
    /// Side of the street that traffic keeps to.
    pub driving_side: DrivingSide,
}

/// The intersections of an extract.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Survey {
    /// Intersections, and signals that are none.
    pub found: Found,
    /// Traffic by intersection and arm.
    pub traffic: Vec<Vec<ArmTraffic>>,
    /// What became of the rows of the signal list.
    pub listed: Vec<ListMatch>,
    /// The smallest box around the streets of the extract, degrees: x is the longitude and y the
    /// latitude; nothing without any street.
    pub covered: Option<Rect<f64>>,
}

impl Survey {
    /// Returns the survey of an extract.
    pub fn new(extract: &Extract, settings: &Settings, inputs: &Inputs<'_>) -> Self {
        let match_m = settings.intersections.list_match_m;
        let rows = inputs.signals.map_or(&[][..], |list| &list.signals[..]);
        let graph = Graph::new(extract);
        let (mut found, named) = mirror::found(&graph, settings, rows, inputs.driving_side);
        // A junction outside the boundary ends the reach of a count as well.
        let limit_m = settings.counts.spread_m;
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
        let traffic = traffic(&found.intersections, counts, &settings.traffic);
        Self { found, traffic, listed, covered: covered(extract) }
    }

    /// Returns whether a traffic count was found for any arm.
    pub fn is_counted(&self) -> bool {
        self.traffic.iter().flatten().any(|t| t.count_distance_m.is_some())
    }

    /// Says in which unit the counts of a survey may be, if too few vehicles come for the classes of its streets.
    ///
    /// Half of the counted arms of main streets (tertiary and above) have, per lane and day, less than any quiet street:
    /// then the counts are in thousands; or less than a twentieth of what is usual there: then they are of an hour.
    pub fn count_doubt(&self) -> Option<String> {
        let arms = self.found.intersections.iter().flat_map(|i| &i.arms);
        let main = arms.zip(self.traffic.iter().flatten()).filter(|(arm, traffic)| {
            traffic.source == InflowSource::Counted && arm.highway <= Highway::Tertiary
        });
        let mut per_lane: Vec<f64> = main.map(|(_, traffic)| traffic.aadt_per_lane).collect();
        per_lane.sort_by(f64::total_cmp);
        let middle = *per_lane.get(per_lane.len() / 2).filter(|_| per_lane.len() >= 3)?;
        let way_out = match middle {
            _ if middle < THOUSANDS => "if they are in thousands, multiply them by 1000",
            _ if middle < HOURLY => {
                "if they are of an hour, divide them by its share of the day (family.hourly_share)"
            }
            _ => return None,
        };
        Some(format!(
            "traffic counts: half of the counted approaches of main streets have {middle:.0} vehicles a day and lane or \
             less; {way_out}"
        ))
    }

    /// Returns how many signals are no intersection, by reason, most frequent first.
    pub fn skips(&self) -> Vec<(Skip, usize)> {
        let mut counts = BTreeMap::new();
        for skipped in &self.found.skipped {
            *counts.entry(skipped.reason).or_default() += skipped.signals.len().max(1);
        }
        let mut counts: Vec<(Skip, usize)> = counts.into_iter().collect();
        counts.sort_by_key(|(skip, n)| (Reverse(*n), *skip));
        counts
    }
}

fn covered(extract: &Extract) -> Option<Rect<f64>> {
    let line: LineString<f64> = extract
        .nodes
        .places
        .iter()
        .flatten()
        .map(|p| Coord { x: p.longitude(), y: p.latitude() })
        .collect();
    line.bounding_rect()
}
