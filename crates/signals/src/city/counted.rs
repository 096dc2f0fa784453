//! A scenario with turning counts, made from a scenario with approaches or from UTDF.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use osm_signals::DrivingSide;
use serde_json::json;
use toml::Table;

use super::surroundings::SURROUNDINGS;
use super::{
    APPROACHES_FILE, CityError, EXISTING_FILE, InputFile, SCENARIO_FILE, SOURCES_FILE, hours,
    networks_folder, scenario_name,
};
use crate::existing::{self, Plans};
use crate::family::approaches::{Approach, to_csv};
use crate::family::doubts::Doubt;
use crate::family::load::{LoadedScenario, Uncounted, from_text};
use crate::placed::placed;
use crate::settings::Scenario;
use crate::turning::{Joined, Period, TurningCounts, without_zero_pedestrians};
use basics::files::{self, beneath, limits, write_atomically};
use basics::hash::sha256;
use evaluation::family::error::FamilyError;
use evaluation::settings::overrides::Override;

/// A scenario that turning counts are given to.
#[derive(Debug, Clone, Copy)]
pub struct CountedRequest<'a> {
    /// The scenario.
    pub uncounted: &'a Uncounted,
    /// Its folder, if it has one, whose map and names are taken over.
    pub folder: Option<&'a Path>,
    /// Files of counts; none to take the volumes that the approaches have.
    pub files: &'a [PathBuf],
    /// Layout of the counts, instead of those that are known.
    pub layout: Option<&'a Path>,
    /// Plans that its signals have today.
    pub plans: Option<&'a Plans>,
    /// Other files that it was made from, with what they are.
    pub sources: &'a [(&'static str, PathBuf)],
    /// Periods of the day; none for the busiest hour of all that was counted.
    pub periods: &'a [Period],
    /// Settings of the scenario that is written.
    pub overrides: &'a [Override],
    /// Folder to write to.
    pub out: &'a Path,
    /// Whether what is there is replaced, also where it was edited.
    pub force: bool,
}

/// Writes a folder with a scenario and its approaches, to which turning counts were given. Returns the scenario, what was
/// joined, and the folder for its networks.
///
/// # Errors
///
/// [`CityError`] with the file that is to blame: counts that cannot be read or belong to other intersections, a scenario
/// without approaches, a folder whose tables were edited.
pub fn counted(
    request: &CountedRequest<'_>,
) -> Result<(LoadedScenario, Joined, PathBuf), CityError> {
    let CountedRequest { uncounted, out, .. } = *request;
    if !request.force {
        super::check(out)?;
    }
    let joined = match request.files {
        [] => Joined {
            approaches: uncounted.intersections.iter().flat_map(|i| i.arms.clone()).collect(),
            ..Joined::default()
        },
        files => {
            let periods = uncounted.intersections.iter().map(|i| i.period.as_str());
            if let Some(period) = periods.into_iter().find(|period| !period.is_empty()) {
                let expected = "the table of approaches has periods already; give one without the column period";
                return Err(refused(request, "period", period.to_owned(), expected));
            }
            let side = driving_side(request)?;
            let mut joined = TurningCounts::read(files, request.layout)?
                .into_approaches(&uncounted.intersections, request.periods, side)?;
            if !uncounted.scenario.family.zero_pedestrians {
                joined.doubts.extend(without_zero_pedestrians(joined.approaches.iter_mut()));
            }
            joined
        }
    };
    let mut joined = with_traffic(joined, request)?;
    let table = to_csv(&joined.approaches);
    let file = out.join(SCENARIO_FILE).display().to_string();
    let mut plans = None;
    if let Some(given) = request.plans {
        let loaded =
            from_text(&scenario_text(request, false)?, &file, &[], &|_| Ok(table.clone()))?;
        let found = placed(&loaded, given)?.whole(given)?;
        joined.doubts.extend(found.left_out());
        joined.doubts.extend(found.doubts.iter().cloned());
        plans = (!found.of_point.is_empty()).then(|| existing::table::to_csv(&found.given));
    }
    let text = scenario_text(request, plans.is_some())?;
    let counted = from_text(&text, &file, &[], &|name| {
        Ok(plans.clone().filter(|_| name == EXISTING_FILE).unwrap_or_else(|| table.clone()))
    })?;
    files::make_folder_beneath(out, out)?;
    let mut written = vec![(APPROACHES_FILE, &table), (SCENARIO_FILE, &text)];
    written.extend(plans.as_ref().map(|plans| (EXISTING_FILE, plans)));
    for (name, text) in &written {
        write_atomically(&out.join(name), text.as_bytes())?;
    }
    let counts = request.files.iter().map(|path| ("turning-counts", path));
    let files = request.sources.iter().map(|(role, path)| (*role, path)).chain(counts);
    let inputs: Vec<_> =
        files.map(|(role, path)| InputFile::read(role, path)).collect::<Result<_, _>>()?;
    let hashes = written.iter().map(|(name, text)| ((*name).to_owned(), sha256(text.as_bytes())));
    let sources = json!({ "files": inputs, "written": hashes.collect::<BTreeMap<_, _>>() });
    let sources = serde_json::to_string_pretty(&sources).expect("hashes are plain data") + "\n";
    write_atomically(&out.join(SOURCES_FILE), sources.as_bytes())?;
    for name in SURROUNDINGS {
        let Some(folder) = request.folder.filter(|folder| folder.join(name).is_file()) else {
            continue;
        };
        let bytes = files::read(&folder.join(name), limits::DOCUMENT)?;
        write_atomically(&out.join(name), &bytes)?;
    }
    let networks = out.join(networks_folder(counted.scenario.preset));
    beneath(out, &networks)?;
    Ok((counted, joined, networks))
}

