//! `tsc-family routes`: a recorded episode, for plain `sumo` and `sumo-gui`.

use std::fs;
use std::path::{Path, PathBuf};

use super::build_networks::network;
use super::folder::{EPISODE, check_file};
use super::output::{line, note};
use super::point::unknown_point;
use super::scenario::ScenarioArg;
use crate::cli::exit::{self, Refused, refuse};
use crate::files::{FileError, quoted, write_atomically};
use crate::hash::sha256;
use crate::store::Layout;
use crate::store::manifest::{Identity, PointRow, Task};
use crate::store::record::{Metrics, Outcome, Record, Summary};
use crate::store::results::Results;
use crate::suggest::did_you_mean;
use crate::traffic::city::default_folder;
use crate::traffic::domain::Traffic;
use crate::traffic::network::demand::DemandSpec;
use crate::traffic::program::SignalProgram;
use crate::traffic::report::plans::episode::{CONFIGURATION, Episode};
use crate::traffic::trial::DELAY;

/// `tsc-family routes`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
With --run, an episode of a run is played again. FOLDER gets what each signal showed, the vehicles and \
episode.sumocfg: sumo-gui -c shows the episode, and plain sumo repeats it. A learned method is not trained \
again, and a tuned one not tuned: the model or plan of the run is taken.

Without --run, FILE gets the vehicles of a seed, and the command that simulates them under the network's own \
signal program, as the baseline does, is printed. The delay of a record is the mean of timeLoss + departDelay \
over all vehicles in trips.xml.

Examples:
  tsc-family routes --run results/smoke --point busy --method nema --out results/smoke-episode
  tsc-family routes --point busy smoke --seed 1889785958 --out busy.rou.xml")]
pub struct RoutesArgs {
    /// Scenario that has the point MDP
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Results directory that `run` wrote, whose episode is played again
    #[arg(long, value_name = "DIR", requires = "method", conflicts_with_all = ["scenario", "set", "preset"])]
    pub run: Option<PathBuf>,
    /// Id or title of the point MDP; its network is built if it is missing
    #[arg(long, value_name = "ID")]
    pub point: String,
    /// Method of the run
    #[arg(long, value_name = "NAME", requires = "run")]
    pub method: Option<String>,
    /// Seed of the episode [default with --run: the first evaluation episode]
    #[arg(long, value_name = "S", required_unless_present = "run")]
    pub seed: Option<u64>,
    /// Training, from 0, of a method that was trained several times
    #[arg(long, value_name = "R", default_value_t = 0)]
    pub replicate: u32,
    /// Route file to write, or folder of the episode
    #[arg(long, value_name = "FILE|FOLDER")]
    pub out: PathBuf,
    /// Folder of the networks [default: that of the run, or networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
}

pub(super) fn run(args: &RoutesArgs) -> anyhow::Result<u8> {
    match (&args.run, &args.method, args.seed) {
        (Some(dir), Some(method), _) => episode(args, dir, method),
        (None, _, Some(seed)) => vehicles(args, seed),
        _ => refuse("give --run with --method, or --seed"),
    }
}

fn vehicles(args: &RoutesArgs, seed: u64) -> anyhow::Result<u8> {
    check_file(&args.out, "--out", &[b"<routes"], "route file")?;
    let loaded = args.scenario.signals(&args.scenario.settings())?;
    let Some(index) = loaded.family.position(&args.point) else {
        return Err(unknown_point(&args.point, &loaded, &args.scenario.scenario).into());
    };
    let point = &loaded.family.points[index].id;
    let networks =
        args.networks.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, &loaded));
    let files = network(&loaded, point, &networks)?;
    let demand = DemandSpec::read(&files.demand)?;
    let (vehicles, text) = demand.routes(seed);
    write_atomically(&args.out, text.as_bytes())?;
    line(command(&files.sumocfg, &args.out, seed, loaded.scenario.simulation.time_to_teleport_s))?;
    let sha256 = sha256(text.as_bytes());
    note(format!("{vehicles} vehicles in {}, sha256 {sha256}", args.out.display()));
    Ok(exit::DONE)
}

/// Returns the command that simulates the episode under the network's own signal program, as the
/// baseline does.
fn command(config: &Path, out: &Path, seed: u64, time_to_teleport_s: f64) -> String {
    let (config, routes) = (quoted(config), quoted(out));
    format!(
        "sumo -c {config} --route-files {routes} --seed {seed} --time-to-teleport \
         {time_to_teleport_s} --tripinfo-output trips.xml --tripinfo-output.write-unfinished \
         --tripinfo-output.write-undeparted"
    )
}

