//! Conversions between the units at the boundaries; names of values carry their unit.

/// Metres per second in one mile per hour (exact: 1609.344 m / 3600 s).
pub const MPS_PER_MPH: f64 = 0.447_04;

/// Seconds per hour.
pub const SECONDS_PER_HOUR: f64 = 3600.0;

/// Returns a speed in metres per second.
pub fn mph_to_mps(speed_mph: f64) -> f64 {
    speed_mph * MPS_PER_MPH
}

/// Kilometres in a mile (exact).
const KM_PER_MILE: f64 = 1.609_344;

/// Kilometres in a nautical mile (exact).
const KM_PER_NAUTICAL_MILE: f64 = 1.852;

/// Returns a speed in miles per hour.
pub fn kmh_to_mph(speed_kmh: f64) -> f64 {
    speed_kmh / KM_PER_MILE
}

/// Returns a speed in miles per hour.
pub fn knots_to_mph(speed_knots: f64) -> f64 {
    kmh_to_mph(speed_knots * KM_PER_NAUTICAL_MILE)
}

/// Returns an angle in `[0, 360)`.
pub fn normalise_degrees(angle_deg: f64) -> f64 {
    angle_deg.rem_euclid(360.0)
}

/// Returns the signed turn from one heading to another in `(-180, 180]`; positive is to the right.
pub fn turn_degrees(from_deg: f64, to_deg: f64) -> f64 {
    let turn = normalise_degrees(to_deg - from_deg);
    if turn > 180.0 { turn - 360.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_from_north_to_west_is_to_the_left() {
        assert_eq!(turn_degrees(0.0, 270.0), -90.0);
    }

    #[test]
    fn a_turn_across_north_is_the_short_way() {
        assert_eq!(turn_degrees(350.0, 10.0), 20.0);
    }
}
