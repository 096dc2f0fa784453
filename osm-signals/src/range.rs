//! Ranges of settings.

/// A setting that is out of its range.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{setting}: {reason}")]
pub struct OutOfRange {
    /// Its name, such as `counts.match_m`.
    pub setting: String,
    /// Its value, and what was expected.
    pub reason: String,
}

/// Checks that a setting lies within limits, both included; NaN does not.
///
/// # Errors
///
/// [`OutOfRange`] if it does not.
pub(crate) fn check(
    setting: impl Into<String>,
    value: f64,
    (low, high): (f64, f64),
) -> Result<(), OutOfRange> {
    let reason = || format!("{value}: expected a number from {low} to {high}");
    let out = || OutOfRange { setting: setting.into(), reason: reason() };
    if (low..=high).contains(&value) { Ok(()) } else { Err(out()) }
}
