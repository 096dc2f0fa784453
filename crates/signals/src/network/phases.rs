//! The phases that controllers choose from, for any number of arms.
//!
//! For every pair of opposing approaches, those whose through movements lead to each other: both
//! through, both left if both have left-only lanes, then each of the two alone if it has a through
//! and a left movement and no lane that both share. (Where they share lanes, through and left go
//! together anyway, and a phase for one approach alone would waste half of the junction.) An approach
//! without an opposite is always served alone. For four equal arms with left-only lanes this gives
//! RESCO's eight pairs in RESCO's order, and two without.
//!
//! Choices where implementations differ:
//! - **Left turns** are also green in their own through phase, and yield there where they conflict
//!   with the opposing approach.
//!   With `signal.left_turns` they are green there if they may yield, and alone or together if they have an arrow;
//!   see [`left_turns`](super::left_turns).
//! - **Right turns** are green with their own through movement, and in every phase in which they
//!   conflict with no green movement, as in netconvert's own programs. Whether they may go on red
//!   does not change what is green, see [`on_red`].
//! - **Pointless phases** that give no movement more than another phase does are left out.
//! - **Yellow** depends on the next phase in the list: links that are green in both stay green.
//!
//! Source: RESCO (Ault and Sharon, NeurIPS 2021), eight phase pairs of its full four-way signals.

use osm_signals::Turn;
use osm_signals::angle::normalise_degrees;

use super::intersection::IntersectionSpec;
use super::lanes::{LaneLayout, turns_left_from_its_own_lanes};
use super::movements::opposite;
use crate::junction::{Conflicts, Movement};
use crate::program::ProgramPhase;
use crate::settings::{LeftTurns, NetworkSettings};
use crate::vocabulary::{self, Light};

/// Program id of these phases in a network.
pub const PHASES_PROGRAM: &str = "phases";

/// Yellow in the listing of phases, seconds; controllers have their own.
const YELLOW_S: f64 = 3.0;

/// Bearing from which RESCO's order of single approaches counts clockwise, degrees.
const WEST_DEG: f64 = 270.0;

/// One green phase: a light per movement, in the order of [`LaneLayout::movements`].
pub type Lights = Vec<Light>;

/// Returns the green phases of an intersection; every movement is green in one of them.
/// * `lefts` — how the left turns of every arm are signalled, where that is set.
pub fn phases(
    spec: &IntersectionSpec,
    layout: &LaneLayout,
    conflicts: &Conflicts,
    lefts: Option<&[LeftTurns]>,
) -> Vec<Lights> {
    let has_arrow = |arm: &usize| lefts.is_none_or(|lefts| lefts[*arm].has_arrow());
    let all = &layout.movements;
    let mut phases: Vec<Lights> = Vec::new();
    for arm in 0..spec.arms.len() {
        match opposite(all, arm) {
            Some(other) if other < arm => {}
            Some(other) if is_split(layout, lefts, [arm, other]) => {
                phases.extend([arm, other].map(|arm| alone(all, conflicts, arm)));
            }
            Some(other) => {
                phases.push(through_phase(all, conflicts, [arm, other], lefts));
                if [arm, other].iter().all(has_arrow) {
                    phases.extend(left_phase(layout, conflicts, [arm, other]));
                }
                let mut order = [arm, other];
                order.sort_by(|a, b| {
                    let from_west =
                        |i: usize| normalise_degrees(spec.arms[i].bearing_deg - WEST_DEG);
                    from_west(*a).total_cmp(&from_west(*b))
                });
                let apart = |i: &usize| turns_left_from_its_own_lanes(layout, *i) && has_arrow(i);
                phases.extend(order.into_iter().filter(apart).map(|i| alone(all, conflicts, i)));
            }
            None if all.iter().any(|m| m.from == arm) => phases.push(alone(all, conflicts, arm)),
            None => {}
        }
    }
    serve_all(&mut phases, all, conflicts);
    let covers = |a: &Lights, b: &Lights| a.iter().zip(b).all(|(a, b)| a >= b);
    let pointless = |i: usize| {
        let better = |j: usize| covers(&phases[j], &phases[i]) && (j < i || phases[j] != phases[i]);
        (0..phases.len()).filter(|&j| j != i).any(better)
    };
    (0..phases.len()).filter(|&i| !pointless(i)).map(|i| phases[i].clone()).collect()
}

