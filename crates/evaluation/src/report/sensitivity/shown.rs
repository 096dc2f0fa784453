//! A sensitivity as it is shown: its parts, and what they are called.

use crate::analysis::sensitivity::{Distribution, NAMED, Reversal, Sensitivity};
use crate::report::format;
use crate::report::whole::Report;
use crate::study::CaseStudy;

/// A sensitivity before it is written.
#[derive(Debug)]
pub struct SensitivityReport<'a> {
    /// What records say.
    pub data: &'a Sensitivity,
    /// The report on the same records: names, words, colours.
    pub report: &'a Report,
    /// How well estimators do in the paper's cases 1 to 3; nothing where that was not asked for.
    pub cases: &'a [CaseStudy],
    /// The command that asked for it.
    pub command: String,
}

impl SensitivityReport<'_> {
    /// Returns the distributions that people mean: those before the random ones.
    pub(super) fn meant(&self) -> &[Distribution] {
        &self.data.distributions[..self.data.distributions.len() - NAMED]
    }

    /// Returns the random distributions that are shown one by one.
    pub(super) fn drawn(&self) -> &[Distribution] {
        &self.data.distributions[self.meant().len()..]
    }

    /// Returns what a distribution is called in a heading.
    pub(super) fn heading(&self, distribution: &Distribution) -> String {
        let features = &self.report.manifest.identity.features;
        match features.iter().find(|f| f.name == distribution.name) {
            Some(feature) => format!("by {}", format::words(&feature.name, &feature.unit)),
            None => distribution.name.clone(),
        }
    }

    /// Returns the name of a method's score, with its direction.
    pub(super) fn score(&self) -> String {
        let (noun, relative) = (&self.report.words.noun, self.report.relative());
        format!("{noun}{relative}, {}", self.report.better())
    }
}

/// Returns a score with as many decimals as distributions differ in.
pub(super) fn score(value: f64) -> String {
    if value.abs() < 100.0 { format!("{value:.3}") } else { format::score(value) }
}

/// Says which methods change places.
pub(super) fn in_words(reversals: &[Reversal]) -> String {
    let one = |r: &Reversal| format!("{} is ahead of {}", r.here, r.overall);
    reversals.iter().map(one).collect::<Vec<_>>().join(", ")
}
