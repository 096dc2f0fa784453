//! Who stands for so long in somebody's own scenario that SUMO by its defaults would move it on, and SUMO's reason for that:
//! its lane does not lead where it goes (wrong lane), it has to yield or sees red (yield), or those ahead stand (jam).
//!
//! Source: SUMO 1.15, `MSLane::executeMovements`.

use crate::sim::{Link, Scene, Snapshot};

/// SUMO's default of `time-to-teleport`, seconds.
pub const STANDING_S: f64 = 300.0;

/// Returns since when, where and why the vehicle stands that has stood longest, if that is so long.
/// * `state` — what a signal shows.
pub(super) fn standing<'a>(
    scene: &Scene,
    snapshot: &Snapshot,
    time_s: f64,
    state: impl Fn(usize) -> Option<&'a String>,
) -> Option<String> {
    let stands = snapshot.vehicles.iter().filter(|vehicle| vehicle.waiting_s >= STANDING_S);
    let longest = stands.max_by(|a, b| {
        let waited = a.waiting_s.total_cmp(&b.waiting_s);
        waited.then(b.distance_m.total_cmp(&a.distance_m))
    })?;
    let is_here = |link: &Link| link.from_lane == longest.lane as usize;
    let signal = scene.signals.iter().position(|s| s.links.iter().flatten().any(is_here))?;
    let links = &scene.signals[signal].links;
    let link = longest.link.map(|link| link as usize).filter(|i| links[*i].iter().any(is_here));
    let reason = match link.and_then(|link| state(signal)?.as_bytes().get(link)) {
        None => "wrong lane",
        Some(letter) if letter.is_ascii_uppercase() => "jam",
        Some(_) => "yield",
    };
    let (lane, since_s) = (&scene.lanes[longest.lane as usize].id, time_s - longest.waiting_s);
    Some(format!("from second {since_s:.0} on at lane {lane} ({reason})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::testing::crossing;
    use crate::sim::VehicleState;

    #[test]
    fn who_stands_longest_is_named_with_its_place_and_the_reason_that_sumo_has() {
        let scene = crossing(&[("n_0", 0.0, "s"), ("e_0", 90.0, "s")], &["Gg"]);
        let said = |waiting_s: f64, lane: u32, link: Option<u32>| {
            let vehicle =
                |lane, waiting_s| VehicleState { lane, link, waiting_s, ..VehicleState::default() };
            let vehicles = vec![vehicle(0, 10.0), vehicle(lane, waiting_s)];
            let seen = Snapshot { vehicles, phases: vec![] };
            let state = &scene.signals[0].programs[0].phases[0].state;
            standing(&scene, &seen, 1000.0, |_| Some(state))
        };
        assert_eq!(said(299.0, 0, Some(0)), None);
        assert_eq!(said(400.0, 0, Some(0)).unwrap(), "from second 600 on at lane n_0 (jam)");
        assert_eq!(said(300.0, 1, Some(1)).unwrap(), "from second 700 on at lane e_0 (yield)");
        for link in [None, Some(1)] {
            assert!(said(300.0, 0, link).unwrap().ends_with("n_0 (wrong lane)"));
        }
    }
}
