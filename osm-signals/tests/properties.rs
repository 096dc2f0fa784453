//! What holds for every intersection, on random ones.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use proptest::prelude::*;

use osm_signals::extract::{Extract, Nodes, Place, SignalNode, Way};
use osm_signals::intersections::Intersection;
use osm_signals::oddities::Oddities;
use osm_signals::settings::Settings;
use osm_signals::survey::{Inputs, Survey};
use osm_signals::tags::{SignalTags, Street};
use osm_signals::turn::Turns;

/// The middle of every intersection.
const CENTRE: (f64, f64) = (40.0, -75.0);

/// Metres per degree of latitude.
const M_PER_DEG: f64 = 111_194.9;

/// How a street is tagged and drawn.
#[derive(Debug, Clone)]
struct Drawn {
    bearing_deg: f64,
    length_m: f64,
    /// Nodes between its ends.
    nodes: usize,
    lanes: u32,
    /// 0: both ways, 1: inwards, 2: outwards.
    one_way: u8,
    /// Whether its nodes are listed from the outer end.
    from_outside: bool,
}

fn drawn() -> impl Strategy<Value = Vec<Drawn>> {
    let street = (0.0..20.0_f64, 60.0..300.0_f64, 0..4_usize, 1..7_u32, 0..3_u8, any::<bool>());
    prop::collection::vec(street, 3..=6).prop_map(|streets| {
        let step = 360.0 / streets.len() as f64;
        let streets = streets.into_iter().enumerate();
        streets
            .map(|(i, (turn, length_m, nodes, lanes, one_way, from_outside))| Drawn {
                bearing_deg: i as f64 * step + turn,
                length_m,
                nodes,
                lanes,
                one_way,
                from_outside,
            })
            .collect()
    })
}

/// The tags of a street; the same traffic whichever way its nodes are listed.
fn street(way: i64, drawn: &Drawn, from_outside: bool) -> Street {
    let lanes = drawn.lanes.to_string();
    let name = format!("street {way}");
    let one_way = match (drawn.one_way, from_outside) {
        (0, _) => "no",
        (1, true) | (2, false) => "yes",
        _ => "-1",
    };
    let tags = [("highway", "primary"), ("lanes", &*lanes), ("name", &*name), ("oneway", one_way)];
    Street::parse(way, &tags, &mut Oddities::default()).unwrap()
}

fn extract(streets: &[Drawn], reversed: bool) -> Extract {
    let metric = M_PER_DEG * CENTRE.0.to_radians().cos();
    let mut places = vec![(1_i64, Place::from_degrees(CENTRE.0, CENTRE.1).unwrap())];
    let (mut ways, mut refs) = (Vec::new(), Vec::new());
    for (street_index, drawn) in streets.iter().enumerate() {
        let (sin, cos) = drawn.bearing_deg.to_radians().sin_cos();
        let mut nodes = vec![1];
        for k in 1..=drawn.nodes + 1 {
            let metres = drawn.length_m * k as f64 / (drawn.nodes + 1) as f64;
            let id = 100 * (street_index as i64 + 1) + k as i64;
            let place = Place::from_degrees(
                CENTRE.0 + metres * cos / M_PER_DEG,
                CENTRE.1 + metres * sin / metric,
            );
            places.push((id, place.unwrap()));
            nodes.push(id);
        }
        let from_outside = drawn.from_outside != reversed;
        if from_outside {
            nodes.reverse();
        }
        let start = refs.len();
        refs.extend(nodes);
        let id = street_index as i64 + 1;
        ways.push(Way { id, refs: start..refs.len(), street: street(id, drawn, from_outside) });
    }
    let mut nodes = Nodes::wanted(refs.clone());
    for (id, place) in &places {
        nodes.set(*id, *place);
    }
    let signal = SignalNode { id: 1, place: places[0].1, tags: SignalTags::default() };
    Extract { ways, refs, nodes, signals: vec![signal], ..Extract::default() }
}

fn intersection(streets: &[Drawn], reversed: bool) -> Option<Intersection> {
    let extract = extract(streets, reversed);
    let mut survey = Survey::new(&extract, &Settings::default(), &Inputs::default());
    survey.found.intersections.pop()
}

/// Exits of an arm by side: left, through, right, as far as angles tell.
fn sides(intersection: &Intersection, from: usize) -> Turns {
    let heading = intersection.arms[from].bearing_deg + 180.0;
    let exits = intersection.arms.iter().enumerate().filter(|(i, a)| *i != from && a.lanes_out > 0);
    let angles: Vec<f64> =
        exits.map(|(_, a)| (a.bearing_deg - heading + 180.0).rem_euclid(360.0) - 180.0).collect();
    Turns {
        left: angles.iter().any(|a| *a < 0.0),
        through: angles.iter().any(|a| a.abs() < 45.0),
        right: angles.iter().any(|a| *a > 0.0),
    }
}

proptest! {
    #[test]
    fn arms_are_sorted_and_lanes_are_conserved(streets in drawn()) {
        let Some(found) = intersection(&streets, false) else { return Ok(()) };
        prop_assert!(found.arms.windows(2).all(|w| w[0].bearing_deg < w[1].bearing_deg));
        prop_assert_eq!(found.arms.len(), streets.len());
        let exits = found.arms.iter().filter(|a| a.lanes_out > 0).count();
        for (arm, drawn) in found.arms.iter().zip(&streets) {
            if exits <= usize::from(arm.lanes_out > 0) {
                prop_assert_eq!(arm.lanes_in, 0);
                continue;
            }
            // An odd lane of a two-way street is shared; a single one is one in each direction.
            let total = arm.lanes_in - arm.centre_lanes + arm.lanes_out;
            let odd = u32::from(drawn.one_way == 0 && drawn.lanes % 2 == 1);
            let expected = if odd == 1 && drawn.lanes == 1 { 2 } else { drawn.lanes - odd };
            prop_assert_eq!(total, expected);
            prop_assert!(arm.left_turn_lanes + arm.right_turn_lanes <= arm.lanes_in);
            prop_assert!((arm.length_m - drawn.length_m).abs() < 1.0);
        }
    }

    #[test]
    fn every_movement_has_an_exit(streets in drawn()) {
        let Some(found) = intersection(&streets, false) else { return Ok(()) };
        for (from, turns) in found.turns.iter().enumerate() {
            prop_assert_eq!(turns.is_some(), found.arms[from].lanes_in > 0);
            let (Some(turns), exits) = (turns, sides(&found, from)) else { continue };
            prop_assert!(!turns.left || exits.left);
            prop_assert!(!turns.through || exits.through);
            prop_assert!(!turns.right || exits.right);
            prop_assert!(turns.left || turns.through || turns.right);
        }
    }

    #[test]
    fn reversing_the_nodes_and_the_tag_of_streets_changes_nothing(streets in drawn()) {
        let (a, b) = (intersection(&streets, false), intersection(&streets, true));
        prop_assert_eq!(a.is_some(), b.is_some());
        let (Some(a), Some(b)) = (a, b) else { return Ok(()) };
        prop_assert_eq!(&a.turns, &b.turns);
        for (x, y) in a.arms.iter().zip(&b.arms) {
            prop_assert_eq!((x.lanes_in, x.lanes_out), (y.lanes_in, y.lanes_out));
            prop_assert_eq!(x.left_turn_lanes, y.left_turn_lanes);
            prop_assert!((x.bearing_deg - y.bearing_deg).abs() < 1e-9);
            prop_assert!((x.length_m - y.length_m).abs() < 1e-6);
        }
    }
}