/// Adds the approaches alone of which a movement has no green.
fn serve_all(phases: &mut Vec<Lights>, all: &[Movement], conflicts: &Conflicts) {
    for i in 0..all.len() {
        if phases.iter().all(|p| p[i] == Light::Red) {
            phases.push(alone(all, conflicts, all[i].from));
        }
    }
}

/// Returns greens of a program in which left turns are signalled as it is set, each with whether it is a stage for left
/// turns. Nothing changes but the streets of which both approaches lead to each other. There the left turns yield or
/// wait beside the through movements, and those of both approaches that have an arrow come after, as netconvert has
/// them. The arrow of one approach alone comes before, with its through movement, because after it the left turns of
/// the other one would have yellow beside the green of those to whom they yield.
/// * `own` — netconvert's greens.
pub fn stages(
    own: &[Lights],
    layout: &LaneLayout,
    conflicts: &Conflicts,
    lefts: &[LeftTurns],
) -> Vec<(Lights, bool)> {
    let all = &layout.movements;
    let is_green = |lights: &Lights, arm: usize, turn: Turn| {
        of(all, arm, turn).any(|i| lights[i] != Light::Red)
    };
    let mut stages: Vec<(Lights, bool)> = own.iter().map(|own| (own.clone(), false)).collect();
    for arm in 0..lefts.len() {
        let Some(other) = opposite(all, arm).filter(|other| *other > arm) else { continue };
        let pair = [arm, other];
        let serves_both =
            |(lights, _): &(Lights, bool)| pair.iter().all(|a| is_green(lights, *a, Turn::Through));
        if !stages.iter().any(serves_both) {
            continue;
        }
        let is_arrow = |stage: &(Lights, bool)| {
            let own = |i: usize| all[i].turn == Turn::Right || pair.contains(&all[i].from);
            let alone = (0..all.len()).all(|i| stage.0[i] == Light::Red || own(i));
            alone && !serves_both(stage) && pair.iter().any(|a| is_green(&stage.0, *a, Turn::Left))
        };
        stages.retain(|stage| !is_arrow(stage));
        let place = stages.iter().position(serves_both).expect("that stage is no arrow's");
        if is_split(layout, Some(lefts), pair) {
            let apart = pair.map(|arm| (alone(all, conflicts, arm), false));
            drop(stages.splice(place..=place, apart));
            continue;
        }
        for i in pair.into_iter().flat_map(|arm| of(all, arm, Turn::Left)) {
            let lights = &mut stages[place].0;
            lights[i] = Light::Red;
            if lefts[all[i].from] != LeftTurns::Protected {
                lights[i] = conflicts.best_light(lights, i);
            }
        }
        let has_arrow = |arm: &usize| lefts[*arm].has_arrow();
        match left_phase(layout, conflicts, pair).filter(|_| pair.iter().all(has_arrow)) {
            Some(left) => stages.insert(place + 1, (left, true)),
            None => {
                let arrows = pair.into_iter().filter(has_arrow);
                let arrows = arrows.map(|arm| (alone(all, conflicts, arm), true));
                drop(stages.splice(place..place, arrows.collect::<Vec<_>>()));
            }
        }
    }
    let mut greens = stages.iter().map(|(lights, _)| lights.clone()).collect::<Vec<_>>();
    serve_all(&mut greens, all, conflicts);
    let left_over = greens.split_off(stages.len());
    stages.extend(left_over.into_iter().map(|lights| (lights, false)));
    stages
}

