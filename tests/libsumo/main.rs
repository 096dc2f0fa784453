//! SUMO within this process: what is seen and set, and what it really shows. One simulation at a time.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::sync::{Mutex, MutexGuard, PoisonError};

mod episodes;
mod errors;
mod fixture;
mod left_hand;
mod observe;
mod programs;
mod shown;
mod shown_states;
mod trace;

/// Waits until no other test simulates.
fn alone() -> MutexGuard<'static, ()> {
    static SIMULATION: Mutex<()> = Mutex::new(());
    SIMULATION.lock().unwrap_or_else(PoisonError::into_inner)
}
