//! Ranges of numbers.

use super::setting::Section;
use crate::family::error::FamilyError;

/// Checks that a number lies within limits, both included; NaN does not.
pub fn within(value: f64, low: f64, high: f64) -> Result<(), String> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(format!("expected a number from {low} to {high}"))
}

/// Checks all numbers of sections, which are given by name.
///
/// # Errors
///
/// [`FamilyError::Setting`] for the first number that is out of its range, in a scenario of this file.
pub fn all_within(
    file: &str,
    sections: &[(&'static str, &dyn Section)],
) -> Result<(), FamilyError> {
    for (name, section) in sections {
        for number in section.ranges() {
            within(number.value, number.low, number.high).map_err(|expected| {
                let field = format!("{name}.{}", number.name);
                FamilyError::setting(file, field, shortest(number.value), expected)
            })?;
        }
    }
    Ok(())
}

/// Returns a number as it was written, also one that was read in single precision.
pub fn shortest(value: f64) -> String {
    let single = value as f32;
    if f64::from(single) == value { single.to_string() } else { value.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_none_lies_nowhere() {
        assert!(within(f64::NAN, 0.0, 1.0).is_err());
        assert!(within(1.0, 0.0, 1.0).is_ok());
    }

    #[test]
    fn numbers_are_shown_as_they_were_written() {
        assert_eq!([shortest(f64::from(2.1f32)), shortest(86_400.001)], ["2.1", "86400.001"]);
    }
}