/// Whether an approach of a street has protected left turns from a lane that goes through, so that each is served alone.
fn is_split(layout: &LaneLayout, lefts: Option<&[LeftTurns]>, pair: [usize; 2]) -> bool {
    let is = |arm: usize| {
        let is_protected = lefts.is_some_and(|lefts| lefts[arm] == LeftTurns::Protected);
        let turns_left = of(&layout.movements, arm, Turn::Left).next().is_some();
        is_protected && turns_left && !turns_left_from_its_own_lanes(layout, arm)
    };
    pair.into_iter().any(is)
}

/// Returns the indices of one approach's movements of one category.
fn of(all: &[Movement], from: usize, turn: Turn) -> impl Iterator<Item = usize> {
    all.iter().enumerate().filter(move |(_, m)| m.from == from && m.turn == turn).map(|(i, _)| i)
}

fn through_phase(
    all: &[Movement],
    conflicts: &Conflicts,
    pair: [usize; 2],
    lefts: Option<&[LeftTurns]>,
) -> Lights {
    let mut lights = vec![Light::Red; all.len()];
    let waits = |arm: usize| lefts.is_some_and(|lefts| lefts[arm] == LeftTurns::Protected);
    for turn in [Turn::Through, Turn::Right, Turn::Left] {
        let arms = pair.into_iter().filter(|arm| turn != Turn::Left || !waits(*arm));
        for i in arms.flat_map(|arm| of(all, arm, turn)) {
            lights[i] = conflicts.best_light(&lights, i);
        }
    }
    with_free_rights(all, conflicts, lights)
}

fn left_phase(layout: &LaneLayout, conflicts: &Conflicts, pair: [usize; 2]) -> Option<Lights> {
    let all = &layout.movements;
    let mut lights = vec![Light::Red; all.len()];
    for arm in pair {
        let mut lefts = of(all, arm, Turn::Left).peekable();
        lefts.peek()?;
        for i in lefts {
            if layout.left_only_lanes[arm] == 0
                || conflicts.best_light(&lights, i) != Light::Protected
            {
                return None;
            }
            lights[i] = Light::Protected;
        }
    }
    Some(with_free_rights(all, conflicts, lights))
}

fn alone(all: &[Movement], conflicts: &Conflicts, arm: usize) -> Lights {
    let light = |m: &Movement| if m.from == arm { Light::Protected } else { Light::Red };
    with_free_rights(all, conflicts, all.iter().map(light).collect())
}

/// Adds the right turns that conflict with no green movement.
fn with_free_rights(all: &[Movement], conflicts: &Conflicts, mut lights: Lights) -> Lights {
    for i in 0..all.len() {
        let waits = all[i].turn == Turn::Right && lights[i] == Light::Red;
        if waits && conflicts.best_light(&lights, i) == Light::Protected {
            lights[i] = Light::Protected;
        }
    }
    lights
}

/// Returns the program that serves the phases in turn, each followed by its yellow.
/// * `links` — shape `[L]`; per link of the signal the index of its movement.
pub fn program(
    phases: &[Lights],
    links: &[usize],
    settings: &NetworkSettings,
) -> Vec<ProgramPhase> {
    let mut program = Vec::new();
    for (i, phase) in phases.iter().enumerate() {
        let next = &phases[(i + 1) % phases.len()];
        let green: String = links.iter().map(|&m| phase[m].letter()).collect();
        let ends = |m: usize| phase[m] != Light::Red && next[m] == Light::Red;
        let yellow: String =
            links.iter().map(|&m| if ends(m) { 'y' } else { phase[m].letter() }).collect();
        program.push(ProgramPhase::fixed(green, settings.phase_green_s));
        if yellow.contains('y') {
            program.push(ProgramPhase::fixed(yellow, YELLOW_S));
        }
    }
    program
}

