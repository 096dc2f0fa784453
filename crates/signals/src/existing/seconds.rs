//! Plans in whole seconds.

use super::ExistingPlan;

/// What makes a time that is a whole number but for rounding stay one, seconds.
const ROUNDING_S: f64 = 1e-6;

/// When a phase is green in a cycle of splits, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timed {
    /// From the beginning of the cycle.
    pub begin_s: u32,
    /// Green, until yellow.
    pub green_s: u32,
    /// Yellow.
    pub yellow_s: u32,
    /// All-red.
    pub all_red_s: u32,
}

/// Returns yellow and all-red in whole seconds: yellow is rounded up, and both together once.
pub fn change_s(yellow_s: f64, all_red_s: f64) -> (u32, u32) {
    let up = |seconds: f64| (seconds - ROUNDING_S).ceil().max(0.0) as u32;
    let yellow = up(yellow_s);
    (yellow, up(yellow_s + all_red_s).saturating_sub(yellow))
}

/// Returns the nearest whole second; a half is rounded up.
pub fn nearest_s(seconds: f64) -> u32 {
    (seconds + ROUNDING_S).round().max(0.0) as u32
}

/// Returns when every phase is green if each lasts its split, and the cycle, seconds. The last phase of a ring lasts until
/// the barrier.
pub fn schedule(plan: &ExistingPlan) -> (Vec<Timed>, u32) {
    let nothing = Timed { begin_s: 0, green_s: 0, yellow_s: 0, all_red_s: 0 };
    let mut timed = vec![nothing; plan.phases.len()];
    let mut side_begins_s = 0.0;
    for side in plan.sides() {
        let sum = |ring: &Vec<usize>| ring.iter().map(|i| plan.phases[*i].split_s()).sum::<f64>();
        let side_ends_s = side_begins_s + sum(&side[0]).max(sum(&side[1]));
        for ring in &side {
            let mut begins_s = side_begins_s;
            for (place, index) in ring.iter().enumerate() {
                let phase = &plan.phases[*index];
                let is_last = place + 1 == ring.len();
                let ends_s = if is_last { side_ends_s } else { begins_s + phase.split_s() };
                let (yellow_s, all_red_s) = change_s(phase.yellow_s, phase.all_red_s);
                let (begin_s, end_s) = (nearest_s(begins_s), nearest_s(ends_s));
                let green_s = (end_s - begin_s).saturating_sub(yellow_s + all_red_s);
                timed[*index] = Timed { begin_s, green_s, yellow_s, all_red_s };
                begins_s = ends_s;
            }
        }
        side_begins_s = side_ends_s;
    }
    (timed, nearest_s(side_begins_s))
}

#[cfg(test)]
mod tests {
    use super::super::Control;
    use super::super::testing::plan;
    use super::*;

    #[test]
    fn yellow_is_rounded_up_and_both_together_once() {
        assert_eq!(change_s(3.5, 1.0), (4, 1));
        assert_eq!(change_s(3.6, 1.4), (4, 1));
        assert_eq!(change_s(4.3, 1.2), (5, 1));
        assert_eq!(change_s(3.0, 0.0), (3, 0));
        assert_eq!(change_s(4.1, 1.1), (5, 1));
    }

    #[test]
    fn starts_are_rounded_and_the_cycle_does_not_drift() {
        // Splits of 12.5, 24.5 and 24.5 s: starts at 0, 12.5 and 37 s, cycle 61.5 s.
        let (timed, cycle_s) = schedule(&plan(Control::Pretimed));
        let of = |i: usize| (timed[i].begin_s, timed[i].green_s);
        assert_eq!([of(0), of(1), of(2)], [(0, 8), (13, 19), (37, 20)]);
        assert_eq!((of(3), of(4), of(5), cycle_s), (of(0), of(1), of(2), 62));
    }

    #[test]
    fn the_last_phase_of_a_ring_lasts_until_the_barrier() {
        let mut plan = plan(Control::Pretimed);
        plan.phases.remove(3);
        let (timed, _) = schedule(&plan);
        // Phase 6 alone in ring 2: 37 s without its change of 5 s.
        assert_eq!((timed[3].begin_s, timed[3].green_s), (0, 32));
    }
}
