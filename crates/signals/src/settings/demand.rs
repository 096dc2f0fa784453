//! Settings of the vehicles that arrive: how long, how they turn, how unevenly they come.

use osm_signals::{DrivingSide, Turn};
use serde::{Deserialize, Serialize};

use evaluation::settings::setting::settings;

/// Largest [`DemandSettings::approach_spread`]: a larger one leaves an approach without vehicles.
pub const MAX_APPROACH_SPREAD: f64 = 0.745;

/// Peak hour factor below which the other quarters of the horizon would have less than no vehicle.
pub(crate) const MIN_PEAK_HOUR_FACTOR: f64 = 0.25;

settings! {
    /// Which vehicles arrive.
    pub struct DemandSettings, source "our choice" {
        /// Simulated time; vehicles arrive during all of it.
        horizon_s: f64 = 3600.0, in 10.0..=86_400.0, unit "s", source "the paper's hour";
        /// How arriving vehicles turn; renormalised over the movements that exist.
        turn_shares: TurnShares = TurnShares::default();
        /// Volume of the horizon divided by four times the volume of its busiest quarter, which is the second one. 1 is
        /// constant demand. A value is above 0.25 and at most 1. The volume of the horizon stays the same. This is the
        /// peak hour factor of the Highway Capacity Manual, `V / (4 V15)`, whose default is 0.92.
        peak_hour_factor: f64 = 1.0;
        /// Variation (standard deviation divided by the mean) of the inflow between the four approaches of a
        /// six-feature point MDP, whose mean stays the same; 0 makes them equal. It has no effect on approaches that
        /// have their own features, because these have their own inflows. 0.4 is the variation within the intersections
        /// of Salt Lake City.
        approach_spread: f64 = 0.0, in 0.0..=MAX_APPROACH_SPREAD;
        /// Share of vehicles that are heavy: single-unit trucks of 9.1 m, which stand for buses too. Arrivals, turns
        /// and desired speeds do not depend on it. The default of the Highway Capacity Manual is 0.03.
        #[serde(skip_serializing_if = "is_zero")]
        heavy_vehicles: f64 = 0.0, in 0.0..=1.0;
        /// How much drivers dawdle: 0 not at all, 1 as much as SUMO's model of following allows (SUMO's `sigma`). Less of it
        /// raises saturation flow.
        #[serde(skip_serializing_if = "is_sumo_sigma")]
        sigma: f64 = SUMO_SIGMA, in 0.0..=1.0, source "SUMO";
        /// Drivers that yield accept gaps in which those with priority have to brake: 0 never, 1 as hard as they can
        /// (SUMO's `impatience`, which grows with the time that a driver waits).
        #[serde(skip_serializing_if = "is_zero")]
        impatience: f64 = 0.0, in 0.0..=1.0, source "SUMO";
    }
}

/// SUMO's default of [`DemandSettings::sigma`].
pub(crate) const SUMO_SIGMA: f64 = 0.5;

/// Returns whether drivers dawdle as in SUMO by default, which manifests and files of demand do not say.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(crate) fn is_sumo_sigma(sigma: &f64) -> bool {
    *sigma == SUMO_SIGMA
}

/// Returns whether a number is 0, which manifests and files of demand do not say.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(crate) fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// Shares of the vehicles of an approach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurnShares {
    /// Left turns.
    pub left: f64,
    /// Straight on.
    pub through: f64,
    /// Right turns.
    pub right: f64,
}

impl TurnShares {
    /// Returns the share of a turn.
    pub fn of(self, turn: Turn) -> f64 {
        match turn {
            Turn::Left => self.left,
            Turn::Through => self.through,
            Turn::Right => self.right,
        }
    }

    /// Returns the shares, which are as on the ground, as right-hand traffic would have them.
    #[must_use]
    pub fn as_right_hand(self, side: DrivingSide) -> Self {
        let (left, right) = side.swapped((self.left, self.right));
        Self { left, right, ..self }
    }
}

impl Default for TurnShares {
    fn default() -> Self {
        Self { left: 0.1, through: 0.8, right: 0.1 }
    }
}
