//! Deep Q-learning on carts and poles: settings and their presets.
//!
//! Source: Stable-Baselines3 2.9 (`DQN`), and for `tuned` rl-baselines3-zoo 2.9 (`hyperparams/dqn.yml`,
//! `CartPole-v1`).

pub use crate::rl::sb3::dqn::Settings;

/// Returns Stable-Baselines3's defaults, for 100,000 steps; they hardly learn this task.
pub fn default() -> Settings {
    Settings::default()
}

/// Returns the settings that rl-baselines3-zoo tuned for gymnasium's own cart and pole: half the steps, a wider
/// network, large steps in blocks of 128 updates after every 256 steps.
pub fn tuned() -> Settings {
    Settings {
        total_steps: 50_000,
        learning_rate: 2.3e-3,
        buffer_size: 100_000,
        batch_size: 64,
        learning_starts: 1000,
        train_frequency: 256,
        gradient_steps: 128,
        target_network_frequency: 10,
        end_epsilon: 0.04,
        exploration_fraction: 0.16,
        hidden: vec![256, 256],
        ..Settings::default()
    }
}
