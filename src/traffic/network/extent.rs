//! How many vehicles a file of demand may ask for: one of a stranger is refused before they are drawn.

use std::io::{Error, ErrorKind};
use std::path::Path;

use crate::files::FileError;
use crate::units::SECONDS_PER_HOUR;

/// Most vehicles of an episode on average: what the settings allow on the largest intersection, and far more than
/// fit on its roads.
const MOST_VEHICLES: f64 = 5e7;

/// Longest episode, seconds.
const LONGEST_S: f64 = 86_400.0;

/// Checks of a file how long an episode is and how many vehicles arrive, per hour and stream.
///
/// # Errors
///
/// [`FileError`] with how many they are, and how many are taken.
pub(super) fn check_extent(
    path: &Path,
    horizon_s: f64,
    inflows_vph: impl Iterator<Item = f64>,
) -> Result<(), FileError> {
    let vehicles = inflows_vph.map(|q| q.max(0.0)).sum::<f64>() * horizon_s / SECONDS_PER_HOUR;
    if (0.0..=LONGEST_S).contains(&horizon_s) && vehicles <= MOST_VEHICLES {
        return Ok(());
    }
    let reason = format!(
        "{vehicles:e} vehicles within {horizon_s:e} s: expected at most {MOST_VEHICLES} within at most {LONGEST_S} s"
    );
    Err(FileError::at("use", path)(Error::new(ErrorKind::InvalidInput, reason)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_vehicles_than_anybody_simulates_are_refused() {
        check_extent(Path::new("d"), 86_400.0, [50_000.0; 4].into_iter()).unwrap();
        for (horizon_s, inflow_vph) in
            [(3600.0, 1e308), (1e308, 1.0), (-1.0, 1.0), (3600.0, f64::NAN)]
        {
            let result = check_extent(Path::new("d"), horizon_s, [inflow_vph, 1e308].into_iter());
            assert!(
                result
                    .unwrap_err()
                    .to_string()
                    .contains("expected at most 50000000 within at most 86400 s")
            );
        }
    }
}
