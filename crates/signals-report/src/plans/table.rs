//! `plans.csv`: a row per green of every plan, or one that says why there is none.

use super::task_plan::TaskPlan;
use evaluation::analysis::Analysis;
use signals::existing::ran::greens;
use signals::program::ProgramKind;

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
    if plan.programs.is_empty() {
        let none = |signal: &str, remark: String| {
            let mut cells: [String; 12] = std::array::from_fn(|_| empty());
            (cells[0], cells[1], cells[11]) = (signal.to_owned(), "none".to_owned(), remark);
            row(cells)
        };
        if plan.phases.is_empty() {
            return vec![none("", "its record has no program".to_owned())];
        }
        let phases = |(signal, phases): &(String, String)| {
            none(signal, format!("decides every second; {phases}"))
        };
        return plan.phases.iter().map(phases).collect();
    }
    let mut all = Vec::new();
    for program in &plan.programs {
        let kind = match (program.own, program.kind) {
            (true, ProgramKind::Static) => "the network's own",
            (true, _) => "the network's own, not fixed",
            (false, kind) => kind.name(),
        };
        let remark = match program.kind {
            ProgramKind::Actuated => {
                "SUMO prolongs greens from green_s up to max_green_s while vehicles follow closely"
            }
            _ => "",
        };
        let greens = greens(program);
        if greens.is_empty() {
            let mut cells: [String; 12] = std::array::from_fn(|_| empty());
            (cells[0], cells[1]) = (program.signal.clone(), kind.to_owned());
            (cells[10], cells[11]) = (file.to_owned(), remark.to_owned());
            all.push(row(cells));
        }
        let total_s: f64 = program.phases.iter().map(|p| p.duration_s).sum();
        let fixed = program.kind == ProgramKind::Static;
        for (i, green) in greens.into_iter().enumerate() {
            all.push(row([
                program.signal.clone(),
                kind.to_owned(),
                (i + 1).to_string(),
                green.state,
                green.green_s.to_string(),
                number(green.max_s),
                green.yellow_s.to_string(),
                green.all_red_s.to_string(),
                number(Some(total_s).filter(|_| fixed)),
                number(Some(program.offset_s).filter(|_| fixed && !program.own)),
                file.to_owned(),
                remark.to_owned(),
            ]));
        }
    }
    all
}