/// Returns a program in which vehicles may turn on red.
///
/// Source: MUTCD (2009), section 4D.04, steady circular red: a right turn after stopping, unless a sign
/// forbids it. Deviation: the left turn from a one-way street into another one, which most states allow
/// too, is left out; and of several lanes or links that turn right and meet, only the rightmost and the first may.
/// * `may` — shape `[L]`; whether vehicles of a link may.
/// * `meet` — whether the paths of two links meet.
pub fn on_red(
    program: Vec<ProgramPhase>,
    may: &[bool],
    meet: &dyn Fn(usize, usize) -> bool,
) -> Vec<ProgramPhase> {
    let state = |state: &str| vocabulary::on_red(state, may, meet);
    program.into_iter().map(|p| ProgramPhase { state: state(&p.state), ..p }).collect()
}

#[cfg(test)]
mod tests {
    use osm_signals::Turns;

    use super::super::lanes::layout;
    use super::super::movements::shapes::{cross, spec, star, tee, wye};
    use super::*;

    /// Per phase the state with one letter per movement: by arm, from left to right.
    fn states(spec: &IntersectionSpec) -> Vec<String> {
        phases_of(spec).iter().map(|p| p.iter().map(|l| l.letter()).collect()).collect()
    }

    fn phases_of(spec: &IntersectionSpec) -> Vec<Lights> {
        let layout = layout(spec).unwrap();
        phases(spec, &layout, &Conflicts::of(&layout.movements), None)
    }

    fn with_left_lanes() -> IntersectionSpec {
        let mut s = cross();
        for arm in &mut s.arms {
            arm.left_turn_lanes = 1;
        }
        s
    }

    /// What netconvert makes of four arms or a T: every street, and the left turns of those that have lanes for them.
    fn netconvert_s(spec: &IntersectionSpec) -> Vec<Lights> {
        let layout = layout(spec).unwrap();
        let conflicts = Conflicts::of(&layout.movements);
        let pairs = phases(spec, &layout, &conflicts, None);
        let lefts = [LeftTurns::ProtectedPermissive; 4];
        let opposed = |arm: usize| opposite(&layout.movements, arm).is_some();
        let street = |arm: usize| match opposite(&layout.movements, arm) {
            Some(other) => through_phase(&layout.movements, &conflicts, [arm, other], Some(&lefts)),
            None => alone(&layout.movements, &conflicts, arm),
        };
        let arms = [0, 1];
        let arrows = pairs.into_iter().filter(|lights| {
            let through = |i: usize| layout.movements[i].turn == Turn::Through;
            (0..lights.len()).all(|i| !through(i) || lights[i] == Light::Red) && opposed(1)
        });
        arms.map(street).into_iter().chain(arrows).collect()
    }

    /// What is wrong with greens, in words: movements of right of way that meet, and left turns that are signalled
    /// otherwise than they should be.
    fn wrong(all: &[Movement], greens: &[Lights], lefts: &[LeftTurns]) -> Vec<String> {
        let mut wrong = Vec::new();
        for lights in greens {
            for (i, a) in all.iter().enumerate() {
                let beside = |j: usize| lights[j] != Light::Red && a.conflicts_with(&all[j]);
                let met: Vec<usize> = (0..all.len()).filter(|j| beside(*j)).collect();
                if lights[i] == Light::Protected
                    && met.iter().any(|j| lights[*j] == Light::Protected)
                {
                    wrong.push(format!("{i} has right of way beside {met:?}"));
                }
                if lights[i] == Light::Permissive && a.turn == Turn::Through {
                    wrong.push(format!("{i} goes straight on and yields"));
                }
                if a.turn == Turn::Left && opposite(all, a.from).is_some() {
                    let is_wrong = match lefts[a.from] {
                        LeftTurns::Permissive => lights[i] == Light::Protected,
                        LeftTurns::Protected => lights[i] == Light::Permissive,
                        _ => false,
                    };
                    if is_wrong {
                        wrong.push(format!("{i} is {:?} under {:?}", lights[i], lefts[a.from]));
                    }
                }
            }
        }
        let dark = |i: &usize| greens.iter().all(|lights| lights[*i] == Light::Red);
        wrong.extend((0..all.len()).filter(dark).map(|i| format!("{i} is never green")));
        wrong
    }