/// Plays an episode of a run again and writes it.
fn episode(args: &RoutesArgs, dir: &Path, method: &str) -> anyhow::Result<u8> {
    EPISODE.check(&args.out, "--out", None)?;
    let layout = Layout::new(dir);
    let results = Results::load(&layout)?;
    let identity = &results.manifest.identity;
    if identity.domain != Traffic::NAME {
        return refuse(format!("{} has no signals: it is of {}", dir.display(), identity.domain));
    }
    let point = point_of(identity, dir, &args.point)?;
    let record = record_of(&results, (dir, &point.point), method, args.replicate)?;
    let seed = seed_of(record, args.seed)?;
    let networks = args.networks.as_deref();
    let networks = networks.unwrap_or(Path::new(&results.manifest.provenance.networks));
    let (metrics, programs) = play(&layout, (identity, point, networks), &record.summary, seed)?;
    compare(record, seed, &metrics);
    let create = FileError::at("create", &args.out);
    fs::create_dir_all(&args.out).map_err(create)?;
    let programs = programs.as_slice();
    let episode = Episode { identity, point, networks, method, seed, programs };
    for (name, text) in episode.files(&args.out)? {
        write_atomically(&args.out.join(name), text.as_bytes())?;
    }
    line(format!("sumo-gui -c {}", quoted(&args.out.join(CONFIGURATION))))?;
    note(format!("{} has {method} on {}, seed {seed}", args.out.display(), point.point));
    Ok(exit::DONE)
}

fn point_of<'a>(identity: &'a Identity, dir: &Path, name: &str) -> anyhow::Result<&'a PointRow> {
    let points = &identity.points;
    let is = |p: &&PointRow| p.point == name || p.title == name;
    Ok(points.iter().find(is).ok_or_else(|| {
        let hint = did_you_mean(name, points.iter().map(|p| p.point.as_str()));
        let (dir, first) = (dir.display(), points.first().map_or("none", |p| &p.point));
        Refused(format!(
            "{dir} has no point MDP {name:?}{hint}; it has {} such as {first}",
            points.len()
        ))
    })?)
}

/// Returns the record of a task, whose evaluation is complete.
fn record_of<'a>(
    results: &'a Results,
    (dir, point): (&Path, &str),
    method: &str,
    replicate: u32,
) -> anyhow::Result<&'a Record> {
    let (dir, methods) = (dir.display(), &results.manifest.identity.methods);
    if !methods.iter().any(|own| own == method) {
        let hint = did_you_mean(method, methods.iter().map(String::as_str));
        let methods = methods.join(", ");
        return refuse(format!("{dir} has no method {method:?}{hint}; it has {methods}"));
    }
    let is =
        |task: &Task| task.point == point && task.method == method && task.replicate == replicate;
    let reason = match results.rows().find(|(task, _)| is(task)).map(|(_, record)| record) {
        None => {
            format!("{dir} has no training {replicate} of {method} on {point}; they count from 0")
        }
        Some(None) => format!(
            "{dir} has no record of {method} on {point} yet; finish the run first: give `run` the same --out"
        ),
        Some(Some(record)) if record.summary.outcome == Outcome::Failed => {
            let why = record.summary.reason.as_deref().unwrap_or("no reason is known");
            format!("{method} failed on {point} in {dir}: {why}")
        }
        Some(Some(record)) => return Ok(record),
    };
    refuse(reason)
}

fn seed_of(record: &Record, seed: Option<u64>) -> anyhow::Result<u64> {
    let seeds: Vec<u64> = record.evaluations().map(|row| row.seed).collect();
    let first = seeds.first().copied();
    match seed {
        None => Ok(first.ok_or_else(|| Refused("the record has no evaluation episode".into()))?),
        Some(seed) if seeds.contains(&seed) => Ok(seed),
        Some(seed) => {
            let some: Vec<String> = seeds.iter().take(5).map(u64::to_string).collect();
            let some = some.join(", ");
            let reason = format!("--seed {seed} is of no evaluation episode; the first are {some}");
            refuse(reason)
        }
    }
}

/// Warns where the episode is not the one that was recorded.
fn compare(record: &Record, seed: u64, metrics: &Metrics) {
    let then = record.evaluations().find(|row| row.seed == seed);
    let then = then.and_then(|row| row.metrics.get(DELAY));
    let now = metrics.get(DELAY);
    if let (Some(then), Some(now)) = (then, now)
        && then != now
    {
        note(format!(
            "warning: this is not the episode that was recorded: its mean delay is {now:.3} s, and was {then:.3} s; another \
             build or another SUMO made the record"
        ));
    }
}

fn play(
    layout: &Layout,
    (identity, point, prepared): (&Identity, &PointRow, &Path),
    summary: &Summary,
    seed: u64,
) -> anyhow::Result<(Metrics, Vec<SignalProgram>)> {
    use crate::run::domain::Site;
    use crate::traffic::replay::replay;
    use crate::traffic::sim::libsumo::SumoSim;

    let scratch = super::temporary_folder()?;
    let site = Site { settings: &identity.settings, point, prepared, scratch: scratch.path() };
    Ok(replay(SumoSim::new()?, layout, &site, summary, seed)?)
}
