//! Tests of reading UTDF.

use super::*;
use crate::existing::{Control, Recall};
use crate::family::approaches::{Approach, Arrivals};

const TWO: &str = include_str!("../../tests/utdf/two-signals.csv");
const TEE: &str = include_str!("../../tests/utdf/tee.csv");
const DOUBLE: &str = include_str!("../../tests/utdf/double-left.csv");

fn read(text: &str) -> Utdf {
    let mut utdf = Utdf::default();
    utdf.add(text.as_bytes(), "n.csv").unwrap();
    utdf
}

fn refused(text: &str) -> String {
    let mut utdf = Utdf::default();
    let added = utdf.add(text.as_bytes(), "n.csv");
    added.and_then(|()| utdf.intersections().map(|_| ())).unwrap_err().to_string()
}

fn said(converted: &Converted) -> String {
    converted.doubts.iter().map(|doubt| doubt.brief()).collect::<Vec<_>>().join("\n")
}

/// An arm as it was worked out by hand: name; lanes in and out, left-turn and right-turn lanes; storage to the left and to the
/// right, metres; turns that the lane beside turn lanes has; vehicles per hour to the left, through and right; people per hour.
type ByHand = (&'static str, [u32; 4], [f64; 2], &'static str, [f64; 3], Option<f64>);

#[test]
fn arms_are_those_that_were_worked_out_by_hand() {
    let two: [&[ByHand]; 2] = [
        &[
            ("NB Oak Ave", [3, 2, 1, 0], [45.7, 0.0], "", [80.0, 310.0, 45.0], Some(12.0)),
            ("EB Main St", [4, 2, 1, 1], [76.2, 61.0], "", [120.0, 640.0, 90.0], Some(20.0)),
            ("SB Oak Ave", [3, 2, 1, 0], [45.7, 0.0], "", [60.0, 280.0, 70.0], Some(10.0)),
            // Volumes with 10% of growth.
            ("WB Main St", [3, 2, 1, 0], [61.0, 0.0], "", [83.0, 638.0, 55.0], Some(15.0)),
        ],
        // Link 2 to 1 has two lanes, and its bay beside them. No southern exit for the eastbound through lane.
        &[
            ("NB Elm St", [2, 1, 1, 1], [0.0, 30.5], "", [90.0, 0.0, 110.0], None),
            ("EB Main St", [2, 2, 0, 0], [0.0, 0.0], "", [0.0, 700.0, 45.0], None),
            ("WB Main St", [3, 2, 1, 0], [54.9, 0.0], "", [65.0, 610.0, 0.0], None),
        ],
    ];
    // North three lanes less a bay, south four less two, east one without bays.
    let tee: [&[ByHand]; 1] = [&[
        ("NB Elm St", [3, 2, 0, 1], [0.0, 30.5], "", [0.0, 600.0, 50.0], Some(0.0)),
        ("SB Elm St", [3, 2, 1, 0], [45.7, 0.0], "", [40.0, 700.0, 0.0], Some(4.0)),
        ("WB Mill Rd", [2, 1, 1, 1], [0.0, 0.0], "", [120.0, 0.0, 60.0], Some(0.0)),
    ]];
    // South: the link does not count the bay. West: one of two left-turn lanes is in the bay. East: two lanes lead there.
    let double: [&[ByHand]; 1] = [&[
        ("NB", [4, 2, 2, 0], [76.2, 0.0], "", [310.0, 640.0, 60.0], None),
        ("EB", [3, 3, 1, 0], [45.7, 0.0], "l", [80.0, 220.0, 70.0], None),
        ("SB", [3, 2, 1, 0], [61.0, 0.0], "", [90.0, 700.0, 55.0], None),
        ("WB", [4, 2, 1, 1], [45.7, 36.6], "", [110.0, 260.0, 95.0], None),
    ]];
    for (text, networks) in [(TWO, &two[..]), (TEE, &tee), (DOUBLE, &double)] {
        let read = read(text).intersections().unwrap();
        for (intersection, expected) in read.intersections.iter().zip(networks) {
            let arms = intersection.arms.iter().map(|a| {
                let counted = a.counted.unwrap();
                let shared = [(a.shared_left, "l"), (a.shared_right, "r")];
                (
                    a.arm.clone(),
                    [a.lanes_in, a.lanes_out, a.left_turn_lanes, a.right_turn_lanes],
                    [a.left_storage_m, a.right_storage_m].map(Option::unwrap_or_default),
                    shared.map(|(is, letter)| if is { letter } else { "" }).concat(),
                    [counted.left_vph, counted.through_vph, counted.right_vph].map(f64::round),
                    counted.pedestrians_per_h,
                )
            });
            let by_hand = expected.iter().map(|(arm, lanes, storage_m, shared, vph, people)| {
                ((*arm).to_owned(), *lanes, *storage_m, (*shared).to_owned(), *vph, *people)
            });
            assert_eq!(arms.collect::<Vec<_>>(), by_hand.collect::<Vec<_>>());
        }
    }
}

