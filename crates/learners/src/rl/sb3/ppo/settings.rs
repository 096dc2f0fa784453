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
    /// Units of both hidden layers of either network.
    pub hidden: usize,
}
