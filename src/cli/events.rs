//! `tsc-family events`: a recorded episode as a high-resolution data logger writes it.

use std::fs;
use std::path::{Path, PathBuf};

use super::folder::EVENTS;
use super::output::{line, note};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::files::{FileError, quoted, write_atomically};
use crate::store::Layout;
use crate::store::manifest::{Identity, PointRow, Task};
use crate::store::record::{Metrics, Outcome, Record, Summary};
use crate::store::results::Results;
use crate::suggest::did_you_mean;
use crate::traffic::domain::Traffic;
use crate::traffic::env::high_resolution::Recording;
use crate::traffic::events::{detectors, events, phases, start};
use crate::traffic::report::plans::episode::{CONFIGURATION, Episode};
use crate::traffic::trial::DELAY;

/// Where advance detectors lie unless somebody says otherwise, metres before the stop line: 5 s at 45 mph.
const ADVANCE_M: f64 = 100.0;

/// Farthest place of an advance detector, metres.
const MOST_ADVANCE_M: f64 = 1000.0;

/// `tsc-family events`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Plays an episode of a run again and writes what its signals and detectors did: events.csv has Indiana codes, \
detectors.csv the channels, phases.csv the phases. The Python package atspm takes the first two as raw_data \
and detector_config. sumo-gui -c FOLDER/episode.sumocfg shows the episode, and plain sumo repeats it. A \
learned method is not trained again, and a tuned one not tuned: the model or plan of the run is taken.

Example:
  tsc-family events results/smoke --point busy --method nema --out results/smoke-events")]
pub struct EventsArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Id or title of the point MDP
    #[arg(long, value_name = "ID")]
    pub point: String,
    /// Method
    #[arg(long, value_name = "NAME")]
    pub method: String,
    /// Seed of the episode, one of `episodes.csv` [default: the first evaluation episode]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
    /// Training, from 0, of a method that was trained several times
    #[arg(long, value_name = "R", default_value_t = 0)]
    pub replicate: u32,
    /// Distance of advance detectors to the stop line in metres, as far as lanes allow
    #[arg(long, value_name = "M", default_value_t = ADVANCE_M, value_parser = metres)]
    pub advance_m: f64,
    /// Day, or day and time, of simulated second 0
    #[arg(long, value_name = "TIME", default_value = "2000-01-01")]
    pub start: String,
    /// Folder of the networks [default: that of the run]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Folder to write
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
}

fn metres(text: &str) -> Result<f64, String> {
    let metres = text.parse().ok().filter(|m| (10.0..=MOST_ADVANCE_M).contains(m));
    metres.ok_or_else(|| format!("expected metres from 10 to {MOST_ADVANCE_M}"))
}

pub(super) fn run(args: &EventsArgs) -> anyhow::Result<u8> {
    EVENTS.check(&args.out, "--out", None)?;
    let begins = start(&args.start).map_err(|e| Refused(format!("--start: {e}")))?;
    let layout = Layout::new(&args.dir);
    let results = Results::load(&layout)?;
    let manifest = results.manifest.clone();
    let identity = &manifest.identity;
    if identity.domain != Traffic::NAME {
        let reason = format!("{} has no signals: it is of {}", args.dir.display(), identity.domain);
        return Err(Refused(reason).into());
    }
    let point = point_of(identity, args)?;
    let record = record_of(&results, identity, &point.point, args)?;
    let seed = seed_of(record, args)?;
    let prepared =
        args.networks.clone().unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks));
    let (metrics, recording) =
        play(&layout, (identity, point, &prepared), &record.summary, (seed, args.advance_m))?;
    compare(record, seed, &metrics);
    write(
        &args.out,
        &[
            ("events.csv", events(&recording, begins)),
            ("detectors.csv", detectors(&recording)),
            ("phases.csv", phases(&recording)),
        ],
    )?;
    let networks = &prepared;
    let (method, programs) = (args.method.as_str(), recording.programs.as_slice());
    let episode = Episode { identity, point, networks, method, seed, programs };
    let files = episode.files(&args.out)?;
    let files: Vec<(&str, Vec<u8>)> =
        files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect();
    write(&args.out, &files)?;
    let (count, signals) = (recording.events.len(), recording.signals.len());
    let of = if signals == 1 { "1 signal".to_owned() } else { format!("{signals} signals") };
    line(format!("{}: {count} events of {of}, seed {seed}", args.out.display()))?;
    line(format!("look at it: sumo-gui -c {}", quoted(&args.out.join(CONFIGURATION))))?;
    Ok(exit::DONE)
}

