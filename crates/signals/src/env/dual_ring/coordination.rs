//! Two rings within a common cycle: the cycle comes as stages of the signal, one after the other.
//!
//! - **Force-off.** The green of a phase ends at the latest when the last stage that serves it does. A stage serves a phase if
//!   all its links are green in it; a left turn's own phase, if they have the right of way.
//! - **Coordinated phases** are the through phases that the stage of the coordinated street serves. They hold their green
//!   until it is over in the cycle (the yield point), and take what the other phases leave.
//! - **The order** of the phases of a ring is that of the stages, so left turns lead or lag as the stages have it.
//! - **A left turn's own phase that no stage serves** is never called if the left turn also yields in a through phase.
//!
//! Where two rings cannot follow the stages, the signal runs them as a fixed cycle.

use osm_signals::Turn;

use super::links::Links;
use super::plan::{Coordination, Phase, Plan};
use crate::program::{ProgramPhase, RingStages};
use crate::timing::Timing;

/// Returns the phases of a signal within this cycle; `None` where two rings cannot follow its stages.
pub(super) fn coordinate(
    stages: &RingStages,
    mut plan: Plan,
    links: &Links,
    timing: &Timing,
    now_s: u32,
) -> Option<Plan> {
    let count = stages.greens.len();
    stages.greens.get(stages.coordinated)?;
    let before = |stage: usize| (stage + count - 1) % count;
    let serve = |phase| served(stages, phase, &plan, links);
    let served: Vec<Vec<bool>> = plan.phases.iter().map(serve).collect::<Option<_>>()?;
    let only_side = |stage: usize| {
        let is_served =
            |side: &usize| plan.sides[*side].iter().flatten().any(|p| served[*p][stage]);
        let mut sides = (0..plan.sides.len()).filter(is_served);
        sides.next().filter(|_| sides.next().is_none())
    };
    let sides: Vec<usize> = (0..count).map(only_side).collect::<Option<_>>()?;
    // Stages with which a side begins, that of the coordinated street first.
    let is_main = |stage: &usize| sides[*stage] == sides[stages.coordinated];
    let mut starts: Vec<usize> =
        (0..count).filter(|stage| sides[*stage] != sides[before(*stage)]).collect();
    let origin = starts.iter().position(is_main)?;
    starts.rotate_left(origin);
    let origin = starts[0];
    if (0..plan.sides.len()).any(|s| starts.iter().filter(|k| sides[**k] == s).count() != 1) {
        return None;
    }
    // Begin and end of the green of each stage, from the first start on, seconds.
    let mut greens_s = vec![[0, 0]; count];
    let mut cycle_s = 0;
    for stage in (origin..origin + count).map(|stage| stage % count) {
        let (green, next) = (&stages.greens[stage], &stages.greens[(stage + 1) % count]);
        greens_s[stage] = [cycle_s, cycle_s + green.duration_s.round() as u32];
        let change_s: u32 = timing.between(&green.state, &next.state).iter().map(|c| c.1).sum();
        cycle_s = greens_s[stage][1] + change_s;
    }
    let of_phase = |served: &Vec<bool>| {
        let own = || (0..count).filter(|stage| served[*stage]).map(|stage| greens_s[stage]);
        Some([own().map(|green| green[0]).min()?, own().map(|green| green[1]).max()?])
    };
    let phases_s: Vec<Option<[u32; 2]>> = served.iter().map(of_phase).collect();
    let holds = plan.phases.iter().zip(&served);
    let holds = holds.map(|(phase, served)| phase.enters && served[stages.coordinated]).collect();
    let (first, mut cycle) = Coordination::new(cycle_s, &phases_s, holds)?;
    let origin_s = stages.offset_s + cycle_s - greens_s[0][0];
    let yields_s = (origin_s + phases_s[first]?[1]) % cycle_s;
    cycle.yields_s = Some(yields_s);
    cycle.begins_s = (now_s % cycle_s + cycle_s - yields_s) % cycle_s;
    plan.sides = starts.iter().map(|start| plan.sides[sides[*start]].clone()).collect();
    for (place, side) in plan.sides.iter_mut().enumerate() {
        let whole_s = starts.get(place + 1).map_or(cycle_s, |next| greens_s[*next][0]);
        for ring in side {
            ring.sort_by_key(|p| phases_s[*p]);
            let mut begin_s = greens_s[starts[place]][0];
            let mut own = ring.iter().filter_map(|p| Some((*p, phases_s[*p]?))).peekable();
            while let Some((p, [_, end_s])) = own.next() {
                let next_s = own.peek().map(|(_, next_s)| next_s[0]);
                let change_s = plan.phases[p].change.total_s();
                let until_s = next_s.map_or(whole_s, |_| end_s + change_s);
                let split_s = until_s.saturating_sub(begin_s);
                let meets = next_s.is_some_and(|next_s| next_s < end_s);
                if meets || split_s < plan.phases[p].min_s + change_s {
                    return None;
                }
                cycle.splits_s[p] = Some(split_s);
                begin_s = until_s;
            }
        }
    }
    for (phase, holds) in plan.phases.iter_mut().zip(&cycle.holds) {
        phase.recall = *holds;
    }
    plan.coordination = Some(cycle);
    Some(plan)
}

