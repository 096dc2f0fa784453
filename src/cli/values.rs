//! Numbers on the command line.

use std::num::{NonZeroU32, NonZeroUsize};

/// Number of point MDPs: `None` is `all`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget(pub Option<usize>);

pub(super) fn parse_budget(text: &str) -> Result<Budget, String> {
    if text == "all" {
        return Ok(Budget(None));
    }
    // A budget of 0 is refused with the family's size, once that is known.
    let number = text.parse().map_err(|_| "expected a whole number or `all`".to_owned())?;
    Ok(Budget(Some(number)))
}

pub(super) fn at_least_one(text: &str) -> Result<NonZeroU32, String> {
    text.parse().map_err(|_| format!("expected a whole number from 1 to {}", u32::MAX))
}

pub(super) fn at_least_one_worker(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "expected a whole number, 1 or more".to_owned())
}

/// Reads a seed.
///
/// # Errors
///
/// What is expected.
pub(super) fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}
