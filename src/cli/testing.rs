//! What tests of several files of the command line use.

use crate::run::effort::TaskEffort;

/// A task with episodes of training and evaluation of these seconds.
pub(super) fn effort(training: (u32, f64), evaluation: (u32, f64)) -> TaskEffort {
    TaskEffort {
        training: training.0,
        training_s: training.1,
        evaluation: evaluation.0,
        evaluation_s: evaluation.1,
        is_informed: true,
    }
}
