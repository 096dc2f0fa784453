//! Ranges of settings.

/// A setting that is out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{setting}: {}", self.reason())]
pub struct OutOfRange {
    /// Its name, such as `counts.match_m`.
    pub setting: String,
    /// Its value.
    pub value: f64,
    /// Least value that it may have.
    pub low: f64,
    /// Greatest value that it may have.
    pub high: f64,
}

impl OutOfRange {
    /// Returns the value and what was expected.
    pub fn reason(&self) -> String {
        format!("{}: expected a number from {} to {}", self.value, self.low, self.high)
    }

    /// Returns the same of a setting within a section.
    #[must_use]
    pub(crate) fn within(self, section: &str) -> Self {
        Self { setting: format!("{section}.{}", self.setting), ..self }
    }
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
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(OutOfRange { setting: setting.into(), value, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_out_of_range_is_named_with_its_range() {
        let e = check("match_m", f64::NAN, (1.0, 90.0)).unwrap_err().within("counts");
        assert_eq!(e.to_string(), "counts.match_m: NaN: expected a number from 1 to 90");
        assert_eq!(check("match_m", 90.0, (1.0, 90.0)), Ok(()));
    }
}
