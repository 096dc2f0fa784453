//! A small environment without SUMO, for tests of whatever runs episodes.

use std::path::Path;

use super::world::RouteWriter;
use super::{SignalEnv, World};
use crate::family::scenario::{SignalSettings, SimulationSettings};
use crate::sim::mock::MockSim;
use crate::sim::{Direction, Lane, Link, Program, ProgramKind, ProgramPhase, Scene, SignalInfo};

/// Two crossing one-lane roads; `arrivals` are `(second, lane)`.
pub(crate) fn env(arrivals: Vec<(f64, u32)>, scratch: &Path) -> SignalEnv<MockSim> {
    env_of(minute(None), arrivals, scratch)
}

/// A world of a minute.
pub(crate) fn minute(routes: Option<RouteWriter>) -> World {
    World {
        config: "m".into(),
        begin_s: 0.0,
        end_s: 60.0,
        steps_per_second: 1,
        routes,
        turn_shares: vec![],
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
            programs: vec![Program { id: "0".into(), kind: ProgramKind::Static, phases }],
            active_program: "0".into(),
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
