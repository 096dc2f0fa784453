//! Whether arms are those of an intersection that can be built as it is, with `detail = "per-approach"`. Six
//! features are means over arms, whatever these are.

use osm_signals::angle::normalise_degrees;
use osm_signals::intersections::MAX_ARMS;

use super::approach::Intersection;

/// Fewest and most arms that a network is built for.
pub const ARMS: std::ops::RangeInclusive<usize> = 2..=MAX_ARMS;

/// Checks the arms of an intersection.
///
/// # Errors
///
/// What is wrong with them, and the way out: they are too few or too many, two go in one direction, or one has
/// no way out.
pub fn check_arms(intersection: &Intersection) -> Result<(), String> {
    let (id, arms) = (&intersection.id, &intersection.arms);
    if !ARMS.contains(&arms.len()) {
        let (low, high) = (ARMS.start(), ARMS.end());
        return Err(format!(
            "intersection {id} has {} arms, and networks are built for {low} to {high}; join arms, or \
             remove the intersection",
            arms.len()
        ));
    }
    for (i, arm) in arms.iter().enumerate() {
        let bearing_deg = normalise_degrees(arm.bearing_deg);
        let same = arms[..i].iter().find(|a| normalise_degrees(a.bearing_deg) == bearing_deg);
        if let Some(same) = same {
            return Err(format!(
                "intersection {id}: arms {} and {} both have bearing_deg = {bearing_deg}; give each the \
                 direction from the centre to it",
                same.arm, arm.arm
            ));
        }
        let leads_away = arms.iter().enumerate().any(|(j, other)| j != i && other.lanes_out > 0);
        if arm.lanes_in > 0 && !leads_away {
            return Err(format!(
                "intersection {id}: vehicles from arm {} have no way out; give another arm lanes_out \
                 of at least 1",
                arm.arm
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;

    /// What is wrong with the arms of bearings and lanes out.
    fn wrong(arms: &[(f64, u32)]) -> String {
        let mut text =
            "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
                        right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n"
                .to_owned();
        for (i, (bearing_deg, lanes_out)) in arms.iter().enumerate() {
            let name = char::from(b'A' + i as u8);
            text += &format!("1,{name},40,-111,{bearing_deg},2,{lanes_out},0,0,30,200,9000,\n");
        }
        check_arms(&read(&text, "a.csv").unwrap()[0]).unwrap_err()
    }

    #[test]
    fn arms_that_no_network_can_have_are_named() {
        assert_eq!(
            wrong(&[(0.0, 2), (180.0, 2), (360.0, 2)]),
            "intersection 1: arms A and C both have bearing_deg = 0; give each the direction from the \
             centre to it"
        );
        assert_eq!(
            wrong(&[(0.0, 1), (90.0, 0), (180.0, 0)]),
            "intersection 1: vehicles from arm A have no way out; give another arm lanes_out of at least 1"
        );
        let seven: Vec<_> = (0..7).map(|i| (51.0 * f64::from(i), 2)).collect();
        assert_eq!(
            wrong(&seven),
            "intersection 1 has 7 arms, and networks are built for 2 to 6; join arms, or remove the \
             intersection"
        );
        assert!(wrong(&seven[..1]).contains("has 1 arms"));
    }
}
