//! What is doubtful in a table, and what of it is not simulated as it stands there: nothing of it stops a
//! run, and nothing of it is believed without a word.
//!
//! - **Changed:** an inflow that is cut or raised, a count that is missing, a turn lane that needs another lane.
//! - **Implausible for its column:** a speed, length or count that few streets have, with the unit it may be in.
//! - **Contradictory:** arms named after directions of travel that their bearings are not.
//! - **No place:** latitude and longitude 0, or where nobody has signals.
//!
//! Source: thresholds are this project's; each is beside its reason.

use std::collections::BTreeSet;

mod changes;
mod doubt;
mod places;
mod points;
mod values;

use osm_signals::angle::{normalise_degrees, turn_degrees};

use super::approaches::{Approach, Intersection};
use crate::settings::{Detail, FamilySettings};
use crate::vocabulary::{Heading, MOST_OFF_DEG};
pub use doubt::Doubt;
pub(crate) use doubt::Said;
use doubt::at_line;
use evaluation::family::MdpFamily;

/// Returns what is doubtful in a table of approaches, and what of it is changed.
pub fn of_approaches(intersections: &[Intersection], settings: &FamilySettings) -> Vec<Doubt> {
    let per_approach = settings.detail == Detail::PerApproach;
    let mut doubts = changes::changes(intersections, settings, per_approach);
    doubts.extend(periods(intersections, settings));
    doubts.extend(directions(intersections));
    if settings.inflows.is_some() {
        // This program wrote the table from a map, in the right units.
        return doubts;
    }
    doubts.extend(values::values(intersections));
    let placed: Vec<Intersection> =
        intersections.iter().filter(|i| i.latitude.is_finite()).cloned().collect();
    if !placed.is_empty() {
        doubts.extend(places::places(&placed));
    }
    doubts
}

/// Returns that periods count equally, where nobody said how long they are.
fn periods(intersections: &[Intersection], settings: &FamilySettings) -> Option<Doubt> {
    let periods: BTreeSet<&str> = intersections.iter().map(|i| i.period.as_str()).collect();
    (settings.periods.is_none() && periods.len() > 1).then(|| {
        let names = periods.iter().map(|p| if p.is_empty() { "(none)" } else { p });
        Doubt::whole(format!(
            "the periods {} count equally; give their hours per year in [family.periods]",
            names.collect::<Vec<_>>().join(", ")
        ))
    })
}

/// Returns the arms whose names begin with another direction of travel than their bearings have, where the names count.
fn directions(intersections: &[Intersection]) -> Option<Doubt> {
    let mut astray = Vec::new();
    for intersection in intersections {
        let incoming: Vec<&Approach> =
            intersection.arms.iter().filter(|arm| arm.lanes_in > 0).collect();
        let told = Heading::told(incoming.iter().map(|arm| arm.arm.as_str()));
        for (arm, heading) in incoming.into_iter().zip(told.into_iter().flatten()) {
            let way_deg = normalise_degrees(arm.bearing_deg + 180.0);
            if turn_degrees(heading.degrees(), way_deg).abs() > MOST_OFF_DEG {
                let text = format!("{}, whose vehicles travel at {way_deg} degrees", arm.arm);
                astray.push(at_line(arm.line, text));
            }
        }
    }
    let about = "names of arms begin with another direction of travel than bearing_deg has; turning counts, existing plans and \
                 the plans of reports go by the names, so correct them if the compass is meant";
    Doubt::of(about, astray)
}

/// Returns what is doubtful in a table of point MDPs, and what of it is changed.
pub fn of_points(family: &MdpFamily) -> Vec<Doubt> {
    points::points(family)
}

#[cfg(test)]
mod tests;
