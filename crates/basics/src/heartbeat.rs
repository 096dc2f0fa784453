//! How far this process is with what it simulates: a process has one simulation, so that it has one pulse.

use std::sync::atomic::{AtomicU64, Ordering};

static BEATS: AtomicU64 = AtomicU64::new(0);

/// Notes that the simulation, or what prepares one, has gone on by so many steps.
pub fn beat(steps: u32) {
    BEATS.fetch_add(steps.into(), Ordering::Relaxed);
}

/// Returns the steps so far.
pub fn beats() -> u64 {
    BEATS.load(Ordering::Relaxed)
}
