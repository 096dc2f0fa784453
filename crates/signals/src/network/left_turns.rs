//! How each approach's left turns are signalled, from `signal.left_turns`.
//!
//! - **Of an existing plan** the treatments are those of the arms, which [`placed`](crate::placed) tells.
//! - A left turn **without a lane of its own** stays permissive: an arrow for it would have to hold whoever goes
//!   straight on from the same lane, which only a green for one approach alone does.
//! - Of left turns **from their own lanes and a shared one** two lanes would yield. They are protected: both approaches of the
//!   street are served alone (split phasing).
//! - A left turn **without an opposing approach** has nobody to yield to, and nothing to choose.
//! - Left-hand traffic is mirrored before and after, so these are its right turns.
//!
//! By rule, the first that applies, for each approach:
//! 1. two or more lanes for left turns: protected;
//! 2. four or more opposing through lanes: protected;
//! 3. at most two left turns per cycle of the default program: permissive;
//! 4. opposing speed above 45 mph: protected;
//! 5. left turns times opposing vehicles per hour above 50,000 against one lane, 90,000 against two, or 110,000
//!    against three: protected and permissive;
//! 6. else permissive.
//!
//! Deviation: sight distance, crashes and delay, which the guidelines also ask for, are not known. The hour is that
//! of the scenario, and its speed the speed limit.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapter 4, guidelines for left-turn phasing (1 to 4);
//! HCM (2000), cross products for protected left turns (5).

use std::collections::BTreeSet;

use osm_signals::Turn;

use super::default_program::cycle_s;
use super::demand::DemandSpec;
use super::intersection::IntersectionSpec;
use super::lanes::{LaneLayout, turns_left_from_its_own_lanes};
use super::movements::opposite;
use crate::junction::incoming_edge;
use crate::settings::{LeftTurns, NetworkSettings, SignalSettings};
use basics::units::{SECONDS_PER_HOUR, mph_to_mps};

/// Lanes for left turns from which on they are protected.
pub const PROTECTED_LANES: usize = 2;

/// Opposing through lanes from which on left turns are protected.
pub const PROTECTED_OPPOSING_LANES: usize = 4;

/// Left turns per cycle up to which they find their way.
const FEW_PER_CYCLE: f64 = 2.0;

/// Opposing speed above which left turns are protected, miles per hour.
const PROTECTED_SPEED_MPH: f64 = 45.0;

/// Product of left turns and opposing vehicles, per hour each, by opposing lanes: one, two, three.
const CROSS_PRODUCTS: [f64; 3] = [50_000.0, 90_000.0, 110_000.0];

/// What rounding errors may add to a speed, metres per second.
const ROUNDING_MPS: f64 = 1e-6;

/// Returns how the left turns of every arm are signalled; `None` where the settings leave it to the network.
pub fn treatments(
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    demand: &DemandSpec,
    network: &NetworkSettings,
    signal: &SignalSettings,
) -> Option<Vec<LeftTurns>> {
    let cycle_s = cycle_s(network, (signal.min_cycle_s, signal.max_cycle_s));
    let of = |arm: usize| match (opposite(&layout.movements, arm), signal.left_turns) {
        (Some(other), asked) if turns_left_from_its_own_lanes(layout, arm) => {
            match (asked, spec.arms[arm].left_turns) {
                (LeftTurns::Existing, Some(existing)) => existing,
                (LeftTurns::Existing | LeftTurns::ByRule, _) => {
                    by_rule(spec, layout, demand, cycle_s, [arm, other])
                }
                (asked, _) => asked,
            }
        }
        (Some(_), asked) if spec.arms[arm].shared_left => match spec.arms[arm].left_turns {
            Some(LeftTurns::Permissive) if asked == LeftTurns::Existing => LeftTurns::Permissive,
            _ if asked == LeftTurns::Permissive => LeftTurns::Permissive,
            _ => LeftTurns::Protected,
        },
        _ => LeftTurns::Permissive,
    };
    let is_network = signal.left_turns.is_network();
    (!is_network).then(|| (0..spec.arms.len()).map(of).collect())
}

