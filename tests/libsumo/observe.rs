use std::collections::{HashMap, HashSet};

use crate::fixture::Scenario;
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::{Direction, Sim, Snapshot};

/// Far enough apart that the vehicles are seen in this order: 0, 1, 2, 3 and then the flow.
const ROUTES: &str = r#"
    <vehicle id="through" depart="0" departLane="1"><route edges="WA AB BE"/></vehicle>
    <vehicle id="right" depart="2" departLane="0"><route edges="WA AS SX"/></vehicle>
    <vehicle id="ends-at-a" depart="4" departLane="0"><route edges="WA"/></vehicle>
    <vehicle id="ends-at-b" depart="6" departLane="1"><route edges="WA AB"/></vehicle>
    <flow id="queue" begin="20" end="200" number="90" departPos="random_free">
        <route edges="NA AS SX"/></flow>"#;

/// SUMO's lengths are rounded to centimetres, and sums of them to more.
const TOLERANCE_M: f64 = 1e-6;

#[test]
fn a_distance_leads_to_the_next_signal_on_the_vehicles_own_route() {
    let _alone = crate::alone();
    let scenario = Scenario::new();
    let mut sim = SumoSim::new().unwrap();
    let scene = sim.start(&scenario.options("net", "observe", ROUTES)).unwrap();
    assert!(sim.version().unwrap().contains("SUMO"));

    let ids: Vec<&str> = scene.signals.iter().map(|s| s.id.as_str()).collect();
    assert_eq!(ids, ["A", "B", "S"]);
    let lanes: Vec<&str> = scene.lanes.iter().map(|l| l.id.as_str()).collect();
    assert_eq!(HashSet::from_iter(lanes.clone()), {
        HashSet::from(["NA_0", "WA_0", "WA_1", "MB_0", "AB_0", "AS_0", "PS_0"])
    });
    let lane = |id: &str| lanes.iter().position(|&l| l == id).unwrap();
    assert!((scene.lanes[lane("WA_1")].heading_deg - 90.0).abs() < 1.0);
    assert!((scene.lanes[lane("NA_0")].heading_deg - 180.0).abs() < 1.0);
    let link = (scene.signals[0].links.iter().flatten())
        .find(|l| l.from_lane == lane("WA_1") && l.to_lane == "AB_0")
        .unwrap();
    assert_eq!(link.direction, Direction::Straight);
    assert_eq!(link.downstream, [lane("AB_0")]);
    let exit = scene.signals[1].links.iter().flatten().find(|l| l.to_lane == "BE_0").unwrap();
    assert_eq!(exit.downstream, [0; 0]);

    let mut snapshot = Snapshot::default();
    // Distance beyond the end of the lane, by vehicle and lane.
    let mut beyond_m: HashMap<(u32, u32), f64> = HashMap::new();
    let mut most = 0;
    for _ in 0..200 {
        sim.step(1).unwrap();
        sim.observe(&mut snapshot).unwrap();
        assert_eq!(snapshot.phases.len(), 3);
        assert!(snapshot.vehicles.is_sorted_by_key(|v| v.lane));
        most = most.max(snapshot.vehicles.len());
        for v in &snapshot.vehicles {
            let length_m = scene.lanes[v.lane as usize].length_m;
            assert!((0.0..=length_m).contains(&v.position_m) && v.speed_mps >= 0.0);
            let beyond = v.distance_m - (length_m - v.position_m);
            let first = *beyond_m.entry((v.vehicle, v.lane)).or_insert(beyond);
            assert!(first == beyond || (first - beyond).abs() < TOLERANCE_M);
        }
    }
    assert!(most > 32, "the buffer has grown twice, but saw only {most}");

    let beyond = |vehicle: u32, id: &str| beyond_m.get(&(vehicle, lane(id) as u32)).copied();
    assert_eq!(beyond(0, "WA_1").map(|m| m.abs() < TOLERANCE_M), Some(true));
    assert_eq!(beyond(0, "AB_0").map(|m| m.abs() < TOLERANCE_M), Some(true));
    // The right turn at A has no signal; the next one is at the end of AS.
    let to_s = beyond(1, "WA_0").unwrap() - scene.lanes[lane("AS_0")].length_m;
    assert!((0.0..30.0).contains(&to_s), "{to_s} m is no length of a turn");
    assert_eq!(beyond(1, "AS_0").map(|m| m.abs() < TOLERANCE_M), Some(true));
    assert_eq!(beyond(2, "WA_0"), Some(f64::INFINITY));
    assert_eq!(beyond(3, "WA_1").map(|m| m.abs() < TOLERANCE_M), Some(true));
    assert_eq!(beyond(3, "AB_0"), Some(f64::INFINITY));
    assert!(beyond_m.keys().all(|&(vehicle, _)| vehicle < 4 + 90));
}
