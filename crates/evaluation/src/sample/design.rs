//! What is known of every point MDP of a family before anything expensive runs: importance, what describes it, and
//! the scores of cheap methods where these were run everywhere.
//!
//! Samples are spread over it, and estimates use it for the point MDPs that were not evaluated.

use std::borrow::Cow;

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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Cheap methods that were run everywhere; empty where none was.
    pub inputs: Vec<Input>,
    /// All point MDPs, in the order of the family.
    pub points: Vec<DesignPoint>,
    /// How alike scores are, where a sample by Bayesian quadrature rests on that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process: Option<Process>,
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
        Self { inputs: Vec::new(), points, process: None }
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
        self.process = None;
        self.inputs.push(input.clone());
        self.points.iter_mut().zip(values).for_each(|(p, value)| p.inputs.push(*value));
    }

    /// Returns the same without the inputs of some methods, and without a process.
    pub fn without(&self, methods: &[&str]) -> Self {
        let kept: Vec<usize> = (0..self.inputs.len())
            .filter(|c| !methods.contains(&self.inputs[*c].method.as_str()))
            .collect();
        let row = |p: &DesignPoint| DesignPoint {
            inputs: kept.iter().map(|c| p.inputs[*c]).collect(),
            ..p.clone()
        };
        let inputs = kept.iter().map(|c| self.inputs[*c].clone()).collect();
        Self { inputs, points: self.points.iter().map(row).collect(), process: None }
    }

    /// Returns the values of an input, a value per point MDP; `None` where it is none.
    pub fn input(&self, method: &str, measure: Measure) -> Option<Vec<f64>> {
        let wanted = |i: &Input| i.method == method && i.measure == measure;
        let column = self.inputs.iter().position(wanted)?;
        Some(self.points.iter().map(|p| p.inputs[column]).collect())
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
            process: None,
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
    fn an_input_that_is_not_there_is_none() {
        assert_eq!(design().input("plain", Measure::Score), Some(vec![0.5, 2.0]));
        assert_eq!(design().input("plain", Measure::Objective), None);
        assert_eq!(design().input("other", Measure::Score), None);
    }

    #[test]
    fn inputs_of_a_method_can_be_left_out() {
        let without = design().without(&["plain"]);
        assert!(without.inputs.is_empty() && without.points.iter().all(|p| p.inputs.is_empty()));
        assert_eq!(design().without(&["other"]), design());
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
