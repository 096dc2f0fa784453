//! Angles between directions, degrees clockwise from north.

/// Returns an angle in `[0, 360)`.
pub fn normalise_degrees(angle_deg: f64) -> f64 {
    angle_deg.rem_euclid(360.0)
}

/// Returns the signed turn from one heading to another in `(-180, 180]`; positive is to the right.
pub fn turn_degrees(from_deg: f64, to_deg: f64) -> f64 {
    let turn = normalise_degrees(to_deg - from_deg);
    if turn > 180.0 { turn - 360.0 } else { turn }
}

/// Returns a bearing with east and west exchanged, degrees in `[0, 360)`.
pub fn mirrored_deg(bearing_deg: f64) -> f64 {
    normalise_degrees(360.0 - bearing_deg)
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

    #[test]
    fn a_mirror_exchanges_east_and_west_and_leaves_north_and_south() {
        assert_eq!([0.0, 90.0, 180.0, 300.0].map(mirrored_deg), [0.0, 270.0, 180.0, 60.0]);
    }
}
