//! Writes `plans.csv` and the folder `plans/`.

use std::fs;
use std::path::{Path, PathBuf};

use super::TaskPlan;
use super::program_xml::additional;
use crate::shown::Seen;
use basics::files::{FileError, lines, write_atomically};
use evaluation::analysis::Analysis;
use evaluation::report::{csv, format};
use evaluation::store::manifest::PointRow;
use signals::environment::given;
use signals::existing::ran::greens;
use signals::network_files::GENERATED;
use signals::program::{ProgramKind, SignalProgram};
use signals::sim::sumocfg::SumoConfig;

/// The method whose plans are tuned.
const TUNED: &str = "fixed-time";

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "plans.csv";

/// Name of the folder within the report.
pub(crate) const FOLDER: &str = "plans";

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Written {
    /// `plans.csv`.
    pub(crate) table: PathBuf,
    /// Files in `plans/` for `sumo -a`.
    pub(crate) programs: usize,
}

/// Removes a folder that an earlier report left, not what it points to.
pub(crate) fn remove_earlier(folder: &Path) -> Result<(), FileError> {
    match fs::symlink_metadata(folder) {
        Ok(about) if about.is_symlink() => fs::remove_file(folder),
        Ok(_) => fs::remove_dir_all(folder),
        Err(_) => Ok(()),
    }
    .map_err(FileError::at("remove", folder))
}

/// Writes the plans of a report into its folder; what an earlier report left there is replaced.
pub(crate) fn write(folder: &Path, seen: Seen<'_>) -> Result<Written, FileError> {
    let Seen { data, shown } = seen;
    let plans = folder.join(FOLDER);
    remove_earlier(&plans)?;
    let mut written = Written { table: folder.join(TABLE), ..Written::default() };
    let titles = shown.titles(data);
    let titled = csv::Titled(titles.as_deref());
    let mut all = vec![titled.header(HEADER.map(str::to_owned).to_vec())];
    let mut of_points: Vec<Vec<&TaskPlan>> = vec![Vec::new(); data.points.len()];
    shown.plans.iter().for_each(|plan| of_points[plan.point].push(plan));
    for (point, own) in of_points.into_iter().enumerate() {
        let best = best_replicates(seen, &own);
        let begin_s = begin_s(&data.points[point].row, &plans);
        for plan in own {
            let is_shown = best.iter().any(|s| std::ptr::eq(*s, plan));
            let file = if is_shown { program_file(seen, plan, begin_s) } else { None };
            if let Some((name, text)) = &file {
                fs::create_dir_all(&plans).map_err(FileError::at("create", &plans))?;
                write_atomically(&plans.join(name), text.as_bytes())?;
                written.programs += 1;
            }
            let streets = shown.streets_of(&data.points[point].row.point);
            let cells = rows(data, streets, plan, file.as_ref().map(|(name, _)| name.as_str()));
            all.extend(cells.into_iter().map(|cells| titled.row(point, cells)));
        }
    }
    write_atomically(&written.table, &lines(&all))?;
    Ok(written)
}

/// Returns one plan per method with programs on a point MDP: of several trainings that of the best
/// objective.
fn best_replicates<'a>(seen: Seen<'_>, own: &[&'a TaskPlan]) -> Vec<&'a TaskPlan> {
    let mut best: Vec<&TaskPlan> = Vec::new();
    let direction = seen.data.direction();
    for plan in own.iter().copied().filter(|p| !p.programs.is_empty()) {
        match best.iter_mut().find(|b| b.method == plan.method) {
            Some(other) if plan.is_better_than(other, direction) => *other = plan,
            Some(_) => {}
            None => best.push(plan),
        }
    }
    best
}

/// Returns name and text of a plan's file for SUMO; `None` where there is nothing to load.
///
/// SUMO enters an actuated program that it loads where a fixed cycle would be at the begin, and a run enters it in its
/// first phase. An offset of the begin makes the two the same.
fn program_file(seen: Seen<'_>, plan: &TaskPlan, begin_s: f64) -> Option<(String, String)> {
    let identity = &seen.data.manifest.identity;
    let (point, method) = (&identity.points[plan.point], identity.methods[plan.method].as_str());
    let own = point.environment == GENERATED && method == TUNED;
    let of_plan = |program: &SignalProgram| match program.kind {
        ProgramKind::Actuated if !program.own => {
            SignalProgram { offset_s: begin_s, ..program.clone() }
        }
        _ => program.clone(),
    };
    let programs: Vec<SignalProgram> = plan.programs.iter().map(of_plan).collect();
    let text = additional(method, &programs, own, &comment(seen, plan))?;
    let name = match method {
        TUNED => format!("{}.add.xml", point.point),
        other => format!("{}.{other}.add.xml", point.point),
    };
    Some((name, text))
}

/// Says what a plan is.
fn comment(seen: Seen<'_>, plan: &TaskPlan) -> Vec<String> {
    let identity = &seen.data.manifest.identity;
    let (point, method) = (&identity.points[plan.point].point, &identity.methods[plan.method]);
    let streets = seen.shown.streets_of(point).map_or_else(String::new, |s| format!(" ({s})"));
    let mut lines = vec![format!("{method} on {point}{streets}")];
    if let Some(value) = plan.objective {
        let n = format::count(identity.evaluation_seeds.len(), "evaluation episode");
        lines.push(format!("{} {} over {n}", identity.objective, format::amount(value)));
    }
    if identity.replicates_of(method) > 1 {
        lines.push(format!("training {} of those that were recorded, the best", plan.replicate));
    }
    lines
}

/// Returns when the episodes of a point MDP begin, seconds; 0 where that is not to be had. Its scenario may lie in the current
/// folder, or in one that the results lie in.
fn begin_s(point: &PointRow, plans: &Path) -> f64 {
    if point.environment == GENERATED {
        return 0.0;
    }
    let given = given(point).ok().and_then(|given| given.begin_s);
    let above = fs::canonicalize(plans.parent().unwrap_or(plans)).unwrap_or_default();
    let mut folders = std::iter::once(Path::new("")).chain(above.ancestors());
    let own = || {
        let found =
            folders.find_map(|folder| SumoConfig::read(&folder.join(&point.environment)).ok());
        found.map(|config| config.begin_s)
    };
    given.or_else(own).unwrap_or_default()
}

/// The columns.
const HEADER: [&str; 18] = [
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
fn rows(
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
