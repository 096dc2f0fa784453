//! Ranges of numbers.

/// Checks that a number lies within limits, both included; NaN does not.
///
/// # Errors
///
/// What was expected, to be put behind the number's name and value.
pub fn within(value: f64, low: f64, high: f64) -> Result<(), String> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(format!("expected a number from {low} to {high}"))
}
