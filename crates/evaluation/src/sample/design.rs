//! What is known of every point MDP of a family before anything expensive runs: importance, what describes it, and
//! the scores of cheap methods where these were run everywhere.
//!
//! Samples are spread over it, and estimates use it for the point MDPs that were not evaluated.

use std::borrow::Cow;
use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::family::MdpFamily;
use basics::hash::sha256;

/// What a cheap method was measured to do on every point MDP.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Name of the method.
    pub method: String,
    /// What was measured.
    pub measure: Measure,
}

/// What an [`Input`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The score: the objective divided by that of the baseline, or the objective where there is no baseline.
    Score,
    /// The objective itself.
    Objective,
}

/// One point MDP of a [`Design`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignPoint {
    /// Id of the point MDP.
    pub point: String,
    /// Probability in the family.
    pub importance: f64,
    /// What describes it: its features, or what else the family compares.
    pub describing: Vec<f64>,
    /// Values of the [`Design::inputs`], in their order.
    pub inputs: Vec<f64>,
}

/// How alike the scores of a method are on the point MDPs of a design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// Length scale of every column: what describes point MDPs, then the inputs; in standard deviations over the family.
    pub length_scales: Vec<f64>,
    /// Variance of what no column explains, in proportion to that of what they explain.
    pub nugget: f64,
    /// By how much methods are expected to differ, in proportion to the family's mean, a value per point MDP.
    pub spread: Vec<f64>,
    /// Covariance with the overall performance without nugget, a value per point MDP.
    pub covariance: Vec<f64>,
    /// Variance of the overall performance without nugget.
    pub variance: f64,
}

/// What is known of every point MDP of a family; `design.json` of a results directory.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Cheap methods that were run everywhere; empty where none was.
    pub inputs: Vec<Input>,
    /// All point MDPs, in the order of the family.
    pub points: Vec<DesignPoint>,
    /// How alike scores are, where a sample by Bayesian quadrature rests on that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process: Option<Process>,
    /// The same without the scores of some inputs and their near twins, by the names of these, for estimates of one or two
    /// methods that are inputs themselves; empty in a sample that all assist.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub apart: BTreeMap<String, Process>,
}

/// Whether one method is called after the other, as `max-pressure-resco` after `max-pressure`.
fn are_twins(a: &str, b: &str) -> bool {
    let after = |a: &str, b: &str| {
        a.strip_prefix(b).is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()))
    };
    after(a, b) || after(b, a)
}

impl Design {
    /// Returns what a family alone says.
    pub fn of(family: &MdpFamily) -> Self {
        let describing = features(family);
        let row = |(point, describing): (&crate::family::PointMdp, &Vec<f64>)| DesignPoint {
            point: point.id.clone(),
            importance: point.importance,
            describing: describing.clone(),
            inputs: Vec::new(),
        };
        let points = family.points.iter().zip(describing.iter()).map(row).collect();
        Self { points, ..Self::default() }
    }

    /// Returns the bytes of `design.json`.
    pub fn to_json(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec_pretty(self).expect("a design is plain data");
        json.push(b'\n');
        json
    }

    /// Returns the sha256 of [`Design::to_json`].
    pub fn sha256(&self) -> String {
        sha256(&self.to_json())
    }

    /// Returns the position of a point MDP.
    pub fn position(&self, point: &str) -> Option<usize> {
        self.points.iter().position(|p| p.point == point)
    }

    /// Adds an input, a value per point MDP; a process that did not know it goes.
    pub fn add_input(&mut self, input: &Input, values: &[f64]) {
        (self.process, self.apart) = (None, BTreeMap::new());
        self.inputs.push(input.clone());
        self.points.iter_mut().zip(values).for_each(|(p, value)| p.inputs.push(*value));
    }

    /// Returns the same without the scores of some methods and their near twins, and without a process.
    pub fn without(&self, methods: &[&str]) -> Self {
        let out = self.own(methods);
        let kept: Vec<usize> =
            (0..self.inputs.len()).filter(|c| !out.contains(&&*self.inputs[*c].method)).collect();
        let row = |p: &DesignPoint| DesignPoint {
            inputs: kept.iter().map(|c| p.inputs[*c]).collect(),
            ..p.clone()
        };
        let inputs = kept.iter().map(|c| self.inputs[*c].clone()).collect();
        let points = self.points.iter().map(row).collect();
        Self { inputs, points, ..Self::default() }
    }

    /// Returns the inputs that are scores of some methods or of methods called like them.
    fn own(&self, methods: &[&str]) -> Vec<&str> {
        let scores = self.inputs.iter().filter(|input| input.measure == Measure::Score);
        let scores: Vec<&str> = scores.map(|input| input.method.as_str()).collect();
        // What is called after the same input is a twin, too.
        let is_own = |a: &&str| {
            let both = |b: &&str| {
                are_twins(a, b) || scores.iter().any(|c| are_twins(a, c) && are_twins(c, b))
            };
            methods.iter().any(both)
        };
        scores.iter().copied().filter(is_own).collect()
    }