/// Returns which stages serve a phase, in a row around the cycle; none if it is never called.
fn served(stages: &RingStages, phase: &Phase, plan: &Plan, links: &Links) -> Option<Vec<bool>> {
    let needs_arrow =
        !phase.enters && phase.links.ones().all(|link| links.turn(link) == Some(Turn::Left));
    let serves = |green: &ProgramPhase| {
        phase.links.ones().all(|link| match green.state.as_bytes().get(link) {
            Some(b'G') => true,
            Some(b'g') => !needs_arrow,
            _ => false,
        })
    };
    let served: Vec<bool> = stages.greens.iter().map(serves).collect();
    let last = served.iter().cycle().skip(served.len() - 1);
    let rows = last.zip(&served).filter(|(before, own)| **own && !**before).count();
    let also = |other: &Phase| other.number != phase.number && phase.links.is_subset(&other.links);
    let is_never_called = || !served.contains(&true) && plan.phases.iter().any(also);
    (rows == 1 || is_never_called()).then_some(served)
}

#[cfg(test)]
mod tests {
    use super::super::DualRing;
    use super::super::testing::{GREENS, cross, greens, numbers, seen, settings, tee, timing};
    use super::*;
    use crate::control::coordinated;

    fn within(links: &Links, greens: &[(&str, u32)], street: usize) -> Option<Plan> {
        let timing = timing(links, &settings());
        let config = coordinated::rings(&coordinated::Config::default());
        let plan = Plan::new(links, &links.states, &timing, &config);
        let greens = greens.iter().map(|(state, s)| ProgramPhase::fixed(*state, f64::from(*s)));
        let stages = RingStages { greens: greens.collect(), coordinated: street, offset_s: 10 };
        coordinate(&stages, plan, links, &timing, 0)
    }

    fn by_number<T: Copy>(plan: &Plan, of: &[T], number: u32) -> T {
        of[plan.phases.iter().position(|p| p.number == number).unwrap()]
    }

    /// Stages of GREENS: through and left of the main street, the same of the side street; 4 s of change after each.
    const LAGGING: [(&str, u32); 4] =
        [(GREENS[0], 30), (GREENS[1], 8), (GREENS[2], 20), (GREENS[3], 6)];

    #[test]
    fn phases_end_when_the_stages_do_and_left_turns_lag_where_those_do() {
        let plan = within(&cross(), &LAGGING, 0).unwrap();
        assert_eq!(numbers(&plan), "2 1|6 5, 4 3|8 7");
        let cycle = plan.coordination.as_ref().unwrap();
        assert_eq!(cycle.cycle_s, 30 + 8 + 20 + 6 + 4 * 4);
        let ends = [2, 6, 1, 5, 4, 8, 3, 7].map(|n| by_number(&plan, &cycle.ends_s, n));
        assert_eq!(ends, [0, 0, 12, 12, 36, 36, 46, 46]);
        let splits = [2, 6, 1, 5, 4, 8, 3, 7].map(|n| by_number(&plan, &cycle.splits_s, n));
        assert_eq!(splits, [34, 34, 12, 12, 24, 24, 10, 10].map(Some));
        // The street's green is over 30 s after the offset; the episode begins 40 s of 80 before the next time.
        assert_eq!((cycle.yields_s, cycle.begins_s), (Some(40), 40));
        assert_eq!([2, 6, 1].map(|n| by_number(&plan, &cycle.holds, n)), [true, true, false]);
    }

