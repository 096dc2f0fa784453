//! Places of a table of approaches where nobody has signals.

use super::doubt::{Doubt, at_line};
use crate::family::approaches::Intersection;

/// Latitudes between which people have signals, degrees: from Ushuaia to Tromso, and some more.
const INHABITED_DEG: std::ops::RangeInclusive<f64> = -57.0..=72.0;

/// Returns the doubts about intersections that have places.
pub(super) fn places(intersections: &[Intersection]) -> Vec<Doubt> {
    let nowhere = intersections.iter().filter(|i| i.latitude == 0.0 && i.longitude == 0.0);
    let rows = nowhere.map(|i| at_line(i.line, format!("intersection {}", i.id))).collect();
    let zero = Doubt::of("latitude 0 and longitude 0, which stands for no place", rows);
    let beyond = intersections.iter().filter(|i| !INHABITED_DEG.contains(&i.latitude));
    let rows = beyond.map(|i| {
        at_line(
            i.line,
            format!("intersection {}, latitude {}, longitude {}", i.id, i.latitude, i.longitude),
        )
    });
    let about =
        "places where nobody has signals; exchange latitude and longitude if they are exchanged";
    zero.into_iter().chain(Doubt::of(about, rows.collect())).collect()
}
