//! Ranks of values, with ties.

use crate::stats::Direction;

/// Returns ranks from 1; values that are equal have the mean of theirs.
pub(super) fn ranks(values: &[f64], direction: Direction) -> Vec<f64> {
    let rank = |value: &f64| {
        let better = values.iter().filter(|other| direction.is_worse(*value, **other)).count();
        let like = values.iter().filter(|other| *other == value).count();
        better as f64 + (like as f64 + 1.0) / 2.0
    };
    values.iter().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_equal_have_the_mean_of_their_ranks() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0], Direction::Lower), [3.5, 1.0, 3.5, 2.0]);
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0], Direction::Higher), [1.5, 4.0, 1.5, 3.0]);
    }
}
