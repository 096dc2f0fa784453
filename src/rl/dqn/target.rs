//! What the states after transitions are worth.

use super::{Buffers, Dqn, best};
use crate::nn::{Network, TILE};

impl<N: Network> Dqn<N> {
    /// Asks the target network for what it has not been asked since its last copy.
    pub(super) fn value(&mut self, places: &[usize]) {
        let Buffers { states, asked, .. } = &mut self.buffers;
        states.clear();
        asked.clear();
        for place in places.iter().copied() {
            let transition = self.replay.get(place);
            if transition.terminal {
                self.target_values[place] = 0.0;
            } else if self.target_values[place].is_nan() {
                asked.push(place);
                states.extend_from_slice(transition.next);
            }
        }
        if asked.is_empty() {
            return;
        }
        // A tile costs the same however few rows it has: ask ahead for what will be drawn later.
        while !asked.len().is_multiple_of(TILE) && self.ahead < self.replay.len() {
            let place = self.ahead;
            let transition = self.replay.get(place);
            if self.target_values[place].is_nan() && !transition.terminal && !asked.contains(&place)
            {
                asked.push(place);
                states.extend_from_slice(transition.next);
            }
            self.ahead += 1;
        }
        let outputs = self.network.outputs();
        let values = self.network.forward(&self.target, states);
        for (place, values) in asked.iter().zip(values.chunks_exact(outputs)) {
            self.target_values[*place] = values[best(values)];
        }
    }

    /// Values the online network's choices by the target network.
    pub(super) fn value_doubly(&mut self, places: &[usize]) {
        let Buffers { states, best: choices, .. } = &mut self.buffers;
        states.clear();
        places.iter().for_each(|p| states.extend_from_slice(self.replay.get(*p).next));
        let outputs = self.network.outputs();
        choices.clear();
        let values = self.network.forward(&self.parameters, states);
        choices.extend(values.chunks_exact(outputs).map(best));
        let values = self.network.forward(&self.target, states);
        for ((place, choice), values) in
            places.iter().zip(choices.iter()).zip(values.chunks_exact(outputs))
        {
            let terminal = self.replay.get(*place).terminal;
            self.target_values[*place] = if terminal { 0.0 } else { values[*choice] };
        }
    }
}
