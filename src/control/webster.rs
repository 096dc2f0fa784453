//! Webster's cycle and splits: the textbook start of a fixed-time plan.
//!
//! Source: F. V. Webster, "Traffic signal settings", Road Research Technical Paper 39 (1958).

use super::{Service, SignalSpec};

/// Largest degree of saturation for which the formula is used; beyond it the cycle is the
/// longest that is allowed.
const MAX_FLOW_RATIO: f64 = 0.95;

/// Smallest flow ratio of a phase, so that a phase without counted vehicles gets some green.
const MIN_FLOW_RATIO: f64 = 0.01;

/// Factor of the lost time in Webster's cycle.
const LOST_TIME_FACTOR: f64 = 1.5;

/// Constant part of Webster's cycle, seconds.
const CYCLE_OFFSET_S: f64 = 5.0;

/// Limits and constants of the plans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Shortest green, seconds.
    pub min_green_s: f64,
    /// Shortest cycle, seconds.
    pub min_cycle_s: f64,
    /// Longest cycle, seconds.
    pub max_cycle_s: f64,
    /// Time lost per phase, seconds.
    pub lost_time_s: f64,
    /// Saturation flow, vehicles per hour and lane.
    pub saturation_flow_vph: f64,
}

/// Returns the green of each phase of a cycle, seconds.
///
/// # Arguments
///
/// * `phases` — indices into [`SignalSpec::phases`], the phases of the cycle.
/// * `flow_vph` — vehicles per hour and lane, in the order of [`SignalSpec::lanes`].
///
/// A lane's flow is shared equally between the phases of the cycle that serve it with right of
/// way (or permissively, when none does). The flow ratio of a phase is that of its busiest lane.
pub fn greens(
    signal: &SignalSpec,
    phases: &[usize],
    flow_vph: &[f64],
    yellow_s: f64,
    limits: &Limits,
) -> Vec<f64> {
    let shares: Vec<Vec<f64>> =
        (0..signal.lanes.len()).map(|lane| lane_shares(signal, phases, lane)).collect();
    let ratios: Vec<f64> = (0..phases.len())
        .map(|p| {
            (0..signal.lanes.len())
                .map(|lane| shares[lane][p] * flow_vph[lane] / limits.saturation_flow_vph)
                .fold(MIN_FLOW_RATIO, f64::max)
        })
        .collect();
    let total: f64 = ratios.iter().sum();
    let lost_s = limits.lost_time_s * phases.len() as f64;
    let cycle_s = if total < MAX_FLOW_RATIO {
        (LOST_TIME_FACTOR * lost_s + CYCLE_OFFSET_S) / (1.0 - total)
    } else {
        limits.max_cycle_s
    };
    let yellow_s = yellow_s * phases.len() as f64;
    let cycle_s = cycle_s.clamp(limits.min_cycle_s, limits.max_cycle_s);
    let green_s = (cycle_s - yellow_s).max(0.0);
    let greens: Vec<f64> = ratios.iter().map(|r| green_s * r / total).collect();
    within(&greens, yellow_s, limits)
}

/// Returns greens in whole seconds that keep to the limits: none too short, and the cycle not too
/// long unless the shortest greens alone make it so.
pub fn within(greens: &[f64], yellow_s: f64, limits: &Limits) -> Vec<f64> {
    let longest = (limits.max_cycle_s - yellow_s).max(0.0);
    let total: f64 = greens.iter().sum();
    let scale = if total > longest { longest / total } else { 1.0 };
    greens.iter().map(|g| (g * scale).round().max(limits.min_green_s)).collect()
}

fn lane_shares(signal: &SignalSpec, phases: &[usize], lane: usize) -> Vec<f64> {
    let served = |service: Service| -> Vec<f64> {
        let phase = |p: &usize| {
            let serves = signal
                .movements
                .iter()
                .zip(&signal.phases[*p].service)
                .any(|(m, s)| m.lanes.contains(&lane) && *s >= service);
            f64::from(u8::from(serves))
        };
        phases.iter().map(phase).collect()
    };
    let mut shares = served(Service::Protected);
    if shares.iter().sum::<f64>() == 0.0 {
        shares = served(Service::Permissive);
    }
    let total = shares.iter().sum::<f64>().max(1.0);
    shares.iter().map(|s| s / total).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::two_phase_signal;
    use super::*;

    const LIMITS: Limits = Limits {
        min_green_s: 5.0,
        min_cycle_s: 20.0,
        max_cycle_s: 120.0,
        lost_time_s: 4.0,
        saturation_flow_vph: 1800.0,
    };

    #[test]
    fn the_textbook_example_is_reproduced() {
        // Ratios 0.25 and 0.5: cycle (1.5 * 8 + 5) / 0.25 = 68 s, green 62 s, split 1 to 2.
        let greens = greens(&two_phase_signal(), &[0, 1], &[450.0, 900.0], 3.0, &LIMITS);
        assert_eq!(greens, [21.0, 41.0]);
    }

    #[test]
    fn an_oversaturated_signal_gets_the_longest_cycle() {
        let greens = greens(&two_phase_signal(), &[0, 1], &[1800.0, 1800.0], 3.0, &LIMITS);
        assert_eq!(greens, [57.0, 57.0]);
    }

    #[test]
    fn an_empty_signal_gets_the_shortest_cycle() {
        let greens = greens(&two_phase_signal(), &[0, 1], &[0.0, 0.0], 3.0, &LIMITS);
        assert_eq!(greens, [7.0, 7.0]);
    }
}
