//! An object of a class in Python, and calls of its methods.

use pyo3::prelude::*;
use tsc_family::traffic::control::Setup;

use crate::error::explained;
use crate::fork::Guard;

/// An object of a class, or why there is none: one that cannot be made says so when it is called.
pub(crate) struct Object {
    made: Result<Py<PyAny>, String>,
    guard: Option<Guard>,
}

impl Object {
    /// Makes an object of a class.
    pub(crate) fn new(class: &Py<PyAny>, setup: &Setup) -> Self {
        let guard = Guard::new().map_err(|e| format!("no file for temporary data: {e}"));
        let made = guard.as_ref().map_err(Clone::clone).and_then(|guard| {
            Python::attach(|py| {
                let made = class.bind(py).call_method1("create", (setup.seed,));
                guard.check("__init__")?;
                made.map(Bound::unbind).map_err(|e| explained(py, &e))
            })
        });
        Self { made, guard: guard.ok() }
    }

    /// Returns the object.
    ///
    /// # Errors
    ///
    /// Why there is none.
    pub(crate) fn get(&self) -> Result<&Py<PyAny>, String> {
        self.made.as_ref().map_err(Clone::clone)
    }

    /// Calls the object, and looks around afterwards.
    ///
    /// # Arguments
    ///
    /// * `method` — what of it is called, for messages.
    ///
    /// # Errors
    ///
    /// Why there is none, or what it raised, with the traceback.
    pub(crate) fn call<T>(
        &self,
        method: &str,
        call: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, String> {
        let object = self.get()?;
        Python::attach(|py| {
            let result = call(object.bind(py));
            if let Some(guard) = &self.guard {
                guard.check(method)?;
            }
            result.map_err(|e| explained(py, &e))
        })
    }
}
