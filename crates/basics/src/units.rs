//! Conversions between the units at the boundaries; names of values carry their unit.

/// Metres per second in one mile per hour (exact: 1609.344 m / 3600 s).
pub const MPS_PER_MPH: f64 = 0.447_04;

/// Miles per hour in one kilometre per hour, as messages say it.
pub const KMH_TO_MPH: f64 = 0.621_371;

/// Metres in one foot (exact).
pub const FOOT_M: f64 = 0.3048;

/// Seconds per hour.
pub const SECONDS_PER_HOUR: f64 = 3600.0;

/// Returns a speed in metres per second.
pub fn mph_to_mps(speed_mph: f64) -> f64 {
    speed_mph * MPS_PER_MPH
}
