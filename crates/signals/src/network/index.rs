//! `INDEX.csv`: what lies in a folder of networks, so that altered files are noticed.
//!
//! One row per network with the hash of what it was built from and of every file. A file that
//! differs from its row is an error, never silently built again or used.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::network::error::NetworkError;
use crate::network_files::{BY_HASH, FILE_ENDINGS, NetworkFiles, address, file_name};
use basics::files::{self, FileError, limits, write_atomically};
use basics::hash::sha256;

/// Name of the index within its folder.
pub const INDEX_FILE: &str = "INDEX.csv";

/// One network of the index.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexRow {
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
    /// Hash of the `.net.xml`.
    pub net_sha256: String,
    /// Hash of the `.rou.xml`.
    pub routes_sha256: String,
    /// Hash of the `.demand.json`.
    pub demand_sha256: String,
    /// Hash of the `.sumocfg`.
    pub sumocfg_sha256: String,
    /// Where the files lie, seen from the index; empty in the indices of versions that kept one network per
    /// point MDP.
    #[serde(default)]
    pub folder: String,
}

impl IndexRow {
    /// Returns the hashes by the ending of the file, in the order of [`FILE_ENDINGS`].
    fn hashes(&self) -> [&str; 4] {
        [&self.net_sha256, &self.routes_sha256, &self.demand_sha256, &self.sumocfg_sha256]
    }

    /// Returns the hashes by file name.
    pub fn sha256(&self) -> BTreeMap<String, String> {
        let named =
            |(ending, hash): (&str, &str)| (file_name(&self.point, ending), hash.to_owned());
        FILE_ENDINGS.into_iter().zip(self.hashes()).map(named).collect()
    }

    /// Returns where the files lie, seen from the index.
    pub fn place(&self) -> String {
        format!("{BY_HASH}/{}", address(&self.sha256()))
    }
}

/// The index of a folder of networks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Index {
    folder: PathBuf,
    /// By point MDP and hash of what the network was built from.
    rows: BTreeMap<(String, String), IndexRow>,
}

impl Index {
    /// Reads the index of a folder, or returns `None` if it has none.
    ///
    /// # Errors
    ///
    /// [`NetworkError::Index`] if it is malformed, [`NetworkError::Io`] if it cannot be read.
    pub fn load_if_present(folder: &Path) -> Result<Option<Self>, NetworkError> {
        let path = folder.join(INDEX_FILE);
        let bytes = files::if_present(files::read(&path, limits::DOCUMENT))?;
        bytes.map(|bytes| Self::parse(&bytes, folder)).transpose()
    }

    /// Returns the index that bytes are, of a folder.
    ///
    /// # Errors
    ///
    /// [`NetworkError::Index`] if they are none.
    pub fn parse(bytes: &[u8], folder: &Path) -> Result<Self, NetworkError> {
        let path = folder.join(INDEX_FILE);
        let wrong = |reason: String| NetworkError::Index { path: path.clone(), reason };
        let mut rows = BTreeMap::new();
        for row in csv::Reader::from_reader(bytes).deserialize() {
            let row: IndexRow = row.map_err(|e| wrong(e.to_string()))?;
            if row.folder.is_empty() {
                // Built by a version that kept its files elsewhere: it is built again.
                continue;
            }
            let point = row.point.clone();
            if row.folder != row.place() {
                return Err(wrong(format!("the row of {point} is not as it was written")));
            }
            if rows.insert(key(&point, &row.spec_sha256), row).is_some() {
                return Err(wrong(format!("a network of {point} stands twice in the table")));
            }
        }
        Ok(Self { folder: folder.to_path_buf(), rows })
    }

    /// Returns the index of a folder without networks.
    pub fn empty(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), rows: BTreeMap::new() }
    }

    /// Returns the rows, sorted by point MDP.
    pub fn rows(&self) -> impl Iterator<Item = &IndexRow> {
        self.rows.values()
    }

    /// Returns the network of a point MDP that was built from what has this hash.
    pub fn row(&self, point: &str, spec_sha256: &str) -> Option<&IndexRow> {
        self.rows.get(&key(point, spec_sha256))
    }

    /// Adds or replaces a row.
    pub fn insert(&mut self, row: IndexRow) {
        self.rows.insert(key(&row.point, &row.spec_sha256), row);
    }

    /// Keeps only some rows.
    pub fn retain(&mut self, mut keep: impl FnMut(&IndexRow) -> bool) {
        self.rows.retain(|_, row| keep(row));
    }

    /// Returns the files of a row after comparing each with its hash.
    ///
    /// # Errors
    ///
    /// [`NetworkError::Altered`] for the first file that was deleted or altered.
    pub fn verify(&self, row: &IndexRow) -> Result<NetworkFiles, NetworkError> {
        let network = NetworkFiles::new(&self.folder, &row.point, row.sha256());
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

    /// Writes the index; readers see the old one or the new one, never half of it.
    ///
    /// # Errors
    ///
    /// [`FileError`] if the folder cannot be written.
    pub fn write(&self) -> Result<(), FileError> {
        write_atomically(&self.folder.join(INDEX_FILE), &self.to_csv())
    }

    /// Returns the bytes of the table.
    pub fn to_csv(&self) -> Vec<u8> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in self.rows.values() {
            writer.serialize(row).expect("a row is plain data");
        }
        writer.into_inner().expect("memory takes every row")
    }
}

