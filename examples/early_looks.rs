//! What a learner's first episodes, trained on all point MDPs, would add to what M4 knows: error and CPU-hours with and
//! without them, from the records of learners on a whole family.
//!
//! ```sh
//! cargo run --release --example early_looks -- LEARNERS CHEAP [REPEATS]
//! ```
//!
//! LEARNERS and CHEAP are results directories of `run --budget all`. An early look at `k` episodes is the mean delay
//! over the last five of the first `k` training episodes, relative to the baseline: with exploration, on training seeds,
//! for records hold no evaluation in the middle of a training. Hours are those of the trainings of the sample, and of the first `k`
//! episodes everywhere else, whose share of a task's time is taken to be their share of its episodes.
//! `results/salt-lake-city/README.md` has the results.

use std::error::Error;
use std::io::Write;
use std::path::Path;

use tsc_family::analysis::{Analysis, NoMeasures};
use tsc_family::sample::design::{Input, Measure};
use tsc_family::store::Layout;
use tsc_family::store::results::Results;
use tsc_family::study::{Kind, Recorded, StudyPlan, study};

/// Episodes of an early look; 0 is none.
const LOOKS: [usize; 3] = [0, 10, 25];

/// Episodes that a look is the mean of.
const WIDTH: usize = 5;

/// Budgets without an early look, up to where hours are those with one.
const BUDGETS: [usize; 7] = [20, 30, 40, 50, 70, 80, 100];

/// Budgets with an early look.
const WITH_LOOK: [usize; 3] = [20, 40, 80];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [learners, cheap, rest @ ..] = args.as_slice() else {
        return Err("give a results directory with learners and one with cheap methods".into());
    };
    let repeats = rest.first().map_or(Ok(500), |r| r.parse())?;
    let (analysis, all) = read(learners)?;
    let (_, known) = read(cheap)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "learner,look,budget,rmse,bias,cpu_hours")?;
    for method in all.methods.iter().filter(|m| m.learns) {
        let episodes = analysis.trainings.iter().find(|t| t.method == method.name);
        let episodes = episodes.map_or(0, |t| t.episodes);
        let evaluations = analysis.manifest.identity.evaluation_seeds.len();
        let everywhere: Option<f64> = method.cost_s.iter().copied().sum();
        for look in LOOKS {
            let mut recorded = all.clone();
            recorded.methods.retain(|m| m.name == method.name);
            recorded.assisted_by(&known, cheap, learners)?;
            if look > 0 {
                let name = format!("{} after {look} episodes", method.name);
                let input = Input { method: name, measure: Measure::Score };
                recorded.inputs.push((input, early(&analysis, &all, &method.name, look)?));
            }
            let plan = StudyPlan {
                budgets: if look == 0 { BUDGETS.to_vec() } else { WITH_LOOK.to_vec() },
                repeats,
                kinds: vec![Kind::M4],
                seed: 0,
                resamples: 0,
            };
            for cell in study(&recorded, &plan, &|_| {})? {
                let share = look as f64 / (episodes + evaluations) as f64;
                let hours = cell.cpu_hours.zip(everywhere);
                let hours = hours.map(|(own, all)| own + share * (all / 3600.0 - own));
                let hours = hours.map_or_else(String::new, |h| format!("{h:.2}"));
                let (name, budget, error) = (&method.name, cell.budget, cell.error);
                let bias = cell.mean - cell.truth;
                writeln!(out, "{name},{look},{budget},{error:.4},{bias:.4},{hours}")?;
                out.flush()?;
            }
        }
    }
    Ok(())
}

/// Reads results on a whole family.
fn read(dir: &str) -> Result<(Analysis, Recorded), Box<dyn Error>> {
    let results = Results::load(&Layout::new(Path::new(dir)))?;
    let analysis = Analysis::new(&results, &NoMeasures);
    let recorded = Recorded::of(&analysis, dir)?;
    Ok((analysis, recorded))
}

/// Returns what a learner achieved after so many episodes, in the order of the family.
fn early(
    analysis: &Analysis,
    recorded: &Recorded,
    method: &str,
    look: usize,
) -> Result<Vec<f64>, Box<dyn Error>> {
    let mean = |id: &str| {
        let at = |t: &&tsc_family::analysis::TrainingSummary| {
            t.method == method && analysis.points[t.point].row.point == id
        };
        let curves: Vec<&[Option<f64>]> =
            analysis.trainings.iter().filter(at).map(|t| &t.curve[..]).collect();
        let last: Vec<f64> = (curves.iter())
            .filter(|c| c.len() >= look)
            .flat_map(|c| c[look.saturating_sub(WIDTH)..look].iter().copied().flatten())
            .collect();
        if last.is_empty() {
            return Err(format!("{method} has fewer than {look} episodes on {id}"));
        }
        Ok(last.iter().sum::<f64>() / last.len() as f64)
    };
    let all = recorded.family.points.iter().map(|p| mean(&p.id)).collect::<Result<Vec<_>, _>>()?;
    Ok(all)
}
