//! `tsc-family list`: the family, one line per point MDP, or its features beside the paper's.

use std::fmt::Write;

use serde_json::{Map, Value};

use super::output::line;
use super::scenario::ScenarioArg;
use crate::cli::exit;
use crate::family::MdpFamily;
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
    if let Some(entry) = args.scenario.entry()? {
        let problem = (entry.load)(&args.scenario.scenario, &args.scenario.settings())?;
        return other(args, problem.family());
    }
    let loaded = args.scenario.signals(&args.scenario.settings())?;
    if args.warnings {
        for doubt in &loaded.doubts {
            line(doubt.full())?;
        }
    } else if args.json {
        for text in json_lines(&loaded.family, Instances::Intersections) {
            line(text)?;
        }
    } else if args.features {
        line(features(&loaded))?;
    } else {
        line(table(&loaded.family, Instances::Intersections) + imputed(&loaded).as_str())?;
    }
    Ok(exit::DONE)
}

/// What point MDPs stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Instances {
    /// Real intersections.
    Intersections,
    /// Nothing but themselves.
    None,
}

/// Lists a family of another domain than traffic signals.
fn other(args: &ListArgs, family: &MdpFamily) -> anyhow::Result<u8> {
    if args.json {
        for text in json_lines(family, Instances::None) {
            line(text)?;
        }
    } else if args.features {
        let mut text = format!("{:18}{:24}{:>20}", "feature", "unit", "point MDPs");
        for (feature, (mean, sd)) in family.features.iter().zip(family.moments()) {
            write!(text, "\n{:18}{:24}{:>20}", feature.name, feature.unit, mean_sd(mean, sd))
                .expect("writing to a string cannot fail");
        }
        line(text + "\nmean (standard deviation); point MDPs weighted by importance")?;
    } else {
        line(table(family, Instances::None))?;
    }
    Ok(exit::DONE)
}

fn json_lines(family: &MdpFamily, instances: Instances) -> impl Iterator<Item = String> {
    family.points.iter().map(move |point| {
        let mut object = Map::new();
        object.insert("point".into(), point.id.clone().into());
        if point.title != point.id {
            object.insert("name".into(), point.title.clone().into());
        }
        object.insert("importance".into(), point.importance.into());
        if instances == Instances::Intersections {
            object.insert("intersections".into(), point.instances.into());
        }
        for (feature, value) in family.features.iter().zip(&point.features) {
            object.insert(feature.name.clone(), (*value).into());
        }
        Value::Object(object).to_string()
    })
}

fn table(family: &MdpFamily, instances: Instances) -> String {
    let real = instances == Instances::Intersections;
    let id_width = family.points.iter().map(|p| p.id.len()).max().unwrap_or(0).max(5);
    let mut text = format!("{:id_width$}  importance", "point");
    if real {
        text.push_str("  intersections");
    }
    for feature in &family.features {
        write!(text, "  {}", feature.name).expect("writing to a string cannot fail");
    }
    for point in &family.points {
        write!(text, "\n{:id_width$}  {:>10.4}", point.id, point.importance)
            .expect("writing to a string cannot fail");
        if real {
            write!(text, "  {:>13}", point.instances).expect("writing to a string cannot fail");
        }
        for (feature, value) in family.features.iter().zip(&point.features) {
            write!(text, "  {:>width$}", short(*value), width = feature.name.len())
                .expect("writing to a string cannot fail");
        }
        if point.title != point.id && real {
            write!(text, "  {}", point.title).expect("writing to a string cannot fail");
        }
    }
    let count: u64 = family.points.iter().map(|p| u64::from(p.instances)).sum();
    let of = if real { format!(" of {count} intersections") } else { String::new() };
    write!(text, "\n{} point MDPs{of} in scenario {}", family.points.len(), family.name)
        .expect("writing to a string cannot fail");
    text
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

fn features(loaded: &LoadedScenario) -> String {
    let family = &loaded.family;
    let source = raw_moments(loaded);
    let with_paper = family.name == "salt-lake-city";
    let mut text = format!("{:18}{:24}{:>20}", "feature", "unit", "point MDPs");
    if source.is_some() {
        write!(text, "{:>20}", "intersections").expect("writing to a string cannot fail");
    }
    if with_paper {
        write!(text, "{:>20}", "paper").expect("writing to a string cannot fail");
    }
    for (i, (feature, (mean, sd))) in family.features.iter().zip(family.moments()).enumerate() {
        write!(text, "\n{:18}{:24}{:>20}", feature.name, feature.unit, mean_sd(mean, sd))
            .expect("writing to a string cannot fail");
        if let Some(source) = &source {
            let (mean, sd) = source[i];
            write!(text, "{:>20}", mean_sd(mean, sd)).expect("writing to a string cannot fail");
        }
        let paper = PAPER.iter().find(|(name, _)| with_paper && *name == feature.name);
        if let Some((_, paper)) = paper {
            write!(text, "{paper:>20}").expect("writing to a string cannot fail");
        }
    }
    text.push_str("\nmean (standard deviation); point MDPs weighted by importance");
    if with_paper {
        text.push_str(
            "\nThe paper's 73.5 veh/h has probably lost a digit; its lengths, like these, were \
             measured in EPSG:3395 (see length_scale).",
        );
    }
    text.push_str(&imputed(loaded));
    text
}

fn mean_sd(mean: f64, sd: f64) -> String {
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
        let first: Value =
            serde_json::from_str(&json_lines(&family, Instances::Intersections).next().unwrap())
                .unwrap();
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
