//! Threads that compute: as many as a limit on processes allows.
//!
//! Left alone, the pool panics where a thread cannot be started. Here the threads are there before the pool is;
//! where not all can be had it gets half of those that can, as each may start a process of its own.

use std::sync::Mutex;
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle, available_parallelism};

use rayon::{ThreadBuilder, ThreadPoolBuilder};

use crate::machine::LIMIT;

/// Variable that gives the pool's size where no option does.
const NUMBER: &str = "RAYON_NUM_THREADS";

/// A thread that waits for what it is to do.
type Waiting = (Sender<ThreadBuilder>, JoinHandle<()>);

/// Makes the pool of threads of this process; returns what is to be said where it has fewer than were asked for.
///
/// # Arguments
///
/// * `jobs` — how many are asked for; `None` for one per processor.
///
/// # Errors
///
/// When there is a pool already.
pub(super) fn set_up(jobs: Option<usize>) -> anyhow::Result<Option<String>> {
    let usual = || {
        let named: Option<usize> = std::env::var(NUMBER).ok().and_then(|text| text.parse().ok());
        let processors = || available_parallelism().map_or(1, std::num::NonZero::get);
        named.filter(|number| *number > 0).unwrap_or_else(processors)
    };
    let asked = jobs.unwrap_or_else(usual);
    let mut waiting = waiting(asked);
    let mut fewer = None;
    if waiting.len() < asked {
        let kept = waiting.len() / 2;
        for (sender, thread) in waiting.split_off(kept) {
            drop(sender);
            // One that waits for nothing ends without a word.
            let _ = thread.join();
        }
        fewer = Some(format!("{} of {asked} threads can be used: {LIMIT}", kept.max(1)));
    }
    if waiting.is_empty() {
        ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
        return Ok(fewer);
    }
    let builder = ThreadPoolBuilder::new().num_threads(waiting.len());
    let waiting = Mutex::new(waiting);
    let hand_over = |thread: ThreadBuilder| {
        let free = waiting.lock().ok().and_then(|mut waiting| waiting.pop());
        let gone = || std::io::Error::other("a thread has gone");
        free.and_then(|(sender, _)| sender.send(thread).ok()).ok_or_else(gone)
    };
    builder.spawn_handler(hand_over).build_global()?;
    Ok(fewer)
}

/// Whether a thread more may be started.
pub(super) fn can_start() -> bool {
    thread::Builder::new().spawn(|| {}).is_ok_and(|thread| thread.join().is_ok())
}

/// Starts threads that wait, at most so many.
fn waiting(asked: usize) -> Vec<Waiting> {
    let one = || {
        let (sender, receiver) = channel::<ThreadBuilder>();
        let work = move || {
            if let Ok(thread) = receiver.recv() {
                thread.run();
            }
        };
        thread::Builder::new().spawn(work).ok().map(|thread| (sender, thread))
    };
    (0..asked).map_while(|_| one()).collect()
}
