//! What the simulator makes of vehicles at a signal, beside the Highway Capacity Manual.
//!
//! One small intersection is generated with a scenario's settings and simulated a few times: four arms, 30 mph, two
//! lanes for through traffic and one for left turns. Vehicles, drivers, yellow and all-red are those of the settings.
//!
//! Definitions:
//! - **A vehicle crosses** when its front is 0.1 m before the stop line, at a time that SUMO's instant loop
//!   interpolates within the step.
//! - **Saturation flow** is 3,600 over the mean headway of a queue, from the fifth vehicle to the last one within the
//!   green; the queue always lasts longer (HCM, chapter 31, field measurement).
//! - **Start-up lost time** is what the first four vehicles need beyond four such headways.
//! - **Use of yellow** is how many vehicles of a lane cross from the onset of yellow on, per phase.
//! - **Lost time per phase** is green, yellow and all-red, without the headways of all vehicles that crossed in it.
//! - **Vehicles of a green** are all that cross in it and in the yellow after it: what saturation flow and lost time make
//!   together.
//! - **Permissive left capacity** is the flow of a lane that always has a queue, beside a green that never ends, while
//!   vehicles come at random on the two lanes opposite.
//!
//! What the manual says of it: a base saturation flow of 1,900 passenger cars per hour and lane with its factors for
//! heavy vehicles and protected left turns, 2.0 s of start-up lost time, 2.0 s of yellow in use, and its gap model for
//! permissive left turns (HCM, 7th edition, chapters 19 and 31).

mod discharge;
mod street;

use std::path::Path;

use serde::Serialize;

use self::discharge::{Discharge, discharge, mean};
use self::street::{GREENS_S, Street};
use super::error::TrafficError;
use super::settings::Scenario;
use super::sim::Sim;
use basics::units::SECONDS_PER_HOUR;

/// Seeds that everything is measured with.
pub const SEEDS: u32 = 5;

/// Opposing flows of the permissive left turns, vehicles per hour.
const OPPOSING_VPH: [f64; 4] = [300.0, 600.0, 900.0, 1200.0];

/// Simulations of a calibration: queues once, and permissive left turns against each flow, with every seed.
pub const SIMULATIONS: u32 = SEEDS * (1 + OPPOSING_VPH.len() as u32);

/// Base saturation flow of a metropolitan area, passenger cars per hour and lane (HCM, chapter 19).
const BASE_SATURATION_VPH: f64 = 1900.0;

/// Through vehicles that count as much as a protected left turn from a lane of its own (HCM, chapter 19).
const LEFT_EQUIVALENT: f64 = 1.05;

/// What a percent of heavy vehicles takes from saturation flow on a level street (HCM, chapter 19, combined factor of
/// heavy vehicles and grade).
const PER_HEAVY_PERCENT: f64 = 0.0078;

/// Start-up lost time (HCM, chapter 19).
const START_UP_S: f64 = 2.0;

/// Part of yellow that vehicles use (HCM, chapter 19, extension of effective green).
const EXTENSION_S: f64 = 2.0;

/// Critical and follow-up headway of permissive left turns (HCM, chapter 31).
const CRITICAL_S: f64 = 4.5;
const FOLLOW_UP_S: f64 = 2.5;

/// A quantity as it was measured, and as the manual has it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// What it is.
    pub quantity: String,
    /// Its unit.
    pub unit: &'static str,
    /// Mean over the seeds.
    pub measured: f64,
    /// Lowest of the seeds.
    pub lowest: f64,
    /// Highest of the seeds.
    pub highest: f64,
    /// The manual's value.
    pub hcm: f64,
    /// How much more was measured, percent of the manual's value.
    pub difference_percent: f64,
}

impl Quantity {
    fn new(quantity: impl Into<String>, unit: &'static str, of: &[f64], hcm: f64) -> Self {
        let measured = mean(of);
        Self {
            quantity: quantity.into(),
            unit,
            measured,
            lowest: of.iter().copied().fold(f64::INFINITY, f64::min),
            highest: of.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            hcm,
            difference_percent: 100.0 * (measured / hcm - 1.0),
        }
    }
}

