//! Reinforcement learning algorithms, general over network and environment.
//!
//! They see vectors of numbers, numbered actions and rewards; what these mean is the caller's.

pub mod dqn;
pub mod environment;
mod followed;
pub mod normalise;
pub mod persist;
pub mod ppo;
pub mod random;
pub mod replay;
pub mod sb3;
pub mod schedule;
mod values;
