//! What tells intersections with their own arms apart, beyond the six means.
//!
//! Two intersections with the same means can be a crossing and a T junction, or have all vehicles on
//! one arm. Where every intersection keeps its own arms, k-means compares these columns, each
//! standardised:
//!
//! - the six features;
//! - the number of arms;
//! - the number of arms with traffic in one direction only;
//! - the shares of approaches from which a left turn, the way straight on and a right turn exist;
//! - the variation of the inflow between approaches: standard deviation divided by mean.
//!
//! Deviation: the paper clusters the context features, which here describe four equal arms.

use super::approaches::{Approach, Intersection};
use super::features::{per_approach_features, simulated_inflow_vph};
use crate::settings::FamilySettings;

/// Returns what describes an intersection with its own arms, in the order above.
pub fn describing(intersection: &Intersection, settings: &FamilySettings) -> Vec<f64> {
    let arms = &intersection.arms;
    let approaches: Vec<&Approach> = arms.iter().filter(|a| a.lanes_in > 0).collect();
    let count = approaches.len() as f64;
    let one_way = arms.iter().filter(|a| (a.lanes_in == 0) != (a.lanes_out == 0)).count();
    // Where a table names no movements, all that geometry allows exist.
    let share = |turn: char| {
        let has = |a: &&&Approach| a.movements.is_empty() || a.movements.contains(turn);
        approaches.iter().filter(has).count() as f64 / count
    };
    let inflows: Vec<f64> = approaches.iter().map(|a| simulated_inflow_vph(a, settings)).collect();
    let mean = inflows.iter().sum::<f64>() / count;
    let variance = inflows.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / count;
    let mut columns = per_approach_features(intersection, settings).to_array().to_vec();
    columns.extend([arms.len() as f64, one_way as f64]);
    columns.extend(['l', 's', 'r'].map(share));
    columns.push(variance.sqrt() / mean);
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arm(lanes: (u32, u32), aadt: f64, movements: &str) -> Approach {
        Approach {
            lanes_in: lanes.0,
            lanes_out: lanes.1,
            speed_mph: 30.0,
            length_m: 250.0,
            aadt_veh_per_day_per_lane: aadt,
            movements: movements.into(),
            ..Approach::default()
        }
    }

    fn described(arms: Vec<Approach>) -> Vec<f64> {
        let intersection = Intersection { arms, ..Intersection::default() };
        describing(&intersection, &FamilySettings::default())[6..].to_vec()
    }

    #[test]
    fn arms_movements_and_the_spread_of_inflow_tell_intersections_with_equal_means_apart() {
        let cross = described(vec![arm((1, 1), 2400.0, "lsr"); 4]);
        assert_eq!(cross, [4.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
        let tee = [arm((1, 1), 2400.0, "sr"), arm((1, 1), 2400.0, "ls"), arm((1, 1), 2400.0, "lr")];
        let third = 2.0 / 3.0;
        assert_eq!(described(tee.to_vec()), [3.0, 0.0, third, third, third, 0.0]);
        let uneven = vec![arm((1, 0), 3600.0, ""), arm((1, 1), 2400.0, ""), arm((0, 1), 0.0, "")];
        assert_eq!(described(uneven), [3.0, 2.0, 1.0, 1.0, 1.0, 0.2]);
    }
}
