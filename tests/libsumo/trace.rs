//! A street in several edges is seen as if it were one.
//!
//! ```text
//!   W -- w1 -- V -- w2 -- U -- w3 (0.9 m) -- A -- e1 -- F -- e2 -- B     A and B have signals
//!              |                             |
//!              D: vehicles may leave         S
//! ```

use std::collections::BTreeMap;

use crate::fixture::Scenario;
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::{Scene, Sim, Snapshot, StartOptions};

const NODES: &str = r#"<nodes>
    <node id="W" x="-260" y="0"/> <node id="V" x="-120" y="0"/> <node id="D" x="-120" y="-90"/>
    <node id="U" x="-30" y="0"/> <node id="A" x="0" y="0" type="traffic_light"/>
    <node id="S" x="0" y="-90"/> <node id="N" x="0" y="90"/> <node id="F" x="100" y="0"/>
    <node id="B" x="200" y="0" type="traffic_light"/> <node id="M" x="200" y="90"/>
    <node id="E" x="300" y="0"/>
</nodes>"#;

const EDGES: &str = r#"<edges>
    <edge id="w1" from="W" to="V" numLanes="1"/> <edge id="w2" from="V" to="U" numLanes="2"/>
    <edge id="vd" from="V" to="D"/> <edge id="w3" from="U" to="A" numLanes="2" length="0.9"/>
    <edge id="as" from="A" to="S"/> <edge id="na" from="N" to="A"/>
    <edge id="e1" from="A" to="F"/> <edge id="e2" from="F" to="B"/>
    <edge id="mb" from="M" to="B"/> <edge id="be" from="B" to="E"/>
</edges>"#;

const CONNECTIONS: &str = r#"<connections>
    <connection from="w3" to="as" fromLane="0" toLane="0"/>
    <connection from="w3" to="e1" fromLane="1" toLane="0"/>
    <connection from="w1" to="w2" fromLane="0" toLane="0"/>
    <connection from="w1" to="w2" fromLane="0" toLane="1"/>
    <connection from="w1" to="vd" fromLane="0" toLane="0"/>
</connections>"#;

/// In the order of first sight: straight on, right, off before the signal, and to an end before it.
const ROUTES: &str = r#"
    <vehicle id="through" depart="0"><route edges="w1 w2 w3 e1 e2 be"/></vehicle>
    <vehicle id="right" depart="6"><route edges="w1 w2 w3 as"/></vehicle>
    <vehicle id="off" depart="12"><route edges="w1 vd"/></vehicle>
    <vehicle id="ends" depart="18"><route edges="w1 w2"/></vehicle>"#;

/// Distances may be off by what SUMO's lengths are rounded to, metres.
const TOLERANCE_M: f64 = 0.1;

/// Where a vehicle was seen: time, lane, link and distance.
type Sight = (u32, String, Option<u32>, f64);

fn sights(sim: &mut SumoSim, options: &StartOptions) -> (Scene, BTreeMap<u32, Vec<Sight>>) {
    let scene = sim.start(options).unwrap();
    let mut snapshot = Snapshot::default();
    let mut sights: BTreeMap<u32, Vec<Sight>> = BTreeMap::new();
    for second in 0..120 {
        sim.step(1).unwrap();
        sim.observe(&mut snapshot).unwrap();
        for v in &snapshot.vehicles {
            let of_vehicle = sights.entry(v.vehicle).or_default();
            assert!(of_vehicle.last().is_none_or(|s| s.0 < second), "{} is seen twice", v.vehicle);
            let lane = scene.lanes[v.lane as usize].id.clone();
            of_vehicle.push((second, lane, v.link, v.distance_m));
        }
    }
    sim.close().unwrap();
    (scene, sights)
}