fn point_of<'a>(identity: &'a Identity, args: &EventsArgs) -> anyhow::Result<&'a PointRow> {
    let points = &identity.points;
    let is = |p: &&PointRow| p.point == args.point || p.title == args.point;
    let found = points.iter().find(is);
    Ok(found.ok_or_else(|| {
        let names: Vec<&str> = points.iter().map(|p| p.point.as_str()).collect();
        let hint = did_you_mean(&args.point, names.iter().copied());
        let some = names.iter().take(3).copied().collect::<Vec<_>>().join(", ");
        Refused(format!(
            "{} has no point MDP {:?}{hint}; it has {some}{}",
            args.dir.display(),
            args.point,
            if names.len() > 3 { format!(" and {} more", names.len() - 3) } else { String::new() }
        ))
    })?)
}

/// Returns the record of a task, whose evaluation is complete.
fn record_of<'a>(
    results: &'a Results,
    identity: &Identity,
    point: &str,
    args: &EventsArgs,
) -> anyhow::Result<&'a Record> {
    let dir = args.dir.display();
    if !identity.methods.contains(&args.method) {
        let hint = did_you_mean(&args.method, identity.methods.iter().map(String::as_str));
        let methods = identity.methods.join(", ");
        let reason = format!("{dir} has no method {:?}{hint}; it has {methods}", args.method);
        return Err(Refused(reason).into());
    }
    let is = |task: &Task| {
        task.point == point && task.method == args.method && task.replicate == args.replicate
    };
    let Some((_, record)) = results.rows().find(|(task, _)| is(task)) else {
        let (method, replicate) = (&args.method, args.replicate);
        let reason =
            format!("{dir} has no training {replicate} of {method} on {point}; they count from 0");
        return Err(Refused(reason).into());
    };
    let (method, way_out) = (&args.method, "finish the run first: give `run` the same --out");
    match record {
        None => {
            let reason = format!("{dir} has no record of {method} on {point} yet; {way_out}");
            Err(Refused(reason).into())
        }
        Some(record) if record.summary.outcome == Outcome::Failed => {
            let why = record.summary.reason.as_deref().unwrap_or("no reason is known");
            Err(Refused(format!("{method} failed on {point} in {dir}: {why}")).into())
        }
        Some(record) => Ok(record),
    }
}

fn seed_of(record: &Record, args: &EventsArgs) -> anyhow::Result<u64> {
    let seeds: Vec<u64> = record.evaluations().map(|row| row.seed).collect();
    let first = seeds.first().copied();
    match args.seed {
        None => Ok(first.ok_or_else(|| Refused("the record has no evaluation episode".into()))?),
        Some(seed) if seeds.contains(&seed) => Ok(seed),
        Some(seed) => {
            let some: Vec<String> = seeds.iter().take(5).map(u64::to_string).collect();
            let reason = format!(
                "--seed {seed} is of no evaluation episode of {} on {}; the first are {}",
                args.method,
                args.point,
                some.join(", ")
            );
            Err(Refused(reason).into())
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

fn write(folder: &Path, files: &[(&str, Vec<u8>)]) -> Result<(), FileError> {
    fs::create_dir_all(folder).map_err(FileError::at("create", folder))?;
    files.iter().try_for_each(|(name, bytes)| write_atomically(&folder.join(name), bytes))
}

#[cfg(feature = "libsumo")]
fn play(
    layout: &Layout,
    (identity, point, prepared): (&Identity, &PointRow, &Path),
    summary: &Summary,
    (seed, advance_m): (u64, f64),
) -> anyhow::Result<(Metrics, Recording)> {
    use crate::run::domain::Site;
    use crate::traffic::replay::replay;
    use crate::traffic::sim::libsumo::SumoSim;

    let scratch = super::temporary_folder()?;
    let site = Site { settings: &identity.settings, point, prepared, scratch: scratch.path() };
    Ok(replay(SumoSim::new()?, layout, &site, summary, seed, advance_m)?)
}

#[cfg(not(feature = "libsumo"))]
fn play(
    _: &Layout,
    _: (&Identity, &PointRow, &Path),
    _: &Summary,
    _: (u64, f64),
) -> anyhow::Result<(Metrics, Recording)> {
    Err(crate::traffic::sim::SimError::Unavailable("built without the feature `libsumo`".into())
        .into())
}
