//! The surroundings of intersections that are worth a look, for drawings of how they were read.

use osm_signals::geometry::LocalMetric;
use osm_signals::{Extract, Intersection, Place};

use super::flag::Flag;
use super::sites::City;
use super::table::arm_name;

/// Half the width of what is drawn around an intersection, metres.
pub const RADIUS_M: f64 = 90.0;

/// Most intersections that are drawn, so that a page stays small.
pub const MOST: usize = 120;

/// An intersection as it was read, metres east and north of its centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Sketch {
    /// Id of the intersection.
    pub id: String,
    /// Its arms.
    pub arms: Vec<SketchArm>,
    /// Drivable streets of the map around it.
    pub streets: Vec<Vec<(f64, f64)>>,
    /// Its junction nodes.
    pub nodes: Vec<(f64, f64)>,
    /// Its signals.
    pub signals: Vec<(f64, f64)>,
}

/// One arm of a sketch.
#[derive(Debug, Clone, PartialEq)]
pub struct SketchArm {
    /// Its name.
    pub arm: String,
    /// Direction from the centre, degrees clockwise from north.
    pub bearing_deg: f64,
    /// Lanes towards the signal.
    pub lanes_in: u32,
    /// Lanes away from it.
    pub lanes_out: u32,
}

/// Returns the intersections of a city that have a flag, the most doubtful first, at most [`MOST`].
pub(super) fn sketches(extract: &Extract, city: &City) -> Vec<Sketch> {
    let mut flagged: Vec<(Vec<Flag>, &Intersection)> = (city.sites())
        .map(|site| (site.flags(), site.found))
        .filter(|(flags, _)| !flags.is_empty())
        .collect();
    flagged.sort_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.id.cmp(&b.1.id)));
    flagged.into_iter().take(MOST).map(|(_, i)| sketch(extract, i)).collect()
}

fn sketch(extract: &Extract, i: &Intersection) -> Sketch {
    let metric = LocalMetric::at(i.centre.latitude());
    let centre = (i.centre.latitude(), i.centre.longitude());
    let flat = |p: Place| metric.offset_m(centre, (p.latitude(), p.longitude()));
    let place = |id: &i64| {
        let node = extract.nodes.index(*id).and_then(|node| extract.nodes.place(node));
        node.map(flat)
    };
    let near = |(x, y): (f64, f64)| x.abs() <= RADIUS_M && y.abs() <= RADIUS_M;
    let signal = |id: &i64| extract.signals.iter().find(|s| s.id == *id).map(|s| flat(s.place));
    let mut streets = Vec::new();
    for way in &extract.ways {
        let places: Vec<(f64, f64)> = extract.nodes_of(way).iter().filter_map(place).collect();
        // Of each way the stretches near the centre, with one place beyond at either end.
        let mut stretch: Vec<(f64, f64)> = Vec::new();
        for pair in places.windows(2) {
            if near(pair[0]) || near(pair[1]) {
                if stretch.is_empty() {
                    stretch.push(pair[0]);
                }
                stretch.push(pair[1]);
            } else if !stretch.is_empty() {
                streets.push(std::mem::take(&mut stretch));
            }
        }
        if !stretch.is_empty() {
            streets.push(stretch);
        }
    }
    Sketch {
        id: i.id.clone(),
        arms: i
            .arms
            .iter()
            .enumerate()
            .map(|(index, arm)| SketchArm {
                arm: arm_name(index),
                bearing_deg: arm.bearing_deg,
                lanes_in: arm.lanes_in,
                lanes_out: arm.lanes_out,
            })
            .collect(),
        streets,
        nodes: i.nodes.iter().filter_map(place).collect(),
        signals: i.signals.iter().filter_map(signal).collect(),
    }
}
