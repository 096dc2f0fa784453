//! Methods for control tasks: name, settings and defaults of each, and the products and sums of a step (`WORK`), updates
//! included, for observation and action of so many numbers; what they compute is in the crate of learners.

pub(crate) mod ars;
pub(crate) mod dqn;
pub(crate) mod ppo;
pub(crate) mod sac;
pub(crate) mod td3;
pub(crate) mod trpo;

use evaluation::run::method::{Method, Training};
use learners::rl::sb3::Trainer;

pub(crate) type Begin = dyn Fn(u64) -> Box<dyn Trainer>;

/// Returns the weights of a network with two hidden layers and inputs and outputs of so many numbers together; those
/// between the hidden layers count once, all others with the layer they are next to.
fn weights(numbers: usize, hidden: usize, second: usize) -> f64 {
    (hidden * second) as f64 + (numbers * hidden.max(second)) as f64
}
