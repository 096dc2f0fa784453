//! What detectors see: RESCO's per-lane observation with its memory of waiting times.
//!
//! A vehicle is in a signal's zone when it is on an incoming lane and within `detection_m` of the
//! signal. Its waiting time is SUMO's when it is first seen halted; from then on it grows by
//! `delta_time_s` with every observation, **even if the vehicle moves again**, until it leaves the
//! zone. So a "queue" counts vehicles that have halted at least once.
//!
//! In its movement a vehicle counts by its link index at the signal and the edges that it drives from and to,
//! because one index may steer several turns.
//!
//! Vehicles on pieces of street upstream of a lane belong to it, see [`crate::sim::trace`].
//!
//! Source: RESCO, traffic_signal.py. Deviation: arrivals and departures as corrected on RESCO's main
//! branch; the version behind the published figures had them swapped.

use crate::control::{LaneObservation, Observation};
use crate::sim::{Scene, SignalInfo, Snapshot};

use super::derive::DerivedSignal;

/// Speed below which a vehicle halts, metres per second (SUMO's definition of waiting).
const HALT_MPS: f64 = 0.1;

/// What is remembered of a vehicle, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Memory {
    /// Waiting time, seconds; 0 until it halts in the zone.
    wait_s: f64,
    /// Observation at which it was last in the zone.
    seen: u32,
    /// Lane on which it was last counted, plus one.
    counted_on: u32,
    /// Signal in whose zone it was.
    signal: u32,
    /// Movement in which it was last counted, plus one.
    moved_in: u32,
}

/// Turns snapshots into observations and keeps the memory that they need.
#[derive(Debug, Clone, Default)]
pub struct Observer {
    detection_m: f64,
    delta_time_s: f64,
    memory: Vec<Memory>,
    round: u32,
    /// What was seen on each lane of the scene at the last decision.
    pub(super) lanes: Vec<LaneObservation>,
    /// Signal of each lane.
    signals: Vec<u32>,
    /// Vehicles that halt now on all incoming lanes, at any distance.
    pub(super) halting: u32,
    /// Vehicles that have been seen so far on each lane of the scene, its pieces upstream included.
    pub(super) counts: Vec<u32>,
    /// Number of the movement by signal, link index and number among the links of that index; those of all
    /// signals are numbered in a row.
    movements: Vec<Vec<Vec<Option<u32>>>>,
    /// Where the movements of each signal begin.
    first_movement: Vec<usize>,
    seen: Vec<f64>,
}

impl Observer {
    /// Returns an observer for a scene and what was derived of its signals, with an empty memory.
    pub fn new(
        scene: &Scene,
        derived: &[DerivedSignal],
        detection_m: f64,
        delta_time_s: f64,
    ) -> Self {
        let lanes = scene.lanes.len();
        let mut signals = vec![0; lanes];
        for (number, signal) in (0..).zip(&scene.signals) {
            signal.links.iter().flatten().for_each(|link| signals[link.from_lane] = number);
        }
        let of_links = |s: &SignalInfo| s.links.iter().map(|l| vec![None; l.len()]).collect();
        let mut movements: Vec<Vec<Vec<Option<u32>>>> =
            scene.signals.iter().map(of_links).collect();
        let mut first_movement = Vec::new();
        let mut count = 0;
        for (signal, of_link) in derived.iter().zip(&mut movements) {
            first_movement.push(count as usize);
            for ways in &signal.movement_ways {
                ways.iter().for_each(|(link, way)| of_link[*link][*way] = Some(count));
                count += 1;
            }
        }
        Self {
            signals,
            movements,
            first_movement,
            seen: vec![0.0; count as usize],
            detection_m,
            delta_time_s,
            lanes: vec![LaneObservation::default(); lanes],
            counts: vec![0; lanes],
            ..Self::default()
        }
    }

    /// Takes in a snapshot.
    pub fn update(&mut self, snapshot: &Snapshot) {
        self.round += 1;
        self.halting = 0;
        self.lanes.fill(LaneObservation::default());
        for vehicle in &snapshot.vehicles {
            let number = vehicle.vehicle as usize;
            if number >= self.memory.len() {
                self.memory.resize(number + 1, Memory::default());
            }
            let memory = &mut self.memory[number];
            self.halting += u32::from(vehicle.speed_mps < HALT_MPS);
            if memory.counted_on != vehicle.lane + 1 {
                memory.counted_on = vehicle.lane + 1;
                self.counts[vehicle.lane as usize] += 1;
            }
            let signal = self.signals[vehicle.lane as usize];
            let of_link = self.movements.get(signal as usize).zip(vehicle.link);
            let of_way = of_link.and_then(|(links, link)| links.get(link as usize));
            let movement = of_way.and_then(|ways| *ways.get(vehicle.way as usize)?);
            if let Some(movement) = movement.filter(|m| memory.moved_in != m + 1) {
                memory.moved_in = movement + 1;
                self.seen[movement as usize] += 1.0;
            }
            if vehicle.distance_m > self.detection_m {
                continue;
            }
            // Every signal remembers for itself: at the next one the vehicle is new.
            if memory.seen + 1 != self.round || memory.signal != signal {
                memory.wait_s = 0.0;
            }
            if memory.wait_s > 0.0 {
                memory.wait_s += self.delta_time_s;
            } else {
                memory.wait_s = vehicle.waiting_s;
            }
            memory.seen = self.round;
            memory.signal = signal;
            let lane = &mut self.lanes[vehicle.lane as usize];
            lane.total_speed_mps += vehicle.speed_mps;
            if memory.wait_s > 0.0 {
                lane.queue += 1.0;
                lane.total_wait_s += memory.wait_s;
                lane.max_wait_s = lane.max_wait_s.max(memory.wait_s);
            } else {
                lane.approach += 1.0;
            }
        }
    }

