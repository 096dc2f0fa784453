//! Left-hand traffic in the mirror: an extract with east and west exchanged, and what is found in it turned back.
//!
//! Seen in a mirror, left-hand traffic is right-hand traffic: carriageways, roundabouts, slip lanes and
//! the way around a junction are where all code between here knows them, and turns to the right are turns to
//! the left. Only coordinates, the order and turns of marked lanes, and the directions of bus lanes that are told by
//! their side change; one-way streets and restrictions name ways and nodes, which the mirror leaves alone.

use super::arms::Arm;
use super::extract::{Extract, Place};
use super::graph::Graph;
use super::intersections::{Found, Intersection, intersections};
use super::listing::{Named, one_controller, unmapped};
use super::settings::Settings;
use super::signals::ListedSignal;
use super::turn::Turns;
use crate::angle::mirrored_deg;
use crate::driving_side::DrivingSide;

/// As on the ground, and the junctions that a list names. Left-hand traffic takes the memory of its extract twice.
pub(crate) fn found(
    graph: &Graph<'_>,
    settings: &Settings,
    listed: &[ListedSignal],
    side: DrivingSide,
) -> (Found, Named) {
    let match_m = settings.intersections.list_match_m;
    let of = |graph: &Graph<'_>, listed: &[ListedSignal]| {
        let mut found = intersections(graph, settings, &[], &[]);
        let named = unmapped(graph, &found, listed, match_m);
        if !named.0.is_empty() {
            found = intersections(graph, settings, &named.0, &[]);
        }
        let together = one_controller(graph, &found, listed, match_m);
        if !together.is_empty() {
            found = intersections(graph, settings, &named.0, &together);
        }
        (found, named)
    };
    match side {
        DrivingSide::Right => of(graph, listed),
        DrivingSide::Left => {
            let mirrored =
                |row: &ListedSignal| ListedSignal { place: row.place.mirrored(), ..row.clone() };
            let listed: Vec<ListedSignal> = listed.iter().map(mirrored).collect();
            let extract = mirrored_extract(graph.extract);
            let (mut found, named) = of(&Graph::new(&extract), &listed);
            turn_back(&mut found);
            (found, named)
        }
    }
}

/// Returns an extract with east and west exchanged.
pub fn mirrored_extract(extract: &Extract) -> Extract {
    let mut mirrored = extract.clone();
    for place in mirrored.nodes.places.iter_mut().flatten() {
        *place = place.mirrored();
    }
    for signal in &mut mirrored.signals {
        signal.place = signal.place.mirrored();
    }
    for street in mirrored.ways.iter_mut().map(|way| &mut way.street) {
        if let Some(turns) = &mut street.turns {
            turns.mirror();
        }
        if let Some(lanes) = &mut street.lanes_mirrored {
            std::mem::swap(&mut **lanes, &mut street.lanes);
        }
    }
    mirrored
}

fn turn_back(found: &mut Found) {
    found.intersections.iter_mut().for_each(turn_intersection_back);
    for skipped in &mut found.skipped {
        skipped.place = skipped.place.mirrored();
    }
}

fn turn_intersection_back(i: &mut Intersection) {
    i.centre = i.centre.mirrored();
    mirror_places(&mut i.places);
    let arms = std::mem::take(&mut i.arms).into_iter().map(arm_turned_back);
    let turns = std::mem::take(&mut i.turns).into_iter().map(|turns| turns.map(Turns::mirrored));
    let mut both: Vec<(Arm, Option<Turns>)> = arms.zip(turns).collect();
    both.sort_by(|a, b| a.0.bearing_deg.total_cmp(&b.0.bearing_deg));
    (i.arms, i.turns) = both.into_iter().unzip();
}

fn arm_turned_back(mut arm: Arm) -> Arm {
    arm.bearing_deg = mirrored_deg(arm.bearing_deg);
    std::mem::swap(&mut arm.left_turn_lanes, &mut arm.right_turn_lanes);
    mirror_places(&mut arm.places);
    arm
}

fn mirror_places(places: &mut [Place]) {
    for place in places {
        *place = place.mirrored();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bus_lane_on_one_side_is_of_the_other_direction_in_left_hand_traffic() {
        let text = "<osm version=\"0.6\"><node id=\"1\" lat=\"51.5\" lon=\"0.1\"/>\
            <node id=\"2\" lat=\"51.51\" lon=\"0.1\"/><way id=\"3\"><nd ref=\"1\"/><nd ref=\"2\"/>\
            <tag k=\"highway\" v=\"primary\"/><tag k=\"lanes\" v=\"4\"/>\
            <tag k=\"busway:left\" v=\"lane\"/></way></osm>";
        let file = tempfile::Builder::new().suffix(".osm").tempfile().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let extract = crate::read::read(file.path(), &|_, _| {}).unwrap();
        let lanes = |extract: &Extract| {
            let lanes = extract.ways[0].street.lanes;
            (lanes.forward, lanes.backward)
        };
        assert_eq!(lanes(&extract), (Some(2), Some(1)));
        let mirrored = mirrored_extract(&extract);
        assert_eq!(lanes(&mirrored), (Some(1), Some(2)));
        assert_eq!(lanes(&mirrored_extract(&mirrored)), (Some(2), Some(1)));
    }
}
