//! Capacity of movements from the greens that were really shown, and what follows from it: volume to capacity, control delay
//! by formula, and level of service F above capacity.
//!
//! - **Saturation flow** is the setting `fixed_time.saturation_flow_vph` per through lane, divided by 1.05 for left and by 1.18
//!   for right turns. In left-hand traffic the two change places.
//! - **Effective green** is the green that was shown: lost time at its beginning and use of yellow at its end are 2 s each and
//!   cancel.
//! - **A turn that yields** has the capacity of the manual's gap model (headways of 4.5 and 2.5 s) in what the opposing queue
//!   leaves of its green, and two vehicles at the end of each green in which it yields. SUMO's drivers used about 30% less in
//!   the one case that was measured.
//! - **A lane group** is used to the sum, over its movements, of volume divided by the capacity that its lanes would have for
//!   that movement alone. For a group of one movement that is volume divided by capacity.
//! - **Control delay by formula** is the manual's uniform and incremental delay for random arrivals and fixed greens (k = 0.5,
//!   I = 1), with the mean green and cycle. Only for groups that never yield and whose movements have one green.
//!
//! Deviation: turns on red, pedestrians, parking and buses have no part in it; the analysis period is the simulated time.
//!
//! Source: Highway Capacity Manual, 6th edition, chapter 19 (capacity, volume to capacity, uniform and incremental delay), and chapter 31
//! (permissive left turns).

use basics::units::SECONDS_PER_HOUR;
use osm_signals::{DrivingSide, Turn};
use signals::movement_results::{MovementResult, Supply};
use signals::vocabulary::Heading;

/// Through cars that a protected left turn, and a right turn, stands for.
const LEFT: f64 = 1.05;
const RIGHT: f64 = 1.18;

/// Critical headway of a turn that yields, and headway of those who follow, seconds.
const CRITICAL_S: f64 = 4.5;
const FOLLOW_S: f64 = 2.5;

/// Vehicles that turn at the end of each green in which they yield.
const SNEAKERS: f64 = 2.0;

/// Incremental delay: share of random arrivals that a fixed green meets.
const K: f64 = 0.5;

/// What a movement's lane group can take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Capacity {
    /// Capacity of the lane group for its mix of movements, vehicles per hour; `None` without vehicles.
    pub(crate) group_vph: Option<f64>,
    /// Volume to capacity of the lane group; infinite where vehicles have no green.
    pub(crate) ratio: f64,
    /// Control delay by the manual's formula, seconds per vehicle.
    pub(crate) delay_s: Option<f64>,
}

/// What capacity is computed with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Basis {
    /// Saturation flow of a through lane, vehicles per hour.
    pub(crate) saturation_vph: f64,
    /// Simulated time, hours.
    pub(crate) hours: f64,
    /// Side of the street that traffic keeps to.
    pub(crate) side: DrivingSide,
}

impl Basis {
    /// Returns where a movement goes and how it turns; the turn across opposing traffic depends on the side.
    fn way(&self, name: &str) -> Option<(Heading, Turn)> {
        Heading::of_movement(name, self.side)
    }

    fn is_across(&self, turn: Turn) -> bool {
        turn == Turn::across(self.side)
    }

    /// Returns the capacity of the lane group of every movement of a task; `None` for records that do not say what was shown.
    pub(crate) fn capacities(&self, all: &[MovementResult]) -> Vec<Option<Capacity>> {
        all.iter().map(|m| self.capacity(m, all)).collect()
    }

    fn capacity(&self, m: &MovementResult, all: &[MovementResult]) -> Option<Capacity> {
        let own = m.supply.as_ref()?;
        let volume_vph = |m: &MovementResult| m.vehicles_veh / self.hours;
        let in_group =
            |o: &&MovementResult| o.supply.as_ref().is_some_and(|s| s.group == own.group);
        let group: Vec<&MovementResult> = all.iter().filter(in_group).collect();
        let lanes = f64::from(own.group_lanes.max(1));
        let mut ratio = 0.0;
        for member in &group {
            let volume_vph = volume_vph(member);
            if volume_vph > 0.0 {
                ratio += volume_vph / (lanes * self.per_lane_vph(member, all)?);
            }
        }
        let total_vph: f64 = group.iter().map(|m| volume_vph(m)).sum();
        let group_vph = (total_vph > 0.0 && ratio.is_finite()).then(|| total_vph / ratio);
        let same = |s: &Supply| {
            s.permissive_share == 0.0 && (s.protected_share - own.protected_share).abs() < 1e-9
        };
        let is_plain = group.iter().filter_map(|m| m.supply.as_ref()).all(same);
        let delay_s = group_vph
            .filter(|_| is_plain && own.greens_per_h > 0.0)
            .map(|vph| self.delay_s(ratio, vph, own));
        Some(Capacity { group_vph, ratio, delay_s })
    }

