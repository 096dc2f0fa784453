//! `tsc-family build-networks --osm`: from an extract to a family, its networks and its quality.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use super::build_networks::{BuildNetworksArgs, build, networks_folder};
use super::folder::CITY;
use super::output::{Progress, line, note, quoted};
use crate::cli::exit;
use crate::files::FileError;
use crate::files::write_atomically;
use crate::hash::{sha256, sha256_file};
use crate::osm::boundary::Boundary;
use crate::osm::city::{City, Inputs, extent};
use crate::osm::config::OsmConfig;
use crate::osm::counts::Counts;
use crate::osm::drawing::Drawing;
use crate::osm::extract::Extract;
use crate::osm::intersections::Skip;
use crate::osm::quality::{InputFile, Quality, quality};
use crate::osm::side::{SideDecision, SideSetting, decide};
use crate::osm::signals::SignalList;
use crate::osm::surroundings::write_streets;
use crate::osm::write::{
    APPROACHES_FILE, SCENARIO_FILE, ScenarioInputs, family_facts, scenario_text, write_family,
    write_geojson, write_matches,
};
use crate::osm::{OsmError, read};
use crate::report::quality::{QUALITY_FILE, write_quality};
use crate::traffic::family::load::{LoadedScenario, from_text};
use crate::traffic::network::build::BuildOptions;
use crate::traffic::network::intersection::intersections;
use crate::traffic::network::one_green::one_green;
use crate::traffic::settings::Detail;
use crate::traffic::settings::inflow::InflowSources;

/// Budget of the command that is suggested in the end.
const EXAMPLE_BUDGET: usize = 20;

/// Options that only `--osm` understands.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "From OpenStreetMap")]
pub struct OsmArgs {
    /// Extract to derive a family from: .osm.pbf, .osm or .osm.gz
    #[arg(long, value_name = "FILE", conflicts_with = "scenario")]
    pub osm: Option<PathBuf>,
    /// CSV of the signals that count, with latitude and longitude [default: those of the map]
    #[arg(long, value_name = "CSV", requires = "osm")]
    pub signals: Option<PathBuf>,
    /// Traffic counts: GeoJSON lines or a CSV of places [default: by class of street]
    #[arg(long, value_name = "FILE", requires = "osm")]
    pub aadt: Option<PathBuf>,
    /// Only intersections within a GeoJSON polygon or WEST,SOUTH,EAST,NORTH in degrees
    #[arg(long, value_name = "FILE|BBOX", requires = "osm", allow_hyphen_values = true)]
    pub boundary: Option<String>,
    /// Settings of the derivation, TOML
    #[arg(long, value_name = "FILE", requires = "osm")]
    pub config: Option<PathBuf>,
    /// Side of the street that traffic keeps to [default: auto, by country and streets]
    #[arg(long, value_enum, value_name = "SIDE", requires = "osm")]
    pub driving_side: Option<SideSetting>,
    /// Six features per intersection, or its real arms
    #[arg(long, value_enum, requires = "osm", default_value = "six-features")]
    pub detail: Detail,
}

/// Everything that `--osm` reads.
struct Input {
    config: OsmConfig,
    signals: Option<SignalList>,
    counts: Option<Counts>,
    boundary: Option<Boundary>,
    side: SideDecision,
    extract: Extract,
}

