//! Families, samples of them and estimates, on whatever numbers Python has; none of it needs a simulator.

use std::collections::HashMap;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use tsc_family::analysis::estimator::{Chosen, Estimate, Sample, estimator_of};
use tsc_family::domains::entry_of;
use tsc_family::family::{Feature, MdpFamily, PointMdp};
use tsc_family::sample::{Design, Input, Measure, SamplePlan, Sampling, choose_over};
use tsc_family::seed::derive;
use tsc_family::settings::overrides::Override;
use tsc_family::stats::{PointObjectives, stretch};

use crate::error::raised;
use crate::simulation::load;

#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Given {
    name: String,
    points: Vec<String>,
    titles: Vec<String>,
    features: Vec<Vec<f64>>,
    feature_names: Vec<String>,
    feature_units: Vec<String>,
    importance: Vec<f64>,
    instances: Vec<u32>,
    describing: Vec<Vec<f64>>,
    /// Cheap methods with their scores on every point MDP.
    known: Vec<(String, Vec<f64>)>,
}

impl Given {
    fn family(&self) -> PyResult<MdpFamily> {
        let feature =
            |(name, unit): (&String, &String)| Feature { name: name.clone(), unit: unit.clone() };
        let point = |i: usize| PointMdp {
            id: self.points[i].clone(),
            title: self.titles[i].clone(),
            features: self.features[i].clone(),
            importance: self.importance[i],
            instances: self.instances[i],
        };
        let points = (0..self.points.len()).map(point).collect();
        let names = self.feature_names.iter().zip(&self.feature_units).map(feature).collect();
        let mut family = MdpFamily::new(&self.name, names, points, &self.name).map_err(raised)?;
        if !self.describing.is_empty() {
            family.describing = self.in_order(&family, &self.describing);
        }
        Ok(family)
    }

    fn in_order<T: Clone>(&self, family: &MdpFamily, values: &[T]) -> Vec<T> {
        let given: HashMap<&str, &T> = self.points.iter().map(String::as_str).zip(values).collect();
        family.points.iter().map(|p| given[p.id.as_str()].clone()).collect()
    }

    fn design(&self, family: &MdpFamily) -> Design {
        let mut design = Design::of(family);
        for (method, scores) in &self.known {
            let input = Input { method: method.clone(), measure: Measure::Score };
            design.add_input(&input, &self.in_order(family, scores));
        }
        design
    }
}

/// Returns the family of a scenario.
#[pyfunction]
pub(crate) fn family<'py>(
    py: Python<'py>,
    scenario: &str,
    settings: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let family = match entry_of(scenario).map_err(raised)? {
        None => load(scenario, &settings)?.family,
        Some(entry) => {
            let overrides: Result<Vec<Override>, _> = settings.iter().map(|s| s.parse()).collect();
            let problem = (entry.load)(scenario, &overrides.map_err(raised)?).map_err(raised)?;
            problem.family().clone()
        }
    };
    let dict = PyDict::new(py);
    let of = |get: &dyn Fn(&PointMdp) -> String| family.points.iter().map(get).collect::<Vec<_>>();
    dict.set_item("name", &family.name)?;
    dict.set_item("points", of(&|p| p.id.clone()))?;
    dict.set_item("titles", of(&|p| p.title.clone()))?;
    dict.set_item(
        "feature_names",
        family.features.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(),
    )?;
    dict.set_item(
        "feature_units",
        family.features.iter().map(|f| f.unit.as_str()).collect::<Vec<_>>(),
    )?;
    let features: Vec<&[f64]> = family.points.iter().map(|p| p.features.as_slice()).collect();
    dict.set_item("features", features)?;
    dict.set_item("importance", family.importance())?;
    dict.set_item("instances", family.points.iter().map(|p| p.instances).collect::<Vec<_>>())?;
    dict.set_item("describing", &family.describing)?;
    Ok(dict)
}

/// Returns the published results, as JSON, with which a run can be compared, or raises why there are none.
#[pyfunction]
pub(crate) fn published(run: [String; 3], settings: &str) -> PyResult<String> {
    let settings = serde_json::from_str(settings).map_err(raised)?;
    tsc_family::published::comparable(&run, &settings).map(|file| file.to_string()).map_err(raised)
}

