//! The default program of a network: netconvert's greens, within the limits that hold for every method.
//!
//! The cycle stays as long as the settings say. Left-turn phases get their green from the settings, the
//! others share what yellow and all-red leave, in netconvert's proportions. No phase gets less than its
//! least or more than its longest green; where these do not fit, the cycle is another one. Yellow and
//! all-red are ours: netconvert's, which it gives wide and slow junctions, are left out.

use super::intersection::{Arm, IntersectionSpec};
use super::lanes::LaneLayout;
use super::plain::LANE_WIDTH_M;
use crate::control::webster::fill;
use crate::program::ProgramPhase;
use crate::settings::{NetworkSettings, SignalSettings};
use crate::timing::{Approach, Timing, Way, has_unopposed};

/// Returns the limits of an intersection's signal.
/// * `movement_of_link` — shape `[L]`; per link of the signal the index of its movement.
pub fn timing(
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    movement_of_link: &[usize],
    settings: &SignalSettings,
) -> Timing {
    let incoming: Vec<usize> =
        (0..spec.arms.len()).filter(|i| spec.arms[*i].lanes_in > 0).collect();
    let approach = |i: &usize| Approach {
        heading_deg: spec.arms[*i].bearing_deg + 180.0,
        width_m: LANE_WIDTH_M * f64::from(spec.arms[*i].lanes_in + layout.exit_lanes[*i]),
        plain_lanes: spec.arms[*i].lanes_in + layout.exit_lanes[*i],
        speed_mps: spec.arms[*i].speed_mps,
    };
    let way = |m: &usize| {
        let movement = &layout.movements[*m];
        let approach = incoming.iter().position(|i| *i == movement.from);
        let approach = approach.expect("movements come from incoming arms");
        vec![Way { approach, turn: movement.turn }]
    };
    let links = movement_of_link.iter().map(way).collect();
    let settings =
        SignalSettings { pedestrian_calls_per_h: buttons(spec, settings), ..settings.clone() };
    Timing::new(&settings, incoming.iter().map(approach).collect(), links)
}

/// Returns the push buttons that the default program depends on: `None` but where an approach without an opposite one
/// has an arrow because people push them. Elsewhere fixed cycles let pedestrians cross every time.
pub fn buttons(spec: &IntersectionSpec, settings: &SignalSettings) -> Option<f64> {
    let incoming = spec.arms.iter().filter(|arm| arm.lanes_in > 0);
    let headings_deg: Vec<f64> = incoming.map(|arm| arm.bearing_deg + 180.0).collect();
    let walks = |arm: &Arm| arm.counted.is_some_and(|counted| counted.pedestrians_per_h.is_some());
    let pushes = settings.pedestrian_calls_per_h.is_some() || spec.arms.iter().any(walks);
    (settings.pedestrians && pushes && has_unopposed(&headings_deg)).then_some(0.0)
}

/// Returns netconvert's program within the limits.
pub fn within_limits(
    own: &[ProgramPhase],
    timing: &Timing,
    settings: &NetworkSettings,
) -> Vec<ProgramPhase> {
    let greens = greens(own, timing);
    let next = |i: usize| &greens[(i + 1) % greens.len()].state;
    let changes: Vec<Vec<(String, u32)>> =
        (0..greens.len()).map(|i| timing.between(&greens[i].state, next(i))).collect();
    let lost_s: u32 = changes.iter().flatten().map(|(_, seconds)| seconds).sum();
    let cycle_s = cycle_s(settings, (timing.settings.min_cycle_s, timing.settings.max_cycle_s));
    let durations = durations(&greens, timing, settings, cycle_s.saturating_sub(lost_s));
    let mut program = Vec::new();
    for ((green, duration_s), change) in greens.iter().zip(durations).zip(changes) {
        program.push(ProgramPhase::fixed(&green.state, duration_s));
        program.extend(
            change
                .into_iter()
                .map(|(state, seconds)| ProgramPhase::fixed(state, f64::from(seconds))),
        );
    }
    program
}

/// Returns the cycle of a program, seconds, within the shortest and the longest one.
pub fn cycle_s(settings: &NetworkSettings, (shortest_s, longest_s): (u32, u32)) -> u32 {
    (settings.default_cycle_s.round() as u32).clamp(shortest_s, longest_s.max(shortest_s))
}

