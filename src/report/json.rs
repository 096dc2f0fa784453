//! A method as `--json` prints it.

use serde::Serialize;

use super::data::{MethodSummary, ReportData};
use super::summaries::Estimated;

/// A method as `--json` prints it; `null` is what is not known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JsonRow {
    /// Name of the method.
    pub method: String,
    /// Name of the method that scores are divided by.
    pub against: String,
    /// Overall performance.
    pub overall: Option<f64>,
    /// Lower end of the 95% interval.
    pub overall_low: Option<f64>,
    /// Upper end of the 95% interval.
    pub overall_high: Option<f64>,
    /// Importance-weighted mean of the objective.
    pub delay_s: Option<f64>,
    /// Point MDPs in the estimate.
    pub points: usize,
    /// Tasks that failed.
    pub failed: usize,
    /// Mean objective divided by the reference's.
    pub ratio_of_means: Option<f64>,
    /// Lower end of its 95% interval.
    pub ratio_of_means_low: Option<f64>,
    /// Upper end of its 95% interval.
    pub ratio_of_means_high: Option<f64>,
    /// Importance-weighted median score.
    pub median: Option<f64>,
    /// Lower end of its 95% interval.
    pub median_low: Option<f64>,
    /// Upper end of its 95% interval.
    pub median_high: Option<f64>,
    /// Importance-weighted geometric mean of the scores.
    pub geometric_mean: Option<f64>,
    /// Lower end of its 95% interval.
    pub geometric_mean_low: Option<f64>,
    /// Upper end of its 95% interval.
    pub geometric_mean_high: Option<f64>,
    /// Mean score where the baseline is at level of service E or better.
    pub up_to_e: Option<f64>,
    /// Lower end of its 95% interval.
    pub up_to_e_low: Option<f64>,
    /// Upper end of its 95% interval.
    pub up_to_e_high: Option<f64>,
    /// Mean score where the baseline is at level of service F.
    pub at_f: Option<f64>,
    /// Lower end of its 95% interval.
    pub at_f_low: Option<f64>,
    /// Upper end of its 95% interval.
    pub at_f_high: Option<f64>,
    /// Share of the vehicles that never entered or had not arrived.
    pub unfinished_share: Option<f64>,
    /// Share of the evaluation episodes that ended in gridlock.
    pub gridlock_share: Option<f64>,
    /// Median objective of an evaluation episode.
    pub episode_median_delay_s: Option<f64>,
    /// Largest objective of an evaluation episode.
    pub episode_worst_delay_s: Option<f64>,
    /// Median objective of an evaluation episode, relative to the reference on the same seed.
    pub episode_median: Option<f64>,
    /// Largest objective of an evaluation episode, relative to the reference on the same seed.
    pub episode_worst: Option<f64>,
}

impl ReportData {
    /// Returns the summaries as `--json` prints them, best first.
    pub fn json_rows(&self) -> Vec<JsonRow> {
        self.methods.iter().map(|m| json_row(m, &self.reference.name)).collect()
    }
}

fn json_row(m: &MethodSummary, against: &str) -> JsonRow {
    let (s, e) = (&m.summaries, &m.episodes);
    let value = |of: Option<Estimated>| of.map(|of| of.value);
    let low = |of: Option<Estimated>| Some(of?.interval?.0);
    let high = |of: Option<Estimated>| Some(of?.interval?.1);
    JsonRow {
        method: m.method.clone(),
        against: against.to_owned(),
        overall: m.overall,
        overall_low: m.interval.map(|i| i.0),
        overall_high: m.interval.map(|i| i.1),
        delay_s: m.objective,
        points: m.points,
        failed: m.failed,
        ratio_of_means: value(s.ratio_of_means),
        ratio_of_means_low: low(s.ratio_of_means),
        ratio_of_means_high: high(s.ratio_of_means),
        median: value(s.median),
        median_low: low(s.median),
        median_high: high(s.median),
        geometric_mean: value(s.geometric_mean),
        geometric_mean_low: low(s.geometric_mean),
        geometric_mean_high: high(s.geometric_mean),
        up_to_e: value(s.up_to_e),
        up_to_e_low: low(s.up_to_e),
        up_to_e_high: high(s.up_to_e),
        at_f: value(s.at_f),
        at_f_low: low(s.at_f),
        at_f_high: high(s.at_f),
        unfinished_share: e.unfinished,
        gridlock_share: e.gridlocked,
        episode_median_delay_s: e.median,
        episode_worst_delay_s: e.worst,
        episode_median: e.median_relative,
        episode_worst: e.worst_relative,
    }
}
