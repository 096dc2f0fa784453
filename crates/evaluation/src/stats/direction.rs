//! Which of two values is better.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

/// Whether less or more of an objective is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Less is better, as of delays.
    #[default]
    Lower,
    /// More is better, as of returns.
    Higher,
}

impl Direction {
    /// Whether less is better.
    pub fn is_lower(&self) -> bool {
        *self == Self::Lower
    }

    /// Orders values, better ones first.
    pub fn compare(self, a: f64, b: f64) -> Ordering {
        match self {
            Self::Lower => a.total_cmp(&b),
            Self::Higher => b.total_cmp(&a),
        }
    }

    /// Whether one value is worse than another.
    pub fn is_worse(self, value: f64, than: f64) -> bool {
        self.compare(value, than) == Ordering::Greater
    }

    /// Returns the best of some values; `None` of none.
    pub fn best(self, values: impl IntoIterator<Item = f64>) -> Option<f64> {
        values.into_iter().min_by(|a, b| self.compare(*a, *b))
    }

    /// Returns the worst of some values; `None` of none.
    pub fn worst(self, values: impl IntoIterator<Item = f64>) -> Option<f64> {
        values.into_iter().max_by(|a, b| self.compare(*a, *b))
    }

    /// Returns by how much a value is ahead of another; negative when it is behind.
    pub fn ahead(self, value: f64, other: f64) -> f64 {
        match self {
            Self::Lower => other - value,
            Self::Higher => value - other,
        }
    }

    /// Returns `lower` or `higher`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Higher => "higher",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn better_values_come_first() {
        let sorted = |direction: Direction| {
            let mut values = [2.0, 1.0, 3.0];
            values.sort_by(|a, b| direction.compare(*a, *b));
            values
        };
        assert_eq!(sorted(Direction::Lower), [1.0, 2.0, 3.0]);
        assert_eq!(sorted(Direction::Higher), [3.0, 2.0, 1.0]);
    }
}
