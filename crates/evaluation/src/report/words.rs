//! What people call what is evaluated: its objective, with the unit, and what stands behind a point MDP.

use super::format;
use crate::analysis::{Reference, noun, unit};
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

impl Reference {
    /// Returns it in a sentence: `the baseline NAME`, or `NAME`.
    pub(super) fn in_full(&self) -> String {
        if self.is_baseline { baseline_in_full(&self.name) } else { self.name.clone() }
    }

    /// Returns it in a sentence, short: `the baseline`, or `NAME`.
    pub(super) fn in_short(&self) -> &str {
        if self.is_baseline { "the baseline" } else { &self.name }
    }

    /// Returns it in a label: `baseline`, or `NAME`.
    pub(super) fn as_label(&self) -> &str {
        if self.is_baseline { "baseline" } else { &self.name }
    }

    /// Returns its name in a table, marked as what the others are divided by.
    pub(super) fn marked(&self) -> String {
        match self.is_baseline {
            true if self.name == "baseline" => self.name.clone(),
            true => format!("{} (baseline)", self.name),
            false => format!("{} (divisor)", self.name),
        }
    }
}

/// Returns a baseline in a sentence: `the baseline NAME`, without a name that says just that.
pub(super) fn baseline_in_full(name: &str) -> String {
    if name == "baseline" { "the baseline".to_owned() } else { format!("the baseline {name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(name: &str, is_baseline: bool) -> Reference {
        Reference { name: name.into(), index: Some(0), is_baseline }
    }

    #[test]
    fn the_baseline_is_called_so_and_another_method_is_not() {
        let baseline = reference("untuned", true);
        assert_eq!(baseline.in_full(), "the baseline untuned");
        assert_eq!(baseline.in_short(), "the baseline");
        assert_eq!(reference("baseline", true).in_full(), "the baseline");
        assert_eq!(reference("fixed-time", false).in_full(), "fixed-time");
        assert_eq!(reference("fixed-time", false).as_label(), "fixed-time");
    }
}
