//! What a learner of a policy has learned, and what it goes on from.

use super::Ppo;
use super::rollout::Rollout;
use crate::nn::Network;
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::persist::{Persist, depends_on_both, spread};

impl<N: Network> Persist for Ppo<N> {
    fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }

    /// Of the logits: the value, which comes last, chooses no action.
    fn is_alive(&mut self) -> bool {
        let (inputs, width) = (self.network.inputs(), self.network.outputs());
        let state = |place: usize| &self.collected.states[place * inputs..][..inputs];
        let states: Vec<f32> =
            spread(self.collected.actions.len()).flat_map(state).copied().collect();
        let outputs = self.network.forward(&self.parameters, &states);
        let logits = outputs.chunks_exact(width).flat_map(|row| &row[..width - 1]);
        depends_on_both(&logits.copied().collect::<Vec<_>>(), width - 1)
    }

    fn learned(&self, prefix: &str, archive: &mut Archive) {
        crate::nn::save(&self.network, &self.parameters, prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.parameters = crate::nn::load(&self.network, prefix, archive)?;
        Ok(())
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        let name = |part: &str| format!("{prefix}{part}");
        archive.put_f32(name("parameters"), &[self.parameters.len()], &self.parameters);
        self.adam.save(prefix, archive);
        self.sampling.save(&name("sampling"), archive);
        self.shuffling.save(&name("shuffling"), archive);
        self.collected.save(prefix, self.network.inputs(), archive);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let name = |part: &str| format!("{prefix}{part}");
        let shape = [self.parameters.len()];
        self.parameters.copy_from_slice(archive.f32(&name("parameters"), &shape)?);
        self.adam.restore(prefix, archive)?;
        self.sampling.restore(&name("sampling"), archive)?;
        self.shuffling.restore(&name("shuffling"), archive)?;
        self.collected = Rollout::restore(prefix, self.network.inputs(), archive)?;
        Ok(())
    }
}
