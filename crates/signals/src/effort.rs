//! About how long episodes take: what a forecast starts from before anything has been measured.

use super::controllers::training_episodes;
use super::settings::Scenario;
use basics::units::SECONDS_PER_HOUR;
use evaluation::run::domain::Effort;
use evaluation::run::method::Method;

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

/// Returns the effort of a task of a method on a point MDP with so many signals and these context features.
pub fn effort(
    scenario: &Scenario,
    method: &Method,
    signals: u32,
    feature: &dyn Fn(&str) -> Option<f64>,
) -> Effort {
    let hours = scenario.demand.horizon_s / SECONDS_PER_HOUR;
    let inflow_vph = feature("inflow_vph");
    let (inflow_vph, is_informed) = (inflow_vph.unwrap_or(0.0), inflow_vph.is_some());
    let vehicles = inflow_vph * APPROACHES * hours;
    let lanes_in = feature("lanes").map_or(1.0, |lanes| (lanes / 2.0).ceil());
    let congestion =
        1.0 + (inflow_vph / lanes_in.max(1.0) - FREE_VPH_PER_LANE).max(0.0) / DOUBLING_VPH_PER_LANE;
    let vehicle_s = SECONDS_PER_VEHICLE * congestion.min(MAX_CONGESTION);
    let evaluation_s = SECONDS_PER_EPISODE + vehicles * vehicle_s;
    let decisions = scenario.demand.horizon_s / f64::from(scenario.signal.delta_time_s);
    let training = training_episodes(method, scenario, signals);
    let training_s = evaluation_s + decisions * method.decision_s;
    Effort { training, training_s, evaluation_s, is_informed }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{fixed_time, idqn};
    use crate::settings::table::defaults;

    #[test]
    fn tuning_takes_more_simulations_for_more_signals_and_learning_its_episodes_once() {
        let scenario = defaults();
        let of = |method, signals| effort(&scenario, method, signals, &|_| None).training;
        assert_eq!([1, 4].map(|n| of(&fixed_time::METHOD, n)), [24, 48]);
        assert_eq!([1, 4].map(|n| of(&idqn::METHOD, n)), [100, 100]);
    }
}
