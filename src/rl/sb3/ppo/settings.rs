//! Settings of proximal policy optimisation.

use crate::rl::sb3::Schedule;

/// Settings of the algorithm.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Steps of the training, in all environments together.
    pub total_steps: u64,
    /// Environments side by side.
    pub environments: usize,
    /// Steps per environment and update.
    pub num_steps: usize,
    /// Steps per gradient step.
    pub minibatch_size: usize,
    /// Passes over the steps of an update.
    pub update_epochs: usize,
    /// Step size of Adam.
    pub learning_rate: f32,
    /// How it falls.
    pub learning_rate_schedule: Schedule,
    /// Adam's epsilon.
    pub adam_epsilon: f32,
    /// Discount per step.
    pub gamma: f32,
    /// Discount of later errors in the advantage.
    pub gae_lambda: f32,
    /// Largest relative change of a probability that pays.
    pub clip_range: f32,
    /// How it falls.
    pub clip_range_schedule: Schedule,
    /// Weight of the entropy.
    pub entropy_coefficient: f32,
    /// Weight of the squared error of the value.
    pub value_coefficient: f32,
    /// Largest norm of the gradient.
    pub max_grad_norm: f32,
    /// Sizes of the hidden layers of either network.
    pub hidden: Vec<usize>,
}

impl Default for Settings {
    /// Returns those of Stable-Baselines3 2.9, for 100,000 steps.
    fn default() -> Self {
        Self {
            total_steps: 100_000,
            environments: 1,
            num_steps: 2048,
            minibatch_size: 64,
            update_epochs: 10,
            learning_rate: 3e-4,
            learning_rate_schedule: Schedule::Constant,
            adam_epsilon: 1e-5,
            gamma: 0.99,
            gae_lambda: 0.95,
            clip_range: 0.2,
            clip_range_schedule: Schedule::Constant,
            entropy_coefficient: 0.0,
            value_coefficient: 0.5,
            max_grad_norm: 0.5,
            hidden: vec![64, 64],
        }
    }
}
