//! Two rings within a common cycle: the cycle comes as stages of the signal, one after the other.
//!
//! - **Force-off.** The green of a phase ends at the latest when the last stage that serves it does. A stage serves a phase if
//!   all its links are green in it; a left turn's own phase, if they have the right of way.
//! - **Coordinated phases** are the through phases that the stage of the coordinated street serves. They hold their green
//!   until it is over in the cycle (the yield point), and take what the other phases leave.
//! - **The order** of the phases of a ring is that of the stages, so left turns lead or lag as the stages have it.
//! - **A left turn's own phase that no stage serves** is never called if the left turn also yields in a through phase.
//!
//! Where the stages cannot be followed in two rings, the reason says why; the signal then runs them as a fixed cycle.

use osm_signals::Turn;

use super::links::Links;
use super::plan::{Coordination, Phase, Plan};
use crate::program::{ProgramPhase, RingStages};
use crate::timing::Timing;

/// Stages in a row, as the first one and how many, around the end of the cycle.
type Run = (usize, usize);

/// Returns the phases of a signal within this cycle.
///
/// # Arguments
///
/// * `now_s` — the time at which the signal begins, seconds.
pub(super) fn coordinate(
    stages: &RingStages,
    mut plan: Plan,
    links: &Links,
    timing: &Timing,
    now_s: u32,
) -> Result<Plan, String> {
    let (ends_s, cycle_s) = ends_s(stages, timing);
    let count = stages.greens.len();
    let runs: Vec<Option<Run>> = (plan.phases.iter())
        .map(|phase| run(stages, phase, &plan, links))
        .collect::<Result<_, _>>()?;
    let coordinated: Vec<bool> = (plan.phases.iter().zip(&runs))
        .map(|(phase, run)| {
            let is_in =
                |(first, length): &Run| (stages.coordinated + count - first) % count < *length;
            phase.enters && run.as_ref().is_some_and(is_in)
        })
        .collect();
    let holds = |side: &[Vec<usize>; 2]| side.iter().flatten().any(|p| coordinated[*p]);
    if plan.sides.iter().filter(|side| holds(side)).count() != 1 {
        return Err("its coordinated street is green with no through phase, or with those of several streets".into());
    }
    // Where each side begins among the stages, and how many it has.
    let mut windows: Vec<Run> = Vec::new();
    for side in &plan.sides {
        let is_of = |stage: usize| {
            let of = side.iter().flatten().filter_map(|p| runs[*p]);
            of.into_iter().any(|(first, length)| (stage + count - first) % count < length)
        };
        let window = in_a_row((0..count).map(is_of).collect())
            .ok_or("the stages of a street do not follow each other")?;
        windows.push(window);
    }
    if windows.iter().map(|window| window.1).sum::<usize>() != count {
        return Err("a stage serves phases of several streets, or of none".into());
    }
    let origin = windows[plan.sides.iter().position(holds).unwrap_or_default()].0;
    let after = |stage: usize, from: usize| (stage + count - from) % count;
    let mut order: Vec<usize> = (0..plan.sides.len()).collect();
    order.sort_by_key(|side| after(windows[*side].0, origin));
    plan.sides = order.iter().map(|side| plan.sides[*side].clone()).collect();
    let windows: Vec<Run> = order.into_iter().map(|side| windows[side]).collect();
    for (side, window) in plan.sides.iter_mut().zip(&windows) {
        for ring in side {
            ring.sort_by_key(|p| runs[*p].map(|run| after(run.0, window.0)));
            let served: Vec<Run> = ring.iter().filter_map(|p| runs[*p]).collect();
            let meet =
                |pair: &[Run]| after(pair[1].0, window.0) < after(pair[0].0, window.0) + pair[0].1;
            if served.windows(2).any(meet) {
                return Err("a stage serves two phases of one ring".into());
            }
        }
    }
    let end_s = |(first, length): Run| ends_s[(first + length - 1) % count];
    // The yield point: when the first coordinated phase ends after which no other one ends long after.
    let yields = || (0..plan.phases.len()).filter(|p| coordinated[*p]);
    let since = |from_s: u32, to_s: u32| (to_s + cycle_s - from_s) % cycle_s;
    let ends = |p: usize| runs[p].map_or(0, end_s);
    let zero_s = yields()
        .map(ends)
        .min_by_key(|zero_s| yields().map(|p| since(*zero_s, ends(p))).max())
        .ok_or("no phase is coordinated")?;
    let ends_in_cycle_s = |(run, holds): (&Option<Run>, &bool)| {
        let Some(run) = *run else { return 0 };
        let begin_s = ends_s[run.0] - green_s(&stages.greens[run.0]);
        let after_s = since(zero_s, end_s(run));
        let goes_on = after_s < since(begin_s, end_s(run)) && !holds;
        if goes_on { cycle_s + after_s } else { after_s }
    };
    let mut coordination = Coordination {
        cycle_s,
        ends_s: runs.iter().zip(&coordinated).map(ends_in_cycle_s).collect(),
        inhibits_max: vec![false; plan.phases.len()],
        splits_s: vec![None; plan.phases.len()],
        yields_s: Some((stages.offset_s + zero_s) % cycle_s),
        begins_s: 0,
        holds: coordinated,
    };
    for (phase, holds) in plan.phases.iter_mut().zip(&coordination.holds) {
        phase.recall = *holds;
    }
    coordination.begins_s = since((stages.offset_s + zero_s) % cycle_s, now_s % cycle_s);
    for (side, window) in plan.sides.iter().zip(&windows) {
        let before_s = ends_s[(window.0 + count - 1) % count];
        let change_s = |stage: usize| {
            let next = &stages.greens[(stage + 1) % count];
            change_s(timing, &stages.greens[stage], next)
        };
        let begin_s = before_s + change_s((window.0 + count - 1) % count);
        let last = (window.0 + window.1 - 1) % count;
        let whole_s = since(begin_s % cycle_s, (ends_s[last] + change_s(last)) % cycle_s);
        let whole_s = if whole_s == 0 { cycle_s } else { whole_s };
        for ring in side {
            let served = || ring.iter().copied().filter(|p| runs[*p].is_some());
            let mut until_s = 0;
            for (place, p) in served().enumerate() {
                let own = &plan.phases[p];
                let all_s = own.change_s.0 + own.change_s.1;
                let to_s = match place + 1 == served().count() {
                    true => whole_s,
                    false => since(begin_s % cycle_s, (ends(p) + all_s) % cycle_s),
                };
                let split_s = to_s.saturating_sub(until_s);
                if split_s < own.min_s + all_s {
                    return Err(format!(
                        "phase {} has {split_s} s, less than its shortest green and the change after it",
                        own.number
                    ));
                }
                coordination.splits_s[p] = Some(split_s);
                until_s = to_s;
            }
        }
    }
    plan.coordination = Some(coordination);
    Ok(plan)
}

