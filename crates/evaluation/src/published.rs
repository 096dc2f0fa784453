//! Published scores that come with the program, a file per family and preset under `data/published`, written by
//! `scripts/published_scores.py`: version of the program, settings that the scores depend on, a row per method, and the
//! scores of methods that do not learn on every point MDP.

use serde_json::Value;

use crate::family::{MdpFamily, PointMdp};
use crate::run::domain::Problem;
use crate::sample::{Choice, Design, Input, Measure, Sampling};
use crate::store::assisting::{self, MOST_NAMED};

const FILES: &[&str] = include!(concat!(env!("OUT_DIR"), "/published.rs"));

/// How far the importance of a point MDP may be from that of a file, which has ten digits.
const TOLERANCE: f64 = 1e-9;

/// Returns what is published of a scenario under the preset that settings name; `None` where nothing is.
fn published(scenario: &str, settings: &Value) -> Option<Value> {
    let mut parsed = FILES.iter().map(|text| -> Value {
        serde_json::from_str(text).expect("the files are those of the script")
    });
    let is_of = |file: &Value| {
        file["scenario"] == scenario && file["settings"]["preset"] == settings["preset"]
    };
    parsed.find(is_of)
}

/// Returns the published results, as in their file, with which a run of these settings can be compared.
///
/// # Errors
///
/// Why there are none.
pub fn comparable(
    [scenario, version, simulator]: &[String; 3],
    settings: &Value,
) -> Result<Value, String> {
    let nothing = "with this preset are published with the program";
    let file = published(scenario, settings)
        .ok_or_else(|| format!("no scores of {scenario} {nothing}"))?;
    for (what, here) in [("version", version), ("simulator", simulator)] {
        let there = file[what].as_str().unwrap_or_default();
        if there != here {
            return Err(format!("published scores are of {what} {there}, these of {here}"));
        }
    }
    match &assisting::differing(&file["settings"], settings)[..] {
        [] => Ok(file),
        other => {
            let named = other[..other.len().min(MOST_NAMED)].join(", ");
            Err(format!("published scores have other settings ({named})"))
        }
    }
}

/// Scores of methods on every point MDP, and the settings that they have.
type Known = (Vec<(Input, Vec<f64>)>, Value);

/// Returns the scores of methods that do not learn on every point MDP of a family, and the settings that they have.
///
/// # Errors
///
/// Why they do not fit; `None` where there are none.
pub fn inputs(family: &MdpFamily, settings: &Value) -> Result<Known, Option<String>> {
    let mut file = published(&family.name, settings).ok_or(None)?;
    let unfit = |why: &str| Err(Some(format!("published scores do not assist, because {why}")));
    // Results of older versions lack the sections of newer methods.
    let known = file["settings"].as_object_mut().expect("the files are those of the script");
    known.retain(|section, _| settings.get(section).is_some());
    if let Some(named) = assisting::differences(&file["settings"], settings) {
        return unfit(&format!("settings differ: {named}"));
    }
    let rows = file["points"].as_array().map_or(&[][..], Vec::as_slice);
    let is_same = |(row, point): (&Value, &PointMdp)| {
        let importance = row[1].as_f64().unwrap_or(f64::NAN);
        row[0] == *point.id && (importance - point.importance).abs() <= TOLERANCE
    };
    if rows.len() != family.points.len() || !rows.iter().zip(&family.points).all(is_same) {
        return unfit("the family is another one");
    }
    let input = |(column, method): (usize, &Value)| {
        // The baseline comes first.
        let measure = if column == 0 { Measure::Objective } else { Measure::Score };
        let values = rows.iter().map(|row| row[column + 2].as_f64()).collect::<Option<_>>()?;
        Some((Input { method: method.as_str()?.to_owned(), measure }, values))
    };
    let methods = file["inputs"].as_array().into_iter().flatten();
    let inputs = methods.enumerate().map(input).collect::<Option<_>>();
    Ok((inputs.expect("every row has a number per method"), file["settings"].take()))
}

/// Returns a sample by Bayesian quadrature that published scores of the scenario assist.
///
/// # Errors
///
/// Those of [`inputs`].
pub fn choice(problem: &dyn Problem, budget: usize) -> Result<Choice, Option<String>> {
    let family = problem.family();
    let (inputs, settings) = inputs(family, &problem.settings())?;
    let mut design = Design::of(family);
    inputs.iter().for_each(|(input, values)| design.add_input(input, values));
    Ok(Choice::Budget {
        budget,
        sampling: Sampling::BayesianQuadrature,
        design: Some(design.assisting()),
        assisting: Some(settings),
    })
}
