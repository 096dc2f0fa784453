//! Proximal policy optimisation on carts and poles: settings and their presets.
//!
//! Source: Stable-Baselines3 2.9 (`PPO`), and for `tuned` rl-baselines3-zoo 2.9 (`hyperparams/ppo.yml`,
//! `CartPole-v1`).

use crate::rl::sb3::Schedule;
pub use crate::rl::sb3::ppo::Settings;

/// Returns Stable-Baselines3's defaults, for 100,000 steps.
pub fn default() -> Settings {
    Settings::default()
}

/// Returns the settings that rl-baselines3-zoo tuned for gymnasium's own cart and pole: short rollouts of
/// eight environments, more passes, step size and clip range that fall to 0.
pub fn tuned() -> Settings {
    Settings {
        total_steps: 100_000,
        environments: 8,
        num_steps: 32,
        minibatch_size: 256,
        update_epochs: 20,
        learning_rate: 1e-3,
        learning_rate_schedule: Schedule::Linear,
        gamma: 0.98,
        gae_lambda: 0.8,
        clip_range: 0.2,
        clip_range_schedule: Schedule::Linear,
        ..Settings::default()
    }
}
