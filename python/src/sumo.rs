//! Where SUMO is, which Python finds out.

use std::path::PathBuf;

use pyo3::prelude::*;
use tsc_family::traffic::sim::libsumo::{KIND, LIBRARY, look_for};

/// Where libsumo came from when this was built, `eclipse-sumo` for the package, and where it was.
#[pyfunction]
pub(crate) fn sumo_built_with() -> (&'static str, &'static str) {
    (KIND, LIBRARY)
}

/// Says where libsumo is, or why it is nowhere and what to do.
#[pyfunction]
#[pyo3(signature = (library, missing))]
pub(crate) fn sumo_found(library: Option<PathBuf>, missing: Option<String>) {
    let nobody = || "nobody said where SUMO is".to_owned();
    look_for(library.ok_or_else(|| missing.unwrap_or_else(nobody)));
}