/// Measures everything with a simulator and the settings of a scenario; takes about a minute with SUMO.
///
/// # Arguments
///
/// * `folder` — for files of the simulations.
///
/// # Errors
///
/// [`TrafficError`] when the network cannot be built or not be simulated.
pub fn calibrate(
    sim: &mut dyn Sim,
    scenario: &Scenario,
    folder: &Path,
) -> Result<Vec<Quantity>, TrafficError> {
    let street = Street::build(scenario, folder)?;
    let (mut through, mut left) = (Vec::new(), Vec::new());
    for k in 0..SEEDS {
        let (plan, crossings) = street.queues(sim, k)?;
        through.push(discharge(&crossings.through, plan.cycle_s, plan.through)?);
        left.push(discharge(&crossings.left, plan.cycle_s, plan.left)?);
    }
    let change_s = f64::from(street.change_s());
    let heavy = 1.0 - PER_HEAVY_PERCENT * 100.0 * scenario.demand.heavy_vehicles;
    let saturation_vph = BASE_SATURATION_VPH * heavy;
    let of = |all: &[Discharge], value: fn(&Discharge) -> f64| -> Vec<f64> {
        all.iter().map(value).collect()
    };
    let flow = |d: &Discharge| SECONDS_PER_HOUR / d.headway_s;
    // A green ends half a headway after its last vehicle on average, which the manual counts as lost.
    let in_yellow = EXTENSION_S * saturation_vph / SECONDS_PER_HOUR + 0.5;
    let lost_s = START_UP_S + change_s - EXTENSION_S;
    let mut table = vec![
        Quantity::new(
            "saturation flow, through",
            "veh/h per lane",
            &of(&through, flow),
            saturation_vph,
        ),
        Quantity::new(
            "saturation flow, protected left",
            "veh/h per lane",
            &of(&left, flow),
            saturation_vph / LEFT_EQUIVALENT,
        ),
        Quantity::new("start-up lost time", "s", &of(&through, |d| d.start_up_s), START_UP_S),
        Quantity::new(
            "use of yellow",
            "veh per lane and phase",
            &of(&through, |d| d.in_yellow),
            in_yellow,
        ),
        Quantity::new(
            format!("lost time per phase, {change_s} s of yellow and all-red"),
            "s",
            &of(&through, |d| d.lost_s),
            lost_s,
        ),
        Quantity::new(
            format!("vehicles of a through lane in {} s of green", GREENS_S[0]),
            "veh per lane and phase",
            &of(&through, |d| d.vehicles),
            (GREENS_S[0] + change_s - lost_s) * saturation_vph / SECONDS_PER_HOUR,
        ),
    ];
    for opposing_vph in OPPOSING_VPH {
        let mut measured = Vec::new();
        for k in 0..SEEDS {
            measured.push(street.permissive_vph(sim, opposing_vph, k)?);
        }
        table.push(Quantity::new(
            format!("permissive left against {opposing_vph} veh/h"),
            "veh/h",
            &measured,
            gap_model_vph(opposing_vph),
        ));
    }
    Ok(table)
}

/// Returns the capacity of permissive left turns by the manual's gap model, vehicles per hour.
fn gap_model_vph(opposing_vph: f64) -> f64 {
    let per_s = opposing_vph / SECONDS_PER_HOUR;
    opposing_vph * (-per_s * CRITICAL_S).exp() / (1.0 - (-per_s * FOLLOW_UP_S).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_model_has_the_manual_s_values() {
        let values = OPPOSING_VPH.map(|v| gap_model_vph(v).round());
        assert_eq!(values, [1096.0, 832.0, 629.0, 474.0]);
    }

    #[test]
    fn a_quantity_is_the_mean_of_its_seeds_beside_the_manual_s() {
        let q = Quantity::new("x", "s", &[1.0, 2.0, 3.0], 1.6);
        assert_eq!((q.measured, q.lowest, q.highest), (2.0, 1.0, 3.0));
        assert!((q.difference_percent - 25.0).abs() < 1e-9);
    }
}
