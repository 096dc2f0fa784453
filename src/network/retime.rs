//! The default program of a network: netconvert's greens, within the limits that hold for every method.
//!
//! The cycle stays as long as the settings say. Left-turn phases get their green from the settings, the
//! others share what yellow and all-red leave, in netconvert's proportions, and none gets less than its
//! least or more than its longest green; only then is the cycle another one.

use super::intersection::IntersectionSpec;
use super::lanes::Layout;
use super::movements::Turn;
use super::phases::ProgramPhase;
use super::plain::LANE_WIDTH_M;
use crate::control;
use crate::family::scenario::{NetworkSettings, SignalSettings};
use crate::timing::{Approach, Timing, Way};

/// Returns the limits of an intersection's signal.
///
/// # Arguments
///
/// * `movement_of_link` — shape `[L]`; per link of the signal the index of its movement.
pub fn timing(
    spec: &IntersectionSpec,
    layout: &Layout,
    movement_of_link: &[usize],
    settings: &SignalSettings,
) -> Timing {
    let incoming: Vec<usize> =
        (0..spec.arms.len()).filter(|i| spec.arms[*i].lanes_in > 0).collect();
    let approach = |i: &usize| Approach {
        heading_deg: spec.arms[*i].bearing_deg + 180.0,
        width_m: LANE_WIDTH_M * f64::from(spec.arms[*i].lanes_in + layout.exit_lanes[*i]),
        speed_mps: spec.arms[*i].speed_mps,
    };
    let way = |m: &usize| {
        let movement = &layout.movements[*m];
        let approach = incoming.iter().position(|i| *i == movement.from);
        let turn = match movement.turn {
            Turn::Left => control::Turn::Left,
            Turn::Through => control::Turn::Through,
            Turn::Right => control::Turn::Right,
        };
        vec![Way { approach: approach.expect("movements come from incoming arms"), turn }]
    };
    let links = movement_of_link.iter().map(way).collect();
    Timing::new(settings, incoming.iter().map(approach).collect(), links)
}

/// Returns netconvert's program within the limits.
pub fn retime(
    own: &[ProgramPhase],
    timing: &Timing,
    settings: &NetworkSettings,
) -> Vec<ProgramPhase> {
    let greens: Vec<&ProgramPhase> = own.iter().filter(|p| !p.state.contains('y')).collect();
    let between =
        |i: usize| timing.between(&greens[i].state, &greens[(i + 1) % greens.len()].state);
    let changes: Vec<Vec<(String, u32)>> = (0..greens.len()).map(between).collect();
    let lost_s: u32 = changes.iter().flatten().map(|(_, seconds)| seconds).sum();
    let (shortest_s, longest_s) = timing.cycle_s();
    let cycle_s =
        (settings.default_cycle_s.round() as u32).clamp(shortest_s, longest_s.max(shortest_s));
    let durations = durations(&greens, timing, settings, cycle_s.saturating_sub(lost_s));
    let mut program = Vec::new();
    for ((green, duration_s), change) in greens.iter().zip(durations).zip(changes) {
        program.push(ProgramPhase { duration_s, state: green.state.clone() });
        program.extend(
            change
                .into_iter()
                .map(|(state, seconds)| ProgramPhase { duration_s: f64::from(seconds), state }),
        );
    }
    program
}