fn by_rule(
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    demand: &DemandSpec,
    cycle_s: u32,
    [arm, other]: [usize; 2],
) -> LeftTurns {
    let lanes = |arm: usize, turn: Turn| {
        let own =
            layout.connections.iter().filter(|c| (c.movement.from, c.movement.turn) == (arm, turn));
        own.map(|c| c.from_lane).collect::<BTreeSet<_>>().len()
    };
    let volume_vph = |arm: usize, wanted: &dyn Fn(Turn) -> bool| -> f64 {
        let edges: Vec<String> = (layout.movements.iter())
            .filter(|m| m.from == arm && wanted(m.turn))
            .map(|m| m.to_edge())
            .collect();
        let streams = demand.streams.iter().filter(|s| s.from == incoming_edge(arm));
        let shares = streams.flat_map(|s| s.routes.iter().map(|r| (r, s.inflow_vph)));
        shares.filter(|(r, _)| edges.contains(&r.to)).map(|(r, vph)| r.share * vph).sum()
    };
    let opposing_lanes = lanes(other, Turn::Through);
    let left_vph = volume_vph(arm, &|turn| turn == Turn::Left);
    let opposing_vph = volume_vph(other, &|turn| turn != Turn::Left);
    let per_cycle = left_vph * f64::from(cycle_s) / SECONDS_PER_HOUR;
    let product = CROSS_PRODUCTS[opposing_lanes.clamp(1, CROSS_PRODUCTS.len()) - 1];
    if lanes(arm, Turn::Left) >= PROTECTED_LANES || opposing_lanes >= PROTECTED_OPPOSING_LANES {
        LeftTurns::Protected
    } else if per_cycle <= FEW_PER_CYCLE {
        LeftTurns::Permissive
    } else if spec.arms[other].speed_mps > mph_to_mps(PROTECTED_SPEED_MPH) + ROUNDING_MPS {
        LeftTurns::Protected
    } else if left_vph * opposing_vph > product {
        LeftTurns::ProtectedPermissive
    } else {
        LeftTurns::Permissive
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::layout;
    use super::super::movements::shapes::{cross, tee};
    use super::*;
    use crate::settings::DemandSettings;

    fn of(spec: &IntersectionSpec, left_turns: LeftTurns) -> Option<Vec<LeftTurns>> {
        within(spec, &SignalSettings { left_turns, ..SignalSettings::default() })
    }

    fn within(spec: &IntersectionSpec, signal: &SignalSettings) -> Option<Vec<LeftTurns>> {
        let demand = DemandSpec::from_intersection(spec, &DemandSettings::default()).unwrap();
        treatments(spec, &layout(spec).unwrap(), &demand, &NetworkSettings::default(), signal)
    }

    /// Arms with one lane to the left and two straight on, 10% of whose vehicles turn left.
    fn with_left_lanes(inflow_vph: f64) -> IntersectionSpec {
        let mut spec = cross();
        for arm in &mut spec.arms {
            (arm.lanes_in, arm.left_turn_lanes, arm.inflow_vph) = (3, 1, inflow_vph);
        }
        spec
    }

    fn by_rule(spec: &IntersectionSpec) -> LeftTurns {
        of(spec, LeftTurns::ByRule).unwrap()[0]
    }

    #[test]
    fn lefts_without_a_lane_or_an_opposing_approach_stay_permissive() {
        assert_eq!(of(&cross(), LeftTurns::Protected), Some(vec![LeftTurns::Permissive; 4]));
        assert_eq!(of(&cross(), LeftTurns::Network), None);
        let all = of(&with_left_lanes(400.0), LeftTurns::Protected);
        assert_eq!(all, Some(vec![LeftTurns::Protected; 4]));
        let mut tee = tee();
        tee.arms.iter_mut().for_each(|arm| arm.left_turn_lanes = 1);
        let stem = of(&tee, LeftTurns::Protected).unwrap()[1];
        assert_eq!(stem, LeftTurns::Permissive);
    }

    #[test]
    fn the_rule_looks_at_lanes_then_volumes_then_speeds() {
        // 80 left turns per hour are two per cycle; 90 times 810 are 72,900.
        assert_eq!(by_rule(&with_left_lanes(800.0)), LeftTurns::Permissive);
        assert_eq!(by_rule(&with_left_lanes(900.0)), LeftTurns::Permissive);
        // 110 times 990 are 108,900.
        assert_eq!(by_rule(&with_left_lanes(1100.0)), LeftTurns::ProtectedPermissive);
        let mut fast = with_left_lanes(900.0);
        fast.arms[2].speed_mps = mph_to_mps(45.0);
        assert_eq!(by_rule(&fast), LeftTurns::Permissive);
        fast.arms[2].speed_mps = mph_to_mps(50.0);
        assert_eq!(by_rule(&fast), LeftTurns::Protected);
        let mut two = with_left_lanes(100.0);
        (two.arms[0].lanes_in, two.arms[0].left_turn_lanes) = (4, 2);
        assert_eq!(by_rule(&two), LeftTurns::Protected);
        // What the existing plan has comes before the rule, where it has something.
        two.arms[0].left_turns = Some(LeftTurns::Permissive);
        let existing = of(&two, LeftTurns::Existing).unwrap()[0];
        assert_eq!([existing, by_rule(&two)], [LeftTurns::Permissive, LeftTurns::Protected]);
        let mut wide = with_left_lanes(100.0);
        (wide.arms[2].lanes_in, wide.arms[2].lanes_out) = (5, 5);
        assert_eq!(by_rule(&wide), LeftTurns::Protected);
    }

    #[test]
    fn the_rule_counts_left_turns_in_the_cycle_that_the_program_has() {
        // 100 left turns per hour are 2.5 in 90 s and 1.7 in 60 s; 100 times 900 are no more than 90,000, so speed decides.
        let mut spec = with_left_lanes(1000.0);
        spec.arms[2].speed_mps = mph_to_mps(50.0);
        let longest = |max_cycle_s| {
            let left_turns = LeftTurns::ByRule;
            let signal = SignalSettings { max_cycle_s, left_turns, ..SignalSettings::default() };
            within(&spec, &signal).unwrap()[0]
        };
        assert_eq!(longest(150), LeftTurns::Protected);
        assert_eq!(longest(60), LeftTurns::Permissive);
    }
}
