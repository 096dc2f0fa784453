//! What networks a folder has: beside the files of each, `network.json` says what it was built from.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::network::error::NetworkError;
use crate::network_files::{BY_HASH, NetworkFiles, address};
use basics::files::{self, FileError, limits};
use basics::hash::sha256;

/// Name of the file that says what a network was built from.
pub const BUILT_FILE: &str = "network.json";

/// A network that was built.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Built {
    /// Id of the point MDP.
    pub point: String,
    /// Version of the netconvert that built it.
    pub netconvert: String,
    /// Arms of the intersection.
    pub arms: usize,
    /// Links of the signal.
    pub links: usize,
    /// Green phases to choose from.
    pub phases: usize,
    /// Hash of intersection and settings.
    pub spec_sha256: String,
    /// Hash of each file by its name.
    pub sha256: BTreeMap<String, String>,
}

impl Built {
    /// Returns the networks of a folder, without those whose `network.json` is damaged: they are built again.
    ///
    /// # Errors
    ///
    /// [`FileError`] if the folder cannot be read.
    pub fn all(networks: &Path) -> Result<Vec<Self>, FileError> {
        let folder = networks.join(BY_HASH);
        let entries = match std::fs::read_dir(&folder) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(FileError::at("read", &folder))?,
        };
        let mut all = Vec::new();
        for entry in entries {
            let entry = entry.map_err(FileError::at("read", &folder))?;
            let bytes = files::read(&entry.path().join(BUILT_FILE), limits::DOCUMENT);
            let built = bytes.ok().and_then(|bytes| serde_json::from_slice::<Self>(&bytes).ok());
            let is_own = |built: &Self| *address(&built.sha256) == *entry.file_name();
            all.extend(built.filter(is_own));
        }
        Ok(all)
    }

    /// Returns its files after comparing each with its hash.
    ///
    /// # Errors
    ///
    /// [`NetworkError::Altered`] for the first file that was deleted or altered.
    pub fn verify(&self, networks: &Path) -> Result<NetworkFiles, NetworkError> {
        let network = NetworkFiles::new(networks, &self.point, self.sha256.clone());
        for (name, expected) in &network.sha256 {
            let path = network.folder.join(name);
            let bytes = files::if_present(files::read(&path, limits::NETWORK))?;
            let Some(bytes) = bytes else {
                return Err(NetworkError::Altered { path, what: "was deleted" });
            };
            if sha256(&bytes) != *expected {
                return Err(NetworkError::Altered { path, what: "was altered" });
            }
        }
        Ok(network)
    }

    /// Returns the text of its file.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("hashes are plain data") + "\n"
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_network_is_listed_unless_what_says_so_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let built = Built {
            point: "p".into(),
            netconvert: "1".into(),
            arms: 4,
            links: 12,
            phases: 4,
            spec_sha256: "s".into(),
            sha256: [("p.net.xml".to_owned(), sha256(b"net"))].into(),
        };
        assert_eq!(Built::all(folder.path()).unwrap(), []);
        let files = NetworkFiles::new(folder.path(), "p", built.sha256.clone());
        fs::create_dir_all(&files.folder).unwrap();
        fs::write(files.folder.join("p.net.xml"), "net").unwrap();
        let path = files.folder.join(BUILT_FILE);
        fs::write(&path, built.to_json()).unwrap();
        assert_eq!(Built::all(folder.path()).unwrap(), std::slice::from_ref(&built));
        assert_eq!(built.verify(folder.path()).unwrap(), files);
        fs::write(&path, built.to_json().replace("p.net", "q.net")).unwrap();
        assert_eq!(Built::all(folder.path()).unwrap(), []);
        fs::write(&path, "{").unwrap();
        assert_eq!(Built::all(folder.path()).unwrap(), []);
    }
}
