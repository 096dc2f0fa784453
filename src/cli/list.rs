//! `tsc-family list`: the family, one line per point MDP, or its features beside the paper's.

use serde_json::Value;

use super::output::line;
use super::scenario::ScenarioArg;
use crate::cli::exit;
use crate::family::{MdpFamily, PointMdp};
use crate::report::table::{Cell, Columns, Table};
use crate::traffic::family::features::six_features;
use crate::traffic::family::load::LoadedScenario;

/// Mean and standard deviation of each feature in the paper's table.
///
/// Source: Jayawardana et al. (NeurIPS 2022), appendix, intersection features; the inflow's mean
/// has probably lost a digit.
const PAPER: [(&str, &str); 6] = [
    ("lanes", "3.8 (1.37)"),
    ("speed_mph", "32.6 (5.40)"),
    ("length_m", "260.8 (193)"),
    ("inflow_vph", "73.5 (774)"),
    ("left_turn_lanes", "0.229 (0.496)"),
    ("right_turn_lanes", "0.100 (0.298)"),
];

/// `tsc-family list`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family list
  tsc-family list --features
  tsc-family list --set family.detail=per-approach
  tsc-family list cartpole
  tsc-family list my-city.toml --json | head")]
pub struct ListArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Show mean and standard deviation of each feature; for signals beside the paper's table
    #[arg(long)]
    pub features: bool,
    /// Print one JSON line per point MDP
    #[arg(long)]
    pub json: bool,
    /// Print everything doubtful or changed in the table, row by row, instead
    #[arg(long, conflicts_with_all = ["features", "json"])]
    pub warnings: bool,
}

pub(super) fn run(args: &ListArgs) -> anyhow::Result<u8> {
    let settings = args.scenario.settings();
    if let Some(entry) = args.scenario.entry()? {
        let problem = (entry.load)(&args.scenario.scenario, &settings)?;
        print(args, problem.family(), None)?;
        return Ok(exit::DONE);
    }
    let loaded = args.scenario.signals(&settings)?;
    match args.warnings {
        true => loaded.doubts.iter().try_for_each(|doubt| line(doubt.full()))?,
        false => print(args, &loaded.family, Some(&loaded))?,
    }
    Ok(exit::DONE)
}

fn print(
    args: &ListArgs,
    family: &MdpFamily,
    loaded: Option<&LoadedScenario>,
) -> anyhow::Result<()> {
    let imputed = loaded.map(imputed).unwrap_or_default();
    if args.json {
        for row in points(family, loaded.is_some()).json() {
            line(Value::Object(row).to_string())?;
        }
        return Ok(());
    }
    if args.features {
        return Ok(line(format!("{}{imputed}", features(family, loaded)))?);
    }
    let count: u64 = family.points.iter().map(|p| u64::from(p.instances)).sum();
    let of = loaded.map(|_| format!(" of {count} intersections")).unwrap_or_default();
    Ok(line(format!(
        "{}\n{} point MDPs{of} in scenario {}{imputed}",
        points(family, loaded.is_some()).plain(),
        family.points.len(),
        family.name
    ))?)
}

/// Returns a row per point MDP.
fn points(family: &MdpFamily, real: bool) -> Table {
    let mut columns = Columns::<&PointMdp>::new().text("point", "point", |p| p.id.clone()).column(
        "importance",
        "importance",
        |p| Cell::number(p.importance, |v| format!("{v:.4}")),
    );
    if real {
        let instances = |p: &&PointMdp| Cell::count(p.instances as usize);
        columns = columns.column("intersections", "intersections", instances);
    }
    for (i, feature) in family.features.iter().enumerate() {
        let value = move |p: &&PointMdp| Cell::number(p.features[i], short);
        columns = columns.column(&feature.name, &feature.name, value);
    }
    let is_other = |p: &PointMdp| p.title != p.id;
    if family.points.iter().any(is_other) {
        let title = move |p: &&PointMdp| if is_other(p) { p.title.clone() } else { String::new() };
        columns = columns.text("name", if real { "name" } else { "" }, title);
    }
    columns.table(&family.points)
}

/// Says how many approaches have no count of their own, if there are any.
fn imputed(loaded: &LoadedScenario) -> String {
    let imputed: u32 = loaded.intersections.iter().map(|i| i.imputed).sum();
    if imputed == 0 {
        return String::new();
    }
    let arms = loaded.intersections.iter().flat_map(|i| &i.arms).filter(|a| a.lanes_in > 0).count();
    format!(
        "\n{imputed} of {arms} approaches have no traffic count; the mean of others stands for it"
    )
}

/// Returns a number without needless digits.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Returns mean and standard deviation of each feature; for signals beside the intersections and the paper.
fn features(family: &MdpFamily, loaded: Option<&LoadedScenario>) -> String {
    let (moments, source) = (family.moments(), loaded.and_then(raw_moments));
    let of = |moments: Option<&(f64, f64)>| moments.map(|m| mean_sd(*m)).unwrap_or_default();
    let mut columns = Columns::<usize>::new()
        .text("feature", "feature", |f| family.features[*f].name.clone())
        .text("unit", "unit", |f| family.features[*f].unit.clone())
        .shown("point MDPs", |f| Cell::text(of(moments.get(*f))));
    if let Some(source) = &source {
        columns = columns.shown("intersections", |f| Cell::text(of(source.get(*f))));
    }
    let with_paper = family.name == "salt-lake-city";
    if with_paper {
        let of = |name: &str| PAPER.iter().find(|(feature, _)| *feature == name);
        columns = columns.shown("paper", move |f| {
            Cell::text(of(&family.features[*f].name).map_or("", |(_, moments)| moments))
        });
    }
    let mut text = columns.table(0..family.features.len()).plain();
    text.push_str("\nmean (standard deviation); point MDPs weighted by importance");
    if with_paper {
        text.push_str(
            "\nThe paper's 73.5 veh/h has probably lost a digit; its lengths, like these, were \
             measured in EPSG:3395 (see length_scale).",
        );
    }
    text
}

fn mean_sd((mean, sd): (f64, f64)) -> String {
    let digits = if mean.abs() >= 100.0 { 0 } else { 2 };
    format!("{mean:.digits$} ({sd:.digits$})")
}

/// Returns mean and standard deviation over the real intersections, before quantising.
fn raw_moments(loaded: &LoadedScenario) -> Option<[(f64, f64); 6]> {
    if loaded.intersections.is_empty() {
        return None;
    }
    let rows: Vec<[f64; 6]> = loaded
        .intersections
        .iter()
        .map(|i| six_features(i, &loaded.scenario.family).to_array())
        .collect();
    let n = rows.len() as f64;
    Some(std::array::from_fn(|f| {
        let mean = rows.iter().map(|r| r[f]).sum::<f64>() / n;
        let variance = rows.iter().map(|r| (r[f] - mean).powi(2)).sum::<f64>() / n;
        (mean, variance.sqrt())
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::family::load::load;

    #[test]
    fn a_json_line_has_the_features_by_name() {
        let family = load("smoke").unwrap().family;
        let first = points(&family, true).json().remove(0);
        assert_eq!(first["point"], "quiet");
        assert_eq!(first["importance"], 0.75);
        assert_eq!(first["intersections"], 3);
        assert_eq!(first["speed_mph"], 30.0);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([short(4.0), short(2.5), short(250.0)], ["4", "2.5", "250"]);
    }
}
