//! Settings of proximal policy optimisation.

/// Settings of the algorithm.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Step size of Adam.
    pub learning_rate: f32,
    /// Adam's epsilon.
    pub adam_epsilon: f32,
    /// Discount per decision.
    pub gamma: f32,
    /// Discount of later errors in the advantage.
    pub gae_lambda: f32,
    /// Steps collected per update.
    pub num_steps: usize,
    /// Passes over them.
    pub update_epochs: usize,
    /// Steps per gradient step.
    pub minibatch_size: usize,
    /// Largest relative change of a probability that pays.
    pub clip_range: f32,
    /// Weight of the squared error of the value.
    pub value_coefficient: f32,
    /// Weight of the entropy.
    pub entropy_coefficient: f32,
    /// Largest norm of the gradient.
    pub max_grad_norm: f32,
}
