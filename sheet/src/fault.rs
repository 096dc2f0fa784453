//! What is wrong with a table.

/// What is wrong at a line of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Line of the file, from 1.
    pub line: u64,
    /// What is wrong and the way out.
    pub message: String,
}

impl Fault {
    /// Returns a fault.
    pub fn new(line: u64, message: impl Into<String>) -> Self {
        Self { line, message: message.into() }
    }
}
