//! Webster's cycle and splits: the textbook start of a fixed-time plan.
//!
//! Source: F. V. Webster, "Traffic signal settings", Road Research Technical Paper 39 (1958).

use super::{Light, SignalSpec};

/// Largest degree of saturation for which the formula is used; beyond it the cycle is the
/// longest that is allowed.
const MAX_FLOW_RATIO: f64 = 0.95;

/// Largest factor that greens are multiplied with to fill a cycle.
const MAX_FACTOR: f64 = 1e6;

/// Halvings in the search for that factor.
const BISECTIONS: u32 = 100;

/// What rounding errors may take from a whole second.
const ROUNDING_S: f64 = 1e-6;

/// Smallest flow ratio of a phase, so that a phase without counted vehicles gets some green.
const MIN_FLOW_RATIO: f64 = 0.01;

/// Least green of all phases together, seconds: where the formula's cycle is no longer than the changes in it, this keeps
/// the ratios of the greens, which limits then lengthen.
const LEAST_GREEN_S: f64 = 1.0;

/// Factor of the lost time in Webster's cycle.
const LOST_TIME_FACTOR: f64 = 1.5;

/// Constant part of Webster's cycle, seconds.
const CYCLE_OFFSET_S: f64 = 5.0;

/// Constants of the formula.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
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
    constants: &Constants,
) -> Vec<f64> {
    let ratios = flow_ratios(signal, phases, flow_vph, constants);
    let total: f64 = ratios.iter().sum();
    let lost_s = constants.lost_time_s * phases.len() as f64;
    let limits = &signal.limits;
    let cycle_s = if total < MAX_FLOW_RATIO {
        (LOST_TIME_FACTOR * lost_s + CYCLE_OFFSET_S) / (1.0 - total)
    } else {
        limits.max_cycle_s
    };
    let green_s = (cycle_s - limits.lost_s(phases)).max(LEAST_GREEN_S);
    let greens: Vec<f64> = ratios.iter().map(|r| green_s * r / total).collect();
    within(signal, phases, &greens)
}

/// Returns the green of each phase of a cycle of this length, seconds: by flow ratios, within the limits of each green.
/// Where these do not fit the cycle, the greens do not fill it or are more than it has.
///
/// # Arguments
///
/// * `phases`, `flow_vph` — as in [`greens`].
pub fn split(
    signal: &SignalSpec,
    phases: &[usize],
    flow_vph: &[f64],
    constants: &Constants,
    cycle_s: f64,
) -> Vec<f64> {
    let limits = &signal.limits;
    let most_s: Vec<f64> = phases.iter().map(|p| limits.max_green_s[*p]).collect();
    let ratios = flow_ratios(signal, phases, flow_vph, constants);
    fill(&ratios, &limits.least_s(phases), &most_s, cycle_s - limits.lost_s(phases))
}

/// Returns the flow ratio of each phase: that of its busiest lane.
fn flow_ratios(
    signal: &SignalSpec,
    phases: &[usize],
    flow_vph: &[f64],
    constants: &Constants,
) -> Vec<f64> {
    let shares: Vec<Vec<f64>> =
        (0..signal.lanes.len()).map(|lane| lane_shares(signal, phases, lane)).collect();
    let ratio = |p: usize| {
        (0..signal.lanes.len())
            .map(|lane| shares[lane][p] * flow_vph[lane] / constants.saturation_flow_vph)
            .fold(MIN_FLOW_RATIO, f64::max)
    };
    (0..phases.len()).map(ratio).collect()
}

/// Returns greens in whole seconds that keep to the limits of the signal: each within its own, and the
/// cycle neither too short nor too long, as far as the greens allow. Their ratios stay where they can.
pub fn within(signal: &SignalSpec, phases: &[usize], greens: &[f64]) -> Vec<f64> {
    let limits = &signal.limits;
    let low: Vec<f64> = limits.least_s(phases);
    let high: Vec<f64> = phases.iter().map(|p| limits.max_green_s[*p]).collect();
    let (least, most) = (low.iter().sum::<f64>(), high.iter().sum::<f64>());
    let lost_s = limits.lost_s(phases);
    let longest = (limits.max_cycle_s - lost_s).clamp(least, most);
    let shortest = (limits.min_cycle_s - lost_s).clamp(least, longest);
    let wanted: f64 = greens.iter().zip(&low).zip(&high).map(|((g, l), h)| g.clamp(*l, *h)).sum();
    fill(greens, &low, &high, wanted.clamp(shortest, longest))
}

/// Returns greens in whole seconds with this sum, each between its least and its most, in the ratios that
/// are wanted as far as these allow. Where even the least are more than the sum, they are returned, and
/// where the most are less, those.
///
/// # Arguments
///
/// * `wanted`, `least`, `most` — seconds per green; the latter two are whole numbers, or infinite.
pub fn fill(wanted: &[f64], least: &[f64], most: &[f64], total_s: f64) -> Vec<f64> {
    let (low, high) = (least.iter().sum::<f64>(), most.iter().sum::<f64>());
    let total_s = total_s.round().clamp(low, high);
    let scaled = |factor: f64| -> Vec<f64> {
        let bounds = least.iter().zip(most);
        wanted.iter().zip(bounds).map(|(g, (l, h))| (g * factor).clamp(*l, *h)).collect()
    };
    // The sum grows with the factor, from that of the shortest greens to that of the longest.
    let (mut below, mut above) = (0.0, MAX_FACTOR);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + above);
        if scaled(middle).iter().sum::<f64>() < total_s { below = middle } else { above = middle }
    }
    let exact = scaled(above);
    // Whole seconds, the largest fractions up.
    let mut rounded: Vec<f64> =
        exact.iter().zip(least).map(|(g, l)| (g + ROUNDING_S).floor().max(*l)).collect();
    let mut order: Vec<usize> = (0..exact.len()).collect();
    order.sort_by(|a, b| (exact[*b] - rounded[*b]).total_cmp(&(exact[*a] - rounded[*a])));
    let left_s = total_s - rounded.iter().sum::<f64>();
    for i in order.into_iter().take(left_s.max(0.0) as usize) {
        rounded[i] += 1.0;
    }
    rounded
}

