//! Carts and poles: dynamics and training.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod dynamics;
mod training;
