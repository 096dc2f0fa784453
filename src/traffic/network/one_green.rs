//! Which networks have nothing to decide: the program that netconvert made for their signal shows one green.

use std::path::Path;

use rayon::prelude::*;

use super::index::file;
use super::intersection::IntersectionSpec;
use super::net_file::NetFile;
use super::plain::DEFAULT_PROGRAM;
use crate::files::{self, FileError, limits};

/// Returns the point MDPs with one green, by id, with the reason in words.
///
/// # Errors
///
/// If a network cannot be read.
pub fn one_green(
    folder: &Path,
    specs: &[IntersectionSpec],
) -> Result<Vec<(String, String)>, FileError> {
    let found: Result<Vec<_>, FileError> = specs
        .par_iter()
        .map(|spec| {
            let path = file(folder, &spec.point, "net.xml");
            let text = files::read_text(&path, limits::NETWORK)?;
            // What a build has checked can be parsed.
            let one = NetFile::parse(&text).is_ok_and(|net| net.has_one_green(DEFAULT_PROGRAM));
            Ok(one.then(|| (spec.point.clone(), "a single green".to_owned())))
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}
