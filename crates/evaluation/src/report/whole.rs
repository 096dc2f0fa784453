//! A report before it is written: what records say, and what their domain adds.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use serde_json::{Value, json};

use super::sections::Sections;
use super::titles::differ;
use super::words::Words;
use crate::analysis::joined::{Joined, Source};
use crate::analysis::{Analysis, AnalysisError, Mix};
use crate::stats::Limit;
use crate::store::manifest::Manifest;
use crate::store::results::Results;

/// A report before it is written.
#[derive(Debug)]
pub struct Report {
    /// What records say.
    pub analysis: Analysis,
    /// What the objective is called.
    pub words: Words,
    /// What the domain adds.
    pub sections: Box<dyn Sections>,
    /// What it compares, where it is of several runs.
    pub runs: Option<Runs>,
    mix: OnceLock<Option<Mix>>,
    titles: Vec<String>,
}

/// The runs that a report compares.
#[derive(Debug)]
pub struct Runs {
    /// What they are called, their paths, and the settings of each.
    pub sources: Vec<(String, String, Arc<Manifest>)>,
    /// What differs between them, and how much that matters, a sentence each.
    pub differences: Vec<String>,
    /// How many episodes are equal of methods that several runs have, a sentence each.
    pub repeated: Vec<String>,
}

impl Deref for Report {
    type Target = Analysis;

    fn deref(&self) -> &Analysis {
        &self.analysis
    }
}

impl Report {
    /// Returns a report with scores relative to the run's baseline, if it has one.
    pub fn new(results: &Results, sections: Box<dyn Sections>) -> Self {
        Self::of(Analysis::new(results, sections.measures()), sections)
    }

    /// Returns a report with scores relative to another method.
    ///
    /// # Errors
    ///
    /// Those of [`Analysis::against`].
    pub fn against(
        results: &Results,
        method: &str,
        sections: Box<dyn Sections>,
    ) -> Result<Self, AnalysisError> {
        Ok(Self::of(Analysis::against(results, method, sections.measures())?, sections))
    }

    /// Returns a report that compares several runs.
    pub fn joined(joined: Joined, sections: Box<dyn Sections>) -> Self {
        let mut report = Self::new(&joined.results, sections);
        let Joined { sources, differences, repeated, .. } = joined;
        let of = |s: Source| (s.name, s.path, s.results.manifest);
        report.runs =
            Some(Runs { sources: sources.into_iter().map(of).collect(), differences, repeated });
        report
    }

    /// Sets what a failure is, instead of what the domain counts as one.
    ///
    /// # Errors
    ///
    /// Those of [`Analysis::fail_beyond`].
    pub fn failing(mut self, limit: Limit) -> Result<Self, AnalysisError> {
        self.analysis.fail_beyond(limit)?;
        Ok(self)
    }

    /// Sets the methods of the mix; without any there is none.
    ///
    /// # Errors
    ///
    /// [`AnalysisError`] for a method that the run has not.
    pub fn mixing(mut self, methods: &[String]) -> Result<Self, AnalysisError> {
        self.mix = self.analysis.mix(Some(methods))?.into();
        Ok(self)
    }

    fn of(mut analysis: Analysis, sections: Box<dyn Sections>) -> Self {
        analysis.failure = sections.failure();
        let words = sections.words(&analysis.manifest.identity.objective);
        let titles = analysis.points.iter().map(|p| sections.title(&p.row)).collect();
        Self { analysis, words, sections, titles, runs: None, mix: OnceLock::new() }
    }

    /// Returns the best choice among the methods per point MDP; `None` where it is not known or not asked for.
    pub(super) fn mix(&self) -> Option<&Mix> {
        // Without names nothing is refused.
        self.mix.get_or_init(|| self.analysis.mix(None).unwrap_or_default()).as_ref()
    }

    pub(super) fn better(&self) -> String {
        format!("{} is better", self.direction().name())
    }

    /// Says what scores are relative to, after a space; nothing where they are relative to nothing.
    pub(super) fn relative(&self) -> String {
        match self.reference.is_none() {
            true => String::new(),
            false => format!(" relative to {}", self.reference.name),
        }
    }

    /// Returns what a point MDP is called.
    pub(super) fn title_of(&self, point: &str) -> String {
        self.position(point).map_or(point, |p| self.titles[p].as_str()).to_owned()
    }

    /// Returns what every point MDP is called, in the order of [`Analysis::points`]; `None` where all
    /// are called by their ids, so that tables need no column for it.
    pub(super) fn titles(&self) -> Option<&[String]> {
        differ(&self.points, &self.titles).then_some(self.titles.as_slice())
    }

    /// Returns what a point MDP is called with its id behind it, for those who have to type that.
    pub(super) fn called(&self, point: &str) -> String {
        let title = self.title_of(point);
        if title == point { title } else { format!("{title} ({point})") }
    }
}

impl Runs {
    /// Returns the runs that are compared as `--json` prints them.
    pub fn json(&self) -> Value {
        let run = |(name, path, manifest): &(String, String, Arc<Manifest>)| {
            let (i, p) = (&manifest.identity, &manifest.provenance);
            json!({
                "run": name,
                "path": path,
                "simulator": i.simulator,
                "tsc_family": i.tsc_family,
                "git": p.git,
                "manifest": manifest.sha256(),
            })
        };
        let runs: Vec<Value> = self.sources.iter().map(run).collect();
        json!({"event": "compare", "runs": runs, "differences": self.differences, "repeated": self.repeated})
    }
}
