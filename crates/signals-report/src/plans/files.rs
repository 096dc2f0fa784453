//! Writes `plans.csv` and the folder `plans/`.

use std::fs;
use std::path::{Path, PathBuf};

use super::TaskPlan;
use super::program_xml::additional;
use crate::shown::Seen;
use basics::files::{FileError, write_atomically};
use evaluation::report::table::{Cell, Columns};
use evaluation::store::manifest::PointRow;
use signals::environment::given;
use signals::existing::ran::{Green, greens};
use signals::network_files::GENERATED;
use signals::program::{ProgramKind, SignalProgram};
use signals::sim::sumocfg::SumoConfig;

/// The method whose plans are tuned.
const TUNED: &str = "fixed-time";

/// Name of the table in the report's folder.
pub(crate) const TABLE: &str = "plans.csv";

/// Name of the folder within the report.
pub(crate) const FOLDER: &str = "plans";

/// Removes a folder that an earlier report left, not what it points to.
pub(crate) fn remove_earlier(folder: &Path) -> Result<(), FileError> {
    match fs::symlink_metadata(folder) {
        Ok(about) if about.is_symlink() => fs::remove_file(folder),
        Ok(_) => fs::remove_dir_all(folder),
        Err(_) => Ok(()),
    }
    .map_err(FileError::at("remove", folder))
}

/// Writes the plans of a report into its folder, and returns the path of the table; what an earlier report left there is
/// replaced.
pub(crate) fn write(folder: &Path, seen: Seen<'_>) -> Result<PathBuf, FileError> {
    let Seen { data, shown } = seen;
    let plans = folder.join(FOLDER);
    remove_earlier(&plans)?;
    let mut all = Vec::new();
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
            }
            all.extend(rows(plan, file.map_or_else(String::new, |(name, _)| name)));
        }
    }
    let table = folder.join(TABLE);
    write_atomically(&table, columns(seen).table(all).csv().as_bytes())?;
    Ok(table)
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
    let mut programs = plan.programs.clone();
    let loaded = programs.iter_mut().filter(|p| p.kind == ProgramKind::Actuated && !p.own);
    loaded.for_each(|program| program.offset_s = begin_s);
    let text = additional(method, &programs, own, &[format!("{method} on {}", point.point)])?;
    let name = match method {
        TUNED => format!("{}.add.xml", point.point),
        other => format!("{}.{other}.add.xml", point.point),
    };
    Some((name, text))
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
    let mut own = || folders.find_map(|f| SumoConfig::read(&f.join(&point.environment)).ok());
    given.or_else(|| Some(own()?.begin_s)).unwrap_or_default()
}

/// A row: a plan, and of the program of a signal one green with its place.
struct Row<'a> {
    plan: &'a TaskPlan,
    signal: &'a str,
    program: Option<&'a SignalProgram>,
    green: Option<(usize, Green)>,
    /// Name of the file for SUMO that has it.
    file: String,
    remark: String,
}

fn columns(Seen { data, shown }: Seen<'_>) -> Columns<'_, Row<'_>> {
    let identity = &data.manifest.identity;
    let point = |row: &Row<'_>| &identity.points[row.plan.point].point;
    let wins = |row: &Row<'_>| {
        data.winners[row.plan.point].as_ref().is_some_and(|w| w.best == row.plan.method)
    };
    let kind = |row: &Row<'_>| match row.program.map(|program| (program.own, program.kind)) {
        None => "none",
        Some((true, ProgramKind::Static)) => "the network's own",
        Some((true, _)) => "the network's own, not fixed",
        Some((false, kind)) => kind.name(),
    };
    let of_cycle = |of: fn(&SignalProgram) -> Option<f64>| {
        move |row: &Row<'_>| {
            let program = row.program.filter(|_| row.green.is_some());
            Cell::exact(program.filter(|p| p.kind == ProgramKind::Static).and_then(of))
        }
    };
    let green = |of: fn(&Green) -> Option<f64>| {
        move |row: &Row<'_>| Cell::exact(row.green.as_ref().and_then(|(_, green)| of(green)))
    };
    let number = |row: &Row<'_>| row.green.as_ref().map(|(place, _)| Cell::count(place + 1));
    let state = |row: &Row<'_>| row.green.as_ref().map(|(_, green)| green.state.clone());
    let columns = Columns::new()
        .text("point", "", move |row: &Row<'_>| point(row).clone())
        .text("streets", "", move |row| shown.streets_of(point(row)).unwrap_or_default())
        .text("method", "", |row| identity.methods[row.plan.method].clone())
        .file("replicate", |row| Cell::count(row.plan.replicate as usize))
        .file("delay_s", |row| Cell::exact(row.plan.objective))
        .text("winner", "", move |row| if wins(row) { "yes" } else { "no" }.to_owned())
        .text("signal", "", |row| row.signal.to_owned())
        .text("program", "", move |row| kind(row).to_owned())
        .file("green", move |row| number(row).unwrap_or_else(Cell::unknown))
        .text("state", "", move |row| state(row).unwrap_or_default())
        .file("green_s", green(|green| Some(green.green_s)))
        .file("max_green_s", green(|green| green.max_s))
        .file("yellow_s", green(|green| Some(green.yellow_s)))
        .file("all_red_s", green(|green| Some(green.all_red_s)))
        .file("cycle_s", of_cycle(|p| Some(p.phases.iter().map(|phase| phase.duration_s).sum())))
        .file("offset_s", of_cycle(|p| (!p.own).then_some(p.offset_s)))
        .text("file", "", |row| row.file.clone())
        .text("remark", "", |row| row.remark.clone());
    match shown.titles(data) {
        Some(titles) => columns.text("title", "", move |row| titles[row.plan.point].clone()),
        None => columns,
    }
}

fn rows(plan: &TaskPlan, file: String) -> Vec<Row<'_>> {
    let row = |signal, program, green, remark: &str| {
        let (file, remark) = (file.clone(), format!("{remark}{}", plan.chosen));
        Row { plan, signal, program, green, file, remark }
    };
    if !plan.programs.is_empty() {
        let mut rows = Vec::new();
        for program in &plan.programs {
            let remark = match program.kind {
                ProgramKind::Actuated => {
                    "SUMO prolongs greens from green_s up to max_green_s while vehicles follow closely"
                }
                _ => "",
            };
            let greens: Vec<_> = greens(program).into_iter().enumerate().map(Some).collect();
            let greens = if greens.is_empty() { vec![None] } else { greens };
            let of = |green| row(program.signal.as_str(), Some(program), green, remark);
            rows.extend(greens.into_iter().map(of));
        }
        return rows;
    }
    let rings = plan.rings.iter().filter(|program| program.kind == ProgramKind::DualRing);
    let rings = rings.map(|program| program.signal.as_str());
    let of = |signal| row(signal, None, None, "decides every second; phases in cabinet.csv");
    let rows: Vec<Row<'_>> = rings.map(of).collect();
    if rows.is_empty() { vec![row("", None, None, "its record has no program")] } else { rows }
}
