//! Whether somebody wants this process to stop.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag::register;

/// Returns a flag that signals to stop set from now on. A flag needs no thread, which a limit may refuse.
///
/// # Errors
///
/// When the signals cannot be heard.
pub(super) fn interrupted() -> io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        register(signal, Arc::clone(&flag))?;
    }
    Ok(flag)
}
