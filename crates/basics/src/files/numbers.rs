//! Numbers that somebody else gives: what is finite and too large makes infinite whatever is computed of it.

/// Largest number, positive or negative: sums of squares of as many as fit into memory are finite.
pub const LARGEST: f64 = 1e100;

/// Checks numbers that have names.
/// The error is the first that is larger, and what was expected.
pub fn check_all<'a>(
    numbers: impl IntoIterator<Item = (&'a String, &'a f64)>,
) -> Result<(), String> {
    let beyond = numbers.into_iter().find(|(_, number)| !is_usable(**number));
    beyond.map_or(Ok(()), |(name, number)| {
        Err(format!("{name} = {number:e}: expected a number from -1e100 to 1e100"))
    })
}

/// Returns whether a number can be computed with.
pub fn is_usable(number: f64) -> bool {
    number.abs() <= LARGEST
}
