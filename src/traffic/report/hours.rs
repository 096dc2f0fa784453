//! From seconds of delay per vehicle to vehicle-hours of an intersection.

use super::demand;
use super::level_of_service::DELAY;
use crate::analysis::{Analysis, PointSummary};
use crate::report::Stakes;

/// Seconds in an hour.
pub(super) const HOUR_S: f64 = 3600.0;

/// Returns what differences in delay amount to at an intersection: vehicle-hours in a day, where the settings say which
/// share of it the simulated hour is, else in that hour; `None` where vehicles or the hour are not known.
pub(super) fn stakes(data: &Analysis) -> Option<Stakes> {
    let identity = &data.manifest.identity;
    if identity.objective != DELAY {
        return None;
    }
    let share = demand::hourly_share(&identity.settings);
    let per_hour = HOUR_S / demand::horizon_s(identity)?;
    let vehicles = |p: &PointSummary| {
        let results = p.results.iter().flatten();
        results.filter_map(|r| r.metrics.get("vehicles_veh").copied()).next()
    };
    let factor = |p: &PointSummary| Some(vehicles(p)? * per_hour / share.unwrap_or(1.0) / HOUR_S);
    let factors: Vec<Option<f64>> = data.points.iter().map(factor).collect();
    factors.iter().any(Option::is_some).then(|| Stakes {
        heading: "Vehicle-hours".to_owned(),
        unit: match share {
            Some(_) => "per intersection and day".to_owned(),
            None => "per intersection, simulated hour".to_owned(),
        },
        from: match share {
            Some(share) => format!(
                "times the vehicles of a day, if each of them is delayed as one in the simulated hour, which has \
                 {:.1}% of the day\u{2019}s traffic",
                100.0 * share
            ),
            None => "times the vehicles of the simulated hour".to_owned(),
        },
        factors,
    })
}
