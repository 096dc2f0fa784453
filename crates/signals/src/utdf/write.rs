//! Plans as UTDF, for Synchro to merge into the network that they belong to: `[Lanes]` with the phases of movements,
//! `[Timeplans]` and `[Phases]`. Nodes, links and volumes stay those of the network.
//!
//! Only settings that plans have are written. Of what plans do not have, Synchro keeps the settings of the network: gap
//! reduction, detectors, calls of pedestrians, the master, the yield point, locked timings, nodes of the controller,
//! units.

use super::plans::{MOST_OF_MOVEMENT, PEOPLE};
use crate::existing::{Control, ExistingPlan, PlanPhase};

/// Columns of movements, in UTDF's order.
const MOVEMENTS: [&str; 24] = [
    "NBL", "NBT", "NBR", "SBL", "SBT", "SBR", "EBL", "EBT", "EBR", "WBL", "WBT", "WBR", "NEL",
    "NET", "NER", "NWL", "NWT", "NWR", "SEL", "SET", "SER", "SWL", "SWT", "SWR",
];

/// Returns the cell of a phase in a record.
type CellOf<'a> = &'a dyn Fn(&PlanPhase) -> String;

/// Fewest columns of phases.
const LEAST_PHASES: u32 = 8;

/// Returns plans by the number of their node as UTDF.
pub fn to_utdf(plans: &[(u32, ExistingPlan)]) -> Result<String, String> {
    for (node, plan) in plans {
        check(plan).map_err(|reason| format!("node {node}: {reason}"))?;
    }
    let mut text = "[Network]\nNetwork Settings\nRECORDNAME,DATA\nUTDFVERSION,8\n".to_owned();
    text.push_str("\n[Lanes]\nLane Group Data\n");
    text.push_str(&format!("RECORDNAME,INTID,{},{PEOPLE}\n", MOVEMENTS.join(",")));
    plans.iter().for_each(|(node, plan)| lanes(&mut text, *node, plan));
    text.push_str("\n[Timeplans]\nTiming Plan Settings\nRECORDNAME,INTID,DATA\n");
    plans.iter().for_each(|(node, plan)| times(&mut text, *node, plan));
    text.push_str("\n[Phases]\nPhasing Data\nRECORDNAME,INTID");
    let numbers = plans.iter().flat_map(|(_, plan)| plan.phases.iter().map(|p| p.number));
    let most = numbers.max().unwrap_or_default().max(LEAST_PHASES);
    (1..=most).for_each(|number| text.push_str(&format!(",D{number}")));
    text.push('\n');
    plans.iter().for_each(|(node, plan)| phases(&mut text, *node, plan, most));
    text.push('\n');
    Ok(text)
}

/// Checks that UTDF can say what a plan is.
fn check(plan: &ExistingPlan) -> Result<(), String> {
    plan.check()?;
    for phase in &plan.phases {
        if [phase.barrier, phase.ring, phase.position].iter().any(|place| *place > 9) {
            return Err(format!("phase {} has a barrier or position above 9", phase.number));
        }
        if let Some(name) = phase.all_movements().find(|name| !MOVEMENTS.contains(&name.as_str())) {
            return Err(format!("{name} is no movement of UTDF"));
        }
    }
    let is_in_many = |name: &&&str| {
        let of = |yields| plan.phases.iter().filter(|p| serves(p, name, yields)).count();
        of(false).max(of(true)) > MOST_OF_MOVEMENT
    };
    match MOVEMENTS.iter().chain([&PEOPLE]).find(is_in_many) {
        Some(name) => Err(format!("{name} has more than {MOST_OF_MOVEMENT} phases")),
        None => Ok(()),
    }
}

/// Whether a phase serves what stands in a column, with the right of way or without.
fn serves(phase: &PlanPhase, column: &str, yields: bool) -> bool {
    let names = if yields { &phase.yielding } else { &phase.movements };
    let is_for_people = column == PEOPLE && phase.is_for_people() && !yields;
    is_for_people || names.iter().any(|name| name == column)
}

fn record(text: &mut String, name: &str, node: u32, cells: impl Iterator<Item = String>) {
    text.push_str(&format!("{name},{node}"));
    cells.for_each(|cell| text.push_str(&format!(",{cell}")));
    text.push('\n');
}

/// Returns a time as UTDF has it: tenths, and more where there are more.
fn number(value: f64) -> String {
    ((value * 1000.0).round() / 1000.0).to_string()
}

fn lanes(text: &mut String, node: u32, plan: &ExistingPlan) {
    for (kind, yields) in [("Phase", false), ("PermPhase", true)] {
        for n in 0..MOST_OF_MOVEMENT {
            let cell = |name: &str| {
                let phase = plan.phases.iter().filter(|p| serves(p, name, yields)).nth(n);
                phase.map(|phase| phase.number.to_string()).unwrap_or_default()
            };
            let cells: Vec<String> = MOVEMENTS.into_iter().chain([PEOPLE]).map(cell).collect();
            // An empty record would empty that of the network.
            if cells.iter().any(|cell| !cell.is_empty()) {
                record(text, &format!("{kind}{}", n + 1), node, cells.into_iter());
            }
        }
    }
}

