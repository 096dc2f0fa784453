//! What counts as a failure of a controller at an intersection.

use evaluation::stats::{Limit, Side};

/// Mean waiting per vehicle above which a controller fails at an intersection, seconds.
///
/// Source: Jayawardana et al. (NeurIPS 2022), appendix, "Further experiments on approximation algorithms".
const FAILED_WAITING_S: f64 = 20.0;

/// Returns what counts as a failure.
pub fn failure() -> Limit {
    Limit { metric: "waiting_s".to_owned(), side: Side::Above, value: FAILED_WAITING_S }
}
