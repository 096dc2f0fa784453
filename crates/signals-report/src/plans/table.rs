//! `plans.csv`: a row per green of every plan, or one that says why there is none.

use super::task_plan::{Source, TaskPlan};
use evaluation::analysis::Analysis;
use signals::program::{ProgramKind, ProgramPhase, SignalProgram};
use signals::settings::signal::SignalSettings;
use signals::timing::Timing;

/// The columns.
pub(super) const HEADER: [&str; 17] = [
    "point",
    "streets",
    "method",
    "replicate",
    "delay_s",
    "winner",
    "signal",
    "program",
    "phase",
    "state",
    "green_s",
    "max_green_s",
    "yellow_s",
    "all_red_s",
    "cycle_s",
    "file",
    "remark",
];

/// A green with the change after it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Green {
    /// Its state.
    pub(super) state: String,
    /// Its duration, of actuated programs the shortest, seconds.
    pub(super) green_s: f64,
    /// Longest duration of actuated programs, seconds.
    pub(super) max_s: Option<f64>,
    /// Yellow after it, seconds.
    pub(super) yellow_s: f64,
    /// All-red after it, seconds.
    pub(super) all_red_s: f64,
}

/// Returns the rows of a plan.
///
/// # Arguments
///
/// * `streets` — of its intersections.
/// * `file` — name of the file for SUMO that has it, if there is one.
pub(super) fn rows(
    data: &Analysis,
    streets: Option<String>,
    plan: &TaskPlan,
    file: Option<&str>,
) -> Vec<Vec<String>> {
    let identity = &data.manifest.identity;
    let point = identity.points[plan.point].point.as_str();
    let winner = data.winners[plan.point].as_ref().is_some_and(|w| w.best == plan.method);
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let head = [
        point.to_owned(),
        streets.unwrap_or_default(),
        identity.methods[plan.method].clone(),
        plan.replicate.to_string(),
        number(plan.objective),
        if winner { "yes" } else { "no" }.to_owned(),
    ];
    let row = |cells: [String; 11]| head.iter().cloned().chain(cells).collect::<Vec<_>>();
    let empty = String::new;
    let file = file.unwrap_or_default();
    let Some(programs) = &plan.programs else {
        let program = if plan.source == Source::Decides { "none" } else { "unknown" };
        if !plan.phases.is_empty() {
            let phases = |(signal, phases): &(String, String)| {
                let mut cells: [String; 11] = std::array::from_fn(|_| empty());
                (cells[0], cells[1]) = (signal.clone(), program.to_owned());
                cells[10] = format!("decides every second; {phases}");
                row(cells)
            };
            return plan.phases.iter().map(phases).collect();
        }
        let mut cells: [String; 11] = std::array::from_fn(|_| empty());
        cells[1] = program.to_owned();
        cells[10] = remark(plan, None);
        return vec![row(cells)];
    };
    let mut all = Vec::new();
    for (program, cycle_s) in programs.all.iter().zip(&programs.cycles_s) {
        let kind = match (program.own, program.kind) {
            (true, ProgramKind::Static) => "the network's own",
            (true, _) => "the network's own, not fixed",
            (false, kind) => kind.name(),
        };
        let remark = remark(plan, Some(program));
        let changes_known = plan.is_whole();
        let greens = greens(program, changes_known);
        if greens.is_empty() {
            let mut cells: [String; 11] = std::array::from_fn(|_| empty());
            (cells[0], cells[1]) = (program.signal.clone(), kind.to_owned());
            (cells[9], cells[10]) = (file.to_owned(), remark.clone());
            all.push(row(cells));
        }
        let total_s: f64 = program.phases.iter().map(|p| p.duration_s).sum();
        let fixed = program.kind == ProgramKind::Static;
        let cycle_s = cycle_s.or(Some(total_s).filter(|_| fixed && changes_known));
        for (i, green) in greens.into_iter().enumerate() {
            all.push(row([
                program.signal.clone(),
                kind.to_owned(),
                (i + 1).to_string(),
                green.state,
                green.green_s.to_string(),
                number(green.max_s),
                number(Some(green.yellow_s).filter(|_| changes_known)),
                number(Some(green.all_red_s).filter(|_| changes_known)),
                number(cycle_s),
                file.to_owned(),
                remark.clone(),
            ]));
        }
    }
    all
}

