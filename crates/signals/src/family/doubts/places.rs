//! What the places, bearings and lengths of a table of approaches say of each other.

use osm_signals::angle::turn_degrees;
use osm_signals::geometry::LocalMetric;

use super::doubt::{Doubt, at_line, median};
use crate::family::approaches::{Approach, Intersection};
use basics::units::FOOT_M;

/// Latitudes between which people have signals, degrees: from Ushuaia to Tromso, and some more.
const INHABITED_DEG: std::ops::RangeInclusive<f64> = -57.0..=72.0;

/// Farthest that a place of a city may be from the middle of all, metres.
const CITY_M: f64 = 200_000.0;

/// Farthest that the rows of one intersection may be apart, metres.
const ONE_PLACE_M: f64 = 200.0;

/// Distances of intersections that are neighbours, metres.
const NEAR_M: std::ops::RangeInclusive<f64> = 30.0..=2000.0;

/// Largest deviation of a neighbour from the bearing of the arm that leads to it, degrees.
const TOWARDS_DEG: f64 = 20.0;

/// Largest deviation of the arm that leads back, degrees: bearings may be schematic (0, 120, 240).
const BACK_DEG: f64 = 65.0;

/// How much longer than the way to the next intersection a street may be that winds; lengths that were
/// measured in Web Mercator are 1.3 to 1.6 times too long in the middle latitudes.
const LONGER: f64 = 1.65;

/// Shares of the distance to a neighbour that an arm's length has which leads to it, not to a junction before.
const WHOLE_WAY: std::ops::RangeInclusive<f64> = 0.8..=1.6;

/// Least arms of which a median tells a unit.
const ENOUGH: usize = 4;

/// From what somebody calls a bearing to the bearing that is meant, degrees.
type AsMeant = fn(f64) -> f64;

/// What other people call a bearing.
const CONVENTIONS: [(AsMeant, &str); 3] = [
    (|deg| deg + 180.0, "the heading of the traffic that comes in: add 180"),
    (|deg| 90.0 - deg, "anticlockwise from east: take 90 minus each"),
    (|deg| -deg, "anticlockwise from north: take 360 minus each"),
];

/// Returns the doubts.
///
/// # Arguments
///
/// * `scale` — factor on every length.
pub(super) fn places(intersections: &[Intersection], scale: f64) -> Vec<Doubt> {
    let exchanged = exchanged(intersections);
    let found = !exchanged.is_empty();
    let mut doubts = exchanged;
    let nowhere = intersections.iter().filter(|i| i.latitude == 0.0 && i.longitude == 0.0);
    let rows = nowhere.map(|i| at_line(i.line, format!("intersection {}", i.id))).collect();
    doubts.extend(Doubt::of("latitude 0 and longitude 0, which stands for no place", rows));
    doubts.extend(scattered(intersections));
    if !found {
        let near = Near::new(intersections);
        doubts.extend(lengths(&near, scale));
        doubts.extend(bearings(&near, scale));
    }
    doubts
}

/// Returns doubts about latitudes and longitudes that may be exchanged.
fn exchanged(intersections: &[Intersection]) -> Vec<Doubt> {
    if intersections.iter().all(|i| !INHABITED_DEG.contains(&i.latitude)) {
        return vec![Doubt::whole(format!(
            "the first place, latitude {} and longitude {}, is where nobody has signals; exchange latitude and \
             longitude if they are exchanged",
            intersections[0].latitude, intersections[0].longitude
        ))];
    }
    let middle = |f: &dyn Fn(&Intersection) -> f64| {
        median(intersections.iter().map(f).collect()).unwrap_or_default()
    };
    let centre = (middle(&|i| i.latitude), middle(&|i| i.longitude));
    let metric = LocalMetric::at(centre.0);
    let metres = |at: (f64, f64)| {
        let (east, north) = metric.offset_m(centre, at);
        east.hypot(north)
    };
    let (mut swapped, mut far) = (Vec::new(), Vec::new());
    for i in intersections.iter().filter(|i| metres((i.latitude, i.longitude)) > CITY_M) {
        let row = at_line(
            i.line,
            format!("intersection {}, latitude {}, longitude {}", i.id, i.latitude, i.longitude),
        );
        match metres((i.longitude, i.latitude)) <= CITY_M {
            true => swapped.push(row),
            false => far.push(row),
        }
    }
    let far = Doubt::of(format!("places more than {} km from the others", CITY_M / 1000.0), far);
    let swapped = Doubt::of("latitude and longitude are exchanged, beside the other rows", swapped);
    swapped.into_iter().chain(far).collect()
}

