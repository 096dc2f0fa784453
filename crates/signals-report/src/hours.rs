//! From seconds of delay per vehicle to vehicle-hours of an intersection.

use super::demand::{self, HOUR_S};
use super::level_of_service::DELAY;
use evaluation::analysis::{Analysis, PointSummary};
use evaluation::report::Stakes;

/// Returns what differences in delay amount to at an intersection: vehicle-hours in a day, where the settings say which
/// share of it an hour has, else in the time that was simulated; `None` where vehicles or that time are not known.
pub(super) fn stakes(data: &Analysis) -> Option<Stakes> {
    let identity = &data.manifest.identity;
    if identity.objective != DELAY {
        return None;
    }
    let share = demand::hourly_share(&identity.settings);
    let horizon_s = demand::horizon_s(identity)?;
    let span = demand::span(horizon_s);
    let times = share.map_or(1.0, |share| HOUR_S / horizon_s / share);
    let vehicles = |p: &PointSummary| {
        let results = p.results.iter().flatten();
        results.filter_map(|r| r.metrics.get("vehicles_veh").copied()).next()
    };
    let factor = |p: &PointSummary| Some(vehicles(p)? * times / HOUR_S);
    let factors: Vec<Option<f64>> = data.points.iter().map(factor).collect();
    factors.iter().any(Option::is_some).then(|| Stakes {
        heading: "Vehicle-hours".to_owned(),
        unit: match share {
            Some(_) => "per intersection and day".to_owned(),
            None => format!("per intersection, simulated {span}"),
        },
        from: match share {
            Some(share) if horizon_s == HOUR_S => format!(
                "times the vehicles of a day, if each of them is delayed as one in the simulated hour, which has \
                 {:.1}% of the day\u{2019}s traffic",
                100.0 * share
            ),
            Some(share) => format!(
                "times the vehicles of a day, if each of them is delayed as one in the simulated {span}, of which an \
                 hour has {:.1}% of the day\u{2019}s traffic: an extrapolation from that alone",
                100.0 * share
            ),
            None => format!("times the vehicles of the simulated {span}"),
        },
        factors,
    })
}
