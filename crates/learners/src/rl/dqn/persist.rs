//! What a learner of action values has learned, and what it goes on from.

use super::Dqn;
use crate::nn::Network;
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::persist::{Persist, depends_on_both};

impl<N: Network> Persist for Dqn<N> {
    fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }

    fn is_alive(&mut self) -> bool {
        let actions = self.network.outputs();
        let values = self.network.forward(&self.parameters, &self.replay.probes());
        depends_on_both(values, actions)
    }

    fn learned(&self, prefix: &str, archive: &mut Archive) {
        crate::nn::save(&self.network, &self.parameters, prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.parameters = crate::nn::load(&self.network, prefix, archive)?;
        self.target.copy(&self.parameters);
        Ok(())
    }

    fn save(&self, prefix: &str, archive: &mut Archive) {
        let count = self.parameters.len();
        archive.put_f32(format!("{prefix}parameters"), &[count], &self.parameters);
        archive.put_f32(format!("{prefix}target"), &[count], &self.target.parameters);
        let values = &self.target.values;
        archive.put_f32(format!("{prefix}target-values"), &[values.len()], values);
        archive.put(&format!("{prefix}transitions"), self.transitions);
        archive.put(&format!("{prefix}ahead"), self.target.ahead);
        self.adam.save(prefix, archive);
        self.replay.save(prefix, archive);
        self.draws.save(&format!("{prefix}draws"), archive);
        self.exploration.save(&format!("{prefix}exploration"), archive);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let shape = [self.parameters.len()];
        self.parameters.copy_from_slice(archive.f32(&format!("{prefix}parameters"), &shape)?);
        self.target.parameters.copy_from_slice(archive.f32(&format!("{prefix}target"), &shape)?);
        self.adam.restore(prefix, archive)?;
        self.replay.restore(prefix, archive)?;
        let values = archive.f32(&format!("{prefix}target-values"), &[self.replay.len()])?;
        self.target.values = values.to_vec();
        self.transitions = archive.get(&format!("{prefix}transitions"))?;
        self.target.ahead = archive.get(&format!("{prefix}ahead"))?;
        self.draws.restore(&format!("{prefix}draws"), archive)?;
        self.exploration.restore(&format!("{prefix}exploration"), archive)
    }
}
