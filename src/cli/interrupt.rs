//! Whether somebody wants this process to stop.
//!
//! INT, TERM and HUP come from people and systems; TERM also when a batch system takes a machine back, USR1 when it
//! was asked to warn of a limit of time. With `nohup`, HUP says nothing.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag::{register, register_conditional_default};

use crate::machine::ignores;
use crate::run::stop::Stop;

/// Signals that ask to stop.
const SIGNALS: [i32; 4] = [SIGHUP, SIGINT, SIGTERM, SIGUSR1];

/// Returns the signals that ask this process to stop.
fn signals() -> impl Iterator<Item = i32> {
    SIGNALS.into_iter().filter(|signal| *signal != SIGHUP || !ignores(SIGHUP))
}

/// Returns a flag that signals to stop set from now on. A flag needs no thread, which a limit may refuse.
pub(super) fn interrupted() -> io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in signals() {
        register(signal, Arc::clone(&flag))?;
    }
    Ok(flag)
}

/// Returns what says from now on whether signals ask a task to stop. They end the process while there is nothing that
/// it would keep.
pub(super) fn stop() -> io::Result<Stop> {
    let stop = Stop::default();
    for signal in signals() {
        register_conditional_default(signal, stop.at_once())?;
        register(signal, stop.asked())?;
    }
    Ok(stop)
}
