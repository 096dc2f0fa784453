//! What the states after transitions are worth.

use super::super::replay::Replay;
use super::super::values::largest;
use crate::nn::{Network, TILE};

/// The target network's parameters and what they say of stored transitions.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub(super) parameters: Vec<f32>,
    /// Value of the state after each stored transition; NaN where the network was not asked.
    pub(super) values: Vec<f32>,
    /// Place up to which the network has been asked ahead.
    pub(super) ahead: usize,
    states: Vec<f32>,
    asked: Vec<usize>,
    choices: Vec<usize>,
}

impl Target {
    /// Returns the target of a learner that starts from these parameters.
    pub(super) fn new(parameters: Vec<f32>) -> Self {
        let (values, states) = (Vec::new(), Vec::new());
        Self { parameters, values, ahead: 0, states, asked: Vec::new(), choices: Vec::new() }
    }

    /// Takes over what the online network has become.
    pub(super) fn copy(&mut self, parameters: &[f32]) {
        self.parameters.copy_from_slice(parameters);
        self.values.fill(f32::NAN);
        self.ahead = 0;
    }

    /// Forgets what was stored at a place; the replay buffer holds `len` transitions.
    pub(super) fn forget(&mut self, place: usize, len: usize) {
        self.values.resize(len, f32::NAN);
        self.values[place] = f32::NAN;
    }

    /// Asks the target network for what it has not been asked since its last copy.
    pub(super) fn value(&mut self, places: &[usize], replay: &Replay, network: &mut impl Network) {
        let Self { states, asked, .. } = self;
        states.clear();
        asked.clear();
        for place in places.iter().copied() {
            let transition = replay.get(place);
            if transition.terminal {
                self.values[place] = 0.0;
            } else if self.values[place].is_nan() {
                asked.push(place);
                states.extend_from_slice(transition.next);
            }
        }
        if asked.is_empty() {
            return;
        }
        // A tile costs the same however few rows it has: ask ahead for what will be drawn later.
        while !asked.len().is_multiple_of(TILE) && self.ahead < replay.len() {
            let place = self.ahead;
            let transition = replay.get(place);
            if self.values[place].is_nan() && !transition.terminal && !asked.contains(&place) {
                asked.push(place);
                states.extend_from_slice(transition.next);
            }
            self.ahead += 1;
        }
        let outputs = network.outputs();
        let values = network.forward(&self.parameters, states);
        for (place, values) in asked.iter().zip(values.chunks_exact(outputs)) {
            self.values[*place] = values[largest(values)];
        }
    }

    /// Values the online network's choices by the target network.
    pub(super) fn value_doubly(
        &mut self,
        places: &[usize],
        replay: &Replay,
        network: &mut impl Network,
        online: &[f32],
    ) {
        let Self { states, choices, .. } = self;
        states.clear();
        places.iter().for_each(|p| states.extend_from_slice(replay.get(*p).next));
        let outputs = network.outputs();
        choices.clear();
        let values = network.forward(online, states);
        choices.extend(values.chunks_exact(outputs).map(largest));
        let values = network.forward(&self.parameters, states);
        for ((place, choice), values) in
            places.iter().zip(choices.iter()).zip(values.chunks_exact(outputs))
        {
            let terminal = replay.get(*place).terminal;
            self.values[*place] = if terminal { 0.0 } else { values[*choice] };
        }
    }
}
