//! `tsc-family build-networks`, and what `run` needs of it.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::folder::{CITY, NETWORKS};
use super::osm;
use super::osm::OsmArgs;
use super::output::{Progress, line, note};
use super::scenario::ScenarioArg;
use super::values::at_least_one_worker;
use crate::cli::exit::{self, refuse};
use crate::traffic::city::counted::{CountedRequest, counted};
use crate::traffic::city::{APPROACHES_FILE, default_folder};
use crate::traffic::family::approaches::Intersection;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::network::build::{BuildOptions, BuildSummary, build_all};
use crate::traffic::network::intersection::IntersectionSpec;
use crate::traffic::network_files::NetworkFiles;
use crate::traffic::placed::with_plans;
use crate::traffic::problem::networks;
use crate::traffic::turning::{self, Period};
use crate::traffic::utdf::{Utdf, read_plans};

/// `tsc-family build-networks`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family build-networks
  tsc-family build-networks my-city.toml --out networks/my-city
  tsc-family build-networks --osm utah-latest.osm.pbf --boundary=-112.1,40.7,-111.8,40.8 \
      --signals signals.csv --aadt counts.geojson --out networks/my-city
  tsc-family build-networks --utdf my-network.csv --out networks/my-network
  tsc-family build-networks networks/my-city --existing plans.csv --out networks/with-plans
  tsc-family build-networks networks/my-city --turning-counts counts.csv --period am=07:00-09:00 \
      --period pm=16:00-18:00 --out networks/counted
  sumo-gui -c networks/salt-lake-city/L4-S30-D300-Q500-l0-r0/*.sumocfg")]
pub struct BuildNetworksArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Folder to write to [default: networks/NAME of the scenario or extract]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Build all networks again, also those that are up to date or were altered, and write into a
    /// folder that holds other things
    #[arg(long)]
    pub force: bool,
    /// Network in UTDF, as Synchro exports it, instead of a scenario: the combined file of version 7 or 8
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scenario", "osm"])]
    pub utdf: Option<PathBuf>,
    /// Vehicles by approach and turn: tables with columns such as INTID, Time, NBL, NBT, NBR; CSV, workbook, or a folder of
    /// them (repeatable)
    #[arg(long, value_name = "FILE")]
    pub turning_counts: Vec<PathBuf>,
    /// What the columns of the turning counts are, where no known layout fits
    #[arg(long, value_name = "FILE", requires = "turning_counts")]
    pub counts_layout: Option<PathBuf>,
    /// Plans that the signals have today, for the method existing: a table with a row per phase, or UTDF
    /// [default: those of the scenario or of --utdf]
    #[arg(long, value_name = "FILE", conflicts_with = "osm")]
    pub existing: Option<PathBuf>,
    /// Part of the day whose busiest hour is simulated, such as am=07:00-09:00, or am=07:00-09:00,500 with its hours
    /// per year (repeatable) [default: the busiest hour of all counts]
    #[arg(long, value_name = "NAME=FROM-TO[,HOURS]", requires = "turning_counts")]
    pub period: Vec<Period>,
    /// Intersections that are built, by their ids in the table or in UTDF, and no others (repeatable, or with commas)
    #[arg(long, value_name = "ID,...", conflicts_with = "osm")]
    pub only: Vec<String>,
    /// Intersections that are left out (repeatable, or with commas)
    #[arg(long, value_name = "ID,...", conflicts_with = "osm")]
    pub skip: Vec<String>,
    /// Processors to use [default: all]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Print no progress
    #[arg(long, short)]
    pub quiet: bool,
    /// Family from OpenStreetMap instead
    #[command(flatten)]
    pub osm: OsmArgs,
}

pub(super) fn run(args: &BuildNetworksArgs) -> anyhow::Result<u8> {
    check_periods(&args.period)?;
    if let Some(extract) = &args.osm.osm {
        let to = (args.out.as_deref(), args.force);
        let files = turning::files(&args.turning_counts)?;
        let counted = (files, args.counts_layout.clone(), args.period.as_slice());
        return osm::run(&args.osm, extract, to, counted, args.scenario.settings(), args.quiet);
    }
    if !args.turning_counts.is_empty() || args.utdf.is_some() || args.existing.is_some() {
        return with_volumes(args);
    }
    let loaded = args.scenario.signals(&args.scenario.settings())?;
    let out = args.out.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, &loaded));
    NETWORKS.check(&out, "--out", Some(args.force))?;
    let mut specs = with_plans(&loaded)?;
    let is_chosen = chosen(args, &loaded.intersections)?;
    let own: BTreeSet<&str> = (loaded.family.points.iter().zip(&loaded.members))
        .filter(|(_, of)| of.iter().any(|i| is_chosen(&loaded.intersections[*i].id)))
        .map(|(point, _)| point.id.as_str())
        .collect();
    specs.retain(|spec| loaded.intersections.is_empty() || own.contains(spec.point.as_str()));
    let start = std::time::Instant::now();
    let options = BuildOptions { force: args.force, leave_out: false };
    let summary = build(&loaded, &specs, &out, options, args.quiet)?;
    if !args.quiet {
        line(format!(
            "{} networks in {}: {} built, {} up to date, {:.1} s",
            specs.len(),
            out.display(),
            summary.built,
            summary.up_to_date,
            start.elapsed().as_secs_f64()
        ))?;
    }
    Ok(exit::DONE)
}

/// Returns which intersections `--only` and `--skip` leave.
fn chosen(
    args: &BuildNetworksArgs,
    all: &[Intersection],
) -> anyhow::Result<impl Fn(&str) -> bool + use<>> {
    let ids = |given: &[String]| -> anyhow::Result<Vec<String>> {
        let find = |name: &str| turning::meant(name, all.iter().map(|i| i.id.as_str()));
        // An id may have commas of its own.
        let names = given.iter().flat_map(|name| match find(name) {
            Ok(None) => name.split(',').collect(),
            _ => vec![name.as_str()],
        });
        let id = |name: &str| match find(name) {
            Ok(Some(id)) => Ok(id.to_owned()),
            Ok(None) => refuse(format!(
                "{name}: no intersection is called so; give ids of the table or of UTDF"
            )),
            Err(message) => refuse(message),
        };
        names.map(id).collect()
    };
    let (only, skip) = (ids(&args.only)?, ids(&args.skip)?);
    let is_in = |ids: &[String], id: &str| ids.iter().any(|own| own == id);
    let is_chosen = move |id: &str| (only.is_empty() || is_in(&only, id)) && !is_in(&skip, id);
    match all.is_empty() || all.iter().any(|i| is_chosen(&i.id)) {
        true => Ok(is_chosen),
        false => refuse("--only and --skip leave no intersection".to_owned()),
    }
}

/// Refuses periods of one name, and hours per year for some of them only.
fn check_periods(periods: &[Period]) -> anyhow::Result<()> {
    for (i, period) in periods.iter().enumerate() {
        let name = &period.name;
        if periods[..i].iter().any(|other| other.name == *name) {
            return refuse(format!("--period {name} is given twice; give each period one name"));
        }
        if period.hours.is_some() != periods[0].hours.is_some() {
            return refuse(format!(
                "--period {name}: give hours per year for every period, or for none, so that all count equally"
            ));
        }
    }
    Ok(())
}

/// Writes the folder of a scenario from UTDF or to which turning counts are given, and builds its networks.
fn with_volumes(args: &BuildNetworksArgs) -> anyhow::Result<u8> {
    let scenario = &args.scenario.scenario;
    let from_utdf = args
        .utdf
        .as_ref()
        .map(|file| Path::new("networks").join(file.file_stem().unwrap_or_default()));
    let Some(out) = args.out.clone().or(from_utdf) else {
        return refuse(format!(
            "{scenario}: --{} makes a scenario of its own; say with --out in which folder",
            if args.turning_counts.is_empty() { "existing" } else { "turning-counts" }
        ));
    };
    let out = out.as_path();
    CITY.check(out, "--out", Some(args.force))?;
    let (mut uncounted, converted) = match &args.utdf {
        None => (args.scenario.uncounted()?, None),
        Some(file) => {
            let (uncounted, converted) = Utdf::read(file)?.scenario(&args.scenario.settings())?;
            (uncounted, Some(converted))
        }
    };
    let all: Vec<String> = uncounted.intersections.iter().map(|i| i.id.clone()).collect();
    let is_chosen = chosen(args, &uncounted.intersections)?;
    uncounted.intersections.retain(|intersection| is_chosen(&intersection.id));
    let path = Path::new(scenario);
    let folder = if path.is_dir() { Some(path) } else { path.parent().filter(|_| path.is_file()) };
    let utdf = args.utdf.iter().map(|file| ("utdf", file.clone()));
    let layout = args.counts_layout.iter().map(|file| ("counts-layout", file.clone()));
    let sources: Vec<_> = utdf
        .chain(layout)
        .chain(args.existing.iter().map(|file| ("existing", file.clone())))
        .collect();
    let side = uncounted.scenario.network.driving_side;
    let given = args.existing.as_deref().map(|path| read_plans(path, side)).transpose()?;
    for doubt in given.iter().flat_map(|(_, doubts)| doubts) {
        note(format!("warning: {}", doubt.brief()));
    }
    let mut plans = given.map(|(plans, _)| plans).or_else(|| uncounted.plans.clone());
    if let Some(plans) = &mut plans {
        let meant =
            |name: &str| turning::meant(name, all.iter().map(String::as_str)).ok().flatten();
        plans.all.retain(|plan| meant(&plan.intersection).is_none_or(&is_chosen));
    }
    let (loaded, joined, networks) = counted(&CountedRequest {
        uncounted: &uncounted,
        folder: folder.filter(|_| converted.is_none()),
        files: &turning::files(&args.turning_counts)?,
        layout: args.counts_layout.as_deref(),
        plans: plans.as_ref(),
        sources: &sources,
        periods: &args.period,
        overrides: &args.scenario.settings(),
        out,
        force: args.force,
    })?;
    let of_utdf = converted.iter().flat_map(|converted| &converted.doubts);
    for doubt in of_utdf.chain(&joined.doubts) {
        note(format!("warning: {}", doubt.brief()));
    }
    let table = out.join(APPROACHES_FILE);
    for doubt in &loaded.doubts {
        note(format!("warning: {}: {}", table.display(), doubt.brief()));
    }
    let specs = with_plans(&loaded)?;
    let options = BuildOptions { force: args.force, leave_out: false };
    let summary = build(&loaded, &specs, &networks, options, args.quiet)?;
    if args.quiet {
        return Ok(exit::DONE);
    }
    converted.iter().flat_map(|c| &c.found).chain(&joined.found).try_for_each(line)?;
    line(format!(
        "{} networks in {}: {} built, {} up to date",
        specs.len(),
        networks.display(),
        summary.built,
        summary.up_to_date
    ))?;
    line(osm::next(out, specs.len(), &loaded.scenario.name))?;
    Ok(exit::DONE)
}

/// Returns the network of a point MDP, which is built if it is missing.
pub(super) fn network(
    loaded: &LoadedScenario,
    point: &str,
    folder: &Path,
) -> anyhow::Result<NetworkFiles> {
    NETWORKS.check(folder, "--networks", None)?;
    let mut files = networks(loaded, &BTreeSet::from([point]), folder, &|_| ())?;
    Ok(files.remove(point).expect("what is not built is an error"))
}

/// Builds the networks that are missing, with progress.
pub(super) fn build(
    loaded: &LoadedScenario,
    specs: &[IntersectionSpec],
    out: &Path,
    options: BuildOptions,
    quiet: bool,
) -> anyhow::Result<BuildSummary> {
    let done = Progress::new(specs.len() as u64, Some("networks"), quiet);
    let built = build_all(specs, &loaded.scenario, out, options, &|point| done.add(1, point));
    done.finish();
    Ok(built?)
}
