//! Which networks have nothing to decide: the program that netconvert made for their signal shows one green.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::plain::DEFAULT_PROGRAM;
use crate::network_files::NetworkFiles;
use crate::sim::net_file::NetFile;
use basics::files::{self, FileError, limits};

/// Returns the point MDPs with one green, by id, with the reason in words.
///
/// # Errors
///
/// If a network cannot be read.
pub fn one_green(
    networks: &BTreeMap<String, NetworkFiles>,
) -> Result<Vec<(String, String)>, FileError> {
    let found: Result<Vec<_>, FileError> = networks
        .par_iter()
        .map(|(point, network)| {
            let text = files::read_text(&network.net, limits::NETWORK)?;
            // What a build has checked can be parsed.
            let one = NetFile::parse(&text).is_ok_and(|net| net.has_one_green(DEFAULT_PROGRAM));
            Ok(one.then(|| (point.clone(), "a single green".to_owned())))
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}
