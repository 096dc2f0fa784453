//! Writes `plans.csv` and the folder `plans/`.

use std::fs;
use std::path::{Path, PathBuf};

use super::beside::{Beside, refused};
use super::config::{Show, configuration, set_by_run, way_to};
use super::program_xml::additional;
use super::table;
use super::task_plan::TaskPlan;
use crate::shown::Seen;
use basics::files::{self, FileError, limits, lines, write_atomically};
use basics::hash::sha256;
use evaluation::analysis::Analysis;
use evaluation::report::{csv, format};
use evaluation::store::manifest::PointRow;
use signals::control::program as own_program;
use signals::environment::given;
use signals::network_files::{GENERATED, NetworkFiles, file_name};
use signals::program::{ProgramKind, SignalProgram};
use signals::sim::intake::Intake;
use signals::sim::mutual::Mutual;
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
    /// Configurations that show the best method.
    pub(crate) configurations: usize,
    /// Why a configuration is missing that could be there, if one is.
    pub(crate) missing: Option<String>,
}

/// Removes a folder that an earlier report left, not what it points to.
///
/// # Errors
///
/// [`FileError`] when it cannot be removed.
pub(crate) fn remove_earlier(folder: &Path) -> Result<(), FileError> {
    match fs::symlink_metadata(folder) {
        Ok(about) if about.is_symlink() => fs::remove_file(folder),
        Ok(_) => fs::remove_dir_all(folder),
        Err(_) => Ok(()),
    }
    .map_err(FileError::at("remove", folder))
}

/// Writes the plans of a report into its folder; what an earlier report left there is replaced.
///
/// # Errors
///
/// [`FileError`] when a file cannot be written.
pub(crate) fn write(folder: &Path, seen: Seen<'_>) -> Result<Written, FileError> {
    let Seen { data, shown } = seen;
    let plans = folder.join(FOLDER);
    remove_earlier(&plans)?;
    let mut written = Written { table: folder.join(TABLE), ..Written::default() };
    let titles = shown.titles(data);
    let titled = csv::Titled(titles.as_deref());
    let mut rows = vec![titled.header(table::HEADER.map(str::to_owned).to_vec())];
    let mut of_points: Vec<Vec<&TaskPlan>> = vec![Vec::new(); data.points.len()];
    shown.plans.iter().for_each(|plan| of_points[plan.point].push(plan));
    for (point, own) in of_points.into_iter().enumerate() {
        let best = best_replicates(seen, &own);
        let begin_s = begin_s(data, &data.points[point].row, &plans);
        let mutual = mutual(data, &data.points[point].row, &plans);
        for plan in own {
            let is_shown = best.iter().any(|s| std::ptr::eq(*s, plan));
            let file = if is_shown { program_file(seen, plan, begin_s, &mutual) } else { None };
            if let Some(ProgramFile { name, text, .. }) = &file {
                make(&plans)?;
                write_atomically(&plans.join(name), text.as_bytes())?;
                written.programs += 1;
            }
            if is_shown && data.winners[point].as_ref().is_some_and(|w| w.best == plan.method) {
                show(&plans, seen, plan, file.as_ref(), &mut written)?;
            }
            let streets = shown.streets_of(&data.points[point].row.point);
            let cells = table::rows(data, streets, plan, file.as_ref().map(|f| f.name.as_str()));
            rows.extend(cells.into_iter().map(|cells| titled.row(point, cells)));
        }
    }
    write_atomically(&written.table, &lines(&rows))?;
    Ok(written)
}

