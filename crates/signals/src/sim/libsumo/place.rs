//! Where libsumo is: where it was when this was built, unless somebody knows better.
//!
//! A Python package takes SUMO along as another package, in whatever environment both are installed.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use libsumo_sys::LIBRARY;

/// What [`look_for`] said; `None` where nobody did.
static PLACE: Mutex<Option<Result<PathBuf, String>>> = Mutex::new(None);

/// Says where libsumo is, or why it is nowhere and what to do; counts until SUMO is loaded.
pub fn look_for(library: Result<PathBuf, String>) {
    *PLACE.lock().unwrap_or_else(PoisonError::into_inner) = Some(library);
}

/// Returns where libsumo is.
/// The error is why it is nowhere, as [`look_for`] was told.
pub fn library() -> Result<PathBuf, String> {
    let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner);
    place.clone().unwrap_or_else(|| Ok(PathBuf::from(LIBRARY)))
}
