//! What a learner leaves behind and goes on from, whatever its algorithm.

use crate::nn::archive::{Archive, ArchiveError};

/// A learner whose state can be kept; names in archives begin with a prefix, so that several fit into one.
pub trait Persist {
    /// Whether parameters and moments are numbers; where they are not, training has diverged.
    fn is_finite(&self) -> bool;

    /// Adds what was learned.
    fn learned(&self, prefix: &str, archive: &mut Archive);

    /// Takes over what [`Self::learned`] added, also in another learner.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when it does not fit the network.
    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;

    /// Adds everything that learning goes on from.
    fn save(&self, prefix: &str, archive: &mut Archive);

    /// Goes on from what [`Self::save`] added, which is to be done between two episodes.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when it is of another shape.
    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;
}
