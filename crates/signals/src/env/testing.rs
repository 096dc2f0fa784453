//! A small environment without SUMO, for tests of whatever runs episodes.

use std::path::Path;

use super::world::RouteWriter;
use super::{SignalEnv, World};
use crate::settings::{SignalSettings, SimulationSettings};
use crate::sim::testing::MockSim;
use crate::sim::{Direction, Lane, Link, Program, ProgramKind, ProgramPhase, Scene, SignalInfo};

/// A scene of one signal: lanes of 100 m as `(id, heading, directions)` with one link per letter of
/// the directions, and a program of greens.
pub(crate) fn crossing(lanes: &[(&str, f64, &str)], greens: &[&str]) -> Scene {
    let mut links = Vec::new();
    for (index, (_, _, directions)) in lanes.iter().enumerate() {
        for letter in directions.chars() {
            let direction = Direction::from_letter(letter).expect("a direction");
            links.push(vec![Link::new(index, "x_0", direction)]);
        }
    }
    let lane = |(id, heading_deg, _): &(&str, f64, &str)| Lane {
        id: (*id).into(),
        length_m: 100.0,
        speed_mps: 14.0,
        heading_deg: *heading_deg,
        ..Lane::default()
    };
    let phases = greens.iter().map(|g| ProgramPhase::fixed(*g, 30.0)).collect();
    let program = Program::new("0", ProgramKind::Static, phases);
    Scene {
        lanes: lanes.iter().map(lane).collect(),
        signals: vec![SignalInfo {
            id: "s".into(),
            links,
            programs: vec![program],
            active_program: "0".into(),
            meets: Vec::new(),
        }],
    }
}

/// Two crossing one-lane roads; `arrivals` are `(second, lane)`.
pub(crate) fn env(arrivals: Vec<(f64, u32)>, scratch: &Path) -> SignalEnv<MockSim> {
    env_of(minute(None), arrivals, scratch)
}

pub(crate) fn minute(routes: Option<RouteWriter>) -> World {
    World {
        config: "m".into(),
        begin_s: 0.0,
        end_s: 60.0,
        steps_per_second: 1,
        routes,
        ways: None,
        side: osm_signals::DrivingSide::Right,
        turn_shares: vec![],
        bays: Vec::new(),
        pedestrians: std::collections::BTreeMap::new(),
        existing: None,
        files: None,
        day_plan: false,
    }
}

/// The same in another world.
pub(crate) fn env_of(
    world: World,
    arrivals: Vec<(f64, u32)>,
    scratch: &Path,
) -> SignalEnv<MockSim> {
    let lane = |id: &str, heading_deg| Lane {
        id: id.into(),
        length_m: 100.0,
        speed_mps: 14.0,
        heading_deg,
        ..Lane::default()
    };
    let link = |from_lane| vec![Link::new(from_lane, "x_0", Direction::Straight)];
    let phases = vec![
        ProgramPhase::fixed("Gr", 20.0),
        ProgramPhase::fixed("yr", 3.0),
        ProgramPhase::fixed("rG", 20.0),
        ProgramPhase::fixed("ry", 3.0),
    ];
    let scene = Scene {
        lanes: vec![lane("s_0", 180.0), lane("w_0", 270.0)],
        signals: vec![SignalInfo {
            id: "c".into(),
            links: vec![link(0), link(1)],
            programs: vec![Program::new("0", ProgramKind::Static, phases)],
            active_program: "0".into(),
            meets: Vec::new(),
        }],
    };
    SignalEnv::new(
        MockSim::new(scene, arrivals),
        world,
        SignalSettings::default(),
        SimulationSettings::default(),
        scratch.to_path_buf(),
    )
}
