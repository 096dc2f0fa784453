//! An object of a class in Python, and calls of its methods.

use std::path::PathBuf;

use pyo3::prelude::*;
use rustix::process::{Pid, Signal, getpid, kill_process};
use tsc_family::traffic::control::Setup;

use crate::error::explained;

/// An object of a class, or why there is none: one that cannot be made says so when it is called.
pub(crate) struct Object {
    made: Result<Py<PyAny>, String>,
    guard: Guard,
}

impl Object {
    pub(crate) fn new(class: &Py<PyAny>, setup: &Setup) -> Self {
        let guard = Guard::new();
        let made = Python::attach(|py| {
            let made = class.bind(py).call_method1("create", (setup.seed,));
            guard.check("__init__")?;
            made.map(Bound::unbind).map_err(|e| explained(py, &e))
        });
        Self { made, guard }
    }

    pub(crate) fn get(&self) -> Result<&Py<PyAny>, String> {
        self.made.as_ref().map_err(Clone::clone)
    }

    /// Calls the object, and looks around afterwards.
    /// The error is why there is none, or what it raised, with the traceback.
    pub(crate) fn call<T>(
        &self,
        method: &str,
        call: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, String> {
        let object = self.get()?;
        Python::attach(|py| {
            let result = call(object.bind(py));
            self.guard.check(method)?;
            result.map_err(|e| explained(py, &e))
        })
    }
}

/// Notices what a class's code did to its process.
#[derive(Debug)]
pub(crate) struct Guard {
    pid: Pid,
    /// The working folder; `None` where it cannot be told.
    folder: Option<PathBuf>,
}

impl Guard {
    pub(crate) fn new() -> Self {
        Self { pid: getpid(), folder: std::env::current_dir().ok() }
    }

    /// Ends a process that the code was forked into: it would answer for this one.
    /// The error is that the working folder is another one, where the run would not find its files.
    pub(crate) fn check(&self, method: &str) -> Result<(), String> {
        if getpid() != self.pid {
            let _ = kill_process(getpid(), Signal::KILL);
        }
        if self.folder.is_none() || std::env::current_dir().ok() == self.folder {
            return Ok(());
        }
        Err(format!(
            "{method}() changed the working folder, so that the run would not find its files; use paths that begin at \
             os.path.dirname(os.path.abspath(__file__)), or change back within {method}()"
        ))
    }
}
