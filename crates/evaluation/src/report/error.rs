//! Why a report could not be written.

use basics::files::FileError;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file of the report cannot be written.
    #[error(transparent)]
    Io(#[from] FileError),
    /// The page's template does not fit its data, which is a mistake in this program.
    #[error("the report's page cannot be rendered: {0}; please report this")]
    Template(String),
}
