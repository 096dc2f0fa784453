//! Why a table could not be written.

use crate::store::StoreError;
use basics::files::FileError;

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The results directory cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] FileError),
    /// The writer of Parquet files refused what it was given.
    #[error("cannot write {path}: {reason}")]
    Parquet {
        /// The file.
        path: String,
        /// Its reason.
        reason: String,
    },
}