/// Returns doubts about rows of one intersection at several places.
fn scattered(intersections: &[Intersection]) -> Option<Doubt> {
    let mut rows = Vec::new();
    for i in intersections {
        let metric = LocalMetric::at(i.latitude);
        for arm in &i.arms {
            let at = (arm.latitude, arm.longitude);
            let (east, north) = metric.offset_m((i.latitude, i.longitude), at);
            if east.hypot(north) > ONE_PLACE_M {
                let text =
                    format!("{:.0} m from arm {} of {}", east.hypot(north), i.arms[0].arm, i.id);
                rows.push(at_line(arm.line, text));
            }
        }
    }
    Doubt::of("arms of one intersection at different places, of which the first counts", rows)
}

/// The intersections of a table by latitude, for those near one.
struct Near<'a> {
    /// From south to north.
    by_latitude: Vec<&'a Intersection>,
}

/// The intersection that an arm seems to lead to.
struct Next<'a> {
    from: &'a Intersection,
    arm: &'a Approach,
    to: &'a Intersection,
    metres: f64,
    bearing_deg: f64,
}

impl<'a> Near<'a> {
    fn new(intersections: &'a [Intersection]) -> Self {
        let mut by_latitude: Vec<&Intersection> = intersections.iter().collect();
        by_latitude.sort_by(|a, b| a.latitude.total_cmp(&b.latitude));
        Self { by_latitude }
    }

    /// Returns the intersections near one, each with its distance in metres and its direction in degrees.
    fn around(&self, of: &Intersection) -> Vec<(&'a Intersection, f64, f64)> {
        let metric = LocalMetric::at(of.latitude);
        let margin_deg = NEAR_M.end() / metric.north_m_per_deg;
        let first = self.by_latitude.partition_point(|i| i.latitude < of.latitude - margin_deg);
        let near =
            self.by_latitude[first..].iter().take_while(|i| i.latitude <= of.latitude + margin_deg);
        near.filter_map(|i| {
            let at = (i.latitude, i.longitude);
            let (east, north) = metric.offset_m((of.latitude, of.longitude), at);
            let metres = east.hypot(north);
            NEAR_M.contains(&metres).then(|| (*i, metres, east.atan2(north).to_degrees()))
        })
        .collect()
    }

    /// Returns the arms that lead towards another intersection of the table, each with the nearest such one.
    fn next(&self) -> Vec<Next<'a>> {
        let mut found = Vec::new();
        for from in &self.by_latitude {
            let around = self.around(from);
            for arm in &from.arms {
                let ahead = around
                    .iter()
                    .filter(|(.., deg)| turn_degrees(arm.bearing_deg, *deg).abs() <= TOWARDS_DEG);
                let nearest = ahead.min_by(|a, b| a.1.total_cmp(&b.1));
                found.extend(nearest.map(|(to, metres, bearing_deg)| Next {
                    from,
                    arm,
                    to,
                    metres: *metres,
                    bearing_deg: *bearing_deg,
                }));
            }
        }
        found.sort_by_key(|next| next.arm.line);
        found
    }
}

/// Returns whether an intersection has an arm in a direction.
fn has_arm(i: &Intersection, bearing_deg: f64, limit_deg: f64) -> bool {
    i.arms.iter().any(|a| turn_degrees(a.bearing_deg, bearing_deg).abs() <= limit_deg)
}

