//! Methods for control tasks: name, settings and defaults of each; what they compute is in the crate of learners.

pub mod ars;
pub mod dqn;
pub mod ppo;
pub mod sac;
pub mod td3;
pub mod trpo;

use evaluation::run::method::{Method, Training};
use learners::rl::sb3::Trainer;

/// Makes a training of a method from a seed.
pub type Begin = dyn Fn(u64) -> Box<dyn Trainer>;

/// Returns the weights of a network with two hidden layers and inputs and outputs of so many numbers together; those
/// between the hidden layers count once, all others with the layer they are next to.
fn weights(numbers: usize, hidden: usize, second: usize) -> f64 {
    (hidden * second) as f64 + (numbers * hidden.max(second)) as f64
}
