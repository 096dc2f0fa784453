//! `INDEX.csv`: what lies in a folder of networks, so that altered files are noticed.
//!
//! One row per point MDP with the hash of what it was built from and of every file. A file that
//! differs from its row is an error, never silently built again or used.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::{self, FileError, limits, write_atomically};
use crate::hash::sha256;
use crate::traffic::network::error::NetworkError;

/// Name of the index within its folder.
pub const INDEX_FILE: &str = "INDEX.csv";

/// One point MDP of the index.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexRow {
    /// Id of the point MDP, which is also the name of its folder.
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
}

impl IndexRow {
    /// Returns the hashes by the ending of the file, in the order of [`FILE_ENDINGS`].
    fn hashes(&self) -> [&str; 4] {
        [&self.net_sha256, &self.routes_sha256, &self.demand_sha256, &self.sumocfg_sha256]
    }
}

/// Endings of a point MDP's files; each is called after the point MDP.
pub const FILE_ENDINGS: [&str; 4] = ["net.xml", "rou.xml", "demand.json", "sumocfg"];

/// The files of a point MDP, known to be as built.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkFiles {
    /// SUMO's road network with both signal programs.
    pub net: PathBuf,
    /// Vehicles of seed 0, for plain `sumo` and `sumo-gui`.
    pub routes: PathBuf,
    /// Demand from which the vehicles of any seed are drawn.
    pub demand: PathBuf,
    /// Configuration for plain `sumo` and `sumo-gui`.
    pub sumocfg: PathBuf,
    /// Hash of each by file name.
    pub sha256: BTreeMap<String, String>,
}

/// The index of a folder of networks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Index {
    folder: PathBuf,
    rows: BTreeMap<String, IndexRow>,
}

impl Index {
    /// Reads the index of a folder.
    ///
    /// # Errors
    ///
    /// [`NetworkError::Index`] if it is missing or malformed, [`NetworkError::Io`] if it cannot be
    /// read.
    pub fn load(folder: &Path) -> Result<Self, NetworkError> {
        Self::load_if_present(folder)?.ok_or_else(|| NetworkError::Index {
            path: folder.join(INDEX_FILE),
            reason: "does not exist".to_owned(),
        })
    }

    /// Reads the index of a folder, or returns `None` if it has none.
    ///
    /// # Errors
    ///
    /// As [`Self::load`].
    pub fn load_if_present(folder: &Path) -> Result<Option<Self>, NetworkError> {
        let path = folder.join(INDEX_FILE);
        let bytes = files::if_present(files::read(&path, limits::DOCUMENT))?;
        let Some(bytes) = bytes else { return Ok(None) };
        let wrong = |reason: String| NetworkError::Index { path: path.clone(), reason };
        let mut rows = BTreeMap::new();
        for row in csv::Reader::from_reader(bytes.as_slice()).deserialize() {
            let row: IndexRow = row.map_err(|e| wrong(e.to_string()))?;
            let point = row.point.clone();
            if rows.insert(point.clone(), row).is_some() {
                return Err(wrong(format!("point {point} stands twice in the table")));
            }
        }
        Ok(Some(Self { folder: folder.to_path_buf(), rows }))
    }

