//! From a method and a scenario to a controller, and how long it is trained.

use crate::control::fixed_time::budget;
use crate::control::registry::{METHODS, methods};
use crate::control::{self, Controller, Setup};
use crate::settings::Scenario;
use basics::units::SECONDS_PER_HOUR;
use evaluation::run::RunError;
use evaluation::run::domain::Effort;
use evaluation::run::method::{Method, TUNED, Training, find};
use evaluation::settings::overrides::number;
use evaluation::settings::setting::NoSettings;

/// The settings of a method, if it has any.
macro_rules! settings_of {
    ($scenario:ident $method:ident $config:ident) => {
        &$scenario.$method
    };
    ($scenario:ident $method:ident) => {
        &NoSettings
    };
}

macro_rules! make {
    ($(super::$first:ident $(::$a:ident)?),*; $(super::$then:ident $(::$b:ident)?),*) => {
        fn make(name: &str, scenario: &Scenario, setup: &Setup) -> Option<Box<dyn Controller>> {
            $(if name == control::$first::METHOD.name {
                return Some(control::$first::create(settings_of!(scenario $first $($a)?), setup));
            })*
            $(if name == control::$then::METHOD.name {
                return Some(control::$then::create(settings_of!(scenario $then $($b)?), setup));
            })*
            None
        }
    };
}
methods!(make);

/// Returns a controller by name, not yet trained.
/// * `imported` — whether the network is an imported one.
/// * `seed` — of everything random in it.
///
/// Fails with [`RunError::Method`] for a name that no method has.
pub fn create(
    name: &str,
    scenario: &Scenario,
    imported: bool,
    seed: u64,
) -> Result<Box<dyn Controller>, RunError> {
    let setup = setup(scenario, imported, seed);
    let name = find(METHODS, name)?.name;
    let name = name.strip_suffix(TUNED).unwrap_or(name);
    Ok(make(name, scenario, &setup).expect("both follow from the list of methods"))
}

/// Returns what a controller is set up with in a scenario, beside the settings of its method.
pub fn setup(scenario: &Scenario, imported: bool, seed: u64) -> Setup {
    let decision_s = scenario.signal.delta_time_s;
    let (episodes, nema) = (scenario.training.episodes, scenario.nema.clone());
    let longest_wait_s = scenario.signal.longest_wait_s;
    let fixed_time = scenario.fixed_time.clone();
    Setup { seed, episodes, imported, decision_s, longest_wait_s, nema, fixed_time }
}

/// Returns the episodes that a method is trained or tuned for in a scenario with so many signals, at most:
/// signals learn together, and tuning has [`budget`].
fn training_episodes(method: &Method, scenario: &Scenario, signals: u32) -> u32 {
    match method.training {
        Training::None => 0,
        Training::Learned => scenario.training.episodes,
        Training::Tuned { episodes: n } => budget(number(&scenario.sections(), n) as u32, signals),
    }
}

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
    let evaluation_s = SECONDS_PER_EPISODE + vehicles * SECONDS_PER_VEHICLE * congestion;
    let decisions = scenario.demand.horizon_s / f64::from(scenario.signal.delta_time_s);
    let training = training_episodes(method, scenario, signals);
    let training_s = evaluation_s + decisions * method.decision_s;
    Effort { training, training_s, evaluation: 0, evaluation_s, is_informed }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{fixed_time, idqn};
    use crate::settings::defaults;

    #[test]
    fn tuning_takes_more_simulations_for_more_signals_and_learning_its_episodes_once() {
        let scenario = defaults();
        let of = |method, signals| effort(&scenario, method, signals, &|_| None).training;
        assert_eq!([1, 4].map(|n| of(&fixed_time::METHOD, n)), [24, 48]);
        assert_eq!([1, 4].map(|n| of(&idqn::METHOD, n)), [100, 100]);
    }
}
