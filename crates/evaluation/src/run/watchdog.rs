//! Notices a process that stands still: no step is simulated any more, for whatever reason.
//!
//! Time is counted in naps of the watching thread, not by the clock: a process that was stopped, or a machine that
//! slept, has not stood still.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use basics::heartbeat;

/// Time without a step of the simulation after which a task is given up, seconds.
pub const STALL_TIMEOUT_S: u64 = 600;

/// Longest nap.
const NAP: Duration = Duration::from_millis(500);

/// Signs of life within the time that a process may stand still.
const SIGNS: u32 = 4;

/// Watches until it is dropped.
#[derive(Debug)]
pub struct Watchdog {
    _end: Sender<()>,
}

impl Watchdog {
    /// Starts to watch this process.
    ///
    /// # Arguments
    ///
    /// * `limit` — time that it may stand still.
    /// * `alive` — called several times within the limit while all is well, with the steps so far.
    /// * `stalled` — called once, when it has stood still; what it does decides what follows.
    ///
    /// # Errors
    ///
    /// If no thread can be started.
    pub fn start(
        limit: Duration,
        mut alive: impl FnMut(u64) + Send + 'static,
        stalled: impl FnOnce(u64) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (end, ended) = channel();
        let nap = NAP.min(limit / SIGNS);
        thread::Builder::new().name("watchdog".to_owned()).spawn(move || {
            let (mut last, mut still, mut silent) =
                (heartbeat::beats(), Duration::ZERO, Duration::ZERO);
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(nap) {
                let now = heartbeat::beats();
                still = if now == last { still + nap } else { Duration::ZERO };
                silent += nap;
                last = now;
                if still >= limit {
                    return stalled(now);
                }
                if silent >= limit / SIGNS {
                    silent = Duration::ZERO;
                    alive(now);
                }
            }
        })?;
        Ok(Self { _end: end })
    }
}

/// Returns what to say of a process that stands still.
///
/// # Arguments
///
/// * `steps` — that were simulated before.
pub fn stalled(limit: Duration, steps: u64) -> String {
    let limit = limit.as_secs_f64();
    format!(
        "nothing was simulated for {limit} s, after {steps} steps: the simulator or the method hangs; \
         --stall-timeout allows more time"
    )
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    // The pulse is the process's, and other tests simulate meanwhile: one test for all.
    #[test]
    fn what_stands_still_is_noticed_and_what_works_or_is_over_is_not() {
        let limit = Duration::from_millis(200);
        let (say, said) = channel();
        let working = Watchdog::start(limit, move |_| say.send("alive").unwrap(), |_| {}).unwrap();
        for _ in 0..40 {
            heartbeat::beat(1);
            thread::sleep(Duration::from_millis(10));
        }
        drop(working);
        assert!(said.try_iter().count() >= 2);

        let (say, said) = channel();
        let over = Watchdog::start(limit, |_| {}, move |_| say.send(()).unwrap()).unwrap();
        drop(over);
        thread::sleep(2 * limit);
        assert!(said.try_recv().is_err());

        let (say, said) = channel();
        let _dog = Watchdog::start(limit, |_| {}, move |_| say.send(()).unwrap()).unwrap();
        assert_eq!(said.recv_timeout(Duration::from_secs(20)), Ok(()));
    }
}
