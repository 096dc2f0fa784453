//! MPLight*: MPLight that sees four numbers per movement instead of one.
//!
//! Pressure, waiting time, speeds and approaching vehicles ([`super::state::full_demand`]); everything
//! else, the reward too, is [MPLight](super::mplight)'s.
//!
//! RESCO cuts the numbers of movement m out of the state from m on instead of from 4 m on, so that its
//! twelve movements see a window that slides over the first fifteen of 48 numbers, those of four
//! movements. There are two methods therefore:
//! - `mplight-star` gives every movement its own four numbers, as intended;
//! - `mplight-star-resco` does as RESCO does, for comparison with what was published.
//!
//! Source: RESCO, agents/mplight.py (`MPLightFULL`) and states.py (`mplight_full`).

use serde::{Deserialize, Serialize};

use super::mplight::{self, MpLight};
use super::state::{Demand, FULL_WIDTH};

/// Name of the variant in which every movement sees its own numbers.
pub const NAME: &str = "mplight-star";

/// Name of the variant that does as RESCO does.
pub const RESCO_NAME: &str = "mplight-star-resco";

/// Distance between the windows of two movements in RESCO's code.
const RESCO_STRIDE: usize = 1;

/// Hyper-parameters of `mplight-star` and `mplight-star-resco`; the defaults are RESCO's.
///
/// Source: RESCO, config/agent_config.py and agents/mplight.py.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Step size of Adam.
    pub learning_rate: f32,
    /// Adam's epsilon, added to the root of the second moment (PyTorch's default).
    pub adam_epsilon: f32,
    /// Discount per decision.
    pub gamma: f32,
    /// Transitions in the replay buffer.
    pub buffer_size: usize,
    /// Transitions per update, drawn uniformly without replacement.
    pub batch_size: usize,
    /// Transitions stored before the first update, a batch at least.
    pub learning_starts: usize,
    /// Decisions between two updates; one is made for all signals together.
    pub train_frequency: u32,
    /// Decisions between two copies into the target network.
    pub target_network_frequency: u32,
    /// Share of random actions at the start.
    pub start_e: f64,
    /// Share of random actions at the end.
    pub end_e: f64,
    /// Share of the training's episodes over which exploration falls from start to end; the
    /// product is cut to whole episodes.
    pub exploration_fraction: f64,
    /// Whether the last state of an episode has a value of its own. RESCO takes the time limit for
    /// the end of the world, although traffic goes on.
    pub bootstrap_at_time_limit: bool,
    /// Whether the online network chooses the action that the target network values (Van Hasselt et
    /// al., 2016). Not in RESCO.
    pub double_dqn: bool,
    /// Whether observations are shifted and scaled by their running mean and deviation. Not in RESCO.
    pub normalise_observations: bool,
    /// Whether weights start orthogonal instead of PyTorch's uniform default. Not in RESCO.
    pub orthogonal_initialisation: bool,
    /// Whether the speeds of all lanes of a movement count; in RESCO only those of its last lane.
    pub speed_of_all_lanes: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            learning_rate: 1e-3,
            adam_epsilon: 1e-8,
            gamma: 0.99,
            buffer_size: 10_000,
            batch_size: 32,
            learning_starts: 32,
            train_frequency: 1,
            target_network_frequency: 500,
            start_e: 1.0,
            end_e: 0.0,
            exploration_fraction: 0.8,
            bootstrap_at_time_limit: false,
            double_dqn: false,
            normalise_observations: false,
            orthogonal_initialisation: false,
            speed_of_all_lanes: false,
        }
    }
}

impl Config {
    /// Returns name, value, lowest and highest value of every number.
    pub fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
        self.common().ranges()
    }

    /// Returns what MPLight has as well.
    fn common(&self) -> mplight::Config {
        mplight::Config {
            learning_rate: self.learning_rate,
            adam_epsilon: self.adam_epsilon,
            gamma: self.gamma,
            buffer_size: self.buffer_size,
            batch_size: self.batch_size,
            learning_starts: self.learning_starts,
            train_frequency: self.train_frequency,
            target_network_frequency: self.target_network_frequency,
            start_e: self.start_e,
            end_e: self.end_e,
            exploration_fraction: self.exploration_fraction,
            bootstrap_at_time_limit: self.bootstrap_at_time_limit,
            double_dqn: self.double_dqn,
            normalise_observations: self.normalise_observations,
            orthogonal_initialisation: self.orthogonal_initialisation,
        }
    }
}

/// Returns an untrained `mplight-star`; `seed` is for everything random in it.
pub fn mplight_star(config: &Config, episodes: u32, seed: u64) -> MpLight {
    let demand = Demand::Full { all_lanes: config.speed_of_all_lanes, stride: FULL_WIDTH };
    MpLight::variant(NAME, config.common(), demand, episodes, seed)
}

/// Returns an untrained `mplight-star-resco`; `seed` is for everything random in it.
pub fn mplight_star_resco(config: &Config, episodes: u32, seed: u64) -> MpLight {
    let demand = Demand::Full { all_lanes: config.speed_of_all_lanes, stride: RESCO_STRIDE };
    MpLight::variant(RESCO_NAME, config.common(), demand, episodes, seed)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{check_learner, signal_with};
    use super::super::{Controller, LaneObservation, Observation, Service};
    use super::*;

    #[test]
    fn both_variants_learn_and_go_on_from_a_checkpoint() {
        check_learner(&|episodes| Box::new(mplight_star(&Config::default(), episodes, 7)));
        check_learner(&|episodes| Box::new(mplight_star_resco(&Config::default(), episodes, 7)));
    }

    #[test]
    fn resco_s_variant_is_blind_for_the_later_movements() {
        // Movements 1, 4, 7 and 10 in RESCO's numbers; windows of four from m on end before the
        // numbers of movement 7, which begin at 28.
        let rows: [[Service; 4]; 4] = std::array::from_fn(|a| {
            std::array::from_fn(|m| if a == m { Service::Protected } else { Service::None })
        });
        let signal = signal_with(&rows);
        let choice = |mut controller: MpLight, queue: [f64; 4]| {
            controller.begin(std::slice::from_ref(&signal)).unwrap();
            let lane = |queue| LaneObservation { queue, ..LaneObservation::default() };
            let seen = Observation { lanes: queue.map(lane).to_vec(), ..Observation::default() };
            controller.values(&seen)
        };
        let [few, many] = [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 9.0, 0.0]];
        let config = Config::default();
        let resco = || mplight_star_resco(&config, 1, 7);
        assert_eq!(choice(resco(), few), choice(resco(), many));
        let intended = || mplight_star(&config, 1, 7);
        assert_ne!(choice(intended(), few), choice(intended(), many));
    }
}