fn make(folder: &Path) -> Result<(), FileError> {
    fs::create_dir_all(folder).map_err(FileError::at("create", folder))
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

/// A file with the programs of a plan.
struct ProgramFile {
    name: String,
    text: String,
    /// Whether SUMO refuses the programs in an additional file.
    is_refused: bool,
}

/// Returns a plan's file for SUMO; `None` where there is nothing to load.
///
/// SUMO enters an actuated program that it loads where a fixed cycle would be at the begin, and a run enters it in its
/// first phase. An offset of the begin makes the two the same.
fn program_file(
    seen: Seen<'_>,
    plan: &TaskPlan,
    begin_s: f64,
    mutual: &Mutual,
) -> Option<ProgramFile> {
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
    let mut lines = comment(seen, plan);
    let refused = refused(mutual, &programs);
    lines.extend(refused.map(|(signal, (a, b))| {
        format!(
            "SUMO refuses it with -a, since the links {a} and {b} of signal {signal} yield to each other: copy its tlLogic \
             elements into the network, behind the last one there"
        )
    }));
    let text = additional(method, &programs, own, &lines)?;
    let name = match method {
        TUNED => format!("{}.add.xml", point.point),
        other => format!("{}.{other}.add.xml", point.point),
    };
    Some(ProgramFile { name, text, is_refused: refused.is_some() })
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

/// Writes the configuration that shows the best method of a point MDP.
fn show(
    plans: &Path,
    seen: Seen<'_>,
    plan: &TaskPlan,
    file: Option<&ProgramFile>,
    written: &mut Written,
) -> Result<(), FileError> {
    let data = seen.data;
    let identity = &data.manifest.identity;
    let point = &identity.points[plan.point];
    let (own, text) = match own_configuration(data, point, plans) {
        Ok(found) => found,
        Err(reason) => {
            written.missing.get_or_insert(reason);
            return Ok(());
        }
    };
    let method = &identity.methods[plan.method];
    if *method != own_program::METHOD.name && has_day_plan(point, &own) {
        written.missing.get_or_insert_with(|| {
            format!(
                "{}: its signals change their programs by the clock (<WAUT>), and would leave those of {method}; \
                 `tsc-family routes --run` writes an episode without that",
                own.display()
            )
        });
        return Ok(());
    }
    make(plans)?;
    let path = plans.join(format!("{}.winner.sumocfg", point.point));
    match winner(plans, seen, plan, file, (&own, &text)) {
        Ok(text) => {
            write_atomically(&path, text.as_bytes())?;
            written.configurations += 1;
        }
        Err(reason) => {
            written.missing.get_or_insert(reason);
        }
    }
    Ok(())
}

/// Returns the text of the configuration that shows the best method of a point MDP, and writes copies of the scenario's
/// files that it needs.
///
/// # Errors
///
/// Why it cannot be had.
fn winner(
    plans: &Path,
    seen: Seen<'_>,
    plan: &TaskPlan,
    file: Option<&ProgramFile>,
    (own, text): (&Path, &str),
) -> Result<String, String> {
    let identity = &seen.data.manifest.identity;
    let point = &identity.points[plan.point];
    let seed = point.evaluation_seeds(&identity.evaluation_seeds).first().copied();
    let mut comment = comment(seen, plan);
    comment.push("open it with: sumo-gui -c THIS_FILE".to_owned());
    if let (Some(seed), true) = (seed, point.environment == GENERATED) {
        comment.push(format!(
            "the vehicles of the recorded episode: tsc-family routes with this point and seed {seed}, \
             then add the option route-files"
        ));
    }
    let way = way_to(own, plans).map_err(|e| e.to_string())?;
    let mut replaced =
        set_by_run(identity, point, seed.unwrap_or_default()).map_err(|e| e.to_string())?;
    let mut additional = file.map(|file| file.name.as_str());
    if point.environment != GENERATED {
        let copies = format!("{}.scenario", point.point);
        let beside = Beside { own, point, folder: plans, copies: &copies, day_plan: true };
        let refused = file.filter(|file| file.is_refused).map(|file| file.text.as_str());
        let handed = beside.write(refused).map_err(|e| e.to_string())?;
        replaced.extend(handed.replaced);
        additional = additional.filter(|_| !handed.is_inside);
    }
    let show = Show { text, way: &way, additional, replaced: &replaced, comment: &comment };
    configuration(&show).map_err(|reason| format!("{}: {reason}", own.display()))
}

/// Returns when the episodes of a point MDP begin, seconds; 0 where that is not to be had.
fn begin_s(data: &Analysis, point: &PointRow, plans: &Path) -> f64 {
    if point.environment == GENERATED {
        return 0.0;
    }
    let own = || {
        let (path, text) = own_configuration(data, point, plans).ok()?;
        SumoConfig::parse(&text, &path).ok().map(|config| config.begin_s)
    };
    let given = given(point).ok().and_then(|given| given.begin_s);
    given.or_else(own).unwrap_or_default()
}

/// Returns the links of a scenario's network that yield to each other; none where that is not to be had, and of a generated
/// network, with which SUMO takes every program.
fn mutual(data: &Analysis, point: &PointRow, plans: &Path) -> Mutual {
    let own = || {
        let (path, text) = own_configuration(data, point, plans).ok()?;
        let config = SumoConfig::parse(&text, &path).ok()?;
        Mutual::of_scenario(&config).ok()
    };
    let found = if point.environment == GENERATED { None } else { own() };
    found.unwrap_or_default()
}

/// Whether the programs of a scenario change by the clock.
fn has_day_plan(point: &PointRow, own: &Path) -> bool {
    let intake = || Intake::read(own, &given(point).ok()?).ok();
    point.environment != GENERATED && intake().is_some_and(|i| i.sources.has_day_plan())
}

/// Returns the configuration of a point MDP's own scenario and its text: from where the run found it,
/// seen from the current folder or from one that the results lie in.
///
/// # Errors
///
/// Why it is not to be had.
fn own_configuration(
    data: &Analysis,
    point: &PointRow,
    plans: &Path,
) -> Result<(PathBuf, String), String> {
    let networks = Path::new(&data.manifest.provenance.networks);
    let configs = match point.environment.as_str() {
        // The second is where earlier versions had it.
        GENERATED => vec![
            NetworkFiles::new(networks, &point.point, point.sha256.clone()).sumocfg,
            networks.join(&point.point).join(file_name(&point.point, "sumocfg")),
        ],
        environment => vec![PathBuf::from(environment)],
    };
    let above = fs::canonicalize(plans.parent().unwrap_or(plans)).unwrap_or_default();
    let folders = || std::iter::once(Path::new("")).chain(above.ancestors());
    let found = (configs.iter())
        .find_map(|config| folders().map(|f| f.join(config)).find(|path| path.is_file()));
    let config = found.ok_or_else(|| {
        format!(
            "{} is not here; report from the folder that the run was started in, with its networks",
            configs[configs.len() - 1].display()
        )
    })?;
    let network = config.with_extension("net.xml");
    for file in [&config, &network] {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        if let Some(planned) = point.sha256.get(&*name) {
            let bytes = files::read(file, limits::NETWORK).map_err(|e| e.to_string())?;
            if sha256(&bytes) != *planned {
                return Err(format!("{} was altered since the run; restore it", file.display()));
            }
        }
    }
    let text = files::read_text(&config, limits::NETWORK).map_err(|e| e.to_string())?;
    Ok((config, text))
}
