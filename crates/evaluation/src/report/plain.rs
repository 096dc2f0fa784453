//! A domain that adds nothing to a report but what its objective and methods are called and look like.

use super::sections::{Look, Sections};
use super::words::Words;
use crate::analysis::Measures;
use crate::stats::Limit;

/// A domain that adds nothing but names and colours.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plain {
    /// What the objective is called, and its unit; from the name of the metric when there is none.
    pub objective: Option<(String, String)>,
    /// What a row of training is called, and what it is where it is no single episode; an episode when there is none.
    pub row: Option<(String, String)>,
    /// How methods look, by name.
    pub looks: Vec<(String, Look)>,
    /// The most that the objective can be.
    pub most: Option<f64>,
    /// What counts as a failure; `None` where nothing does.
    pub failure: Option<Limit>,
}

impl Measures for Plain {
    fn most(&self, _objective: &str) -> Option<f64> {
        self.most
    }
}

impl Sections for Plain {
    fn measures(&self) -> &dyn Measures {
        self
    }

    fn words(&self, objective: &str) -> Words {
        let mut words = Words::of_metric(objective);
        if let Some((row, row_is)) = &self.row {
            (words.row, words.row_is) = (row.clone(), row_is.clone());
        }
        match &self.objective {
            None => words,
            Some((noun, unit)) => Words {
                noun: noun.clone(),
                amount: noun.clone(),
                unit: unit.clone(),
                unit_in_full: unit.clone(),
                ..words
            },
        }
    }

    fn failure(&self) -> Option<Limit> {
        self.failure.clone()
    }

    fn look(&self, method: &str) -> Option<Look> {
        self.looks.iter().find(|(name, _)| name == method).map(|(_, look)| *look)
    }
}
