//! How a day's traffic becomes the vehicles of the simulated hour.
//!
//! Traffic of a hour is `AADT K D`: a share `K` of the day falls into the hour
//! ([`FamilySettings::hourly_share`]), and of that a share `D` goes in the peak direction of a two-way
//! street ([`FamilySettings::directional_split`]). Annual counts do not tell which direction that is, and the
//! larger share on every arm would be more vehicles than were counted.
//!
//! **Peak by compass.** The peak direction of all streets is the one whose heading is within 90 degrees of
//! one heading ([`FamilySettings::peak_heading_deg`], north-east: north- and eastbound traffic). So of two
//! opposite arms one gets `2 D` and the other `2 (1 - D)` times its mean, and the two ends of a straight
//! street agree: what is inbound at one is outbound at the other. One-way streets have no split.
//!
//! Source: directional design-hour volume, Highway Capacity Manual, and FDOT's Project Traffic Forecasting
//! Handbook.
//! Deviation: there the peak direction of a street is counted; a map has no such counts.

use osm_signals::angle::turn_degrees;

use super::approaches::Approach;
use crate::settings::EVEN_SPLIT;
use crate::settings::FamilySettings;

/// Half of all headings, degrees.
const HALF_DEG: f64 = 90.0;

/// Returns by what the mean of both directions has to be multiplied for the flow towards the signal.
pub(super) fn direction_factor(approach: &Approach, settings: &FamilySettings) -> f64 {
    if approach.lanes_out == 0 {
        return 1.0;
    }
    let heading_deg = approach.bearing_deg + 180.0;
    // Of two opposite headings exactly one is in the half-open range.
    let turn_deg = turn_degrees(settings.peak_heading_deg, heading_deg);
    let peak = turn_deg > -HALF_DEG && turn_deg <= HALF_DEG;
    let share = if peak { settings.directional_split } else { 1.0 - settings.directional_split };
    share / EVEN_SPLIT
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(bearing_deg: f64, lanes_out: u32, split: f64) -> f64 {
        let approach = Approach { bearing_deg, lanes_in: 1, lanes_out, ..Approach::default() };
        let settings = FamilySettings { directional_split: split, ..FamilySettings::default() };
        direction_factor(&approach, &settings)
    }

    #[test]
    fn north_and_eastbound_traffic_has_the_larger_share() {
        // The arm to the south brings the northbound traffic.
        let of = |bearing_deg| (100.0 * factor(bearing_deg, 1, 0.55)).round();
        assert_eq!([180.0, 270.0, 0.0, 90.0].map(of), [110.0, 110.0, 90.0, 90.0]);
    }

    #[test]
    fn opposite_arms_have_the_whole_together_whatever_their_bearing() {
        for tenth in 0..3600 {
            let bearing_deg = f64::from(tenth) / 10.0;
            let both = factor(bearing_deg, 1, 0.6) + factor((bearing_deg + 180.0) % 360.0, 1, 0.6);
            assert!((both - 2.0).abs() < 1e-12, "{bearing_deg}");
        }
    }

    #[test]
    fn equal_directions_and_one_way_streets_change_nothing() {
        assert_eq!([factor(30.0, 1, 0.5), factor(210.0, 1, 0.5), factor(30.0, 0, 0.7)], [1.0; 3]);
    }
}