#[test]
fn a_street_in_several_edges_is_seen_as_one() {
    let _alone = crate::alone();
    let scenario = Scenario::new();
    scenario.build("split", NODES, EDGES, Some(CONNECTIONS));
    let options = StartOptions { trace_m: 200.0, ..scenario.options("split", "trace", ROUTES) };
    let mut sim = SumoSim::new().unwrap();
    let (scene, seen) = sights(&mut sim, &options);

    let lane = |id: &str| &scene.lanes[scene.lanes.iter().position(|l| l.id == id).unwrap()];
    let pieces = |id: &str| lane(id).pieces.iter().map(|p| p.id.as_str()).collect::<Vec<_>>();
    assert_eq!(lane("w3_1").length_m, 0.9);
    assert_eq!(pieces("w3_1"), ["w2_0", "w2_1", "w1_0"]);
    assert_eq!(pieces("e2_0"), ["e1_0"]);
    assert_eq!(pieces("na_0"), [""; 0]);
    let signal = &scene.signals[0];
    let through = signal.links.iter().flatten().find(|l| l.to_lane == "e1_0").unwrap();
    let downstream: Vec<&str> =
        through.downstream.iter().map(|l| scene.lanes[*l].id.as_str()).collect();
    assert_eq!(downstream, ["e2_0"]);
    assert!(through.length_m > 5.0, "{}", through.length_m);
    assert_eq!(lane("w3_0").street_width_m, 6.4);

    // Straight on: seen in every second from its start to the junction, within plain nodes too.
    let at_a: Vec<&Sight> = seen[&0].iter().filter(|s| s.1.starts_with('w')).collect();
    assert!(at_a.windows(2).all(|w| w[1].0 == w[0].0 + 1), "{at_a:?}");
    assert!(at_a.windows(2).all(|w| w[1].3 <= w[0].3 + TOLERANCE_M), "{at_a:?}");
    assert!(at_a.iter().all(|s| s.1 == "w3_1" && s.2.is_some()), "{at_a:?}");
    let (first, last) = (at_a[0], at_a[at_a.len() - 1]);
    assert!(first.3 > 220.0 && last.3 < 15.0, "{first:?} {last:?}");
    let at_b: Vec<&Sight> = seen[&0].iter().filter(|s| !s.1.starts_with('w')).collect();
    assert!(at_b.iter().all(|s| s.1 == "e2_0" && s.2.is_some()) && at_b.len() > 10, "{at_b:?}");

    assert!(seen[&1].iter().all(|s| s.1 == "w3_0"), "{:?}", seen[&1]);
    assert_eq!(seen.keys().copied().collect::<Vec<_>>(), [0, 1]);

    // The second start uses what the first one traced, and sees the same.
    assert_eq!(sights(&mut sim, &options), (scene, seen));
    let (scene, seen) = sights(&mut sim, &StartOptions { trace_m: 0.0, ..options });
    assert!(scene.lanes.iter().all(|l| l.pieces.is_empty()));
    assert!(seen[&0].iter().all(|s| s.3 <= 100.0), "{:?}", seen[&0]);

    grouped_links_are_told_apart_by_their_edges(&scenario, &mut sim);
}

/// A crossing of streets in two edges, whose second ones have two lanes.
const CROSS_NODES: &str = r#"<nodes>
    <node id="C" x="0" y="0" type="traffic_light"/> <node id="N" x="0" y="90"/>
    <node id="E" x="90" y="0"/> <node id="S" x="0" y="-90"/> <node id="V" x="-60" y="0"/>
    <node id="W" x="-160" y="0"/>
</nodes>"#;

const CROSS_EDGES: &str = r#"<edges>
    <edge id="nc" from="N" to="C"/> <edge id="cn" from="C" to="N"/>
    <edge id="ec" from="E" to="C"/> <edge id="ce" from="C" to="E"/>
    <edge id="sc" from="S" to="C"/> <edge id="cs" from="C" to="S"/>
    <edge id="wv" from="W" to="V" numLanes="2"/> <edge id="vc" from="V" to="C" numLanes="2"/>
    <edge id="cw" from="C" to="W"/>
</edges>"#;

const CROSS_ROUTES: &str = r#"
    <vehicle id="right" depart="0" departLane="best"><route edges="wv vc cs"/></vehicle>
    <vehicle id="through" depart="5" departLane="best"><route edges="wv vc ce"/></vehicle>
    <vehicle id="left" depart="10" departLane="best"><route edges="wv vc cn"/></vehicle>
    <vehicle id="from-north" depart="15"><route edges="nc cs"/></vehicle>
    <vehicle id="from-south" depart="20"><route edges="sc cn"/></vehicle>"#;

/// In the order of first sight: edges at the signal.
const CROSS_WAYS: [(&str, &str); 5] =
    [("vc", "cs"), ("vc", "ce"), ("vc", "cn"), ("nc", "cs"), ("sc", "cn")];

fn grouped_links_are_told_apart_by_their_edges(scenario: &Scenario, sim: &mut SumoSim) {
    let options = ["--tls.group-signals", "true"];
    scenario.build_with("cross", CROSS_NODES, CROSS_EDGES, None, &options);
    let start = scenario.options("cross", "cross", CROSS_ROUTES);
    let scene = sim.start(&StartOptions { trace_m: 200.0, ..start }).unwrap();
    let links = &scene.signals[0].links;
    assert!(links.iter().any(|links| links.len() > 1), "{links:?}");
    let edge = |lane: &str| lane.rsplit_once('_').unwrap().0.to_owned();
    let mut snapshot = Snapshot::default();
    let mut seen = [0; CROSS_WAYS.len()];
    for _ in 0..60 {
        sim.step(1).unwrap();
        sim.observe(&mut snapshot).unwrap();
        for v in &snapshot.vehicles {
            let link = &links[v.link.unwrap() as usize][v.way as usize];
            let from = edge(&scene.lanes[link.from_lane].id);
            let expected = CROSS_WAYS[v.vehicle as usize];
            assert_eq!((from.as_str(), edge(&link.to_lane).as_str()), expected);
            // Upstream too it belongs to a lane from which it can turn.
            if scene.lanes[v.lane as usize].length_m - v.position_m != v.distance_m {
                let turns = |l: &&tsc_family::traffic::sim::Link| edge(&l.to_lane) == expected.1;
                let lanes = links.iter().flatten().filter(turns).map(|l| l.from_lane);
                assert!(lanes.into_iter().any(|lane| lane == v.lane as usize), "{v:?}");
            }
            seen[v.vehicle as usize] += 1;
        }
    }
    sim.close().unwrap();
    assert!(seen.iter().all(|count| *count > 3), "{seen:?}");
}
