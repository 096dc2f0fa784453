//! Values on the command line: numbers, and names of choices that the library knows.

use std::num::{NonZeroU32, NonZeroUsize};

use clap::builder::RangedU64ValueParser;

/// Most workers or threads of a machine.
const MOST_WORKERS: usize = 1024;

/// Most samples per budget and estimator: the error of what comes of them is far below what anybody reads.
pub(super) const MOST_REPEATS: u32 = 100_000;

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

pub(super) fn from_one_to<const MOST: u32>(text: &str) -> Result<NonZeroU32, String> {
    let number = text.parse().ok().filter(|number: &NonZeroU32| number.get() <= MOST);
    number.ok_or_else(|| format!("expected a whole number from 1 to {MOST}"))
}

pub(super) fn at_least_one_worker(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|number: &NonZeroUsize| number.get() <= MOST_WORKERS);
    number.ok_or_else(|| format!("expected a whole number from 1 to {MOST_WORKERS}"))
}

/// Returns what reads a number of seconds, up to a century.
pub(super) fn at_least_a_second() -> RangedU64ValueParser {
    RangedU64ValueParser::new().range(1..=100 * 366 * 24 * 3600)
}

/// Reads an amount of memory in MB that a simulation can begin with.
pub(super) fn megabytes() -> RangedU64ValueParser {
    RangedU64ValueParser::new().range(50..=1_000_000_000)
}

/// Returns what reads a number within bounds.
pub(super) fn number(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("expected a number from {least} to {most}"))
    }
}