/// Returns doubts about lengths beyond the next intersection.
fn lengths(near: &Near<'_>, scale: f64) -> Option<Doubt> {
    let joined: Vec<Next<'_>> = near
        .next()
        .into_iter()
        .filter(|n| has_arm(n.to, n.bearing_deg + 180.0, 2.0 * TOWARDS_DEG))
        .collect();
    let ratio = |n: &Next<'_>| n.arm.length_m * scale / n.metres;
    let rows: Vec<String> = (joined.iter().filter(|n| ratio(n) > LONGER))
        .map(|n| {
            let text = format!("{} m, but {} is {:.0} m away", n.arm.length_m, n.to.id, n.metres);
            at_line(n.arm.line, text)
        })
        .collect();
    let middle = median(joined.iter().map(ratio).collect()).filter(|_| joined.len() >= ENOUGH);
    let about = match middle.filter(|middle| *middle > LONGER) {
        Some(middle) => format!(
            "length_m: half of the approaches are {middle:.1} times as long as the way to the next intersection, or \
             longer; if the column is in feet, multiply it by {FOOT_M}"
        ),
        None => format!(
            "length_m goes beyond the next intersection; if it is in feet, multiply it by {FOOT_M}"
        ),
    };
    Doubt::of(about, rows)
}

/// Returns doubts about bearings that contradict those of the neighbours.
fn bearings(near: &Near<'_>, scale: f64) -> Option<Doubt> {
    if let Some((meant, votes)) = convention(near) {
        return Some(Doubt::whole(format!(
            "bearing_deg: {votes} arms point to no neighbour, and would if it were {meant}; it is the direction from \
             the centre to the arm, clockwise from north"
        )));
    }
    let mut rows = Vec::new();
    for n in near.next() {
        let whole = WHOLE_WAY.contains(&(n.arm.length_m * scale / n.metres));
        if whole && !has_arm(n.to, n.bearing_deg + 180.0, BACK_DEG) {
            let back = (n.bearing_deg + 180.0).rem_euclid(360.0);
            rows.push(at_line(
                n.arm.line,
                format!(
                    "arm {} of {} leads to {}, which has no arm near {back:.0} degrees",
                    n.arm.arm, n.from.id, n.to.id
                ),
            ));
        }
    }
    Doubt::of("bearing_deg contradicts the neighbour", rows)
}

/// Returns the convention that the bearings of a table seem to follow instead, and how many neighbours say so.
///
/// Crossings of a grid look alike in all of them; what tells is a neighbour to which an intersection has an arm
/// in one convention only, and which has one back in the same.
fn convention(near: &Near<'_>) -> Option<(&'static str, usize)> {
    let has = |i: &Intersection, deg: f64, as_meant: &dyn Fn(f64) -> f64| {
        i.arms.iter().any(|a| turn_degrees(as_meant(a.bearing_deg), deg).abs() <= TOWARDS_DEG)
    };
    let both = |a: &Intersection, b: &Intersection, deg: f64, as_meant: &dyn Fn(f64) -> f64| {
        has(a, deg, as_meant) && has(b, deg + 180.0, as_meant)
    };
    CONVENTIONS.iter().find_map(|(as_meant, name)| {
        let (mut own, mut other) = (0, 0);
        for from in &near.by_latitude {
            for (to, _, deg) in nearest_around(near.around(from)) {
                let as_is = both(from, to, deg, &|deg| deg);
                match (as_is, both(from, to, deg, as_meant)) {
                    (true, false) => own += 1,
                    (false, true) => other += 1,
                    _ => {}
                }
            }
        }
        // Each pair votes from both sides.
        (other >= 4 && other >= 4 * own).then_some((*name, other / 2))
    })
}

/// Returns those of the intersections around one that no nearer one hides.
fn nearest_around(mut around: Vec<(&Intersection, f64, f64)>) -> Vec<(&Intersection, f64, f64)> {
    around.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut seen: Vec<(&Intersection, f64, f64)> = Vec::new();
    for one in around {
        if seen.iter().all(|s| turn_degrees(s.2, one.2).abs() > 2.0 * TOWARDS_DEG) {
            seen.push(one);
        }
    }
    seen
}
