//! How much work a task is: its episodes and about how long they take.

use crate::run::plan::{Draft, Request};
use crate::traffic::control::registry::METHODS;
use crate::traffic::controllers::training_episodes;
use crate::units::SECONDS_PER_HOUR;

/// Processor time that SUMO takes per vehicle of an isolated intersection, seconds; measured on
/// the Salt Lake City family, see `benches/README.md`.
const SECONDS_PER_VEHICLE: f64 = 4e-4;

/// Processor time of an episode without vehicles, seconds.
const SECONDS_PER_EPISODE: f64 = 0.05;

/// Flow per incoming lane from which vehicles queue and cost more, vehicles per hour; measured on the
/// Salt Lake City family in the mean and the design hour.
const FREE_VPH_PER_LANE: f64 = 350.0;

/// Flow above that which doubles the cost of a vehicle, vehicles per hour and lane.
const DOUBLING_VPH_PER_LANE: f64 = 400.0;

/// Most times that a queueing vehicle costs as much as one that does not: roads are full then.
const MAX_CONGESTION: f64 = 3.0;

/// Approaches of a six-feature point MDP.
const APPROACHES: f64 = 4.0;

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
}

impl Effort {
    /// Returns the effort of a task of a method on a point MDP.
    pub(in crate::cli) fn of(request: &Request, draft: &Draft, method: &str, point: &str) -> Self {
        let scenario = &request.scenario.scenario;
        let hours = scenario.demand.horizon_s / SECONDS_PER_HOUR;
        let inflow_vph = feature(draft, point, "inflow_vph").unwrap_or(0.0);
        let vehicles = inflow_vph * APPROACHES * hours;
        let lanes_in = feature(draft, point, "lanes").map_or(1.0, |lanes| (lanes / 2.0).ceil());
        let congestion = 1.0
            + (inflow_vph / lanes_in.max(1.0) - FREE_VPH_PER_LANE).max(0.0) / DOUBLING_VPH_PER_LANE;
        let vehicle_s = SECONDS_PER_VEHICLE * congestion.min(MAX_CONGESTION);
        let evaluation_s = SECONDS_PER_EPISODE + vehicles * vehicle_s;
        let decisions = scenario.demand.horizon_s / f64::from(scenario.signal.delta_time_s);
        let method = METHODS.iter().find(|m| m.name == method);
        let training = method.map_or(0, |method| training_episodes(method, scenario));
        let decision_s = method.map_or(0.0, |method| method.decision_s);
        let training_s = evaluation_s + decisions * decision_s;
        Self { training, training_s, evaluation: request.evaluation_seeds, evaluation_s }
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

/// Returns a feature of a point MDP that has it.
pub(super) fn feature(draft: &Draft, point: &str, name: &str) -> Option<f64> {
    let family = &draft.family;
    let feature = family.features.iter().position(|f| f.name == name)?;
    Some(family.points[family.position(point)?].features[feature])
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