/// Returns the greens of a program; equal ones that follow each other, such as those of a signal that has
/// nothing to decide, are one. netconvert would make them one later.
fn greens(own: &[ProgramPhase], timing: &Timing) -> Vec<ProgramPhase> {
    let phases: Vec<_> = own.iter().map(|p| (p.state.as_str(), p.duration_s)).collect();
    let mut greens: Vec<ProgramPhase> = Vec::new();
    for phase in timing.greens(&phases).into_iter().map(|i| &own[i]) {
        match greens.last_mut() {
            Some(last) if last.state == phase.state => last.duration_s += phase.duration_s,
            _ => greens.push(phase.clone()),
        }
    }
    if greens.len() > 1 && greens[0].state == greens[greens.len() - 1].state {
        let last = greens.pop().expect("there are two");
        greens[0].duration_s += last.duration_s;
    }
    greens
}

/// Returns the green of every phase, whole seconds, that together fill `total_s`, as far as the limits
/// allow.
fn durations(
    greens: &[ProgramPhase],
    timing: &Timing,
    settings: &NetworkSettings,
    total_s: u32,
) -> Vec<f64> {
    let left_s = settings.default_left_green_s.round();
    let mut least = Vec::new();
    let mut most = Vec::new();
    let states: Vec<&str> = greens.iter().map(|green| green.state.as_str()).collect();
    for (green, low) in greens.iter().zip(timing.least_greens_s(&states)) {
        let low = f64::from(low);
        let high = timing.max_green_s(&green.state).map_or(f64::INFINITY, f64::from);
        let is_left = timing.is_left_only(&green.state);
        let left_s = left_s.clamp(low, high);
        least.push(if is_left { left_s } else { low });
        most.push(if is_left { left_s } else { high });
    }
    let wanted: Vec<f64> = greens.iter().map(|g| g.duration_s).collect();
    fill(&wanted, &least, &most, f64::from(total_s))
}

#[cfg(test)]
mod tests {
    use super::super::lanes::layout;
    use super::super::movements::shapes::cross;
    use super::*;
    use crate::settings::ChangeInterval;

    fn phase(duration_s: f64, state: &str) -> ProgramPhase {
        ProgramPhase::fixed(state, duration_s)
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
        within_limits(own, &timing(&spec, &layout, &links, settings), &NetworkSettings::default())
    }

    fn greens_of(program: &[ProgramPhase]) -> Vec<f64> {
        let green = |p: &&ProgramPhase| p.state.contains('G') && !p.state.contains('y');
        program.iter().filter(green).map(|p| p.duration_s).collect()
    }

    #[test]
    fn a_program_that_keeps_to_the_limits_stays_as_netconvert_made_it() {
        let settings = SignalSettings { min_left_green_s: 6, ..SignalSettings::default() };
        assert_eq!(retimed(&own(3.0), &settings), own(3.0));
        // Its own all-red is no phase.
        let mut with_red = own(3.0);
        with_red.insert(2, phase(1.0, "grrrrrgrrrrr"));
        with_red.insert(5, phase(1.0, "rrrrrrrrrrrr"));
        assert_eq!(retimed(&with_red, &settings), own(3.0));
    }

    #[test]
    fn the_cycle_stays_when_yellow_and_left_greens_change() {
        let program = retimed(&own(4.0), &SignalSettings::default());
        assert_eq!(greens_of(&program), [32.0, 7.0, 32.0, 7.0]);
        assert_eq!(program.iter().map(|p| p.duration_s).sum::<f64>(), 90.0);
        assert_eq!(program[1], phase(3.0, "gyyrrrgyyrrr"));
        let settings = SignalSettings { min_left_green_s: 20, ..SignalSettings::default() };
        assert_eq!(greens_of(&retimed(&own(3.0), &settings)), [19.0, 20.0, 19.0, 20.0]);
    }

    #[test]
    fn shortest_greens_make_the_cycle_longer_and_longest_ones_shorter() {
        let settings = SignalSettings { min_green_s: 50, ..SignalSettings::default() };
        assert_eq!(greens_of(&retimed(&own(3.0), &settings)), [50.0, 7.0, 50.0, 7.0]);
        let settings = SignalSettings { max_green_s: Some(20), ..SignalSettings::default() };
        assert_eq!(greens_of(&retimed(&own(3.0), &settings)), [20.0, 7.0, 20.0, 7.0]);
    }

    #[test]
    fn equal_greens_in_a_row_are_one() {
        let timing = Timing::new(&SignalSettings::default(), vec![], vec![]);
        let program = [phase(45.0, "GGGG"), phase(45.0, "GGGG")];
        assert_eq!(greens(&program, &timing), [phase(90.0, "GGGG")]);
        let program = [phase(20.0, "Gr"), phase(3.0, "yr"), phase(30.0, "rG"), phase(10.0, "Gr")];
        assert_eq!(greens(&program, &timing), [phase(30.0, "Gr"), phase(30.0, "rG")]);
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