    #[test]
    fn a_left_turn_without_a_stage_yields_and_is_never_called() {
        let plan = within(&cross(), &[(GREENS[0], 40), (GREENS[2], 32)], 0).unwrap();
        let cycle = plan.coordination.as_ref().unwrap();
        assert_eq!([1, 2].map(|n| by_number(&plan, &cycle.splits_s, n)), [None, Some(44)]);
        let links = cross();
        let mut rings = DualRing::of(links.clone(), plan, timing(&links, &settings()));
        for _ in 0..400 {
            rings.step(&seen(&rings, &|_| true));
            assert!(!rings.shown.starts_with("rrG"), "{}", rings.shown);
        }
    }

    #[test]
    fn stages_that_two_rings_cannot_follow_are_refused() {
        let [through, left, side, side_left] = LAGGING;
        let refused = |greens: &[(&str, u32)], street| within(&cross(), greens, street).is_none();
        assert!(refused(&[through, side, through, side_left], 0), "phase 2 has two rows of stages");
        assert!(
            refused(&[through, side, left, side_left], 0),
            "each street has two rows of stages"
        );
        assert!(refused(&[through, (GREENS[2], 9)], 0), "phase 4 has less than its shortest green");
        assert!(refused(&LAGGING, 1), "no through phase is green");
    }

    #[test]
    fn a_phase_of_several_stages_ends_with_the_last_of_them() {
        let greens = [("GgrrGG", 30), ("GGGrrr", 9), ("rrGGGr", 12)];
        let plan = within(&tee(), &greens, 0).unwrap();
        assert_eq!(numbers(&plan), "2|6 5, 4|");
        let cycle = plan.coordination.as_ref().unwrap();
        assert_eq!([6, 2, 5, 4].map(|n| by_number(&plan, &cycle.ends_s, n)), [0, 13, 13, 29]);
        let splits = [6, 5, 2, 4].map(|n| by_number(&plan, &cycle.splits_s, n));
        assert_eq!(splits, [34, 13, 47, 16].map(Some));
        // Where phase 2 is coordinated and 5 ends with it, 5 may be green until the end of the cycle.
        let plan = within(&tee(), &greens, 1).unwrap();
        let cycle = plan.coordination.as_ref().unwrap();
        let ends = [2, 5, 6, 4].map(|n| by_number(&plan, &cycle.ends_s, n));
        assert_eq!((ends, cycle.cycle_s), ([0, 63, 50, 16], 63));
    }

    #[test]
    fn coordinated_phases_end_at_their_yield_point_and_others_by_a_gap_or_their_force_off() {
        let links = cross();
        let plan = within(&links, &LAGGING, 0).unwrap();
        let mut rings = DualRing::of(links.clone(), plan, timing(&links, &settings()));
        // The side street always has vehicles, its left turns none; those of the main street come late.
        let on = |number: u32, second: u32| match number {
            4 | 8 => second < 200,
            1 => (100..130).contains(&second),
            _ => false,
        };
        let ended = greens(&mut rings, &on, 241).into_iter();
        let ended: Vec<(u32, u32)> = ended.map(|(n, begin_s, s)| (n, begin_s + s)).collect();
        // Yield points at 40, 120, 200: offset 10 and 30 s of green. Nobody turns left at 40, so that the side street has
        // more, up to its force-off at 76; at 120 phase 1 has its turn, until vehicles are gone or its split is over at 132.
        assert!(ended.contains(&(2, 40)) && ended.contains(&(6, 40)), "{ended:?}");
        assert!(ended.contains(&(4, 76)) && ended.contains(&(8, 76)), "{ended:?}");
        assert!(ended.iter().any(|e| e.0 == 1 && (129..=132).contains(&e.1)), "{ended:?}");
        assert!(ended.contains(&(4, 156)), "{ended:?}");
        // At 200 nobody comes any more: the street stays green.
        assert!(!ended.iter().any(|e| e.1 > 205 && [2, 6].contains(&e.0)), "{ended:?}");
        assert!(rings.shown.starts_with("GGg"), "{}", rings.shown);
    }
}
