//! What the states after transitions are worth.

use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::State;
use crate::nn::{Network, TILE};
use crate::rl::followed::Followed;
use crate::rl::replay::Replay;
use crate::rl::values::largest;

/// What the target network says of stored transitions. Until its next copy that stays the same, so that it is computed once.
#[derive(Debug, Clone, Default)]
pub(super) struct Target {
    /// Value of the state after each stored transition; NaN where the network was not asked.
    pub(super) values: Vec<f32>,
    /// Place up to which the network has been asked ahead.
    ahead: usize,
    states: Vec<f32>,
    asked: Vec<usize>,
    choices: Vec<usize>,
}

impl Target {
    /// Forgets all values, as the network has changed.
    pub(super) fn forget_all(&mut self) {
        self.values.clear();
        self.ahead = 0;
    }

    /// Forgets what was stored at a place.
    pub(super) fn forget(&mut self, place: usize) {
        if let Some(value) = self.values.get_mut(place) {
            *value = f32::NAN;
        }
    }

    /// Asks the target network for what it has not been asked since its last copy; where `is_double`, the online network
    /// chooses the action that it values, and has changed.
    pub(super) fn value<N: Network>(
        &mut self,
        places: &[usize],
        replay: &Replay,
        learned: &mut Followed<N>,
        is_double: bool,
    ) {
        let Self { values, ahead, states, asked, choices } = self;
        values.resize(replay.len(), f32::NAN);
        states.clear();
        asked.clear();
        for place in places.iter().copied() {
            let transition = replay.get(place);
            if transition.terminal {
                values[place] = 0.0;
            } else if is_double || values[place].is_nan() {
                asked.push(place);
                states.extend_from_slice(transition.next);
            }
        }
        if asked.is_empty() {
            return;
        }
        // A tile costs the same however few rows it has: ask ahead for what will be drawn later.
        while !is_double && !asked.len().is_multiple_of(TILE) && *ahead < replay.len() {
            let transition = replay.get(*ahead);
            if values[*ahead].is_nan() && !transition.terminal && !asked.contains(ahead) {
                asked.push(*ahead);
                states.extend_from_slice(transition.next);
            }
            *ahead += 1;
        }
        let Followed { network, parameters, target, .. } = learned;
        let actions = network.outputs();
        choices.clear();
        if is_double {
            choices.extend(network.forward(parameters, states).chunks_exact(actions).map(largest));
        }
        let rows = network.forward(target, states).chunks_exact(actions);
        for (i, (place, row)) in asked.iter().zip(rows).enumerate() {
            values[*place] = row[choices.get(i).copied().unwrap_or_else(|| largest(row))];
        }
    }
}

/// It is computed again.
impl State for Target {
    fn save(&self, _: &str, _: &mut Archive) {}

    fn restore(&mut self, _: &str, _: &Archive) -> Result<(), ArchiveError> {
        self.forget_all();
        Ok(())
    }
}