#[test]
fn lengths_arrivals_signs_and_smallest_splits_are_read() {
    let converted = read(TWO).intersections().unwrap();
    assert_eq!(converted.found, ["UTDF: 2 of 2 signals, 2 with volumes, 2 with a plan; 8 nodes"]);
    let [one, two] = &converted.intersections[..] else { panic!() };
    // Northbound vehicles come from the south, 1200 ft at 30 mph.
    let arm = &one.arms[0];
    assert_eq!((arm.bearing_deg, arm.length_m, arm.speed_mph), (180.0, 365.8, 30.0));
    let counted = one.arms[3].counted.unwrap();
    assert_eq!(
        (counted.heavy_vehicles, counted.arrivals),
        (Some(0.03), Some(Arrivals::PeakHourFactor(0.92)))
    );
    let letters: Vec<&str> = two.arms.iter().map(|a| a.movements.as_str()).collect();
    assert_eq!(letters, ["lr", "sr", "ls"]);
    // Through a bend.
    assert_eq!(two.arms[2].length_m, ((1000.0_f64 + 800.0) * 3.048).round() / 10.0);
    let converted = read(DOUBLE).intersections().unwrap();
    assert!(said(&converted).contains("pedestrian counts are all 0, so nobody counted"));
    let no_turn: Vec<bool> =
        converted.intersections[0].arms.iter().map(|a| a.no_turn_on_red).collect();
    assert_eq!(no_turn, [false, false, false, true]);
    let least_s: Vec<f64> =
        converted.plans.all[0].plan.phases.iter().filter_map(|p| p.min_split_s).collect();
    assert_eq!(least_s, [12.0, 30.5, 12.0, 35.2, 12.0, 30.5, 12.0, 35.2]);
    // Where the plan lets the left turn from the stem beside those who go straight on, each has lanes.
    let together = TEE.replace("PermPhase1,1", "Phase2,1,,,,,8,,,,,,,,,,\nPermPhase1,1");
    assert_eq!(read(&together).intersections().unwrap().intersections[0].arms[0].lanes_out, 3);
    let mut counted = read(DOUBLE);
    counted.zero_pedestrians = true;
    let people = |arm: &Approach| arm.counted.unwrap().pedestrians_per_h == Some(0.0);
    assert!(counted.intersections().unwrap().intersections[0].arms.iter().all(people));
}

#[test]
fn metric_networks_have_metres_and_km_h() {
    let text =
        TWO.replace("Metric,0", "Metric,1").replacen("RECORDNAME,DATA", "RecordName,Value", 1);
    let metric = read(&text).intersections().unwrap();
    let arm = &metric.intersections[0].arms[0];
    assert_eq!((arm.length_m, arm.speed_mph), (1200.0, 18.6));
}

