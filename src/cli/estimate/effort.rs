//! The episodes of a task and about how long each takes.

use crate::run::method::find;
use crate::run::plan::Request;

/// The episodes of a task and about how long each takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::cli) struct Effort {
    /// Episodes of training or tuning, at most.
    training: u32,
    /// Processor time of one of them, seconds.
    training_s: f64,
    /// Episodes of evaluation.
    evaluation: u32,
    /// Processor time of one of them, seconds.
    evaluation_s: f64,
    /// Whether the times rest on what is known of the point MDP; else only their ratio is of use.
    pub(in crate::cli) is_informed: bool,
}

impl Effort {
    /// Returns the effort of a task of a method on a point MDP.
    pub(in crate::cli) fn of(request: &Request<'_>, method: &str, point: &str) -> Self {
        let method = find(request.domain.methods(), method).expect("a draft has known methods");
        let of = request.problem.effort(method, point);
        Self {
            training: of.training,
            training_s: of.training_s,
            evaluation: request.evaluation_seeds,
            evaluation_s: of.evaluation_s,
            is_informed: of.is_informed,
        }
    }

    /// Returns how many episodes the task has at most.
    pub(in crate::cli) fn episodes(&self) -> u32 {
        self.training + self.evaluation
    }

    /// Returns the processor time of the first `episodes` episodes, seconds.
    pub(in crate::cli) fn seconds(&self, episodes: u32) -> f64 {
        let training = episodes.min(self.training);
        let evaluation = (episodes - training).min(self.evaluation);
        f64::from(training) * self.training_s + f64::from(evaluation) * self.evaluation_s
    }
}

#[cfg(test)]
pub(in crate::cli) mod testing {
    use super::Effort;

    /// A task with episodes of training and evaluation of these seconds.
    pub(in crate::cli) fn effort(training: (u32, f64), evaluation: (u32, f64)) -> Effort {
        Effort {
            training: training.0,
            training_s: training.1,
            evaluation: evaluation.0,
            evaluation_s: evaluation.1,
            is_informed: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::effort;

    #[test]
    fn episodes_of_training_come_first_and_count_at_their_own_price() {
        let effort = effort((3, 10.0), (2, 1.0));
        assert_eq!(effort.episodes(), 5);
        let seconds: Vec<_> = [0, 2, 3, 4, 5, 9].map(|n| effort.seconds(n)).to_vec();
        assert_eq!(seconds, [0.0, 20.0, 30.0, 31.0, 32.0, 32.0]);
    }
}
