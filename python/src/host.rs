//! Opens classes of controllers: Python loads the file, this makes methods of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicI32, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use rustix::process::{Signal, getpid, kill_process};
use tsc_family::Training;
use tsc_family::traffic::own::{Host, Hosted, MakeSenses, Play};

use crate::controller::PyController;
use crate::error::{LOADER, explained};
use crate::senses::{PySenses, Replaced};

/// Time that the interpreter has to write where it is.
const PATIENCE: Duration = Duration::from_millis(300);

/// What lines of a stack have that say nothing of the controller.
const OURS: [&str; 2] = ["/tsc_family/__main__.py", "<frozen runpy>"];

/// Where the interpreter writes where it is when it is asked by a signal; below 0 before it was told to.
static STACK_FILE: AtomicI32 = AtomicI32::new(-1);

#[derive(Debug)]
pub(crate) struct PyHost;

/// Says that the interpreter writes where it is into this open file when it gets USR2.
#[pyfunction]
pub(crate) fn stack_in(file: i32) {
    STACK_FILE.store(file, Ordering::Relaxed);
}

impl Host for PyHost {
    fn open(&self, source: &str) -> Result<Hosted, String> {
        Python::attach(|py| {
            let opened = py
                .import(LOADER)
                .and_then(|module| module.call_method1("open_source", (source,)))
                .map_err(|e| explained(py, &e))?;
            self.hosted(&opened).map_err(|e| explained(py, &e))
        })
    }

    /// A controller that hangs may never give back the interpreter, so that it is asked by a signal.
    fn stack(&self) -> Option<String> {
        let file = STACK_FILE.load(Ordering::Relaxed);
        if file < 0 || kill_process(getpid(), Signal::USR2).is_err() {
            return None;
        }
        thread::sleep(PATIENCE);
        let text = fs::read_to_string(format!("/proc/self/fd/{file}")).ok()?;
        let is_ours = |line: &str| OURS.iter().any(|part| line.contains(part));
        let lines: Vec<&str> = text.lines().filter(|line| !is_ours(line)).collect();
        (!lines.is_empty()).then(|| lines.join("\n").trim_end().to_owned())
    }
}

impl PyHost {
    fn hosted(&self, opened: &Bound<'_, PyAny>) -> PyResult<Hosted> {
        let learns: bool = opened.getattr("learns")?.extract()?;
        let name: String = opened.getattr("name")?.extract()?;
        let name: &'static str = name.leak();
        let class = opened.clone().unbind();
        let learner: Option<String> = opened.getattr("learner")?.extract()?;
        let has = |what: &str| opened.getattr(what)?.extract();
        let play = match learner {
            None => Play::Controller(Box::new(move |setup| {
                Box::new(PyController::new(name, &class, learns, setup))
            })),
            Some(learner) => {
                let replaced = Replaced { reward: has("rewards")?, observation: has("observes")? };
                let senses: MakeSenses =
                    Box::new(move |setup| Box::new(PySenses::new(&class, replaced, setup)));
                Play::Learner { learner, senses }
            }
        };
        Ok(Hosted {
            summary: opened.getattr("summary")?.extract()?,
            training: if learns { Training::Learned } else { Training::None },
            files: opened.getattr("files")?.extract::<BTreeMap<String, PathBuf>>()?,
            versions: opened.getattr("versions")?.extract()?,
            play,
        })
    }
}
