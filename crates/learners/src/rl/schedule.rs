//! How exploration falls.

/// Returns the exploration after `seen` transitions: from `start` in a straight line over `span` of them to `end`.
pub fn linear_epsilon(start: f64, end: f64, span: u64, seen: u64) -> f64 {
    if seen >= span { end } else { start + (end - start) * (seen as f64 / span as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exploration_falls_in_a_straight_line() {
        let at = |seen| linear_epsilon(1.0, 0.2, 100, seen);
        assert_eq!((at(0), at(50), at(100), at(1000)), (1.0, 0.6, 0.2, 0.2));
        assert_eq!(linear_epsilon(1.0, 0.0, 0, 0), 0.0);
    }
}