    /// Returns the capacity of a lane that serves a movement alone, vehicles per hour.
    fn per_lane_vph(&self, m: &MovementResult, all: &[MovementResult]) -> Option<f64> {
        let supply = m.supply.as_ref()?;
        let way = self.way(&m.movement);
        let equivalent = match way.map(|(_, turn)| turn) {
            Some(turn) if self.is_across(turn) => LEFT,
            Some(Turn::Left | Turn::Right) => RIGHT,
            _ => 1.0,
        };
        let flow_vph = self.saturation_vph / equivalent;
        let protected_vph = flow_vph * supply.protected_share;
        let yields = supply.permissive_share > 0.0;
        let Some((heading, _)) = way.filter(|(_, turn)| yields && self.is_across(*turn)) else {
            return Some(protected_vph + flow_vph * supply.permissive_share);
        };
        let opposite = heading.clockwise(4);
        let opposing = |o: &&MovementResult| {
            self.way(&o.movement).is_some_and(|(h, turn)| h == opposite && !self.is_across(turn))
        };
        let through = all.iter().filter(opposing).max_by_key(|o| {
            let is_through = self.way(&o.movement).is_some_and(|(_, turn)| turn == Turn::Through);
            (is_through, o.supply.as_ref().map_or(0, |s| s.lanes))
        });
        let Some(against) = through.and_then(|o| o.supply.as_ref()) else {
            return Some(protected_vph + flow_vph * supply.permissive_share);
        };
        let volume_vph: f64 =
            all.iter().filter(opposing).map(|o| o.vehicles_veh / self.hours).sum();
        Some(protected_vph + self.permissive_vph(supply, against, volume_vph))
    }

    /// Returns the capacity of a turn while it yields to a volume.
    fn permissive_vph(&self, own: &Supply, against: &Supply, volume_vph: f64) -> f64 {
        let cycle_s = SECONDS_PER_HOUR / against.greens_per_h.max(1.0);
        // A turn that has the right of way at other times has more greens than those that end while it yields.
        let sneakers_vph = SNEAKERS * own.greens_per_h.min(against.greens_per_h);
        let red_s = (1.0 - against.protected_share - against.permissive_share).max(0.0) * cycle_s;
        let per_lane_vph = volume_vph / f64::from(against.lanes.max(1));
        let queue_s = match per_lane_vph < self.saturation_vph {
            true => per_lane_vph * red_s / (self.saturation_vph - per_lane_vph),
            false => f64::INFINITY,
        };
        let free_s = (own.permissive_share * cycle_s - queue_s).max(0.0);
        let flow_vph = match volume_vph > 0.0 {
            true => {
                let of = |headway_s: f64| (-volume_vph * headway_s / SECONDS_PER_HOUR).exp();
                volume_vph * of(CRITICAL_S) / (1.0 - of(FOLLOW_S))
            }
            false => SECONDS_PER_HOUR / FOLLOW_S,
        };
        flow_vph * free_s / cycle_s + sneakers_vph
    }

