//! Left turns that yield in a plan although the Signal Timing Manual protects them, whatever their volume, or although the
//! existing plan has them protected only. The simulation does not punish such a plan, because its drivers do not collide.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapter 4: two or more left-turn lanes, or four or more
//! opposing lanes.

use std::collections::{BTreeMap, BTreeSet};

use crate::shown::Seen;
use signals::control::existing;
use signals::existing::ExistingPlan;
use signals::network::left_turns::{PROTECTED_LANES, PROTECTED_OPPOSING_LANES};
use signals::places::{DrawnArm, DrawnIntersection};

use super::told::{given_plan, renamed};

/// How far from straight ahead an opposing arm may lie, degrees.
const OPPOSITE_DEG: f64 = 45.0;

/// Returns these left turns with the reason, such as `SBL (2 lanes)`; in left-hand traffic right turns.
pub(crate) fn unprotected(seen: Seen<'_>, point: usize, plan: &ExistingPlan) -> Vec<String> {
    let id = &seen.data.points[point].row.point;
    let Some(drawn) = seen.shown.drawing(id) else {
        return Vec::new();
    };
    let names = renamed(seen, point);
    let mut ways: BTreeMap<&str, &str> = BTreeMap::new();
    for m in seen.shown.movements.iter().filter(|task| task.point == point).flat_map(|t| &t.results)
    {
        ways.insert(names.get(&m.movement).unwrap_or(&m.movement), &m.from);
    }
    let crossing = crossing(drawn);
    let turns = ways.into_iter().filter(|(name, _)| name.contains(crossing) && yields(plan, name));
    let said = turns.filter_map(|(name, from)| Some(format!("{name} ({})", reason(drawn, from)?)));
    said.collect()
}

/// Returns the left turns that yield in a plan and are protected only in the existing plan of the intersection; in left-hand
/// traffic right turns.
pub(crate) fn no_longer_protected(
    seen: Seen<'_>,
    point: usize,
    plan: &ExistingPlan,
) -> Vec<String> {
    let row = &seen.data.manifest.identity.points[point];
    let today = given_plan(row, existing::METHOD.name);
    match (today, seen.shown.drawing(&row.point)) {
        (Some(today), Some(drawn)) => lost(&today, plan, crossing(drawn)),
        _ => Vec::new(),
    }
}

/// Returns the turns of a kind that are protected only in one plan and yield in another one.
fn lost(today: &ExistingPlan, plan: &ExistingPlan, turn: char) -> Vec<String> {
    let protected: BTreeSet<&String> = today.phases.iter().flat_map(|p| &p.movements).collect();
    let is_lost =
        |name: &&String| name.contains(turn) && !yields(today, name) && yields(plan, name);
    protected.into_iter().filter(is_lost).cloned().collect()
}

/// Whether a movement yields in a phase of a plan.
fn yields(plan: &ExistingPlan, name: &str) -> bool {
    plan.phases.iter().any(|p| p.yielding.iter().any(|own| own == name))
}

/// Returns the letter of the turns that cross opposing traffic.
fn crossing(drawn: &DrawnIntersection) -> char {
    if drawn.is_left_hand { 'R' } else { 'L' }
}

/// Returns why the left turns of an arm are protected whatever their volume; `None` where nothing says so.
fn reason(drawn: &DrawnIntersection, from: &str) -> Option<String> {
    let lanes = |arm: &DrawnArm, turn: char| arm.lanes.iter().filter(|l| l.contains(turn)).count();
    let crossing = if drawn.is_left_hand { 'r' } else { 'l' };
    let arm = drawn.arms.iter().find(|arm| arm.edge == from)?;
    let own = lanes(arm, crossing);
    if own >= PROTECTED_LANES {
        return Some(format!("{own} lanes"));
    }
    let off_deg = |other: &DrawnArm| {
        let turned = (other.bearing_deg - arm.bearing_deg).rem_euclid(360.0);
        (turned - 180.0).abs()
    };
    let opposite = drawn.arms.iter().filter(|other| off_deg(other) <= OPPOSITE_DEG);
    let against = lanes(opposite.min_by(|a, b| off_deg(a).total_cmp(&off_deg(b)))?, 's');
    (against >= PROTECTED_OPPOSING_LANES).then(|| format!("{against} opposing lanes"))
}

#[cfg(test)]
mod tests {
    use signals::existing::{Control, PlanPhase, Recall};

    use super::*;

    fn arm(edge: &str, bearing_deg: f64, lanes: &[&str]) -> DrawnArm {
        DrawnArm {
            name: edge.to_owned(),
            edge: edge.to_owned(),
            bearing_deg,
            lanes: lanes.iter().map(|lane| (*lane).to_owned()).collect(),
            lanes_out: 2,
            speed_mph: 35.0,
            left_storage_m: None,
            right_storage_m: None,
        }
    }

    fn plan(phases: &[(&str, &str)]) -> ExistingPlan {
        let names = |all: &str| all.split_whitespace().map(str::to_owned).collect();
        let phase = |(number, (movements, yielding)): (u32, &(&str, &str))| PlanPhase {
            number,
            ring: 1,
            barrier: 1,
            position: number,
            movements: names(movements),
            yielding: names(yielding),
            min_green_s: 5.0,
            max_green_s: 20.0,
            passage_s: 3.0,
            yellow_s: 4.0,
            all_red_s: 1.0,
            walk_s: None,
            recall: Recall::None,
            dual_entry: true,
            inhibit_max: false,
        };
        ExistingPlan::new(Control::Actuated, (1..).zip(phases).map(phase).collect())
    }

    #[test]
    fn left_turns_that_only_the_existing_plan_protects_are_named() {
        let today =
            plan(&[("SBL NBL", ""), ("NBT SBT NBR", ""), ("EBL", ""), ("EBT WBT", "EBL WBL")]);
        // The left turn of the north keeps its arrow and yields after it; that of the south has its arrow alone.
        let proposed = plan(&[("SBL NBL", ""), ("NBT SBT", "SBL NBR"), ("EBT WBT", "EBL WBL")]);
        assert_eq!(lost(&today, &proposed, 'L'), ["SBL"]);
        assert_eq!(lost(&today, &proposed, 'R'), ["NBR"]);
        assert_eq!(lost(&today, &today, 'L'), Vec::<String>::new());
    }

    #[test]
    fn two_lanes_or_four_opposing_ones_are_protected_wherever_they_are() {
        let arms = vec![
            arm("n", 0.0, &["sr", "s", "l", "l"]),
            arm("s", 170.0, &["sr", "s", "l"]),
            arm("e", 90.0, &["r", "s", "s", "s", "s", "l"]),
            arm("w", 268.0, &["sr", "l"]),
        ];
        let drawn = DrawnIntersection {
            point: "i0001".to_owned(),
            intersection: "i0001".to_owned(),
            period: String::new(),
            is_left_hand: false,
            arms,
        };
        let of = |edge: &str| reason(&drawn, edge);
        assert_eq!(of("n").as_deref(), Some("2 lanes"));
        assert_eq!((of("s"), of("e"), of("nowhere")), (None, None, None));
        assert_eq!(of("w").as_deref(), Some("4 opposing lanes"));
        let mirrored = DrawnIntersection { is_left_hand: true, ..drawn.clone() };
        // Its right turns are those that cross, of one lane each, against four.
        assert_eq!(reason(&mirrored, "n"), None);
        assert_eq!(reason(&mirrored, "w").as_deref(), Some("4 opposing lanes"));
    }
}
