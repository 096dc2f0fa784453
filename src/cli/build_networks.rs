//! `tsc-family build-networks`, and what `run` needs of it.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::effects::Use;
use super::folder::NETWORKS;
use super::osm;
use super::osm::OsmArgs;
use super::output::{Counted, line, note};
use super::scenario::ScenarioArg;
use super::values::at_least_one_worker;
use crate::cli::exit;
use crate::traffic::city::folder::default_folder;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::network::build::{BuildOptions, BuildSummary};
use crate::traffic::network::intersection::{IntersectionSpec, intersections};
use crate::traffic::network::prune::{Pruned, prune};
use crate::traffic::network_files::NetworkFiles;
use crate::traffic::problem::{self, networks};

/// `tsc-family build-networks`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family build-networks
  tsc-family build-networks my-city.toml --out networks/my-city
  tsc-family build-networks --osm utah-latest.osm.pbf --boundary=-112.1,40.7,-111.8,40.8 \
      --signals signals.csv --aadt counts.geojson --out networks/my-city
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
    /// Remove networks in the folder that were made with other settings or for other point MDPs; those that a
    /// task simulates stay
    #[arg(long, conflicts_with = "osm")]
    pub prune: bool,
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
    if let Some(extract) = &args.osm.osm {
        let to = (args.out.as_deref(), args.force);
        return osm::run(&args.osm, extract, to, args.scenario.settings(), args.quiet);
    }
    args.osm.without_extract(&args.scenario.scenario)?;
    let loaded = args.scenario.signals(&args.scenario.settings())?;
    let out = args.out.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, &loaded));
    Use::BUILD.check(&loaded, &args.scenario.settings())?;
    NETWORKS.check(&out, "--out", Some(args.force))?;
    let specs = intersections(&loaded)?;
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
    if args.prune {
        let Pruned { removed, in_use, bytes } = prune(&out, &summary.files)?;
        if !args.quiet {
            let megabytes = bytes as f64 / 1e6;
            let in_use = if in_use > 0 { format!(", {in_use} stay in use") } else { String::new() };
            line(format!("{removed} networks removed, {megabytes:.1} MB{in_use}"))?;
        }
    } else if summary.other > 0 && !args.quiet {
        note(format!(
            "{} other networks are in the folder; --prune removes those that nobody simulates",
            summary.other
        ));
    }
    Ok(exit::DONE)
}

/// Returns the network of a point MDP, which is built if it is missing.
///
/// # Arguments
///
/// * `folder` — of the networks.
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
    let done = Counted::new(specs.len(), "networks", quiet);
    let built = problem::build(loaded, specs, out, options, &|point| done.set(point));
    done.finish();
    Ok(built?)
}
