//! The exception that everything here raises, and what others say.

use std::fmt;

use pyo3::prelude::*;

/// Module that loads files.
pub(crate) const LOADER: &str = "tsc_family._host";

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

/// Returns what an exception says: of one of ours its words, of others the traceback.
pub(crate) fn explained(py: Python<'_>, error: &PyErr) -> String {
    let value = error.value(py);
    let explained = py
        .import(LOADER)
        .and_then(|module| module.call_method1("explained", (value, error.traceback(py))))
        .and_then(|text| text.extract());
    explained.unwrap_or_else(|_| error.to_string())
}
