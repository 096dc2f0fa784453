//! sha256 as lower-case hexadecimal digits, of bytes and of files.

use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::files::{self, FileError};

/// Bytes that are read at a time: extracts of countries do not fit into memory twice.
const BUFFER: usize = 1 << 16;

/// Returns the sha256 of bytes.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Returns the sha256 of a file.
pub fn sha256_file(path: &Path) -> Result<String, FileError> {
    let mut file = files::open(path)?;
    let mut hasher = Sha256::new();
    let mut buffer = [0; BUFFER];
    loop {
        match file.read(&mut buffer).map_err(FileError::at("read", path))? {
            0 => return Ok(hex(&hasher.finalize())),
            count => hasher.update(&buffer[..count]),
        }
    }
}

/// Returns bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_of_a_file_is_that_of_its_bytes() {
        let bytes = vec![7; 3 * BUFFER + 1];
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        assert_eq!(sha256_file(file.path()).unwrap(), sha256(&bytes));
    }
}