fn times(text: &mut String, node: u32, plan: &ExistingPlan) {
    let control = match plan.control {
        Control::Pretimed => 0,
        Control::Actuated => 1,
        Control::Coordinated => 3,
    };
    let reference = match plan.reference[..] {
        [one] => one,
        [first, second, ..] => 100 * first + second,
        [] => 0,
    };
    let cycle_s = plan.cycle_s.unwrap_or_else(|| plan.sum_s());
    for (name, value) in [
        ("Control Type", control.to_string()),
        ("Cycle Length", number(cycle_s)),
        ("Referenced To", plan.referenced_to.to_string()),
        ("Reference Phase", reference.to_string()),
        ("Offset", plan.offset_s.map(number).unwrap_or_default()),
    ] {
        // The network keeps what nobody knows.
        if !value.is_empty() {
            record(text, name, node, std::iter::once(value));
        }
    }
}

fn phases(text: &mut String, node: u32, plan: &ExistingPlan, most: u32) {
    let flag = |flag: bool| u32::from(flag).to_string();
    let people =
        |p: &PlanPhase, i: usize| p.walk_s.map_or_else(String::new, |both| number(both[i]));
    let records: [(&str, CellOf<'_>); 12] = [
        ("BRP", &|p| format!("{}{}{}", p.barrier, p.ring, p.position)),
        ("MinGreen", &|p| number(p.min_green_s)),
        ("MaxGreen", &|p| number(p.max_green_s)),
        ("MinSplit", &|p| p.min_split_s.map(number).unwrap_or_default()),
        ("VehExt", &|p| number(p.passage_s)),
        ("Yellow", &|p| number(p.yellow_s)),
        ("AllRed", &|p| number(p.all_red_s)),
        ("Recall", &|p| (p.recall as u32).to_string()),
        ("Walk", &|p| people(p, 0)),
        ("DontWalk", &|p| people(p, 1)),
        ("DualEntry", &|p| flag(p.dual_entry)),
        ("InhibitMax", &|p| flag(p.inhibit_max)),
    ];
    // An empty record would empty that of the network.
    let has_min = plan.phases.iter().any(|phase| phase.min_split_s.is_some());
    for (name, cell) in records.into_iter().filter(|(name, _)| *name != "MinSplit" || has_min) {
        let of = |number: u32| {
            plan.phases.iter().find(|p| p.number == number).map_or_else(String::new, cell)
        };
        record(text, name, node, (1..=most).map(of));
    }
}

#[cfg(test)]
mod tests {
    use super::super::Utdf;
    use super::*;
    use crate::existing::testing::{phase, plan, plans};

    const TWO: &str = include_str!("../../tests/utdf/two-signals.csv");

    /// The network without phases and times, as it is in a model that takes plans back.
    fn without_plans() -> String {
        let streets = TWO.split("[Timeplans]").next().unwrap();
        let is_phase = |line: &str| line.starts_with("Phase") || line.starts_with("PermPhase");
        streets.lines().filter(|line| !is_phase(line)).map(|line| format!("{line}\n")).collect()
    }

    proptest::proptest! {
        #![proptest_config(proptest::test_runner::Config::with_cases(64))]
        #[test]
        fn plans_that_were_written_read_back_as_the_same(plan in plans()) {
            let mut expected = plan.clone();
            expected.phases.iter_mut().for_each(|phase| phase.also = None);
            expected.phases.sort_by_key(|phase| phase.number);
            let text = to_utdf(&[(1, plan)]);
            proptest::prop_assume!(text.is_ok());
            let mut back = Utdf::default();
            back.add(without_plans().as_bytes(), "n.csv").unwrap();
            back.add(text.unwrap().as_bytes(), "p.csv").unwrap();
            let read = back.intersections().unwrap();
            let plans: Vec<&ExistingPlan> = read.plans.all.iter().map(|p| &p.plan).collect();
            proptest::prop_assert_eq!(plans, [&expected], "{:?}", read.doubts);
        }
    }

    #[test]
    fn rows_are_those_of_synchro() {
        let mut plan = plan(Control::Coordinated);
        plan.phases.push(phase(9, [1, 1, 3], ""));
        (plan.phases[6].walk_s, plan.cycle_s) = (Some([7.0, 13.0]), Some(86.0));
        let text = to_utdf(&[(7, plan)]).unwrap();
        for line in [
            "Phase1,7,5,2,2,1,6,6,,4,4,,8,8,,,,,,,,,,,,,9",
            "PermPhase1,7,,,,,,,4,,,8,,,,,,,,,,,,,,,",
            "Control Type,7,3",
            "Cycle Length,7,86",
            "Reference Phase,7,206",
            "BRP,7,111,112,,211,121,122,,221,113",
            "MaxGreen,7,8,20,,20,8,20,,20,20",
            "Yellow,7,3.5,3.5,,3.5,3.5,3.5,,3.5,3.5",
        ] {
            assert!(text.lines().any(|l| l == line), "{line}\n{text}");
        }
    }

    #[test]
    fn what_utdf_cannot_say_is_refused() {
        let mut plan = plan(Control::Actuated);
        plan.phases[0].movements.push("NBL2".into());
        let refused = |plan: &ExistingPlan| to_utdf(&[(7, plan.clone())]).unwrap_err();
        assert_eq!(refused(&plan), "node 7: NBL2 is no movement of UTDF");
        plan.phases[0].position = 12;
        plan.phases[1].position = 13;
        assert_eq!(refused(&plan), "node 7: phase 1 has a barrier or position above 9");
    }
}
