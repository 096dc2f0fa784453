//! The exception that everything here raises.

use std::fmt;

use pyo3::prelude::*;

pyo3::create_exception!(
    tsc_family,
    Error,
    pyo3::exceptions::PyException,
    "What tsc-family cannot do, why, and the way out."
);

/// Returns the exception with an error's words.
pub(crate) fn raised(error: impl fmt::Display) -> PyErr {
    Error::new_err(error.to_string())
}
