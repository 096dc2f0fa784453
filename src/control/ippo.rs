//! IPPO.
use serde::{Deserialize, Serialize};

/// Hyper-parameters of `ippo`; the defaults are RESCO's.
///
/// Source: RESCO, config/agent_config.py and agents/pfrl_ppo.py.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Step size of Adam.
    pub learning_rate: f32,
    /// Adam's epsilon, added to the root of the second moment.
    pub adam_epsilon: f32,
    /// Discount per decision.
    pub gamma: f32,
    /// Discount of later advantages within the generalised advantage estimate.
    pub gae_lambda: f32,
    /// Transitions collected per update.
    pub num_steps: usize,
    /// Passes over the collected transitions per update.
    pub update_epochs: usize,
    /// Transitions per gradient step.
    pub minibatch_size: usize,
    /// Largest relative change of an action's probability that pays.
    pub clip_range: f32,
    /// Weight of the squared error of the value.
    pub value_coefficient: f32,
    /// Weight of the entropy bonus.
    pub entropy_coefficient: f32,
    /// Largest Euclidean norm of the gradient.
    pub max_grad_norm: f32,
    /// Channels of the convolution and units of both hidden layers.
    pub hidden: usize,
    /// Whether evaluation takes the most probable phase; RESCO draws it as in training.
    pub evaluate_mode: bool,
    /// Whether the last state of an episode has a value of its own. RESCO takes the time limit for
    /// the end of the world, although traffic goes on.
    pub bootstrap_at_time_limit: bool,
    /// Whether observations are shifted and scaled by their running mean and deviation. Not in RESCO.
    pub normalise_observations: bool,
    /// Whether weights start orthogonal instead of normally distributed. Not in RESCO.
    pub orthogonal_initialisation: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            learning_rate: 2.5e-4,
            adam_epsilon: 1e-5,
            gamma: 0.99,
            gae_lambda: 0.95,
            num_steps: 1024,
            update_epochs: 4,
            minibatch_size: 256,
            clip_range: 0.1,
            value_coefficient: 1.0,
            entropy_coefficient: 0.001,
            max_grad_norm: 0.5,
            hidden: 64,
            evaluate_mode: false,
            bootstrap_at_time_limit: false,
            normalise_observations: false,
            orthogonal_initialisation: false,
        }
    }
}

impl Config {
    /// Returns name, value, lowest and highest value of every number.
    pub fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let steps = self.num_steps as f64;
        vec![
            ("learning_rate", f64::from(self.learning_rate), 1e-8, 1.0),
            ("adam_epsilon", f64::from(self.adam_epsilon), 1e-12, 1.0),
            ("gamma", f64::from(self.gamma), 0.0, 1.0),
            ("gae_lambda", f64::from(self.gae_lambda), 0.0, 1.0),
            ("num_steps", steps, 2.0, 1e6),
            ("update_epochs", self.update_epochs as f64, 1.0, 1000.0),
            ("minibatch_size", self.minibatch_size as f64, 1.0, steps),
            ("clip_range", f64::from(self.clip_range), 1e-6, 10.0),
            ("value_coefficient", f64::from(self.value_coefficient), 0.0, 1e3),
            ("entropy_coefficient", f64::from(self.entropy_coefficient), 0.0, 1e3),
            ("max_grad_norm", f64::from(self.max_grad_norm), 1e-6, 1e9),
            ("hidden", self.hidden as f64, 1.0, 1024.0),
        ]
    }
}
