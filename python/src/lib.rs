//! The Python package's native part: the command, simulations, families and estimates.
//!
//! What Python sees is in `tsc_family/_native.pyi`; everything that needs no Rust is Python, beside it.

mod answer;
mod controller;
mod error;
mod family;
mod host;
mod lesson;
mod object;
mod observation;
mod senses;
mod signals;
mod simulation;
mod view;

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use pyo3::prelude::*;
use tsc_family::Traffic;
use tsc_family::cli::{Program, main_of};
use tsc_family::traffic::sim::libsumo::{KIND, LIBRARY, look_for};

use crate::host::PyHost;

/// The native part of `tsc_family`.
#[pymodule(gil_used = true)]
mod _native {
    #[pymodule_export]
    use super::error::Error;
    #[pymodule_export]
    use super::family::{difference, estimate, family, published, sample};
    #[pymodule_export]
    use super::host::stack_in;
    #[pymodule_export]
    use super::lesson::Lesson;
    #[pymodule_export]
    use super::observation::PyObservation;
    #[pymodule_export]
    use super::run_command;
    #[pymodule_export]
    use super::signals::{PyLane, PyLimits, PyMovement, PyPhase, PySignal};
    #[pymodule_export]
    use super::simulation::Simulation;
    #[pymodule_export]
    use super::{sumo_built_with, sumo_found};
}

/// Runs the command, once in a process, and returns its exit code. Other Python threads go on meanwhile.
///
/// `args` begins with the name of the command; `start` is how a worker's process is started: program and first
/// arguments.
#[pyfunction]
fn run_command(py: Python<'_>, args: Vec<OsString>, start: Vec<OsString>) -> u8 {
    py.detach(|| {
        let program = Program { traffic: Traffic::default(), start, host: Some(Box::new(PyHost)) };
        let code = main_of(program, args);
        // The process ends without what a program of Rust does at its end.
        let _ = std::io::stdout().flush();
        code
    })
}

/// Where libsumo came from when this was built, `eclipse-sumo` for the package, and where it was.
#[pyfunction]
fn sumo_built_with() -> (&'static str, &'static str) {
    (KIND, LIBRARY)
}

/// Says where libsumo is, or why it is nowhere and what to do.
#[pyfunction]
#[pyo3(signature = (library, missing))]
fn sumo_found(library: Option<PathBuf>, missing: Option<String>) {
    let nobody = || "nobody said where SUMO is".to_owned();
    look_for(library.ok_or_else(|| missing.unwrap_or_else(nobody)));
}
