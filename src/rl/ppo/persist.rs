//! What a learner of a policy has learned, and what it goes on from.

use super::Ppo;
use super::rollout::Rollout;
use crate::nn::Network;
use crate::nn::archive::{Archive, ArchiveError};

impl<N: Network> Ppo<N> {
    /// Network and parameters, for saving what was learned.
    pub fn learned(&self) -> (&N, &[f32]) {
        (&self.network, &self.parameters)
    }

    /// Whether parameters and moments are numbers; where they are not, training has diverged.
    pub fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }

    /// Takes over parameters that were learned elsewhere.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when they do not fit the network.
    pub fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.parameters = crate::nn::load(&self.network, prefix, archive)?;
        Ok(())
    }

    /// Adds everything that learning goes on from to an archive.
    pub fn save(&self, prefix: &str, archive: &mut Archive) {
        let name = |part: &str| format!("{prefix}{part}");
        archive.put_f32(name("parameters"), &[self.parameters.len()], &self.parameters);
        self.adam.save(prefix, archive);
        self.sampling.save(&name("sampling"), archive);
        self.shuffling.save(&name("shuffling"), archive);
        self.collected.save(prefix, self.network.inputs(), archive);
    }

    /// Goes on from what [`Self::save`] kept, which is to be done between two episodes.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when it is of another shape.
    pub fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
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