    /// Writes what the detectors of the signal with this index see into `observation`.
    pub fn write(
        &self,
        index: usize,
        signal: &DerivedSignal,
        phase: usize,
        observation: &mut Observation,
    ) {
        observation.phase = phase;
        observation.lanes.clear();
        observation.lanes.extend(signal.lanes.iter().map(|l| self.lanes[*l]));
        observation.downstream_queue.clear();
        observation.downstream_queue.extend(signal.downstream.iter().map(|l| self.lanes[*l].queue));
        let seen = &self.seen[self.first_movement[index]..][..signal.movement_ways.len()];
        observation.seen.clear();
        observation.seen.extend(seen);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::signal::testing::signal;
    use crate::settings::SignalSettings;
    use crate::sim::{Direction, Lane, Link, VehicleState};

    fn observer() -> Observer {
        let lane =
            |id: &str| Lane { id: id.into(), length_m: 300.0, speed_mps: 14.0, ..Lane::default() };
        let scene = Scene { lanes: vec![lane("a_0"), lane("a_1")], signals: vec![] };
        Observer::new(&scene, &[], 200.0, 10.0)
    }

    fn at(vehicle: u32, distance_m: f64, speed_mps: f64, waiting_s: f64) -> VehicleState {
        VehicleState {
            link: Some(0),
            vehicle,
            speed_mps,
            waiting_s,
            distance_m,
            ..VehicleState::default()
        }
    }

    fn update(observer: &mut Observer, vehicles: &[VehicleState]) -> LaneObservation {
        observer.update(&Snapshot { vehicles: vehicles.to_vec(), phases: vec![] });
        observer.lanes[0]
    }

    #[test]
    fn a_vehicle_that_moves_again_still_counts_as_queued() {
        let mut observer = observer();
        assert_eq!(update(&mut observer, &[at(0, 50.0, 5.0, 0.0)]).approach, 1.0);
        let halted = update(&mut observer, &[at(0, 20.0, 0.0, 4.0)]);
        assert_eq!((halted.queue, halted.total_wait_s), (1.0, 4.0));
        let moving = update(&mut observer, &[at(0, 10.0, 6.0, 0.0)]);
        assert_eq!((moving.queue, moving.total_wait_s, moving.total_speed_mps), (1.0, 14.0, 6.0));
    }

    #[test]
    fn waits_add_up_and_end_with_the_zone_in_which_a_vehicle_counts_once_per_lane() {
        let mut observer = observer();
        let lane = update(&mut observer, &[at(0, 5.0, 0.0, 7.0), at(1, 12.0, 0.0, 3.0)]);
        assert_eq!((lane.max_wait_s, lane.total_wait_s), (7.0, 10.0));
        update(&mut observer, &[]);
        assert_eq!(update(&mut observer, &[at(0, 20.0, 5.0, 0.0)]).approach, 1.0);
        let beyond = update(&mut observer, &[at(2, 200.1, 0.0, 9.0)]);
        assert_eq!((beyond.queue, beyond.approach, observer.halting), (0.0, 0.0, 1));
        assert_eq!(observer.counts, [3, 0]);
    }

    #[test]
    fn waiting_at_one_signal_is_nothing_to_the_next() {
        let lane = |id: &str| Lane { id: id.into(), ..Lane::default() };
        let signal = |from_lane| SignalInfo {
            links: vec![vec![Link::new(from_lane, "x_0", Direction::Straight)]],
            ..SignalInfo::default()
        };
        let scene =
            Scene { lanes: vec![lane("a_0"), lane("b_0")], signals: vec![signal(0), signal(1)] };
        let mut observer = Observer::new(&scene, &[], 200.0, 10.0);
        update(&mut observer, &[at(0, 20.0, 0.0, 20.0)]);
        let moved_on = VehicleState { lane: 1, ..at(0, 90.0, 13.0, 0.0) };
        update(&mut observer, &[moved_on]);
        assert_eq!((observer.lanes[1].approach, observer.lanes[1].queue), (1.0, 0.0));
    }

    #[test]
    fn a_vehicle_is_seen_once_in_its_movement() {
        let derived = DerivedSignal {
            lanes: vec![0],
            movement_ways: vec![vec![(1, 0)], vec![(0, 0), (2, 0)], vec![(2, 1)]],
            ..signal(&SignalSettings::default())
        };
        let lane = Lane { id: "a_0".into(), ..Lane::default() };
        let link = || Link::new(0, "x_0", Direction::Straight);
        let info = SignalInfo {
            links: vec![vec![link()], vec![link()], vec![link(), link()]],
            ..SignalInfo::default()
        };
        let scene = Scene { lanes: vec![lane], signals: vec![info] };
        let mut observer = Observer::new(&scene, std::slice::from_ref(&derived), 200.0, 10.0);
        let turning = |vehicle, link| VehicleState { link, ..at(vehicle, 250.0, 9.0, 0.0) };
        update(&mut observer, &[turning(0, Some(2)), turning(1, None)]);
        update(&mut observer, &[turning(0, Some(0)), turning(2, Some(1)), turning(3, Some(2))]);
        // The same index, another turn.
        update(&mut observer, &[VehicleState { way: 1, ..turning(4, Some(2)) }]);
        let mut observation = Observation::default();
        observer.write(0, &derived, 0, &mut observation);
        assert_eq!(observation.seen, [1.0, 2.0, 1.0]);
    }
}
