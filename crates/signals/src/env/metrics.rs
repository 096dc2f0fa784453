//! What an episode is judged by.

use super::by_movement::MovementTotals;
use super::pedestrians::PedestrianTotals;
use crate::control::{EpisodeOutcome, RingGreens};
use crate::sim::StepCounts;
use crate::sim::tripinfo::TripTotals;
use crate::street_results::StreetResult;

/// What an episode is judged by.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeMetrics {
    /// Sums over vehicles.
    pub trips: TripTotals,
    /// Events during the episode.
    pub counts: StepCounts,
    /// Since when, where and why a vehicle of somebody's own scenario stands for long.
    pub standing: Option<String>,
    /// How many crossed, where they push buttons.
    pub pedestrians: Option<u32>,
    /// People on foot: those, or on recall one of every crosswalk.
    pub people: PedestrianTotals,
    /// Mean over decisions of the halting vehicles on all incoming lanes.
    pub queue_veh: f64,
    /// Largest number of halting vehicles at a decision.
    pub max_queue_veh: f64,
    /// What it is made of, where ways of vehicles are known.
    pub movements: Vec<MovementTotals>,
    /// Who drove along streets of several signals, where that is collected.
    pub streets: Vec<StreetResult>,
    /// Vehicles seen per hour, per signal and lane of the signal.
    pub lane_flow_vph: Vec<Vec<f64>>,
    /// Per signal the greens that a method may choose; absent of others.
    pub rings: Vec<Option<RingGreens>>,
}

impl EpisodeMetrics {
    /// Mean delay per vehicle, seconds; `None` without vehicles, where 0 would be the best delay.
    ///
    /// Source: RESCO, utils/readXML.py: time loss plus departure delay over all vehicles.
    pub fn delay_s(&self) -> Option<f64> {
        self.per_vehicle(self.trips.delay_s)
    }

    /// Mean waiting time per vehicle, seconds; `None` without vehicles.
    pub fn waiting_s(&self) -> Option<f64> {
        self.per_vehicle(self.trips.waiting_s)
    }

    fn per_vehicle(&self, sum: f64) -> Option<f64> {
        (self.trips.vehicles > 0).then(|| sum / f64::from(self.trips.vehicles))
    }

    /// Returns what training may use of the episode; `None` without vehicles.
    pub fn outcome(&self) -> Option<EpisodeOutcome> {
        let (lane_flow_vph, rings) = (self.lane_flow_vph.clone(), self.rings.clone());
        Some(EpisodeOutcome { delay_s: self.delay_s()?, lane_flow_vph, rings })
    }
}