/// Returns the green of every phase, whole seconds, that together fill `total_s`, as far as the limits
/// allow.
fn durations(
    greens: &[&ProgramPhase],
    timing: &Timing,
    settings: &NetworkSettings,
    total_s: u32,
) -> Vec<f64> {
    let within = |green: &ProgramPhase, seconds: f64| {
        let least_s = f64::from(timing.min_green_s(&green.state));
        seconds.clamp(least_s, timing.max_green_s(&green.state).map_or(f64::INFINITY, f64::from))
    };
    let is_left = |green: &&&ProgramPhase| timing.is_left_only(&green.state);
    let left_s = settings.default_left_green_s.round();
    let lefts_s: f64 = greens.iter().filter(is_left).map(|g| within(g, left_s)).sum();
    let mut rest_s = (f64::from(total_s) - lefts_s).max(0.0);
    let mut weight: f64 = greens.iter().filter(|g| !is_left(g)).map(|g| g.duration_s).sum();
    greens
        .iter()
        .map(|green| {
            if is_left(&green) {
                return within(green, left_s);
            }
            // What rounding and limits leave over goes to the phases that follow.
            let share_s = (rest_s * green.duration_s / weight).round();
            let green_s = within(green, share_s);
            weight -= green.duration_s;
            rest_s = (rest_s - green_s).max(0.0);
            green_s
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::lanes::layout;
    use super::super::movements::shapes::cross;
    use super::*;
    use crate::family::scenario::ChangeInterval;

    fn phase(duration_s: f64, state: &str) -> ProgramPhase {
        ProgramPhase { duration_s, state: state.into() }
    }

    /// What netconvert gives four arms with left-only lanes, links by movement.
    fn own(yellow_s: f64) -> Vec<ProgramPhase> {
        let through_s = 39.0 - 2.0 * yellow_s;
        vec![
            phase(through_s, "gGGrrrgGGrrr"),
            phase(yellow_s, "gyyrrrgyyrrr"),
            phase(6.0, "GrrrrrGrrrrr"),
            phase(yellow_s, "yrrrrryrrrrr"),
            phase(through_s, "rrrgGGrrrgGG"),
            phase(yellow_s, "rrrgyyrrrgyy"),
            phase(6.0, "rrrGrrrrrGrr"),
            phase(yellow_s, "rrryrrrrryrr"),
        ]
    }

    fn retimed(own: &[ProgramPhase], settings: &SignalSettings) -> Vec<ProgramPhase> {
        let spec = cross();
        let layout = layout(&spec).unwrap();
        let links: Vec<usize> = (0..12).collect();
        retime(own, &timing(&spec, &layout, &links, settings), &NetworkSettings::default())
    }

    fn greens(program: &[ProgramPhase]) -> Vec<f64> {
        let green = |p: &&ProgramPhase| p.state.contains('G') && !p.state.contains('y');
        program.iter().filter(green).map(|p| p.duration_s).collect()
    }

    #[test]
    fn a_program_that_keeps_to_the_limits_stays_as_netconvert_made_it() {
        let settings = SignalSettings { min_left_green_s: 6, ..SignalSettings::default() };
        assert_eq!(retimed(&own(3.0), &settings), own(3.0));
    }

    #[test]
    fn the_cycle_stays_when_yellow_and_left_greens_change() {
        let program = retimed(&own(4.0), &SignalSettings::default());
        assert_eq!(greens(&program), [32.0, 7.0, 32.0, 7.0]);
        assert_eq!(program.iter().map(|p| p.duration_s).sum::<f64>(), 90.0);
        assert_eq!(program[1], phase(3.0, "gyyrrrgyyrrr"));
    }

    #[test]
    fn shortest_greens_make_the_cycle_longer_and_longest_ones_shorter() {
        let settings = SignalSettings { min_green_s: 50, ..SignalSettings::default() };
        assert_eq!(greens(&retimed(&own(3.0), &settings)), [50.0, 7.0, 50.0, 7.0]);
        let settings = SignalSettings { max_green_s: Some(20), ..SignalSettings::default() };
        assert_eq!(greens(&retimed(&own(3.0), &settings)), [20.0, 7.0, 20.0, 7.0]);
    }

    #[test]
    fn all_red_follows_every_yellow() {
        let settings = SignalSettings {
            change_interval: ChangeInterval::Kinematic,
            all_red_s: 1,
            ..SignalSettings::default()
        };
        let program = retimed(&own(3.0), &settings);
        assert_eq!(program[1], phase(4.0, "gyyrrrgyyrrr"));
        assert_eq!(program[2], phase(1.0, "grrrrrgrrrrr"));
        assert_eq!(program.iter().map(|p| p.duration_s).sum::<f64>(), 90.0);
    }
}