/// Returns when the green of each stage ends, from the beginning of the first one, and the cycle, seconds.
fn ends_s(stages: &RingStages, timing: &Timing) -> (Vec<u32>, u32) {
    let mut ends_s = Vec::new();
    let mut now_s = 0;
    for (stage, green) in stages.greens.iter().enumerate() {
        now_s += green_s(green);
        ends_s.push(now_s);
        now_s += change_s(timing, green, &stages.greens[(stage + 1) % stages.greens.len()]);
    }
    (ends_s, now_s)
}

/// Returns the stages that serve a phase; nothing if it is never called.
fn run(
    stages: &RingStages,
    phase: &Phase,
    plan: &Plan,
    links: &Links,
) -> Result<Option<Run>, String> {
    let is_left = |link: &usize| links.turn(*link) == Some(Turn::Left);
    let needs_arrow = !phase.enters && phase.links.iter().all(is_left);
    let serves = |green: &ProgramPhase| {
        phase.links.iter().all(|link| match green.state.as_bytes().get(*link) {
            Some(b'G') => true,
            Some(b'g') => !needs_arrow,
            _ => false,
        })
    };
    let served: Vec<bool> = stages.greens.iter().map(serves).collect();
    if let Some(run) = in_a_row(served.clone()) {
        return Ok(Some(run));
    }
    let also = |other: &Phase| {
        other.number != phase.number && phase.links.iter().all(|l| other.links.contains(l))
    };
    if !served.contains(&true) && plan.phases.iter().any(also) {
        return Ok(None);
    }
    Err(format!("no stages in a row serve phase {}", phase.number))
}

/// Returns the change between two stages, seconds.
fn change_s(timing: &Timing, from: &ProgramPhase, to: &ProgramPhase) -> u32 {
    timing.between(&from.state, &to.state).iter().map(|step| step.1).sum()
}

/// Returns the green of a stage, which is of whole seconds.
fn green_s(stage: &ProgramPhase) -> u32 {
    stage.duration_s.round() as u32
}

