//! How vehicles fare that drive along all signals of a street, second by second.
//!
//! - **Who counts**: a vehicle that was seen before the first stop line of a street and goes straight on at every one. It is
//!   one that has passed the last stop line; those under way at the end of the episode do not count. It may be on any lane of
//!   the signals, such as to overtake: its next link says where it goes.
//! - **Time** is from the first second on a lane of the first signal, or upstream of it within the detection distance, to the
//!   second after the last stop line. What a vehicle waited to enter the network is not in it.
//! - **Delay** is the time beyond that at the speed limit of the lanes before the stop lines.
//! - **Stops**: how often it came below 0.1 m/s.

use std::collections::BTreeMap;

use osm_signals::DrivingSide;
use osm_signals::angle::mirrored_deg;

use super::derive::DerivedSignal;
use crate::control::SignalSpec;
use crate::control::streets::{Stop, streets};
use crate::sim::{Scene, Snapshot};
use crate::street_results::{StreetEpisode, StreetResult, StreetStop};
use crate::vocabulary::Heading;

/// Speed below which a vehicle halts, metres per second (SUMO's definition of waiting).
const HALT_MPS: f64 = 0.1;

/// A vehicle on its way along a street.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct UnderWay {
    since_s: f64,
    /// Distance to the first stop line when it was first seen, metres.
    before_m: f64,
    stop: usize,
    halts: u32,
    halted: bool,
    /// Round in which it was last seen.
    round: u32,
}

/// Vehicles along the streets of a network.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Along {
    /// The streets, each with the sums of this episode.
    streets: Vec<StreetResult>,
    /// Speed limit before the first stop line of each street, metres per second.
    first_mps: Vec<f64>,
    /// Streets and stops by lane of the scene: all lanes of the signal of a stop.
    of_lane: Vec<Vec<(usize, usize)>>,
    under_way: BTreeMap<(u32, usize), UnderWay>,
    round: u32,
}

impl Along {
    /// Returns a collection for an episode; `None` where no street has two signals.
    pub(super) fn new(
        scene: &Scene,
        (signals, specs): (&[DerivedSignal], &[SignalSpec]),
        side: DrivingSide,
    ) -> Option<Self> {
        let mut along = Self { of_lane: vec![Vec::new(); scene.lanes.len()], ..Self::default() };
        for (street, stops) in streets(specs).iter().enumerate() {
            for (place, stop) in stops.iter().enumerate() {
                for lane in &signals[stop.signal].lanes {
                    along.of_lane[*lane].push((street, place));
                }
            }
            let first = &signals[stops[0].signal];
            let lane = first.spec.movements[stops[0].movement].lanes[0];
            let lane = &scene.lanes[first.lanes[lane]];
            let heading_deg =
                if side.is_right() { lane.heading_deg } else { mirrored_deg(lane.heading_deg) };
            along.first_mps.push(lane.speed_mps.max(HALT_MPS));
            let result = |stop: &Stop| StreetStop {
                signal: specs[stop.signal].id.clone(),
                links: signals[stop.signal].movement_links[stop.movement].clone(),
                at_m: stop.at_m,
                after_s: stop.after_s,
            };
            along.streets.push(StreetResult {
                direction: Heading::of_approaches(&[heading_deg])[0].to_string(),
                stops: stops.iter().map(result).collect(),
                episodes: vec![StreetEpisode::default()],
            });
        }
        (!along.streets.is_empty()).then_some(along)
    }

