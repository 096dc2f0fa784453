//! Where the files of a generated network lie: in a folder named by the hash of what is in it, which is
//! never written again. Networks of one point MDP that were made with different settings lie side by side,
//! and a manifest, which has the hashes, says which of them is meant.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use basics::hash::sha256;

/// Environment of a point MDP whose network lies in the folder of networks.
pub const GENERATED: &str = "network";

/// Folder of the networks' folders.
pub const BY_HASH: &str = "by-hash";

/// Start of the name of folders in which networks are made, beside that one.
pub const TEMPORARY: &str = ".building-";

/// Endings of a point MDP's files; each is called after the point MDP.
pub const FILE_ENDINGS: [&str; 4] = ["net.xml", "rou.xml", "demand.json", "sumocfg"];

/// Digits in the name of a network's folder.
const DIGITS: usize = 16;

/// The files of a point MDP's network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkFiles {
    /// The folder that they lie in.
    pub folder: PathBuf,
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

impl NetworkFiles {
    /// Returns where files with these hashes lie, whether or not they are there.
    /// * `networks` — the folder of networks.
    /// * `sha256` — by file name, as manifests have it.
    pub fn new(networks: &Path, point: &str, sha256: BTreeMap<String, String>) -> Self {
        let folder = networks.join(BY_HASH).join(address(&sha256));
        let [net, routes, demand, sumocfg] =
            FILE_ENDINGS.map(|ending| folder.join(file_name(point, ending)));
        Self { folder, net, routes, demand, sumocfg, sha256 }
    }
}

/// Returns the name of the folder of files with these hashes.
pub fn address(sha256_of: &BTreeMap<String, String>) -> String {
    let lines: Vec<String> =
        sha256_of.iter().map(|(name, hash)| format!("{hash}  {name}\n")).collect();
    let mut address = sha256(lines.concat().as_bytes());
    address.truncate(DIGITS);
    address
}

/// Returns the name of one of a point MDP's files.
pub fn file_name(point: &str, ending: &str) -> String {
    format!("{point}.{ending}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_follows_from_names_and_hashes() {
        let of = |pairs: [(&str, &str); 2]| {
            address(&pairs.map(|(name, hash)| (name.to_owned(), hash.to_owned())).into())
        };
        let one = of([("p.net.xml", "aa"), ("p.rou.xml", "bb")]);
        assert_eq!(one, of([("p.rou.xml", "bb"), ("p.net.xml", "aa")]));
        assert_ne!(one, of([("p.net.xml", "bb"), ("p.rou.xml", "aa")]));
        assert_ne!(one, of([("q.net.xml", "aa"), ("p.rou.xml", "bb")]));
        assert_eq!(one.len(), DIGITS);
    }
}