fn lane_shares(signal: &SignalSpec, phases: &[usize], lane: usize) -> Vec<f64> {
    let served = |service: Light| -> Vec<f64> {
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
    let mut shares = served(Light::Protected);
    if shares.iter().sum::<f64>() == 0.0 {
        shares = served(Light::Permissive);
    }
    let total = shares.iter().sum::<f64>().max(1.0);
    shares.iter().map(|s| s / total).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::two_phase_signal;
    use super::*;
    use crate::needs::Need;

    const CONSTANTS: Constants = Constants { lost_time_s: 4.0, saturation_flow_vph: 1800.0 };

    #[test]
    fn the_textbook_example_is_reproduced() {
        // Ratios 0.25 and 0.5: cycle (1.5 * 8 + 5) / 0.25 = 68 s, green 62 s, split 1 to 2.
        let greens = greens(&two_phase_signal(), &[0, 1], &[450.0, 900.0], &CONSTANTS);
        assert_eq!(greens, [21.0, 41.0]);
        // An oversaturated signal gets the longest cycle, and an empty one the shortest.
        let of = |flow| super::greens(&two_phase_signal(), &[0, 1], &[flow; 2], &CONSTANTS);
        assert_eq!((of(1800.0), of(0.0)), (vec![57.0; 2], vec![7.0; 2]));
    }

    fn limited(low: [f64; 2], high: [f64; 2], cycle: [f64; 2]) -> SignalSpec {
        let mut signal = two_phase_signal();
        signal.limits.needs = (0..2).map(|i| Need::of_green(i, 2, low[i] as u32)).collect();
        signal.limits.max_green_s = high.to_vec();
        [signal.limits.min_cycle_s, signal.limits.max_cycle_s] = cycle;
        signal
    }

    #[test]
    fn a_cycle_that_is_too_short_is_filled_in_proportion() {
        let signal = limited([7.0, 7.0], [f64::INFINITY; 2], [60.0, 120.0]);
        assert_eq!(within(&signal, &[0, 1], &[9.0, 18.0]), [18.0, 36.0]);
        let signal = limited([7.0, 7.0], [30.0; 2], [60.0, 120.0]);
        assert_eq!(within(&signal, &[0, 1], &[9.0, 18.0]), [24.0, 30.0]);
        let signal = limited([7.0, 7.0], [20.0; 2], [60.0, 120.0]);
        assert_eq!(within(&signal, &[0, 1], &[9.0, 18.0]), [20.0, 20.0]);
    }

    #[test]
    fn greens_keep_their_ratios_where_the_formula_s_cycle_is_no_longer_than_the_changes() {
        let mut signal = limited([7.0, 7.0], [f64::INFINITY; 2], [60.0, 120.0]);
        signal.limits.change_s = vec![vec![0.0, 5.0], vec![5.0, 0.0]];
        let constants = Constants { lost_time_s: 0.0, ..CONSTANTS };
        // Ratios 0.05 and 0.1: cycle 5 / 0.85 = 5.9 s, of which the changes take 10 s.
        assert_eq!(greens(&signal, &[0, 1], &[90.0, 180.0], &constants), [17.0, 33.0]);
    }

    #[test]
    fn the_shortest_greens_count_more_than_the_longest_cycle() {
        let signal = limited([40.0, 5.0], [60.0; 2], [20.0, 45.0]);
        assert_eq!(within(&signal, &[0, 1], &[10.0, 90.0]), [40.0, 5.0]);
        let signal = limited([30.0, 5.0], [60.0; 2], [20.0, 45.0]);
        assert_eq!(within(&signal, &[0, 1], &[10.0, 90.0]), [30.0, 9.0]);
    }

    proptest::proptest! {
        #[test]
        fn greens_keep_to_the_limits(
            a in 0.1f64..500.0,
            b in 0.1f64..500.0,
            low in [1u32..40, 1u32..40],
            more in [0u32..60, 0u32..60],
            short in 10u32..100,
            longer in 0u32..100,
        ) {
            let low = low.map(f64::from);
            let high = [low[0] + f64::from(more[0]), low[1] + f64::from(more[1])];
            let cycle = [f64::from(short), f64::from(short + longer)];
            let greens = within(&limited(low, high, cycle), &[0, 1], &[a, b]);
            for i in 0..2 {
                proptest::prop_assert!(low[i] <= greens[i] && greens[i] <= high[i], "{greens:?}");
                proptest::prop_assert_eq!(greens[i].fract(), 0.0);
            }
            let total: f64 = greens.iter().sum::<f64>() + 6.0;
            let (least, most) = (low.iter().sum::<f64>() + 6.0, high.iter().sum::<f64>() + 6.0);
            proptest::prop_assert!(total >= cycle[0].min(most), "{greens:?}");
            proptest::prop_assert!(total <= cycle[1].max(least), "{greens:?}");
        }
    }
}
