//! A request that makes no sense.

/// A request that makes no sense, with the reason and the way out.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);