pub(super) fn run(args: &BuildNetworksArgs, osm: &Path) -> anyhow::Result<u8> {
    let start = Instant::now();
    let out = args.out.clone().unwrap_or_else(|| Path::new("networks").join(stem(osm)));
    CITY.check(&out, "--out", Some(args.force))?;
    let input = input(args, osm, &out)?;
    let read_in = start.elapsed();
    let inputs = Inputs {
        signals: input.signals.as_ref(),
        counts: input.counts.as_ref(),
        boundary: input.boundary.as_ref(),
        side: Some(&input.side),
    };
    if let Some(warning) = &input.side.warning {
        note(format!("warning: {warning}"));
    }
    let mut city = City::new(&input.extract, &input.config, &inputs);
    if let (Some(path), Some(counts), false) = (&args.osm.aadt, inputs.counts, city.is_counted()) {
        return Err(unmatched(path, counts, &city).into());
    }
    let nowhere = city.found.intersections.is_empty() && !city.found.skipped.is_empty();
    if let (Some(path), Some(list), true) = (&args.osm.signals, inputs.signals, nowhere) {
        return Err(elsewhere(path, list, &city).into());
    }
    let derived_in = start.elapsed() - read_in;
    let mut built = 0;
    // Networks come first: without them nothing else is written.
    let (table, loaded, folder) = loop {
        let table = city.table(&input.config, &culprit(args, osm, &city))?;
        let own = |_: &str| Ok(String::from_utf8_lossy(&table).into_owned());
        let file = out.join(SCENARIO_FILE).display().to_string();
        let inflows = Some(city.inflow_sources());
        let scenario = scenario(args, (osm, &out), &input.config, (inflows, Some(&input.side)))?;
        let loaded = from_text(&scenario, &file, &[], &own)?;
        let specs = intersections(&loaded)?;
        let options = BuildOptions { force: args.force && built == 0, leave_out: true };
        let folder = out.join(networks_folder(loaded.scenario.preset));
        let summary = build(&loaded, &specs, &folder, options, args.quiet)?;
        built += summary.built;
        let own_arms = loaded.scenario.family.detail == Detail::PerApproach;
        if summary.failed.is_empty() {
            let one_green = one_green(&folder, &specs)?;
            if own_arms && city.leave_out_one_green(&members(&loaded, &one_green)) > 0 {
                continue;
            }
            break (table, loaded, folder);
        }
        // The family is derived again without them.
        for (_, reason) in &summary.failed {
            note(format!("left out: {reason}"));
        }
        city.leave_out(members(&loaded, &summary.failed));
    };
    let (quality, page) = write(input_files(args, osm)?, &input, &city, &table, &loaded, &out)?;
    if !args.quiet {
        for text in summary(&quality) {
            line(text)?;
        }
        let points = loaded.family.points.len();
        line(format!(
            "{points} networks in {}: {built} built, {} up to date",
            folder.display(),
            points.saturating_sub(built)
        ))?;
        line(format!(
            "read in {:.1} s, derived in {:.1} s, networks in {:.1} s",
            read_in.as_secs_f64(),
            derived_in.as_secs_f64(),
            (start.elapsed() - read_in - derived_in).as_secs_f64()
        ))?;
        line(format!("quality: {}", page.display()))?;
        let name = &loaded.scenario.name;
        let budget =
            if points > EXAMPLE_BUDGET { EXAMPLE_BUDGET.to_string() } else { "all".into() };
        let folder = quoted(&out);
        line(format!("next: tsc-family run {folder} --budget {budget} --out results/{name}"))?;
    }
    Ok(exit::DONE)
}

/// Returns the file that is to blame when there is no intersection.
fn culprit(args: &BuildNetworksArgs, osm: &Path, city: &City) -> PathBuf {
    let from = &args.osm;
    let file = match city.skips().first() {
        Some((Skip::OutsideBoundary, _)) => from.boundary.as_ref().map(PathBuf::from),
        _ => None,
    };
    file.unwrap_or_else(|| osm.to_path_buf())
}

/// Refuses to overwrite tables in a folder that this command did not write, or that were edited
/// since.
fn check_folder(out: &Path) -> Result<(), OsmError> {
    let quality = std::fs::read(out.join(QUALITY_FILE)).unwrap_or_default();
    let quality: serde_json::Value = serde_json::from_slice(&quality).unwrap_or_default();
    for name in [APPROACHES_FILE, SCENARIO_FILE] {
        let path = out.join(name);
        if path.exists() && quality["written"][name] != sha256_file(&path)? {
            let reason =
                "not as this command wrote it; give another --out, or --force to replace it"
                    .to_owned();
            return Err(OsmError::Nothing { path, reason });
        }
    }
    Ok(())
}

