//! The Python package's native part: the command, simulations, families and estimates.
//!
//! What Python sees is in `tsc_family/_native.pyi`; everything that needs no Rust is Python, beside it.

mod answer;
mod command;
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
mod sumo;
mod view;

use pyo3::prelude::*;

/// The native part of `tsc_family`.
#[pymodule(gil_used = true)]
mod _native {
    #[pymodule_export]
    use super::command::run_command;
    #[pymodule_export]
    use super::error::Error;
    #[pymodule_export]
    use super::family::{difference, estimate, family, sample};
    #[pymodule_export]
    use super::host::stack_in;
    #[pymodule_export]
    use super::lesson::Lesson;
    #[pymodule_export]
    use super::observation::PyObservation;
    #[pymodule_export]
    use super::signals::{PyLane, PyLimits, PyMovement, PyPhase, PySignal};
    #[pymodule_export]
    use super::simulation::Simulation;
    #[pymodule_export]
    use super::sumo::{sumo_built_with, sumo_found};
}
