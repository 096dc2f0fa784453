//! MPLight*.
use serde::{Deserialize, Serialize};

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
    /// Transitions stored before the first update.
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
        let buffer = self.buffer_size as f64;
        vec![
            ("learning_rate", f64::from(self.learning_rate), 1e-8, 1.0),
            ("adam_epsilon", f64::from(self.adam_epsilon), 1e-12, 1.0),
            ("gamma", f64::from(self.gamma), 0.0, 1.0),
            ("buffer_size", buffer, 1.0, 1e6),
            ("batch_size", self.batch_size as f64, 1.0, buffer.min(4096.0)),
            ("learning_starts", self.learning_starts as f64, self.batch_size as f64, buffer),
            ("train_frequency", f64::from(self.train_frequency), 1.0, 1e6),
            ("target_network_frequency", f64::from(self.target_network_frequency), 1.0, 1e9),
            ("start_e", self.start_e, 0.0, 1.0),
            ("end_e", self.end_e, 0.0, 1.0),
            ("exploration_fraction", self.exploration_fraction, 0.0, 1.0),
        ]
    }
}