fn key(point: &str, spec_sha256: &str) -> (String, String) {
    (point.to_owned(), spec_sha256.to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A folder with the files of one network, each holding its own ending.
    fn folder() -> (tempfile::TempDir, Index) {
        let folder = tempfile::tempdir().unwrap();
        let [net_sha256, routes_sha256, demand_sha256, sumocfg_sha256] =
            FILE_ENDINGS.map(|ending| sha256(ending.as_bytes()));
        let mut row = IndexRow {
            point: "p".into(),
            spec_sha256: "s".into(),
            net_sha256,
            routes_sha256,
            demand_sha256,
            sumocfg_sha256,
            ..IndexRow::default()
        };
        row.folder = row.place();
        let files = NetworkFiles::new(folder.path(), "p", row.sha256());
        fs::create_dir_all(&files.folder).unwrap();
        for ending in FILE_ENDINGS {
            fs::write(files.folder.join(file_name("p", ending)), ending).unwrap();
        }
        let mut index = Index::empty(folder.path());
        index.insert(row);
        (folder, index)
    }

    fn verified(index: &Index) -> Result<NetworkFiles, NetworkError> {
        index.verify(index.row("p", "s").unwrap())
    }

    #[test]
    fn a_written_index_reads_back() {
        let (folder, index) = folder();
        index.write().unwrap();
        assert_eq!(Index::load_if_present(folder.path()).unwrap().unwrap(), index);
    }

    #[test]
    fn files_as_built_are_returned_with_their_hashes() {
        let (folder, index) = folder();
        let files = verified(&index).unwrap();
        assert!(files.demand.starts_with(folder.path().join("by-hash")));
        assert_eq!(files.sha256["p.sumocfg"], sha256(b"sumocfg"));
    }

    #[test]
    fn two_networks_of_a_point_mdp_stand_side_by_side() {
        let (folder, mut index) = folder();
        let mut other = index.row("p", "s").unwrap().clone();
        (other.spec_sha256, other.net_sha256) = ("t".into(), sha256(b"other"));
        other.folder = other.place();
        assert_ne!(other.folder, index.row("p", "s").unwrap().folder);
        index.insert(other);
        index.write().unwrap();
        assert_eq!(Index::load_if_present(folder.path()).unwrap().unwrap().rows().count(), 2);
        verified(&index).unwrap();
    }

    #[test]
    fn a_row_whose_hashes_are_not_those_of_its_folder_is_refused() {
        let (folder, mut index) = folder();
        let mut row = index.row("p", "s").unwrap().clone();
        row.net_sha256 = sha256(b"other");
        index.insert(row);
        index.write().unwrap();
        let e = Index::load_if_present(folder.path()).unwrap_err().to_string();
        assert!(e.contains("the row of p is not as it was written"), "{e}");
    }

    #[test]
    fn rows_of_versions_that_kept_one_network_per_point_mdp_are_passed_over() {
        let (folder, index) = folder();
        index.write().unwrap();
        let path = folder.path().join(INDEX_FILE);
        let text = fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().map(|line| line.rsplit_once(',').unwrap().0).collect();
        fs::write(&path, lines.join("\n")).unwrap();
        assert_eq!(Index::load_if_present(folder.path()).unwrap().unwrap().rows().count(), 0);
    }

    #[test]
    fn an_index_with_an_unknown_column_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(INDEX_FILE), "point,x\np,1\n").unwrap();
        let e = Index::load_if_present(folder.path()).unwrap_err().to_string();
        assert!(e.contains("INDEX.csv: ") && e.contains("unknown field `x`"), "{e}");
        assert!(e.ends_with("delete it and repeat the command, which builds the networks again"));
    }
}
