//! What a signal's limits and turning shares are, from what SUMO and the demand say of it.

use crate::control::{Limits, SignalSpec};
use crate::settings::SignalSettings;
use crate::sim::topology::edge;
use crate::sim::{Link, Program, ProgramKind, Scene, SignalInfo};
use crate::timing::{Approach, Timing, Way};

use super::movements::turn_of;
use super::world::TurnShare;

/// Returns the incoming edges of a signal in the order of its approaches: that in which its links name them.
pub(super) fn approach_edges<'a>(scene: &'a Scene, signal: &SignalInfo) -> Vec<&'a str> {
    let mut edges = Vec::new();
    for link in signal.links.iter().flatten() {
        let edge = edge(&scene.lanes[link.from_lane].id);
        if !edges.contains(&edge) {
            edges.push(edge);
        }
    }
    edges
}

/// Returns the limits of a signal: its approaches are its incoming edges.
pub(super) fn timing(scene: &Scene, signal: &SignalInfo, settings: &SignalSettings) -> Timing {
    let mut edges: Vec<&str> = Vec::new();
    let mut approaches: Vec<Approach> = Vec::new();
    let mut way = |link: &Link| {
        let lane = &scene.lanes[link.from_lane];
        let approach = edges.iter().position(|e| *e == edge(&lane.id)).unwrap_or_else(|| {
            edges.push(edge(&lane.id));
            approaches.push(Approach {
                heading_deg: lane.heading_deg,
                width_m: lane.street_width_m,
                plain_lanes: lane.plain_lanes,
                speed_mps: lane.speed_mps,
            });
            edges.len() - 1
        });
        Way { approach, turn: turn_of(link.direction) }
    };
    let links = signal.links.iter().map(|links| links.iter().map(&mut way).collect()).collect();
    Timing::new(settings, approaches, links)
}

/// Returns the limits of the phases as controllers see them.
pub(super) fn limits(timing: &Timing, greens: &[String], own: &Program) -> Limits {
    let seconds = |time: u32| f64::from(time);
    let change = |from: &String, to: &String| {
        timing.change(from, to).map_or(0.0, |change| seconds(change.total_s()))
    };
    let (min_cycle_s, max_cycle_s) = timing.cycle_s();
    Limits {
        min_green_s: greens.iter().map(|g| seconds(timing.min_green_s(g))).collect(),
        needs: timing.needs(&greens.iter().map(String::as_str).collect::<Vec<_>>()),
        max_green_s: (greens.iter())
            .map(|g| timing.max_green_s(g).map_or(f64::INFINITY, seconds))
            .collect(),
        change_s: greens.iter().map(|a| greens.iter().map(|b| change(a, b)).collect()).collect(),
        min_cycle_s: seconds(min_cycle_s),
        max_cycle_s: seconds(max_cycle_s),
        own_program: own.kind == ProgramKind::Static && timing.keeps(&own.phases()),
    }
}

/// Puts the turning shares that the demand of a world says into a signal's movements; a movement of an
/// approach of which the demand says nothing has none.
pub(super) fn share_turns(
    spec: &mut SignalSpec,
    movement_ways: &[Vec<(usize, usize)>],
    (scene, signal): (&Scene, &SignalInfo),
    shares: &[TurnShare],
) {
    for (movement, ways) in spec.movements.iter_mut().zip(movement_ways) {
        let links = || ways.iter().map(|(index, number)| &signal.links[*index][*number]);
        let ways = |share: &&TurnShare| {
            links().any(|link| {
                edge(&scene.lanes[link.from_lane].id) == share.from
                    && edge(&link.to_lane) == share.to
            })
        };
        let known = |share: &TurnShare| {
            links().any(|link| edge(&scene.lanes[link.from_lane].id) == share.from)
        };
        movement.share = (shares.iter().any(known))
            .then(|| shares.iter().filter(ways).map(|share| share.share).sum());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::SignalEnv;
    use crate::env::testing::env;
    use crate::sim::testing::MockSim;

    fn share(from: &str, to: &str, share: f64) -> TurnShare {
        TurnShare { from: from.into(), to: to.into(), share }
    }

    fn shares(turn_shares: Vec<TurnShare>) -> Vec<Option<f64>> {
        let dir = tempfile::tempdir().unwrap();
        let mut env: SignalEnv<MockSim> = env(vec![], dir.path());
        env.world_mut().turn_shares = turn_shares;
        env.reset(1).unwrap();
        env.signals()[0].movements.iter().map(|m| m.share).collect()
    }

    #[test]
    fn movements_have_the_shares_that_the_demand_says_of_their_edges() {
        let known = vec![share("s", "x", 0.75), share("s", "y", 0.25)];
        assert_eq!(shares(known), [Some(0.75), None]);
        assert_eq!(shares(vec![]), [None, None]);
    }
}