    #[test]
    fn left_turns_are_signalled_as_they_are_set_and_nobody_meets() {
        use LeftTurns::{Permissive, Protected, ProtectedPermissive};
        let mut tee = tee();
        tee.arms.iter_mut().for_each(|arm| arm.left_turn_lanes = 1);
        for spec in [with_left_lanes(), tee] {
            let layout = layout(&spec).unwrap();
            let (all, conflicts) = (&layout.movements, Conflicts::of(&layout.movements));
            for first in [Permissive, Protected, ProtectedPermissive] {
                for other in [Permissive, Protected, ProtectedPermissive] {
                    // Of a T the stem has no opposing approach, and the arm beside it no left turn.
                    let lefts = [first, Permissive, other, Permissive];
                    let program = stages(&netconvert_s(&spec), &layout, &conflicts, &lefts);
                    let program: Vec<Lights> = program.into_iter().map(|s| s.0).collect();
                    let pairs = phases(&spec, &layout, &conflicts, Some(&lefts));
                    for greens in [&program, &pairs] {
                        let wrong = wrong(all, greens, &lefts);
                        assert_eq!(wrong, [""; 0], "{first:?}, {other:?}: {greens:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_street_whose_left_turns_share_a_lane_with_others_is_served_one_approach_after_the_other() {
        let mut spec = with_left_lanes();
        (spec.arms[0].lanes_in, spec.arms[0].shared_left) = (4, true);
        let layout = layout(&spec).unwrap();
        let (conflicts, mut lefts) = (Conflicts::of(&layout.movements), [LeftTurns::Permissive; 4]);
        lefts[0] = LeftTurns::Protected;
        let program = stages(&netconvert_s(&spec), &layout, &conflicts, &lefts);
        for greens in [
            program.into_iter().map(|s| s.0).collect(),
            phases(&spec, &layout, &conflicts, Some(&lefts)),
        ] {
            let green = |l: &&Lights| [1, 7].map(|m: usize| l[m] != Light::Red) == [true; 2];
            assert_eq!(greens.iter().filter(green).count(), 0, "{greens:?}");
            assert_eq!(
                wrong(&layout.movements, &greens, &[LeftTurns::ProtectedPermissive; 4]),
                [""; 0]
            );
        }
    }

    #[test]
    fn a_planted_conflict_is_found() {
        let spec = with_left_lanes();
        let layout = layout(&spec).unwrap();
        let conflicts = Conflicts::of(&layout.movements);
        let lefts = [LeftTurns::Protected; 4];
        let stages = stages(&netconvert_s(&spec), &layout, &conflicts, &lefts);
        let mut greens: Vec<Lights> = stages.into_iter().map(|s| s.0).collect();
        assert_eq!(greens.len(), 4);
        assert_eq!(wrong(&layout.movements, &greens, &lefts), [""; 0]);
        // The left turn of the first arm beside the opposing through movement, and one that yields.
        greens[0][0] = Light::Protected;
        let found = wrong(&layout.movements, &greens, &lefts).join(", ");
        assert!(found.contains("0 has right of way beside"), "{found}");
        greens[0][0] = Light::Permissive;
        let found = wrong(&layout.movements, &greens, &lefts).join(", ");
        assert!(found.contains("0 is Permissive under Protected"), "{found}");
    }

    #[test]
    fn an_arrow_for_one_approach_comes_before_its_street() {
        let spec = with_left_lanes();
        let layout = layout(&spec).unwrap();
        let mut lefts = [LeftTurns::Permissive; 4];
        lefts[0] = LeftTurns::ProtectedPermissive;
        let stages =
            stages(&netconvert_s(&spec), &layout, &Conflicts::of(&layout.movements), &lefts);
        let letters = |lights: &Lights| lights.iter().map(|l| l.letter()).collect::<String>();
        let shown: Vec<(String, bool)> =
            stages.iter().map(|(l, left)| (letters(l), *left)).collect();
        let of = |state: &str, left| (state.to_owned(), left);
        let expected =
            [of("GGGrrGrrrrrr", true), of("gGGrrrgGGrrr", false), of("rrrgGGrrrgGG", false)];
        assert_eq!(shown, expected);
    }

    #[test]
    fn four_arms_with_left_lanes_have_the_eight_phases_of_resco_in_order() {
        let expected = [
            "gGGrrrgGGrrr", // S-S, N-N
            "GrrrrGGrrrrG", // S-E, N-W
            "GGGrrGrrrrrr", // S-S, S-E
            "rrrrrrGGGrrG", // N-N, N-W
            "rrrgGGrrrgGG", // W-W, E-E
            "rrGGrrrrGGrr", // W-S, E-N
            "rrGrrrrrrGGG", // E-E, E-N
            "rrrGGGrrGrrr", // W-W, W-S
        ];
        assert_eq!(states(&with_left_lanes()), expected);
        // Where left and through share lanes, opposing approaches go together.
        assert_eq!(states(&cross()), ["gGGrrrgGGrrr", "rrrgGGrrrgGG"]);
    }

    #[test]
    fn every_movement_is_green_somewhere_and_protected_greens_do_not_conflict() {
        assert_eq!(states(&star(5)).len(), 5, "equal arms are served one at a time");
        for s in [cross(), with_left_lanes(), tee(), wye(), star(5), star(6), spec(&[0.0, 180.0])] {
            let lefts = [LeftTurns::ProtectedPermissive; 6];
            let wrong = wrong(&layout(&s).unwrap().movements, &phases_of(&s), &lefts);
            assert_eq!(wrong, [""; 0], "{s:?}");
        }
    }

    #[test]
    fn left_turns_that_overlap_within_the_junction_make_no_left_phase() {
        let s = with_left_lanes();
        let layout = layout(&s).unwrap();
        let mut conflicts = Conflicts::of(&layout.movements);
        conflicts.set(0, 6, true);
        conflicts.set(6, 0, true);
        assert_eq!(phases(&s, &layout, &conflicts, None).len(), 7);
    }

    #[test]
    fn a_left_that_would_not_yield_waits_for_its_own_phase() {
        let s = cross();
        let layout = layout(&s).unwrap();
        let mut conflicts = Conflicts::of(&layout.movements);
        conflicts.set(0, 7, false);
        let phases = phases(&s, &layout, &conflicts, None);
        let lights: Vec<_> = phases.iter().map(|p| p[0]).collect();
        assert_eq!(lights, [Light::Red, Light::Red, Light::Protected]);
    }

    #[test]
    fn a_t_and_approaches_that_lack_turns_have_phases_of_their_own() {
        // From the north: left and through; the stem: left and right; from the south: through and right.
        assert_eq!(states(&tee()), ["gGrrGG", "rrGGrG"]);
        let (mut with_lane, mut right_only, mut alone) = (tee(), wye(), cross());
        with_lane.arms[0].left_turn_lanes = 1;
        assert_eq!(states(&with_lane), ["gGrrGG", "GGrGrr", "rrGGrG"]);
        for arm in &mut right_only.arms[..2] {
            arm.turns = Some(Turns { left: false, ..Turns::ALL });
        }
        assert_eq!(states(&right_only), ["GGrG", "GrGG"], "no phase for right turns alone");
        alone.arms[2].turns = Some(Turns { through: false, ..Turns::ALL });
        assert_eq!(states(&alone)[0], "GGGrrGrrrrr", "its opposite does not come through");
    }

    #[test]
    fn yellow_is_for_the_links_that_turn_red_next() {
        let phases = phases_of(&tee());
        let links: Vec<_> = (0..6).collect();
        let program = program(&phases, &links, &NetworkSettings::default());
        let states: Vec<_> = program.iter().map(|p| p.state.as_str()).collect();
        assert_eq!(states, ["gGrrGG", "yyrryG", "rrGGrG", "rryyrG"]);
        assert_eq!((program[0].duration_s, program[1].duration_s), (30.0, 3.0));
    }
}
