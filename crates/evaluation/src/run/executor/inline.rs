//! Tasks one after the other in this process: for tests, debugging, and methods that exist only here.
//!
//! A simulator that ends the process takes the run with it, and nothing is tried twice; workers are
//! safer. This executor notices an interruption only between two tasks, and never notices a task that
//! hangs.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{Event, Executor};
use crate::run::checkpoint::CHECKPOINT_EVERY_S;
use crate::run::domain::Domain;
use crate::run::error::RunError;
use crate::run::progress::{Failure, Fault, News};
use crate::run::stop::Stop;
use crate::run::work::{Workplace, do_task};
use crate::store::Layout;
use crate::store::manifest::{GIT, Manifest, Task};
use crate::store::record::Record;
use crate::store::scratch::Scratch;
use crate::store::wall::Wall;

/// Does tasks in this process.
#[derive(Clone, Copy)]
pub struct Inline<'a> {
    /// What is evaluated.
    pub domain: &'a dyn Domain,
    /// What the run is.
    pub manifest: &'a Manifest,
    /// The results directory.
    pub layout: &'a Layout,
    /// Folder of what was prepared.
    pub prepared: &'a PathBuf,
}

impl Executor for Inline<'_> {
    fn run(
        &self,
        tasks: &[Task],
        interrupted: &AtomicBool,
        on_event: &mut dyn FnMut(Event),
    ) -> Result<(), RunError> {
        for task in tasks {
            if interrupted.load(Ordering::Relaxed) {
                break;
            }
            let event = self.task(task, on_event)?;
            on_event(event);
        }
        Ok(())
    }
}

impl Inline<'_> {
    fn task(&self, task: &Task, on_event: &mut dyn FnMut(Event)) -> Result<Event, RunError> {
        let scratch = Scratch::new(self.layout, task.task)?;
        let workplace = Workplace {
            layout: self.layout.clone(),
            prepared: self.prepared.clone(),
            scratch: scratch.path().to_path_buf(),
            attempt: 1,
            checkpoint_every: Duration::from_secs(CHECKPOINT_EVERY_S),
            stop: Stop::default(),
        };
        let start = Instant::now();
        let mut news = |news| {
            if let News::Episode(progress) = news {
                on_event(Event::Progress { task: task.task, progress });
            }
        };
        let error = match do_task(self.domain, self.manifest, task, &workplace, &mut news) {
            Ok(record) => return Ok(Event::Finished(Box::new(record))),
            Err(error) => error,
        };
        let Failure { fault, reason } = Failure::of(&error);
        match fault {
            Fault::Machine | Fault::Simulator => return Err(error),
            Fault::Disturbed => return Ok(Event::Undone { task: task.task, reason }),
            Fault::Input | Fault::Task | Fault::Own => {}
        }
        let wall_s = start.elapsed().as_secs_f64();
        let wall = Wall { wall_s, attempts: 1, git: GIT.to_owned(), ..Wall::default() };
        let record = Record::failed(task, &self.manifest.sha256(), reason, wall);
        record.commit(self.layout)?;
        Ok(Event::Finished(Box::new(record)))
    }
}
