//! How much can be compared, and what is said of more.

/// Most methods: their number has five bits beside the sum.
pub const MOST_METHODS: usize = 32;

/// Most families: a sum has ten bits more than a score.
pub const MOST_FAMILIES: usize = 1024;

/// Most distinct combinations that are looked at, about an hour on one core.
pub const MOST_COMBINATIONS: u128 = 50_000_000_000;

/// Why ranks cannot be counted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CombinationsError {
    /// More combinations than can be looked at.
    #[error(
        "{distinct} combinations, more than the {MOST_COMBINATIONS} that are looked at one by one; give fewer \
         families, or evaluate some on a sample (run --budget)"
    )]
    TooMany {
        /// How many there are.
        distinct: u128,
    },
    /// More methods or families than sums have room for.
    #[error(
        "{methods} methods of {families} families; at most {MOST_METHODS} methods and {MOST_FAMILIES} families can \
         be compared, so give fewer"
    )]
    TooWide {
        /// Number of methods.
        methods: usize,
        /// Number of families.
        families: usize,
    },
}
