//! The environment: a scenario's signals as a decision process.
//!
//! Words are Gymnasium's: [`SignalEnv::reset`] with a seed, [`SignalEnv::step`] with an action per
//! signal, `terminated`, `truncated`. Timing is RESCO's: a decision every `delta_time_s`, of which
//! the first seconds are yellow and all-red where the phase changes; [`cabinet`] keeps to the limits.

pub mod along;
pub mod by_movement;
pub mod cabinet;
pub mod derive;
pub mod dual_ring;
pub mod episode;
pub mod metrics;
mod movements;
pub mod observe;
pub(crate) mod on_red;
pub mod pairs;
pub mod pedestrians;
pub mod side;
pub mod signal;
pub mod signal_env;
pub mod standing;
#[cfg(test)]
pub(crate) mod testing;
pub mod warnings;
pub mod world;

pub use episode::run_episode;
pub use metrics::EpisodeMetrics;
pub use signal_env::SignalEnv;
pub use warnings::{Warning, warnings};
pub use world::World;
