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
    /// Sizes of the hidden layers.
    pub hidden: Vec<usize>,
}

impl Default for Settings {
    /// Returns those of Stable-Baselines3 2.9, for 100,000 steps.
    fn default() -> Self {
        Self {
            total_steps: 100_000,
            learning_rate: 1e-4,
            adam_epsilon: 1e-8,
            gamma: 0.99,
            buffer_size: 1_000_000,
            batch_size: 32,
            learning_starts: 100,
            train_frequency: 4,
            gradient_steps: 1,
            target_network_frequency: 10_000,
            start_epsilon: 1.0,
            end_epsilon: 0.05,
            exploration_fraction: 0.1,
            max_grad_norm: 10.0,
            hidden: vec![64, 64],
        }
    }
}