/// Returns the error for a signal list that names no intersection of the extract.
fn elsewhere(path: &Path, list: &SignalList, city: &City) -> OsmError {
    let reason = format!(
        "none of its {} signals is at an intersection of the extract; they cover {}{}; give the list \
         of this city, or leave out --signals",
        list.signals.len(),
        extent(list.bounds()),
        covered(city)
    );
    OsmError::Nothing { path: path.to_path_buf(), reason }
}

/// Says where the extract lies, after where something else does.
fn covered(city: &City) -> String {
    city.covered.map_or_else(String::new, |bounds| format!(", the extract {}", extent(bounds)))
}

/// Returns the error for counts of which none lies along a street of an intersection.
fn unmatched(path: &Path, counts: &Counts, city: &City) -> OsmError {
    let over = match counts.over_cap() {
        0 => String::new(),
        n => format!(" ({n} would, but exceed counts.max_veh_per_day_per_lane)"),
    };
    let reason = format!(
        "none of its {} counts lies along a street of an intersection{over}; they cover {}{}; give \
         counts of this city, or leave out --aadt",
        counts.len(),
        extent(counts.bounds()),
        covered(city)
    );
    OsmError::Nothing { path: path.to_path_buf(), reason }
}

/// Returns the intersections of point MDPs that failed, with the reasons.
fn members(loaded: &LoadedScenario, failed: &[(String, String)]) -> BTreeMap<String, String> {
    let mut members = BTreeMap::new();
    for (point, reason) in failed {
        let position = loaded.family.position(point);
        let indices = position.map_or(&[][..], |p| &loaded.members[p]);
        let ids = indices.iter().map(|i| loaded.intersections[*i].id.clone());
        members.extend(ids.map(|id| (id, reason.clone())));
    }
    members
}

/// Writes everything but the networks of a city.
fn write(
    files: Vec<InputFile>,
    input: &Input,
    city: &City,
    table: &[u8],
    loaded: &LoadedScenario,
    out: &Path,
) -> anyhow::Result<(Quality, PathBuf)> {
    let tables = [(APPROACHES_FILE, table), (SCENARIO_FILE, loaded.text.as_bytes())];
    for (name, bytes) in tables {
        write_atomically(&out.join(name), bytes)?;
    }
    write_family(out, &loaded.family)?;
    let written = tables.map(|(name, bytes)| (name.to_owned(), sha256(bytes)));
    let quality = quality(
        family_facts(loaded),
        (files, written.into()),
        &input.extract,
        city,
        input.counts.as_ref().map(|counts| (counts, input.config.counts.spread_m)),
    );
    write_geojson(out, city, &quality, loaded)?;
    if !city.listed.is_empty() {
        write_matches(out, &city.listed)?;
    }
    let drawing = Drawing::new(&input.extract, city);
    write_streets(out, &drawing)?;
    let page = write_quality(out, &quality, &drawing)?;
    Ok((quality, page))
}

/// Returns the text of the scenario that is written.
fn scenario(
    args: &BuildNetworksArgs,
    (osm, out): (&Path, &Path),
    config: &OsmConfig,
    (inflows, side): (Option<InflowSources>, Option<&SideDecision>),
) -> Result<String, OsmError> {
    let from = &args.osm;
    let source = from.config.as_ref().map_or("settings".to_owned(), |c| c.display().to_string());
    let settings = args.scenario.settings();
    let flags: String = settings.iter().map(|o| format!(" {}", o.flag())).collect();
    scenario_text(&ScenarioInputs {
        name: &scenario_name(out),
        extract: &stem(osm),
        detail: from.detail,
        config,
        overrides: &settings,
        source: &format!("{source}{flags}"),
        side,
        inflows,
    })
}

