//! Small neural networks and reinforcement learning, independent of what is learned: a task gives observations,
//! rewards and a number of actions.

pub mod nn;
pub mod rl;
