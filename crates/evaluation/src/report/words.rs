//! What people call what is evaluated: its objective, with the unit, and what stands behind a point MDP.

use super::format;
use crate::analysis::{noun, unit};
use crate::stats::{Limit, Side};

/// What people call what is evaluated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Words {
    /// The objective, in the singular: `delay`.
    pub noun: String,
    /// Several values of it: `delays`.
    pub nouns: String,
    /// What a value is of: `delay per vehicle`.
    pub amount: String,
    /// Its unit, empty where it has none: `s`.
    pub unit: String,
    /// Its unit below a heading: `s per vehicle`.
    pub unit_in_full: String,
    /// What a small and a large value are called, and the largest: `short`, `long`, `longest`.
    pub sizes: [String; 3],
    /// What a point MDP stands for: `intersection`.
    pub instance: String,
    /// What all methods meet in an evaluation episode: `vehicles`.
    pub met: String,
    /// What a row of training is called: `episode`.
    pub row: String,
    /// What such a row is, in a sentence, where it is no single episode; empty where it is.
    pub row_is: String,
    /// What a point MDP may lack on which nothing is measured, as the end of a sentence.
    pub nothing: String,
}

impl Words {
    /// Returns words for an objective, from the name of its metric and the unit in it.
    pub fn of_metric(metric: &str) -> Self {
        let (noun, unit) = (noun(metric), unit(metric));
        Self {
            nouns: "values".to_owned(),
            amount: noun.clone(),
            unit: unit.to_owned(),
            unit_in_full: unit.to_owned(),
            sizes: ["small", "large", "largest"].map(str::to_owned),
            instance: "instance".to_owned(),
            met: "seeds".to_owned(),
            row: "episode".to_owned(),
            row_is: String::new(),
            nothing: String::new(),
            noun,
        }
    }

    /// Returns the objective with its unit, for a column: `delay (s)`.
    pub fn column(&self) -> String {
        match self.unit.as_str() {
            "" => self.noun.clone(),
            unit => format!("{} ({unit})", self.noun),
        }
    }

    /// Returns a value of the objective without its unit: as an amount, or where it has none as a score.
    pub fn value(&self, value: f64) -> String {
        if self.unit.is_empty() { format::score(value) } else { format::amount(value) }
    }

    /// Returns the objective as a heading: `Delay`.
    pub fn heading(&self) -> String {
        format::capitalised(&self.noun)
    }
}

/// Says beyond which value of a metric a method fails: `waiting above 20 s`.
pub(super) fn limit_in_words(limit: &Limit) -> String {
    let side = if limit.side == Side::Above { "above" } else { "below" };
    let text = format!("{} {side} {} {}", noun(&limit.metric), limit.value, unit(&limit.metric));
    text.trim_end().to_owned()
}
