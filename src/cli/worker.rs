//! `tsc-family worker`: one task in a process of its own.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustix::io::fcntl_dupfd_cloexec;
use rustix::stdio::{dup2_stdout, stderr, stdout};

use super::controllers::{self, ControllersArgs};
use super::interrupt::stop;
use super::output::note;
use super::values::at_least_a_second;
use crate::cli::exit;
use crate::domains::domains;
use crate::run::checkpoint::CHECKPOINT_EVERY_S;
use crate::run::progress::{Failure, Fault, News, WorkerLine};
use crate::run::watchdog::{STALL_TIMEOUT_S, Watchdog, stalled};
use crate::run::work::Workplace;
use crate::run::worker::serve;
use crate::store::Layout;
use anyhow::Context;

/// First descriptor that the pipe may get, beyond the three standard ones.
const BEYOND_STANDARD: i32 = 3;

/// `tsc-family worker`.
#[derive(Debug, clap::Args)]
pub struct WorkerArgs {
    /// Results directory with manifest and plan
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Row of the plan
    #[arg(long, value_name = "K")]
    pub task: usize,
    /// sha256 of the manifest as the run has it: another one is damaged or exchanged
    #[arg(long, value_name = "SHA256")]
    pub manifest: Option<String>,
    /// Folder of the networks or whatever was prepared [default: the manifest's]
    #[arg(long, value_name = "DIR")]
    pub prepared: Option<PathBuf>,
    /// Which attempt at the task this is
    #[arg(long, default_value_t = 1)]
    pub attempt: u32,
    /// Time without a step of the simulation after which the task is given up
    #[arg(long, value_name = "SECONDS", default_value_t = STALL_TIMEOUT_S, value_parser = at_least_a_second())]
    pub stall_timeout: u64,
    /// Methods that are not the program's own
    #[command(flatten)]
    pub controllers: ControllersArgs,
    /// End when standard input closes
    #[arg(long)]
    pub watch_stdin: bool,
    /// Wall time between two checkpoints of a training, at least
    #[arg(long, value_name = "SECONDS", default_value_t = CHECKPOINT_EVERY_S)]
    pub checkpoint_every_s: u64,
}

pub(super) fn run(args: &WorkerArgs) -> anyhow::Result<u8> {
    if args.watch_stdin {
        end_with_parent();
    }
    let limit = Duration::from_secs(args.stall_timeout);
    let pipe = pipe().context("cannot keep standard output apart")?;
    let say = |what: &WorkerLine| tell(&pipe, what);
    let (alive, last) = (pipe.clone(), pipe.clone());
    let alive = move |steps| tell(&alive, &WorkerLine::Alive(steps));
    let watchdog = Watchdog::start(limit, alive, move |steps| {
        let mut reason = stalled(limit, steps);
        if let Some(stack) = controllers::stack() {
            reason.push_str(&format!("; just now\n{stack}"));
        }
        tell(&last, &WorkerLine::Failed(Failure { fault: Fault::Task, reason }));
        end();
    });
    // Where a limit allows no thread more, the task is done unwatched.
    let _watchdog = watchdog.inspect_err(|e| note(format!("nobody watches this task: {e}"))).ok();
    let workplace = Workplace {
        layout: Layout::new(&args.dir),
        prepared: args.prepared.clone().unwrap_or_default(),
        scratch: PathBuf::new(),
        attempt: args.attempt,
        checkpoint_every: Duration::from_secs(args.checkpoint_every_s),
        stop: stop()?,
    };
    let mut news = |news: News| match news {
        News::Episode(progress) => say(&WorkerLine::Progress(progress)),
        News::Note(text) => note(text),
    };
    match serve(&domains(), args.task, args.manifest.as_deref(), workplace, &mut news) {
        Ok(_) => {
            say(&WorkerLine::Done);
            Ok(exit::DONE)
        }
        Err(error) => {
            say(&WorkerLine::Failed(Failure::of(&error)));
            Err(error.into())
        }
    }
}

/// Ends this process when standard input closes: its parent is gone.
fn end_with_parent() {
    let watch = || {
        let mut buffer = [0; 64];
        while matches!(std::io::stdin().read(&mut buffer), Ok(n) if n > 0) {}
        end();
    };
    if std::thread::Builder::new().spawn(watch).is_err() {
        // A limit allows no thread more; then the system ends this process, where it can.
        #[cfg(target_os = "linux")]
        let _ =
            rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL));
    }
}

/// Ends this process at once: not by `exit`, which would run SUMO's destructors while the main thread simulates.
fn end() {
    let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
}

/// Takes over standard output and returns it: the pipe to the parent. What is written there from now on, by simulators and
/// methods of somebody's own, goes to standard error, which is the log. Processes that they start do not inherit the pipe.
fn pipe() -> io::Result<Arc<Mutex<File>>> {
    let pipe = fcntl_dupfd_cloexec(stdout(), BEYOND_STANDARD)?;
    dup2_stdout(stderr())?;
    Ok(Arc::new(Mutex::new(File::from(pipe))))
}

/// Says something; a parent that has gone away is noticed by its closed pipe.
fn tell(pipe: &Mutex<File>, what: &WorkerLine) {
    let line = serde_json::to_string(what).expect("plain data") + "\n";
    let mut pipe = pipe.lock().unwrap_or_else(PoisonError::into_inner);
    let _ = pipe.write_all(line.as_bytes());
}
