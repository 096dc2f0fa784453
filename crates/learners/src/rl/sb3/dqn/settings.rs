//! Settings of deep Q-learning.

/// Settings of the algorithm.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Steps of the training.
    pub total_steps: u64,
    /// Step size of Adam.
    pub learning_rate: f32,
    /// Adam's epsilon.
    pub adam_epsilon: f32,
    /// Discount per step.
    pub gamma: f32,
    /// Steps in the replay buffer.
    pub buffer_size: usize,
    /// Steps per update.
    pub batch_size: usize,
    /// Steps before the first update.
    pub learning_starts: u64,
    /// Steps between two blocks of updates.
    pub train_frequency: u64,
    /// Updates of a block.
    pub gradient_steps: u32,
    /// Steps between two copies into the target network.
    pub target_network_frequency: u64,
    /// Share of random actions at the beginning.
    pub start_epsilon: f64,
    /// Share of random actions at the end.
    pub end_epsilon: f64,
    /// Share of the training over which it falls in a straight line.
    pub exploration_fraction: f64,
    /// Largest norm of the gradient.
    pub max_grad_norm: f32,
    /// Units of both hidden layers.
    pub hidden: usize,
}
