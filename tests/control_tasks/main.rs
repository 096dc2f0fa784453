//! Control tasks: dynamics against gymnasium's, step by step (`scripts/control_steps.py` writes the tables), and trainings.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../common/nightly.rs"]
mod nightly;
mod steps;
mod training;
