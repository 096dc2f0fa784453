//! Reinforcement learning algorithms, general over network and environment.