    /// Takes in what is seen at a second.
    pub(super) fn second(&mut self, snapshot: &Snapshot, time_s: f64) {
        self.round += 1;
        for vehicle in &snapshot.vehicles {
            for &(street, stop) in &self.of_lane[vehicle.lane as usize] {
                let known = self.under_way.get(&(vehicle.vehicle, street)).copied();
                let links = &self.streets[street].stops[stop].links;
                let is_on = match vehicle.link {
                    Some(link) => links.contains(&(link as usize)),
                    // It has to change lanes first.
                    None => known.is_some_and(|known| known.stop == stop),
                };
                let before_m = vehicle.distance_m;
                let first = || UnderWay { since_s: time_s, before_m, ..UnderWay::default() };
                let known = known.or_else(|| (stop == 0).then(first));
                if let Some(known) = known.filter(|_| is_on) {
                    let halted = vehicle.speed_mps < HALT_MPS;
                    let halts = known.halts + u32::from(halted && !known.halted);
                    let known = UnderWay { stop, halts, halted, round: self.round, ..known };
                    self.under_way.insert((vehicle.vehicle, street), known);
                }
            }
        }
        self.under_way.retain(|(_, street), known| {
            let StreetResult { stops, episodes, .. } = &mut self.streets[*street];
            let is_over = known.round != self.round && known.stop + 1 == stops.len();
            if is_over {
                let travel_s = time_s - known.since_s;
                let free_s = known.before_m / self.first_mps[*street] + stops[known.stop].after_s;
                episodes[0].vehicles += 1;
                episodes[0].travel_s += travel_s;
                episodes[0].delay_s += travel_s - free_s;
                episodes[0].stops += f64::from(known.halts);
            }
            !is_over
        });
    }

    /// Ends the episode and returns its streets, each with this episode alone.
    pub(super) fn finish(self) -> Vec<StreetResult> {
        let mut streets = self.streets;
        for sum in streets.iter_mut().flat_map(|street| &mut street.episodes) {
            let vehicles = f64::from(sum.vehicles.max(1));
            for total in [&mut sum.travel_s, &mut sum.delay_s, &mut sum.stops] {
                *total /= vehicles;
            }
        }
        streets
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::VehicleState;

    fn street() -> Along {
        let stop = |signal: &str, at_m, after_s| StreetStop {
            signal: signal.into(),
            links: vec![1],
            at_m,
            after_s,
        };
        Along {
            streets: vec![StreetResult {
                direction: "EB".into(),
                stops: vec![stop("a", 0.0, 0.0), stop("b", 100.0, 10.0)],
                episodes: vec![StreetEpisode::default()],
            }],
            first_mps: vec![10.0],
            of_lane: vec![vec![(0, 0)], vec![(0, 1)]],
            ..Along::default()
        }
    }

    /// Lane, link, distance to the stop line and speed of vehicle 7, second by second.
    fn driven(seconds: &[Option<(u32, u32, f64, f64)>]) -> StreetEpisode {
        let mut along = street();
        for (time_s, seen) in (0..).zip(seconds) {
            let vehicles = seen.map(|(lane, link, distance_m, speed_mps)| VehicleState {
                lane,
                link: Some(link),
                vehicle: 7,
                speed_mps,
                distance_m,
                ..VehicleState::default()
            });
            let vehicles = vehicles.into_iter().collect();
            along.second(&Snapshot { vehicles, phases: vec![] }, f64::from(time_s));
        }
        along.finish()[0].episodes[0]
    }

    #[test]
    fn who_drives_along_counts_with_time_delay_and_stops() {
        let seconds = [
            Some((0, 1, 50.0, 10.0)),
            Some((0, 1, 40.0, 0.0)),
            Some((0, 1, 40.0, 0.0)),
            None,
            Some((1, 1, 90.0, 9.0)),
            Some((1, 1, 1.0, 0.0)),
            None,
        ];
        // 6 s for 50 m and the 10 s between the stop lines.
        let expected = StreetEpisode { vehicles: 1, travel_s: 6.0, delay_s: -9.0, stops: 2.0 };
        assert_eq!(driven(&seconds), expected);
    }

    #[test]
    fn who_turns_off_comes_from_the_side_or_is_still_under_way_does_not_count() {
        let none = StreetEpisode::default();
        assert_eq!(driven(&[Some((0, 1, 9.0, 9.0)), Some((1, 2, 9.0, 9.0)), None]), none);
        assert_eq!(driven(&[None, Some((1, 1, 9.0, 9.0)), None]), none);
        assert_eq!(driven(&[Some((0, 1, 9.0, 9.0)), Some((1, 1, 9.0, 9.0))]), none);
    }
}