    /// Returns uniform and incremental delay.
    fn delay_s(&self, ratio: f64, capacity_vph: f64, supply: &Supply) -> f64 {
        let cycle_s = SECONDS_PER_HOUR / supply.greens_per_h;
        let share = supply.protected_share;
        let uniform_s = 0.5 * cycle_s * (1.0 - share).powi(2) / (1.0 - ratio.min(1.0) * share);
        let over = ratio - 1.0;
        let root = (over * over + 8.0 * K * ratio / (capacity_vph * self.hours)).sqrt();
        uniform_s + 900.0 * self.hours * (over + root)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn movement(
        name: &str,
        group: &str,
        lanes: [u32; 2],
        vehicles_veh: f64,
        shares: [f64; 2],
    ) -> MovementResult {
        MovementResult {
            from: String::new(),
            to: String::new(),
            movement: name.to_owned(),
            signal: "c".to_owned(),
            links: vec![],
            vehicles_veh,
            unfinished_veh: 0.0,
            delay_s: None,
            stops: None,
            queue_50_veh: 0.0,
            queue_95_veh: 0.0,
            storage_m: None,
            crosswalk_delay_s: None,
            crosswalk_unserved: false,
            supply: Some(Supply {
                group: group.to_owned(),
                lanes: lanes[0],
                group_lanes: lanes[1],
                protected_share: shares[0],
                permissive_share: shares[1],
                greens_per_h: 40.0,
            }),
        }
    }

    const BASIS: Basis = Basis { saturation_vph: 1900.0, hours: 0.25, side: DrivingSide::Right };

    fn near(value: f64, expected: f64) {
        assert!(
            (value - expected).abs() < 0.005 * expected.abs().max(1.0),
            "{value} instead of {expected}"
        );
    }

    #[test]
    fn an_exclusive_group_is_saturation_flow_times_green_and_has_the_manual_s_delay() {
        // 1,000 veh/h on two lanes with 36 of 90 s: c = 2 x 1900 x 0.4 = 1520, X = 0.658. By hand, T = 0.25 h:
        // d1 = 0.5 x 90 x 0.36 / (1 - 0.658 x 0.4) = 21.98 s; d2 = 225 x (-0.342 + sqrt(0.117 + 0.006927)) = 2.25 s.
        let all = [movement("NBT", "NBT", [2, 2], 250.0, [0.4, 0.0])];
        let capacity = BASIS.capacities(&all)[0].unwrap();
        near(capacity.group_vph.unwrap(), 1520.0);
        near(capacity.ratio, 0.6579);
        near(capacity.delay_s.unwrap(), 21.98 + 2.25);
    }

    #[test]
    fn turns_count_for_more_and_shared_lanes_are_one_group() {
        // 300 through and 100 right on one lane: (300 + 1.18 x 100) / (1900 x 0.5) = 0.44.
        let all = [
            movement("NBT", "NBT NBR", [1, 1], 75.0, [0.5, 0.0]),
            movement("NBR", "NBT NBR", [1, 1], 25.0, [0.5, 0.0]),
            movement("NBL", "NBL", [1, 1], 25.0, [0.1, 0.0]),
        ];
        let of = BASIS.capacities(&all);
        near(of[0].unwrap().ratio, 0.44);
        assert_eq!(of[0], of[1]);
        assert!(of[0].unwrap().delay_s.is_some());
        // The right turn has an arrow longer than the green beside it, for which the manual has no such formula.
        let mut arrow = all.clone();
        arrow[1].supply.as_mut().unwrap().protected_share = 0.6;
        assert_eq!(BASIS.capacities(&arrow)[0].unwrap().delay_s, None);
        near(of[2].unwrap().group_vph.unwrap(), 1900.0 / 1.05 * 0.1);
        let mirrored = Basis { side: DrivingSide::Left, ..BASIS };
        near(mirrored.capacities(&all)[2].unwrap().group_vph.unwrap(), 1900.0 / 1.18 * 0.1);
    }

    #[test]
    fn a_turn_that_yields_has_gaps_after_the_opposing_queue() {
        // 600 veh/h oppose on two lanes with 45 of 90 s: their queue takes 300 x 45 / 1600 = 8.44 s, 36.56 s are free. The gap
        // model gives 600 e^-0.75 / (1 - e^-0.4167) = 831.6 veh/h: (831.6 x 36.56 + 7200) / 90 = 417.8.
        let all = [
            movement("NBL", "NBL", [1, 1], 50.0, [0.0, 0.5]),
            movement("SBT", "SBT", [2, 2], 150.0, [0.5, 0.0]),
        ];
        let capacity = BASIS.capacities(&all)[0].unwrap();
        near(capacity.group_vph.unwrap(), 417.8);
        assert_eq!(capacity.delay_s, None, "the manual needs more than these formulas");
        // With an arrow before it there are twice as many greens, and the same number that end while it yields.
        let mut with_arrow = all.clone();
        let supply = with_arrow[0].supply.as_mut().unwrap();
        (supply.protected_share, supply.greens_per_h) = (0.1, 80.0);
        near(BASIS.capacities(&with_arrow)[0].unwrap().group_vph.unwrap(), 417.8 + 180.95);
        // Nobody opposes: as with the right of way.
        near(BASIS.capacities(&all[..1])[0].unwrap().group_vph.unwrap(), 1900.0 / 1.05 * 0.5);
    }

    #[test]
    fn vehicles_without_green_are_above_any_capacity_and_old_records_say_nothing() {
        let mut all = [movement("NBT", "NBT", [1, 1], 10.0, [0.0, 0.0])];
        let without = BASIS.capacities(&all)[0].unwrap();
        assert_eq!((without.ratio, without.group_vph), (f64::INFINITY, None));
        all[0].supply = None;
        assert_eq!(BASIS.capacities(&all), [None]);
    }
}
