//! What counts as a failure of a controller at an intersection.

/// Mean waiting per vehicle above which a controller fails at an intersection, seconds.
///
/// Source: Jayawardana et al. (NeurIPS 2022), appendix, "Further experiments on approximation algorithms".
pub const FAILED_WAITING_S: f64 = 20.0;