    /// Returns the index of a folder without networks.
    pub fn empty(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), rows: BTreeMap::new() }
    }

    /// Returns the rows, sorted by point MDP.
    pub fn rows(&self) -> impl Iterator<Item = &IndexRow> {
        self.rows.values()
    }

    /// Returns the row of a point MDP.
    pub fn row(&self, point: &str) -> Option<&IndexRow> {
        self.rows.get(point)
    }

    /// Adds or replaces a row.
    pub fn insert(&mut self, row: IndexRow) {
        self.rows.insert(row.point.clone(), row);
    }

    /// Removes the row of a point MDP and returns whether there was one.
    pub fn remove(&mut self, point: &str) -> bool {
        self.rows.remove(point).is_some()
    }

    /// Returns the files of a point MDP after comparing each with its hash.
    ///
    /// # Errors
    ///
    /// [`NetworkError::Altered`] for the first file that was deleted or altered,
    /// [`NetworkError::Index`] if the point MDP is not listed.
    pub fn verify(&self, point: &str) -> Result<NetworkFiles, NetworkError> {
        let row = self.row(point).ok_or_else(|| NetworkError::Index {
            path: self.folder.join(INDEX_FILE),
            reason: format!("point {point} is not listed"),
        })?;
        let mut hashes = BTreeMap::new();
        for (ending, expected) in FILE_ENDINGS.into_iter().zip(row.hashes()) {
            let path = file(&self.folder, point, ending);
            let bytes = files::if_present(files::read(&path, limits::NETWORK))?;
            let Some(bytes) = bytes else {
                return Err(NetworkError::Altered { path, what: "was deleted" });
            };
            if sha256(&bytes) != expected {
                return Err(NetworkError::Altered { path, what: "was altered" });
            }
            hashes.insert(file_name(point, ending), expected.to_owned());
        }
        let [net, routes, demand, sumocfg] =
            FILE_ENDINGS.map(|ending| file(&self.folder, point, ending));
        Ok(NetworkFiles { net, routes, demand, sumocfg, sha256: hashes })
    }

    /// Writes the index; readers see the old one or the new one, never half of it.
    ///
    /// # Errors
    ///
    /// [`FileError`] if the folder cannot be written.
    pub fn write(&self) -> Result<(), FileError> {
        let path = self.folder.join(INDEX_FILE);
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in self.rows.values() {
            writer.serialize(row).expect("a row is plain data");
        }
        let table = writer.into_inner().expect("memory takes every row");
        write_atomically(&path, &table)
    }
}

/// Returns the path of one of a point MDP's files.
pub fn file(folder: &Path, point: &str, ending: &str) -> PathBuf {
    folder.join(point).join(file_name(point, ending))
}

/// Returns the name of one of a point MDP's files.
pub fn file_name(point: &str, ending: &str) -> String {
    format!("{point}.{ending}")
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A folder with the files of one point MDP, each holding its own ending.
    fn folder() -> (tempfile::TempDir, Index) {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("p")).unwrap();
        for ending in FILE_ENDINGS {
            fs::write(file(folder.path(), "p", ending), ending).unwrap();
        }
        let [net_sha256, routes_sha256, demand_sha256, sumocfg_sha256] =
            FILE_ENDINGS.map(|ending| sha256(ending.as_bytes()));
        let mut index = Index::empty(folder.path());
        index.insert(IndexRow {
            point: "p".into(),
            netconvert: "1.15.0".into(),
            arms: 4,
            links: 12,
            phases: 8,
            spec_sha256: "s".into(),
            net_sha256,
            routes_sha256,
            demand_sha256,
            sumocfg_sha256,
        });
        (folder, index)
    }

    #[test]
    fn a_written_index_reads_back() {
        let (folder, index) = folder();
        index.write().unwrap();
        assert_eq!(Index::load(folder.path()).unwrap(), index);
    }

    #[test]
    fn files_as_built_are_returned_with_their_hashes() {
        let (folder, index) = folder();
        let files = index.verify("p").unwrap();
        assert_eq!(files.demand, folder.path().join("p/p.demand.json"));
        assert_eq!(files.sha256["p.sumocfg"], sha256(b"sumocfg"));
    }

    #[test]
    fn an_altered_file_is_named() {
        let (folder, index) = folder();
        fs::write(file(folder.path(), "p", "sumocfg"), "other").unwrap();
        let e = index.verify("p").unwrap_err();
        assert!(
            matches!(&e, NetworkError::Altered { path, what: "was altered" }
            if path.ends_with("p/p.sumocfg")),
            "{e}"
        );
    }

    #[test]
    fn a_deleted_file_is_named() {
        let (folder, index) = folder();
        fs::remove_file(file(folder.path(), "p", "net.xml")).unwrap();
        let e = index.verify("p").unwrap_err();
        assert!(matches!(e, NetworkError::Altered { what: "was deleted", .. }), "{e}");
    }

    #[test]
    fn a_point_that_is_not_listed_is_an_error() {
        assert!(folder().1.verify("q").unwrap_err().to_string().contains("point q is not listed"));
    }

    #[test]
    fn a_missing_index_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let e = Index::load(folder.path()).unwrap_err().to_string();
        assert!(e.ends_with(
            "INDEX.csv: does not exist; repeat the `build-networks` command with --force"
        ));
    }

    #[test]
    fn an_index_with_an_unknown_column_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(INDEX_FILE), "point,x\np,1\n").unwrap();
        assert!(matches!(Index::load(folder.path()), Err(NetworkError::Index { .. })));
    }
}
