//! What is computed with the values of actions.

/// Returns the place of the largest number, the first of several.
pub(super) fn largest(values: &[f32]) -> usize {
    (1..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}

/// Returns Huber's loss of an error: half its square up to 1, a straight line beyond.
pub(super) fn huber(error: f32) -> f32 {
    let size = error.abs();
    if size <= 1.0 { 0.5 * error * error } else { size - 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_largest_numbers_is_taken() {
        assert_eq!(
            (largest(&[1.0, 3.0, 3.0]), largest(&[2.0]), largest(&[f32::NAN, 1.0])),
            (1, 0, 0)
        );
    }
}
