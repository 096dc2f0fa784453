//! Streets that a map has twice, as two ways over each other that share some of their nodes or none: their lanes
//! count once.

use geo::{Coord, Densify, Distance, Euclidean, LineString, Point};

use super::extract::Place;
use super::geometry::LocalMetric;
use super::graph::Graph;
use super::legs::Leg;

/// Farthest that two drawings of one street may be apart, metres: less than half a lane.
const OVER_M: f64 = 1.5;

/// How far two drawings of one street are compared, and at least have to be, metres.
const COMPARED_M: f64 = 60.0;
const LEAST_M: f64 = 15.0;

/// Distance of the places that are compared, metres.
const STEP_M: f64 = 5.0;

/// Returns the legs without those that are drawn over another one which carries their traffic too: of two that
/// carry the same, the better one by `worth` stays.
pub(super) fn once<'l, W: Ord>(
    graph: &Graph<'_>,
    legs: &[&'l Leg],
    worth: &dyn Fn(&Leg) -> W,
) -> Vec<&'l Leg> {
    let covers = |a: &Leg, b: &Leg| (a.inbound || !b.inbound) && (a.outbound || !b.outbound);
    let stays = |i: usize| {
        let b = legs[i];
        !legs.iter().enumerate().any(|(j, a)| {
            let better = || (worth(a), j) < (worth(b), i);
            i != j && covers(a, b) && (!covers(b, a) || better()) && is_over(graph, a, b)
        })
    };
    (0..legs.len()).filter(|i| stays(*i)).map(|i| legs[i]).collect()
}

/// Returns whether two legs are one street, drawn twice: as far as both go they are nowhere apart.
fn is_over(graph: &Graph<'_>, a: &Leg, b: &Leg) -> bool {
    let (a, b) = (graph.places(&a.chain), graph.places(&b.chain));
    let metric = LocalMetric::at(a[0].latitude());
    let origin = (a[0].latitude(), a[0].longitude());
    let flat = |places: &[Place]| -> LineString<f64> {
        let at = |p: &Place| {
            let (x, y) = metric.offset_m(origin, (p.latitude(), p.longitude()));
            Coord { x, y }
        };
        places.iter().map(at).collect()
    };
    let (a_line, b_line) = (flat(&a), flat(&b));
    let start = a_line.0[0];
    let far = |line: &LineString<f64>| {
        let from_start = |c: &Coord<f64>| (c.x - start.x).hypot(c.y - start.y);
        line.0.iter().map(from_start).fold(0.0, f64::max)
    };
    let reach_m = far(&a_line).min(far(&b_line)).min(COMPARED_M);
    let near = |line: &LineString<f64>, other: &LineString<f64>| {
        let points = Euclidean.densify(line, STEP_M).into_inner();
        let within = |c: &&Coord<f64>| (c.x - start.x).hypot(c.y - start.y) <= reach_m;
        points.iter().filter(within).all(|c| Euclidean.distance(&Point(*c), other) <= OVER_M)
    };
    reach_m >= LEAST_M && near(&a_line, &b_line) && near(&b_line, &a_line)
}
