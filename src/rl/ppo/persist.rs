//! What a learner of a policy has learned, and what it goes on from.

use super::Ppo;
use super::rollout::Rollout;
use crate::nn::Network;
use crate::nn::archive::{Archive, ArchiveError};
use crate::rl::persist::Persist;

impl<N: Network> Persist for Ppo<N> {
    fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
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