/// Chooses point MDPs; returns the sample as JSON.
#[pyfunction]
pub(crate) fn sample(given: Given, sampling: &str, budget: usize, seed: u64) -> PyResult<String> {
    let family = given.family()?;
    let sampling: Sampling =
        serde_json::from_value(sampling.into()).map_err(|e| raised(format!("sampling: {e}")))?;
    let design = given.design(&family).for_sampling(sampling);
    let plan = choose_over(&family, &design, sampling, budget, seed).map_err(raised)?;
    serde_json::to_string(&plan).map_err(raised)
}

#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Measured {
    name: String,
    points: Vec<String>,
    /// Per point MDP, replicate and seed.
    scores: Vec<Vec<Vec<f64>>>,
    /// Per point MDP and seed what scores are divided by.
    baseline: Vec<Vec<f64>>,
    resamples: usize,
    seed: u64,
}

/// Returns the estimate of a method's overall performance over a family.
#[pyfunction]
pub(crate) fn estimate<'py>(
    py: Python<'py>,
    given: Given,
    plan: &str,
    measured: Measured,
) -> PyResult<Bound<'py, PyDict>> {
    let family = given.family()?;
    let plan: SamplePlan = serde_json::from_str(plan).map_err(raised)?;
    let design = given.design(&family).for_sampling(plan.sampling);
    let estimator = estimator_of(&plan);
    let at = design.coordinates();
    let mut chosen = Vec::with_capacity(measured.points.len());
    let mut objectives = Vec::with_capacity(measured.points.len());
    for ((id, method), baseline) in
        measured.points.iter().zip(measured.scores).zip(measured.baseline)
    {
        let draw = plan.draws.iter().find(|d| d.point == *id);
        let draw = draw.ok_or_else(|| raised(format!("point {id:?} is not in the sample")))?;
        let row = family.position(id);
        let row = row.ok_or_else(|| raised(format!("point {id:?} is not in the family")))?;
        chosen.push(Chosen {
            count: draw.count,
            inclusion: draw.inclusion,
            importance: family.points[row].importance,
            row: Some(row),
            at: at[row].clone(),
        });
        let (weight, draws) = (draw.weight, estimator.draws(draw.count));
        objectives.push(PointObjectives { weight, draws, method, baseline });
    }
    let sample = Sample {
        family_size: plan.family_size,
        chosen: plan.draws.len(),
        // Trainings of methods have nothing in common.
        method: derive(0, &["method", &measured.name]),
        name: &measured.name,
        points: &chosen,
        design: Some(&design),
        resamples: measured.resamples,
        alpha: plan.alpha(),
        // Scores alone do not tell how often a learner was trained.
        learned_once: false,
    };
    // Equally seeded for all methods, so that their resamples are paired.
    let mut rng = ChaCha8Rng::seed_from_u64(derive(measured.seed, &["report", "bootstrap"]));
    let estimate =
        py.detach(|| estimator.estimate(sample, &objectives, &mut rng)).map_err(raised)?;
    let dict = numbers(py, estimate)?;
    dict.set_item("estimator", estimator.name())?;
    dict.set_item("assumptions", estimator.assumptions())?;
    Ok(dict)
}

fn numbers(py: Python<'_>, estimate: Estimate) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("value", estimate.value)?;
    dict.set_item("interval", estimate.interval)?;
    dict.set_item("level", 1.0 - estimate.alpha)?;
    dict.set_item("centre", estimate.centre)?;
    dict.set_item("degrees", estimate.degrees)?;
    dict.set_item("stretch", stretch(estimate.degrees, estimate.alpha))?;
    dict.set_item("resamples", PyArray1::from_vec(py, estimate.resamples))?;
    Ok(dict)
}

/// The numbers of an estimate, as Python keeps them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Numbers {
    value: f64,
    interval: Option<(f64, f64)>,
    level: f64,
    centre: f64,
    degrees: Option<f64>,
    resamples: Vec<f64>,
}

impl From<Numbers> for Estimate {
    fn from(of: Numbers) -> Self {
        let Numbers { value, interval, level, centre, degrees, resamples } = of;
        Self { value, interval, centre, resamples, alpha: 1.0 - level, degrees }
    }
}

/// Returns the difference of two estimates from the same sample, the second less the first.
#[pyfunction]
pub(crate) fn difference(
    py: Python<'_>,
    first: Numbers,
    second: Numbers,
) -> PyResult<Bound<'_, PyDict>> {
    numbers(py, Estimate::from(first).difference(&second.into()))
}
