//! `tsc-family build-networks --osm`: the arguments, and what is said on the terminal.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use osm_signals::DrivingSide;

use super::folder::CITY;
use super::output::{Progress, line, note};
use crate::cli::exit;
use crate::files::quoted;
use crate::settings::overrides::Override;
use crate::traffic::city::derive::{Event, Request, derive};
use crate::traffic::city::quality::Quality;
use crate::traffic::report::quality::write_quality;
use crate::traffic::settings::Detail;
use crate::traffic::turning::Period;

/// Budget of the command that is suggested in the end.
const EXAMPLE_BUDGET: usize = 20;

/// Options that only `--osm` understands.
#[derive(Debug, clap::Args)]
#[group(conflicts_with = "scenario")]
#[command(next_help_heading = "From OpenStreetMap")]
pub struct OsmArgs {
    /// Extract to derive a family from: .osm.pbf, .osm or .osm.gz
    #[arg(long, value_name = "FILE")]
    pub osm: Option<PathBuf>,
    /// List of the signals that count: CSV, XLSX or GeoJSON, with places [default: those of the map]
    #[arg(long, value_name = "FILE", requires = "osm")]
    pub signals: Option<PathBuf>,
    /// Rows of the list that count, such as TYPE=SIGNAL or 'STATUS!=PLANNED' (repeatable)
    #[arg(long, value_name = "COLUMN=VALUE", requires = "signals")]
    pub signals_where: Vec<String>,
    /// Traffic counts: GeoJSON lines or a CSV of places [default: by class of street]
    #[arg(long, value_name = "FILE", requires = "osm")]
    pub aadt: Option<PathBuf>,
    /// Only intersections within a GeoJSON polygon or WEST,SOUTH,EAST,NORTH in degrees
    #[arg(long, value_name = "FILE|BBOX", requires = "osm", allow_hyphen_values = true)]
    pub boundary: Option<String>,
    /// Settings of the derivation, TOML
    #[arg(long, value_name = "FILE", requires = "osm")]
    pub config: Option<PathBuf>,
    /// Side of the street that traffic keeps to [default: that of the place]
    #[arg(long, value_name = "SIDE", requires = "osm", value_parser = side_parser())]
    pub driving_side: Option<DrivingSide>,
    /// Six features per intersection, or its real arms [default: per-approach]
    #[arg(long, value_enum, requires = "osm")]
    pub detail: Option<Detail>,
}

fn side_parser() -> impl TypedValueParser<Value = DrivingSide> {
    PossibleValuesParser::new(["right", "left"]).map(|word| match &*word {
        "left" => DrivingSide::Left,
        _ => DrivingSide::Right,
    })
}

/// Derives a city and writes its folder.
pub(super) fn run(
    args: &OsmArgs,
    extract: &Path,
    (out, force): (Option<&Path>, bool),
    (turning_counts, counts_layout, periods): (Vec<PathBuf>, Option<PathBuf>, &[Period]),
    overrides: Vec<Override>,
    quiet: bool,
) -> anyhow::Result<u8> {
    let request = Request {
        extract: extract.to_path_buf(),
        signals: args.signals.clone(),
        signals_where: args.signals_where.clone(),
        counts: args.aadt.clone(),
        turning_counts,
        counts_layout,
        periods: periods.to_vec(),
        boundary: args.boundary.clone(),
        config: args.config.clone(),
        driving_side: args.driving_side,
        detail: args.detail,
        overrides,
        out: out.map_or_else(|| Request::default_out(extract), Path::to_path_buf),
        force,
    };
    let out = &request.out;
    CITY.check(out, "--out", Some(force))?;
    let shown: Mutex<Option<(Option<&'static str>, Progress)>> = Mutex::new(None);
    let finish = |is: &dyn Fn(Option<&str>) -> bool| {
        let shown = shown.lock().ok().and_then(|mut shown| shown.take_if(|(what, _)| is(*what)));
        shown.into_iter().for_each(|(_, progress)| progress.finish());
    };
    let derived = derive(&request, &|event| match event {
        Event::Progress { what, done, total, point } => {
            finish(&|shown| shown != what);
            let Ok(mut shown) = shown.lock() else { return };
            let new = || (what, Progress::new(total, what, quiet));
            shown.get_or_insert_with(new).1.set(done, point);
        }
        Event::Warning(text) => note(format!("warning: {text}")),
        Event::Found(_) if quiet => {}
        Event::Found(text) => note(text),
        Event::LeftOut(reason) => note(format!("left out: {reason}")),
    })?;
    finish(&|_| true);
    derived.write(out)?;
    let page = write_quality(out, &derived.quality)?;
    if quiet {
        return Ok(exit::DONE);
    }
    for text in summary(&derived.quality) {
        line(text)?;
    }
    let (points, built) = (derived.loaded.family.points.len(), derived.built);
    line(format!(
        "{points} networks in {}: {built} built, {} up to date",
        derived.networks.display(),
        points.saturating_sub(built)
    ))?;
    line(format!("quality: {}", page.display()))?;
    let name = &derived.loaded.scenario.name;
    line(next(out, points, name))?;
    Ok(exit::DONE)
}

/// Returns the command that runs a scenario's folder.
pub(super) fn next(folder: &Path, points: usize, name: &str) -> String {
    let budget = if points > EXAMPLE_BUDGET { EXAMPLE_BUDGET.to_string() } else { "all".into() };
    let folder = quoted(folder);
    format!("next: tsc-family run {folder} --preset field --budget {budget} --out results/{name}")
}

/// Returns what was found, in a few lines.
fn summary(q: &Quality) -> Vec<String> {
    let mut lines = vec![
        format!(
            "{} signals: {} in {} intersections, which are {} point MDPs",
            q.signals, q.signals_used, q.intersections, q.point_mdps
        ),
        format!("traffic keeps to the {}", q.driving_side),
    ];
    lines.extend(q.skipped.iter().map(|s| format!("  {} {}", s.signals, s.text)));
    let known = q.provenance.iter().map(|p| format!("{} {:.0}%", p.feature, 100.0 * p.tagged));
    let known = known.collect::<Vec<_>>().join(", ");
    lines.push(format!("of {} approaches, known from the data: {known}", q.approaches));
    let (applied, timed) = q.timed_restrictions;
    if timed > 0 {
        lines.push(format!(
            "{applied} of {timed} turn restrictions at certain times hold in the simulated hour (streets.time_of_day)"
        ));
    }
    if !q.listed.is_empty() {
        lines.push(format!("{} listed signals:", q.listed.values().sum::<usize>()));
        lines.extend(q.listed.iter().map(|(outcome, n)| format!("  {n} {outcome}")));
    }
    lines
}