    /// Returns a design with all that Bayesian quadrature needs of it, where no method assists its own estimate.
    pub fn assisting(self) -> Self {
        let names: Vec<&str> = self.inputs.iter().map(|input| input.method.as_str()).collect();
        let pairs = names.iter().flat_map(|a| names.iter().map(move |b| [*a, *b]));
        let out: BTreeMap<String, Vec<&str>> =
            pairs.map(|pair| self.own(&pair)).map(|own| (own.join(" "), own)).collect();
        let apart = out.into_par_iter().filter(|(_, own)| !own.is_empty());
        let apart =
            apart.filter_map(|(key, own)| Some((key, self.without(&own).modelled().process?)));
        let apart = apart.collect();
        Self { apart, ..self.modelled() }
    }

    /// Returns what is known where these methods are estimated, their names separated by blanks: all but their own scores
    /// where the design has a process without them.
    pub fn for_methods(&self, names: &str) -> Cow<'_, Self> {
        let own = self.own(&names.split(' ').collect::<Vec<_>>());
        match self.apart.get(&own.join(" ")) {
            Some(process) => {
                Cow::Owned(Self { process: Some(process.clone()), ..self.without(&own) })
            }
            None => Cow::Borrowed(self),
        }
    }

    /// Returns the inputs, a row per point MDP, in logarithms where all values of a column are above 0.
    pub fn transformed_inputs(&self) -> Vec<Vec<f64>> {
        let positive: Vec<bool> = (0..self.inputs.len())
            .map(|column| self.points.iter().all(|p| p.inputs[column] > 0.0))
            .collect();
        let value = |(x, positive): (&f64, &bool)| if *positive { x.ln() } else { *x };
        let row = |p: &DesignPoint| p.inputs.iter().zip(&positive).map(value).collect();
        self.points.iter().map(row).collect()
    }

    /// Returns where point MDPs lie, a row per point MDP: what describes them and the inputs, each column
    /// standardised over the family.
    pub fn coordinates(&self) -> Vec<Vec<f64>> {
        let inputs = self.transformed_inputs();
        let row = |(p, inputs): (&DesignPoint, Vec<f64>)| [p.describing.clone(), inputs].concat();
        let rows: Vec<Vec<f64>> = self.points.iter().zip(inputs).map(row).collect();
        super::kmeans::standardise(&rows)
    }
}

/// Returns the features that point MDPs are clustered by.
pub(super) fn features(family: &MdpFamily) -> Cow<'_, [Vec<f64>]> {
    match family.describing.is_empty() {
        true => family.points.iter().map(|p| p.features.clone()).collect(),
        false => Cow::Borrowed(&family.describing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design() -> Design {
        let point = |name: &str, describing: f64, score: f64| DesignPoint {
            point: name.to_owned(),
            importance: 0.5,
            describing: vec![describing],
            inputs: vec![score],
        };
        Design {
            inputs: vec![Input { method: "plain".to_owned(), measure: Measure::Score }],
            points: vec![point("a", 1.0, 0.5), point("b", 3.0, 2.0)],
            ..Design::default()
        }
    }

    #[test]
    fn coordinates_are_standardised_with_inputs_in_logarithms() {
        let rows = design().coordinates();
        let rounded: Vec<Vec<f64>> =
            rows.iter().map(|r| r.iter().map(|x| (x * 1e9).round() / 1e9).collect()).collect();
        assert_eq!(rounded, [[-1.0, -1.0], [1.0, 1.0]]);
    }

    #[test]
    fn no_method_and_no_twin_of_it_assists_its_own_estimate() {
        let mut three = design();
        let score = |method: &str| Input { method: method.to_owned(), measure: Measure::Score };
        three.add_input(&score("plain-tuned"), &[0.4, 1.9]);
        three.add_input(&score("plainer"), &[0.7, 1.0]);
        let inputs = |names: &str| three.clone().assisting().for_methods(names).inputs.clone();
        for own in ["plain", "plain-tuned", "plain-resco"] {
            assert_eq!(inputs(own), [score("plainer")]);
        }
        assert_eq!(inputs("plain plainer"), []);
        assert_eq!((inputs("other"), inputs("")), (three.inputs.clone(), three.inputs.clone()));
        assert_eq!(three.for_methods("plain").as_ref(), &three, "older samples");
    }

    #[test]
    fn an_input_of_0_is_taken_as_it_is() {
        let mut design = design();
        design.points[0].inputs[0] = 0.0;
        assert_eq!(design.transformed_inputs(), [[0.0], [2.0]]);
    }

    #[test]
    fn a_design_is_read_as_it_was_written() {
        let read: Design = serde_json::from_slice(&design().to_json()).unwrap();
        assert_eq!((read.sha256(), &read), (design().sha256(), &design()));
        let modelled = design().modelled();
        let read: Design = serde_json::from_slice(&modelled.to_json()).unwrap();
        assert_eq!(read, modelled);
        assert_ne!(read.sha256(), design().sha256());
    }
}
