//! `plans.csv`: a row per green of every plan, or one that says why there is none.

use super::task_plan::{Source, TaskPlan};
use evaluation::analysis::Analysis;
use signals::existing::ran::greens;
use signals::program::{ProgramKind, SignalProgram};

/// The columns.
pub(super) const HEADER: [&str; 18] = [
    "point", "streets", "method", "replicate", "delay_s", "winner", "signal", "program", "phase",
    "state", "green_s", "max_green_s", "yellow_s", "all_red_s", "cycle_s", "offset_s", "file",
    "remark",
];

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
    let row = |cells: [String; 12]| head.iter().cloned().chain(cells).collect::<Vec<_>>();
    let empty = String::new;
    let file = file.unwrap_or_default();
    let Some(programs) = &plan.programs else {
        let program = if plan.source == Source::Decides { "none" } else { "unknown" };
        if !plan.phases.is_empty() {
            let phases = |(signal, phases): &(String, String)| {
                let mut cells: [String; 12] = std::array::from_fn(|_| empty());
                (cells[0], cells[1]) = (signal.clone(), program.to_owned());
                cells[11] = format!("decides every second; {phases}");
                row(cells)
            };
            return plan.phases.iter().map(phases).collect();
        }
        let mut cells: [String; 12] = std::array::from_fn(|_| empty());
        cells[1] = program.to_owned();
        cells[11] = remark(plan, None);
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
            let mut cells: [String; 12] = std::array::from_fn(|_| empty());
            (cells[0], cells[1]) = (program.signal.clone(), kind.to_owned());
            (cells[10], cells[11]) = (file.to_owned(), remark.clone());
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
                number(Some(program.offset_s).filter(|_| fixed && !program.own)),
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