/// Returns why something is missing, or what the numbers mean.
fn remark(plan: &TaskPlan, program: Option<&SignalProgram>) -> String {
    let is = |kind| program.is_some_and(|p| p.kind == kind);
    let text = match plan.source {
        _ if program.is_some_and(|p| p.own && p.phases.is_empty()) => {
            "the network file has it; this record is from a version that did not keep programs"
        }
        Source::Decides => "decides while it runs, so that there is no program",
        Source::NotKept => {
            "the record is from a version that did not keep programs; run the task again to have it"
        }
        Source::Greens => {
            "the record is from a version that did not keep yellow and all-red; they depend on the \
             streets, and the cycle contains them"
        }
        Source::Described => "yellow and all-red follow from the settings",
        Source::Recorded if is(ProgramKind::Actuated) => {
            "SUMO prolongs greens from green_s up to max_green_s while vehicles follow closely"
        }
        Source::Recorded => "",
    };
    text.to_owned()
}

/// Returns the greens of a program with what comes after each; phases before the first green belong to
/// the last.
pub(super) fn greens(program: &SignalProgram, with_changes: bool) -> Vec<Green> {
    let phases = &program.phases;
    let green = |p: &ProgramPhase| Green {
        state: p.state.clone(),
        green_s: p.duration_s,
        max_s: p.max_s.filter(|_| program.kind == ProgramKind::Actuated),
        yellow_s: 0.0,
        all_red_s: 0.0,
    };
    if !with_changes {
        return phases.iter().map(green).collect();
    }
    let timing = Timing::new(&SignalSettings::default(), Vec::new(), Vec::new());
    // Where vehicles may turn on red, it is red.
    let states: Vec<String> = phases.iter().map(|p| p.state.replace('s', "r")).collect();
    let durations = phases.iter().map(|p| p.duration_s);
    let pairs: Vec<(&str, f64)> = states.iter().map(String::as_str).zip(durations).collect();
    let starts = timing.greens(&pairs);
    let mut greens: Vec<Green> = starts.iter().map(|i| green(&phases[*i])).collect();
    for (k, start) in starts.iter().enumerate() {
        let next = starts[(k + 1) % starts.len()];
        let mut i = (start + 1) % phases.len();
        while i != next && i != *start {
            let is_yellow = phases[i].state.contains(['y', 'Y', 'u']);
            let time_s = if is_yellow { &mut greens[k].yellow_s } else { &mut greens[k].all_red_s };
            *time_s += phases[i].duration_s;
            i = (i + 1) % phases.len();
        }
    }
    greens
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(phases: &[(&str, f64)]) -> SignalProgram {
        let phase = |(state, duration_s): &(&str, f64)| ProgramPhase {
            state: (*state).to_owned(),
            duration_s: *duration_s,
            min_s: None,
            max_s: None,
        };
        let phases = phases.iter().map(phase).collect();
        SignalProgram {
            signal: "c".into(),
            own: false,
            kind: ProgramKind::Static,
            phases,
            rings: Vec::new(),
        }
    }

    fn found(phases: &[(&str, f64)], with_changes: bool) -> Vec<(String, [f64; 3])> {
        let greens = greens(&program(phases), with_changes);
        greens.into_iter().map(|g| (g.state, [g.green_s, g.yellow_s, g.all_red_s])).collect()
    }

    #[test]
    fn a_green_has_the_change_after_it_also_across_the_end_of_the_cycle() {
        let cycle =
            [("rr", 1.0), ("Gr", 30.0), ("yr", 4.0), ("rr", 2.0), ("rG", 20.0), ("ry", 3.0)];
        let expected = [("Gr".to_owned(), [30.0, 4.0, 2.0]), ("rG".to_owned(), [20.0, 3.0, 1.0])];
        assert_eq!(found(&cycle, true), expected);
    }

    #[test]
    fn a_single_green_and_none_at_all() {
        assert_eq!(found(&[("GG", 90.0)], true), [("GG".to_owned(), [90.0, 0.0, 0.0])]);
        assert_eq!(found(&[("GG", 9.0), ("rr", 1.0)], true)[0].1, [9.0, 0.0, 1.0]);
        assert_eq!(found(&[], true), []);
        assert_eq!(found(&[("rr", 9.0)], true), []);
    }
}