/// Reads the small files first, so that a mistake in one is known before the extract is read.
fn input(args: &BuildNetworksArgs, osm: &Path, out: &Path) -> Result<Input, OsmError> {
    let from = &args.osm;
    if !args.force {
        check_folder(out)?;
    }
    let config = from.config.as_deref().map(OsmConfig::read).transpose()?.unwrap_or_default();
    // A mistake in the settings is known before the extract is read.
    scenario(args, (osm, out), &config, (None, None))?;
    let boundary = from.boundary.as_deref().map(Boundary::parse).transpose()?;
    let signals = from.signals.as_deref();
    let signals = signals.map(|p| SignalList::read(p, &config.signals)).transpose()?;
    let counts = from.aadt.as_deref().map(|p| Counts::read(p, &config.counts)).transpose()?;
    let progress: Mutex<Option<Progress>> = Mutex::new(None);
    let extract = read::read(osm, &|done, total| {
        if let Ok(mut progress) = progress.lock() {
            progress.get_or_insert_with(|| Progress::new(total, None, args.quiet)).set(done, "");
        }
    });
    if let Ok(Some(progress)) = progress.into_inner() {
        progress.finish();
    }
    let mut extract = extract?;
    let setting = from.driving_side.unwrap_or(config.streets.driving_side);
    let side = decide(&extract, setting, boundary.as_ref())
        .map_err(|reason| OsmError::Nothing { path: osm.to_path_buf(), reason })?;
    extract.retain_ways(|way| config.streets.is_street(way.street.highway));
    Ok(Input { config, signals, counts, boundary, side, extract })
}

fn input_files(args: &BuildNetworksArgs, osm: &Path) -> Result<Vec<InputFile>, FileError> {
    let from = &args.osm;
    let boundary = from.boundary.as_ref().map(PathBuf::from).filter(|p| p.is_file());
    let files = [
        ("extract", Some(osm.to_path_buf())),
        ("signals", from.signals.clone()),
        ("aadt", from.aadt.clone()),
        ("boundary", boundary),
        ("config", from.config.clone()),
    ];
    let files = files.into_iter().filter_map(|(role, path)| path.map(|path| (role, path)));
    files
        .map(|(role, path)| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let sha256 = sha256_file(&path)?;
            Ok(InputFile { role, name, sha256 })
        })
        .collect()
}

/// Returns what was found, in a few lines.
fn summary(quality: &Quality) -> Vec<String> {
    let mut lines = vec![format!(
        "{} signals: {} in {} intersections, which are {} point MDPs",
        quality.signals, quality.signals_used, quality.intersections, quality.point_mdps
    )];
    lines.push(quality.side.text());
    lines.extend(quality.skipped.iter().map(|s| format!("  {} {}", s.signals, s.text)));
    let known: Vec<String> = quality
        .provenance
        .iter()
        .map(|p| format!("{} {:.0}%", p.feature, 100.0 * p.tagged))
        .collect();
    lines.push(format!(
        "of {} approaches, known from the data: {}",
        quality.approaches,
        known.join(", ")
    ));
    if !quality.listed.is_empty() {
        let matched = quality.listed.iter().filter(|l| l.intersection.is_some()).count();
        lines.push(format!("{matched} of {} listed signals matched", quality.listed.len()));
        let mut others: BTreeMap<&str, usize> = BTreeMap::new();
        for row in quality.listed.iter().filter(|l| l.intersection.is_none()) {
            *others.entry(row.reason.unwrap_or("unknown")).or_default() += 1;
        }
        lines.extend(others.into_iter().map(|(reason, n)| format!("  {n} {reason}")));
    }
    lines
}

/// Returns the name of an extract without its endings.
fn stem(osm: &Path) -> String {
    let name = osm.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let endings = [".osm.pbf", ".osm.gz", ".pbf", ".osm", ".xml"];
    let stem = endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(&name);
    let stem: String = stem.chars().map(|c| if c.is_control() { '-' } else { c }).collect();
    if stem.is_empty() { "city".to_owned() } else { stem }
}

/// Returns the name of the scenario in a folder.
fn scenario_name(out: &Path) -> String {
    let name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' };
    let name: String = name.chars().map(safe).collect();
    if name.is_empty() { "city".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_city_is_called_after_its_folder() {
        assert_eq!(scenario_name(Path::new("networks/Salt Lake.City")), "Salt-Lake-City");
        assert_eq!(scenario_name(Path::new("..")), "city");
        assert_eq!(stem(Path::new("a/utah-latest.osm.pbf")), "utah-latest");
        assert_eq!(stem(Path::new("city.north.osm")), "city.north");
        assert_eq!(stem(Path::new("a\nb.osm")), "a-b");
    }
}