/// Returns the side on which people drive in the scenario that is written. What is wrong with it is said when it is read.
fn driving_side(request: &CountedRequest<'_>) -> Result<DrivingSide, CityError> {
    let written: Result<Scenario, _> = toml::from_str(&scenario_text(request, false)?);
    let scenario = written.as_ref().unwrap_or(&request.uncounted.scenario);
    Ok(scenario.network.driving_side)
}

fn refused(request: &CountedRequest<'_>, field: &str, value: String, expected: &str) -> CityError {
    FamilyError::setting(&request.uncounted.file, field, value, expected).into()
}

/// Leaves out intersections without any traffic: neither counts nor volumes nor daily counts.
fn with_traffic(mut joined: Joined, request: &CountedRequest<'_>) -> Result<Joined, CityError> {
    let mut groups: BTreeMap<(&str, &str), Vec<&Approach>> = BTreeMap::new();
    for row in joined.approaches.iter().filter(|row| row.lanes_in > 0) {
        groups.entry((&row.intersection, &row.period)).or_default().push(row);
    }
    let is_empty = |rows: &Vec<&Approach>| {
        let unknown =
            |row: &&Approach| row.counted.is_none() && row.aadt_veh_per_day_per_lane.is_nan();
        let total = |row: &&Approach| row.counted.map(|counted| counted.total_vph());
        rows.iter().any(unknown) || rows.iter().map(total).sum::<Option<f64>>() == Some(0.0)
    };
    let without: BTreeSet<(String, String)> = (groups.iter())
        .filter(|(_, rows)| is_empty(rows))
        .map(|((id, period), _)| ((*id).to_owned(), (*period).to_owned()))
        .collect();
    if without.is_empty() {
        return Ok(joined);
    }
    let all = without.len() == groups.len();
    let named = |(id, period): &(String, String)| match period.as_str() {
        "" => id.clone(),
        period => format!("{id}, {period}"),
    };
    let names: Vec<String> = without.iter().map(named).collect();
    if all {
        let expected = "none of them has volumes, turning counts or daily counts; give --turning-counts, which call the \
                        intersections alike";
        return Err(refused(request, "intersections", names.join("; "), expected));
    }
    joined.doubts.extend(Doubt::of(
        "intersections without volumes, turning counts and daily counts are left out",
        names,
    ));
    let has = |row: &Approach| !without.contains(&(row.intersection.clone(), row.period.clone()));
    joined.approaches.retain(has);
    Ok(joined)
}

/// Returns the text of the scenario that is written.
fn scenario_text(request: &CountedRequest<'_>, has_plans: bool) -> Result<String, CityError> {
    let mut table: Table = request.uncounted.text.parse().expect("it has been read before");
    table.insert("name".to_owned(), scenario_name(request.out).into());
    for setting in request.overrides {
        setting.put_into(&mut table)?;
    }
    let family = table.entry("family").or_insert_with(|| Table::new().into());
    if let Some(family) = family.as_table_mut() {
        family.insert("approaches".to_owned(), APPROACHES_FILE.into());
        family.remove("existing");
        if has_plans {
            family.insert("existing".to_owned(), EXISTING_FILE.into());
        }
        if let Some(periods) = hours(request.periods) {
            family.insert("periods".to_owned(), periods);
        }
    }
    let settings = toml::to_string(&table).expect("settings are plain data");
    Ok(format!(
        "# Made from {} by `tsc-family build-networks`.\n{settings}",
        request.uncounted.scenario.name
    ))
}
