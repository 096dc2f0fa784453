//! The command within Python.

use std::ffi::OsString;
use std::io::Write;

use pyo3::prelude::*;
use tsc_family::Traffic;
use tsc_family::cli::{Program, main_of};

use crate::host::PyHost;

/// Runs the command, once in a process, and returns its exit code. Other Python threads go on meanwhile.
///
/// `args` begins with the name of the command; `start` is how a worker's process is started: program and first
/// arguments.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, args: Vec<OsString>, start: Vec<OsString>) -> u8 {
    py.detach(|| {
        let program = Program { traffic: Traffic::default(), start, host: Some(Box::new(PyHost)) };
        let code = main_of(program, args);
        // The process ends without what a program of Rust does at its end.
        let _ = std::io::stdout().flush();
        code
    })
}
