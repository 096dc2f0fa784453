//! Why results cannot be analysed as asked.

/// Why results cannot be analysed as asked, with the way out.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct AnalysisError(pub(super) String);
