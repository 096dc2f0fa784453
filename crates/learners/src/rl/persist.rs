//! What a learner leaves behind and goes on from, whatever its algorithm.

use crate::nn::state::{Learned, State};

/// A learner; its state is taken between two episodes, or between two updates.
pub trait Persist: State + Learned {
    /// Whether parameters and moments are numbers; where they are not, training has diverged.
    fn is_finite(&self) -> bool;

    /// Whether what was learned depends on state and action, as far as the states of the last decisions show it: a
    /// network whose units all give zero says the same everywhere, and no gradient brings it back. `true` where there
    /// are no states to ask about.
    fn is_alive(&mut self) -> bool;
}
