//! sha256 as lower-case hexadecimal digits, of bytes and of files.

use std::fmt::Write;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::error::FileError;

/// Returns the sha256 of bytes.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Returns the sha256 of a file.
///
/// # Errors
///
/// [`FileError`] when it cannot be read.
pub fn sha256_file(path: &Path) -> Result<String, FileError> {
    Ok(sha256(&std::fs::read(path).map_err(FileError::at("read", path))?))
}

/// Returns bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").expect("writing to a string cannot fail");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_of_nothing_is_the_known_one() {
        assert!(sha256(b"").starts_with("e3b0c44298fc1c149afbf4c8996fb924"));
    }
}