/// Returns the marked stages as a run around the cycle; nothing if none or all are marked, or if others lie between them.
fn in_a_row(marked: Vec<bool>) -> Option<Run> {
    let count = marked.len();
    let begins = |stage: &usize| marked[*stage] && !marked[(stage + count - 1) % count];
    let mut first = (0..count).filter(begins);
    match (first.next(), first.next()) {
        (Some(first), None) => Some((first, marked.iter().filter(|marked| **marked).count())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::rings::{Rings, Seen};
    use super::super::testing::{GREENS, cross, settings, tee, timing};
    use super::*;
    use crate::control::dual_ring::{Config, Recall};

    fn config() -> Config {
        Config {
            max_green_s: 600,
            left_max_green_s: 600,
            recall: Recall::None,
            ..Config::default()
        }
    }

    fn coordinated(links: &Links, greens: &[(&str, u32)], street: usize) -> Result<Plan, String> {
        let timing = timing(links, &settings());
        let plan = Plan::new(links, &links.states, &timing, &config());
        let greens = greens.iter().map(|(state, s)| ProgramPhase::fixed(*state, f64::from(*s)));
        let stages = RingStages { greens: greens.collect(), coordinated: street, offset_s: 10 };
        coordinate(&stages, plan, links, &timing, 0)
    }

    /// Numbers of the phases per side and ring.
    fn order(plan: &Plan) -> Vec<[Vec<u32>; 2]> {
        let of = |ring: &Vec<usize>| ring.iter().map(|p| plan.phases[*p].number).collect();
        plan.sides.iter().map(|side| [of(&side[0]), of(&side[1])]).collect()
    }

    fn by_number<T: Copy>(plan: &Plan, of: &[T], number: u32) -> T {
        of[plan.phases.iter().position(|p| p.number == number).unwrap()]
    }

    /// Stages of GREENS: through and left of the main street, the same of the side street; 4 s of change after each.
    const LAGGING: [(&str, u32); 4] =
        [(GREENS[0], 30), (GREENS[1], 8), (GREENS[2], 20), (GREENS[3], 6)];

    #[test]
    fn phases_end_when_the_stages_do_and_left_turns_lag_where_those_do() {
        let plan = coordinated(&cross(), &LAGGING, 0).unwrap();
        assert_eq!(order(&plan), [[vec![2, 1], vec![6, 5]], [vec![4, 3], vec![8, 7]]]);
        let cycle = plan.coordination.as_ref().unwrap();
        assert_eq!(cycle.cycle_s, 30 + 8 + 20 + 6 + 4 * 4);
        let ends = [2, 6, 1, 5, 4, 8, 3, 7].map(|n| by_number(&plan, &cycle.ends_s, n));
        assert_eq!(ends, [0, 0, 12, 12, 36, 36, 46, 46]);
        let splits = [2, 6, 1, 5, 4, 8, 3, 7].map(|n| by_number(&plan, &cycle.splits_s, n));
        assert_eq!(splits, [34, 34, 12, 12, 24, 24, 10, 10].map(Some));
        // The street's green is over 30 s after the offset; the episode begins 40 s of 80 before the next time.
        assert_eq!((cycle.yields_s, cycle.begins_s), (Some(40), 40));
        let held: Vec<u32> = plan
            .phases
            .iter()
            .filter(|p| by_number(&plan, &cycle.holds, p.number))
            .map(|p| p.number)
            .collect();
        assert_eq!(held, [2, 6]);
    }

    #[test]
    fn left_turns_lead_where_the_stages_do_and_the_side_street_may_be_the_coordinated_one() {
        let leading = [LAGGING[1], LAGGING[0], LAGGING[3], LAGGING[2]];
        let plan = coordinated(&cross(), &leading, 3).unwrap();
        assert_eq!(order(&plan), [[vec![3, 4], vec![7, 8]], [vec![1, 2], vec![5, 6]]]);
        let cycle = plan.coordination.as_ref().unwrap();
        let ends = [4, 1, 2, 3].map(|n| by_number(&plan, &cycle.ends_s, n));
        assert_eq!(ends, [0, 12, 46, 56]);
    }

    #[test]
    fn a_left_turn_without_a_stage_yields_and_is_never_called() {
        let plan = coordinated(&cross(), &[(GREENS[0], 40), (GREENS[2], 32)], 0).unwrap();
        let cycle = plan.coordination.as_ref().unwrap();
        assert_eq!([1, 2].map(|n| by_number(&plan, &cycle.splits_s, n)), [None, Some(44)]);
        let links = cross();
        let mut rings = Rings::new(links.clone(), plan, timing(&links, &settings()));
        let seen = Seen { calls: vec![true; 8], extends: vec![true; 8], walk_s: Vec::new() };
        for _ in 0..400 {
            rings.second(&seen);
            assert!(!rings.shown().starts_with("rrG"), "{}", rings.shown());
        }
    }

    #[test]
    fn stages_that_two_rings_cannot_follow_are_refused_with_the_reason() {
        let refused = |greens: &[(&str, u32)], street, wanted: &str| {
            let reason = coordinated(&cross(), greens, street).unwrap_err();
            assert!(reason.contains(wanted), "{reason}");
        };
        let again = [LAGGING[0], LAGGING[2], LAGGING[0], LAGGING[3]];
        refused(&again, 0, "no stages in a row serve phase 2");
        let between = [LAGGING[0], LAGGING[2], LAGGING[1], LAGGING[3]];
        refused(&between, 0, "the stages of a street do not follow each other");
        refused(
            &[(GREENS[0], 40), (GREENS[2], 9)],
            0,
            "phase 4 has 13 s, less than its shortest green",
        );
        refused(&LAGGING, 1, "green with no through phase");
    }

    #[test]
    fn a_phase_of_several_stages_ends_with_the_last_of_them() {
        let greens = [("GgrrGG", 30), ("GGGrrr", 9), ("rrGGGr", 12)];
        let plan = coordinated(&tee(), &greens, 0).unwrap();
        assert_eq!(order(&plan), [[vec![2], vec![6, 5]], [vec![4], vec![]]]);
        let cycle = plan.coordination.as_ref().unwrap();
        assert_eq!([6, 2, 5, 4].map(|n| by_number(&plan, &cycle.ends_s, n)), [0, 13, 13, 29]);
        let splits = [6, 5, 2, 4].map(|n| by_number(&plan, &cycle.splits_s, n));
        assert_eq!(splits, [34, 13, 47, 16].map(Some));
    }

    #[test]
    fn a_phase_that_ends_with_the_coordinated_one_may_be_green_until_the_end_of_the_cycle() {
        let greens = [("GgrrGG", 30), ("GGGrrr", 9), ("rrGGGr", 12)];
        let plan = coordinated(&tee(), &greens, 1).unwrap();
        let cycle = plan.coordination.as_ref().unwrap();
        // Phase 2 is coordinated; 5 ends with it.
        let ends = [2, 5, 6, 4].map(|n| by_number(&plan, &cycle.ends_s, n));
        assert_eq!((ends, cycle.cycle_s), ([0, 63, 50, 16], 63));
    }

    /// Plays seconds of rings and returns number and second of every green that ended.
    fn greens(rings: &mut Rings, on: &dyn Fn(u32, u32) -> bool, seconds: u32) -> Vec<(u32, u32)> {
        let mut ended = Vec::new();
        for second in 1..=seconds {
            let seen: Vec<bool> =
                rings.plan().phases.iter().map(|p| on(p.number, second)).collect();
            let before: Vec<usize> = rings.green_phases().collect();
            rings.second(&Seen { calls: seen.clone(), extends: seen, walk_s: Vec::new() });
            let over =
                before.into_iter().filter(|p| !rings.green_phases().any(|green| green == *p));
            ended.extend(over.map(|p| (rings.plan().phases[p].number, second)));
        }
        ended
    }

    #[test]
    fn coordinated_phases_end_at_their_yield_point_and_others_by_a_gap_or_their_force_off() {
        let links = cross();
        let plan = coordinated(&links, &LAGGING, 0).unwrap();
        let mut rings = Rings::new(links.clone(), plan, timing(&links, &settings()));
        // The side street always has vehicles, its left turns none; those of the main street come late.
        let on = |number: u32, second: u32| match number {
            4 | 8 => second < 200,
            1 => (100..130).contains(&second),
            _ => false,
        };
        let ended = greens(&mut rings, &on, 240);
        // Yield points at 40, 120, 200: offset 10 and 30 s of green. Nobody turns left at 40, so that the side street has
        // more, up to its force-off at 76; at 120 phase 1 has its turn, until vehicles are gone or its split is over at 132.
        assert!(ended.contains(&(2, 40)) && ended.contains(&(6, 40)), "{ended:?}");
        assert!(ended.contains(&(4, 76)) && ended.contains(&(8, 76)), "{ended:?}");
        assert!(ended.iter().any(|e| e.0 == 1 && (129..=132).contains(&e.1)), "{ended:?}");
        assert!(ended.contains(&(4, 156)), "{ended:?}");
        // At 200 nobody comes any more: the street stays green.
        assert!(!ended.iter().any(|e| e.1 > 205 && [2, 6].contains(&e.0)), "{ended:?}");
        assert!(rings.shown().starts_with("GGg"), "{}", rings.shown());
    }
}
