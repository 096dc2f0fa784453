//! Conversions between the units at the boundaries; names of values carry their unit.

/// Metres per second in one mile per hour (exact: 1609.344 m / 3600 s).
pub const MPS_PER_MPH: f64 = 0.447_04;

/// Seconds per hour.
pub const SECONDS_PER_HOUR: f64 = 3600.0;

/// Returns a speed in metres per second.
pub fn mph_to_mps(speed_mph: f64) -> f64 {
    speed_mph * MPS_PER_MPH
}
