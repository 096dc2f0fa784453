//! A column that is like one that is missing, but may hold something else: its values in another unit, or of all
//! lanes together. Whoever renames it has data that are wrong without a word.

/// Ends of the names of columns, what they measure, and how much of its first unit one of them is.
const UNITS: [(&str, &str, f64); 14] = [
    ("_mph", "speed", 1.0),
    ("_kmh", "speed", 0.621_371),
    ("_kph", "speed", 0.621_371),
    ("_km_h", "speed", 0.621_371),
    ("_mps", "speed", 2.236_936),
    ("_m_s", "speed", 2.236_936),
    ("_m", "length", 1.0),
    ("_ft", "length", 0.3048),
    ("_yd", "length", 0.9144),
    ("_km", "length", 1000.0),
    ("_mi", "length", 1609.344),
    ("_kg", "mass", 1.0),
    ("_g", "mass", 0.001),
    ("_lb", "mass", 0.453_592),
];

/// End of the name of a column of what one lane has.
const PER_LANE: &str = "_per_lane";

/// Says how a column becomes the one that is missing; `None` where renaming it is all.
pub(super) fn conversion(missing: &str, other: &str) -> Option<String> {
    if missing.ends_with(PER_LANE) && !other.to_lowercase().contains("lane") {
        return Some(format!(
            "the column {other} seems to be of all lanes: divide it by the lanes that it counts, those of both \
             directions, and call it {missing}"
        ));
    }
    let ((_, measure, one), (_, other_measure, other_one)) = (unit(missing)?, unit(other)?);
    (measure == other_measure && one != other_one).then(|| {
        let factor = (other_one / one * 1e6).round() / 1e6;
        format!(
            "the column {other} has another unit: multiply it by {factor} and call it {missing}"
        )
    })
}

/// Returns the unit that a name ends in, the longest of those that fit.
fn unit(name: &str) -> Option<(&'static str, &'static str, f64)> {
    let name = name.to_lowercase();
    UNITS.into_iter().filter(|(end, ..)| name.ends_with(end)).max_by_key(|(end, ..)| end.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_unit_comes_with_its_factor() {
        let said = |missing, other| conversion(missing, other).unwrap();
        assert_eq!(
            said("speed_mph", "speed_kmh"),
            "the column speed_kmh has another unit: multiply it by 0.621371 and call it speed_mph"
        );
        assert!(said("length_m", "length_ft").contains("multiply it by 0.3048 "));
        assert!(said("speed_mph", "Speed_m_s").contains("multiply it by 2.236936 "));
        assert!(
            said("aadt_veh_per_day_per_lane", "aadt")
                .contains("divide it by the lanes that it counts")
        );
    }

    #[test]
    fn a_name_without_another_unit_is_no_conversion() {
        for (missing, other) in
            [("speed_mph", "speed"), ("length_m", "Length_m"), ("speed_mph", "spede_mph")]
        {
            assert_eq!(conversion(missing, other), None, "{other}");
        }
        assert_eq!(conversion("aadt_veh_per_day_per_lane", "aadt_per_lane"), None);
    }
}