#[test]
fn what_is_assumed_or_lost_is_said() {
    let text = TWO
        .replace("Speed,1,30,30,40,40\n", "Speed,1,,30,40,40\n")
        .replace("Distance,2,1000,,1320,1000\n", "Distance,2,40,,1320,1000\n")
        .replace("Node 1,1,0\n", "Node 1,1,2\n");
    let said = said(&read(&text).intersections().unwrap());
    for expected in [
        "links without a speed get 30 mph (node 1, NB)",
        "approaches shorter than 25 m are made so long (node 2, NB: 12 m)",
        "nodes of one controller are simulated apart (node 1 with 2)",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
}

#[test]
fn lanes_and_volumes_follow_the_destination_and_not_the_name() {
    // The way called a left turn is the one straight on: its node lies to the north, the through one to the north-east.
    let text = TWO
        .replace("13,1,-1500,0,0", "13,1,-500,1200,0")
        .replace("11,1,0,1200,0", "11,1,900,1200,0");
    let converted = read(&text).intersections().unwrap();
    let arm = &converted.intersections[0].arms[0];
    assert_eq!((arm.left_turn_lanes, arm.right_turn_lanes, arm.lanes_in), (0, 2, 3));
    let counted = arm.counted.unwrap();
    assert_eq!((counted.left_vph, counted.through_vph, counted.right_vph), (0.0, 80.0, 355.0));
    let plan = &converted.plans.all[0].plan;
    assert_eq!(plan.phases.iter().find(|p| p.number == 3).unwrap().movements, ["NBT"]);
    // Both exits on the right keep the vehicles that the file has for them.
    assert_eq!(counted.exits_vph, Some([80.0, 310.0, 45.0, 0.0, 0.0]));
    let said = said(&converted);
    assert!(
        said.contains("lead elsewhere than their names say")
            && said.contains("node 1 NBL is through"),
        "{said}"
    );
}

#[test]
fn wrong_values_and_signals_with_nothing_to_decide_are_named() {
    let cycles = "Cycle Length,1,100\nCycle Length,1,90";
    for (from, to, expected) in [
        ("PHF,1,0.90", "PHF,1,90", "line 74: phf of NBL = 90: expected 0, or a number"),
        ("[Lanes]", "[Lane]", "line 1: no rows below [Lanes] of UTDF; export the"),
        ("UTDFVERSION,8", "UTDFVERSION,6", "line 4: [Network] utdfversion = \"6\": expected a"),
        ("RECORDNAME,DATA", "RECORDNAME,NUMBER", "line 3: [network] has no column DATA;"),
        ("BRP,1,111", "BRP,1,1-1", "BRP of D1 = \"1-1\": expected barrier, ring"),
        ("MinGreen,1,5", "MinGreen,1,five", "mingreen = \"five\": expected a number"),
        ("RECORDNAME,INTID,D1", "RECORDNAME,D1", "[phases] has no column INTID; call it so"),
        ("Metric,0", "Metric,0\nMetric,1", "line 6: [Network] metric stands twice; remove"),
        ("Cycle Length,1,100.0", cycles, "record cycle length of node 1 stands twice; remove one"),
    ] {
        let e = refused(&TWO.replace(from, to));
        assert!(e.contains(expected), "{e}");
    }
    let two_links = TWO.replace("Up ID,2,21,,1,22", "Up ID,2,,,1,22");
    let said = said(&read(&two_links).intersections().unwrap());
    assert!(said.contains("left out (node 2 has fewer than three links, or no lanes)"), "{said}");
}

#[test]
fn phases_and_times_become_existing_plans() {
    let plans = read(TWO).intersections().unwrap().plans.all;
    let one = &plans[0].plan;
    assert_eq!(
        (one.control, one.cycle_s, one.offset_s),
        (Control::Coordinated, Some(100.0), Some(0.0))
    );
    assert_eq!((&one.reference[..], one.sum_s()), (&[2, 6][..], 100.0));
    let detectors = "DetectPos1,1,0,300\nDetectSize1,1,40\nDetectPos2,1,,5\nVolume,1,80";
    let with = read(&TWO.replacen("Volume,1,80", detectors, 1)).intersections().unwrap();
    let all = with.plans.all[0].plan.phases.iter().map(|phase| phase.detectors.as_str());
    assert_eq!(all.collect::<Vec<_>>().join("|"), "||NBL 0 (40) ft|||||NBT 300, 5 ft");
    let phase = |number: u32| one.phases.iter().find(|p| p.number == number).unwrap();
    let main = phase(2);
    assert_eq!((main.barrier, main.ring, main.position), (1, 1, 2));
    assert_eq!(
        (&main.movements[..], &main.yielding[..]),
        (&["EBT".to_owned()][..], &["EBL".to_owned(), "EBR".to_owned()][..])
    );
    assert_eq!([main.min_green_s, main.max_green_s, main.passage_s], [15.0, 34.0, 3.0]);
    assert_eq!([main.yellow_s, main.all_red_s], [4.3, 1.2]);
    assert_eq!((main.walk_s, main.recall, main.dual_entry), (Some([7.0, 14.0]), Recall::Max, true));
    assert_eq!((phase(5).movements.clone(), phase(5).walk_s), (vec!["EBL".to_owned()], None));
    let two = &plans[1].plan;
    let numbers: Vec<u32> = two.phases.iter().map(|p| p.number).collect();
    assert_eq!((numbers, two.offset_s), (vec![1, 2, 6, 8], Some(32.0)));
}

#[test]
fn a_plan_that_cannot_be_is_left_out_with_the_reason() {
    let left_out = |from: &str, to: &str| {
        let converted = read(&TWO.replace(from, to)).intersections().unwrap();
        assert_eq!(converted.plans.all.len(), 1, "{to}");
        assert_eq!(converted.intersections.len(), 2, "the intersection stays");
        said(&converted)
    };
    for (from, to, expected) in [
        (
            "Cycle Length,1,100.0",
            "Cycle Length,1,90.0",
            "node 1: the cycle is 90 s, but the splits",
        ),
        ("Phase1,1,3,8", "Phase1,1,9,8", "phase1 of NBL is 9, which has no times in [Phases]"),
        ("MaxGreen,1,", "MaxGreen,1,-", "n.csv, line 114, node 1: maxgreen of D1 = -12: exp"),
    ] {
        let said = left_out(from, to);
        assert!(
            said.contains("plans that cannot be simulated are left out") && said.contains(expected),
            "{said}"
        );
    }
}
