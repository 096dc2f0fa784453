//! What is doubtful in a table of point MDPs, and what of it is changed.

use super::doubt::Doubt;
use super::values;
use crate::family::features::{incoming_lanes, six_columns};
use crate::settings::SixFeatures;
use evaluation::family::{MdpFamily, PointMdp};

/// Arrivals that no lane carries, vehicles per hour: a saturation flow (Highway Capacity Manual) without any red.
const BUSY_VPH_PER_LANE: f64 = 1900.0;

/// Returns the doubts.
pub(super) fn points(family: &MdpFamily) -> Vec<Doubt> {
    let Ok(columns) = six_columns(family) else { return Vec::new() };
    let row = |point: &PointMdp| {
        let features = SixFeatures::from_array(columns.map(|c| point.features[c]));
        (format!("point {}", point.title), features)
    };
    let rows: Vec<(String, SixFeatures)> = family.points.iter().map(row).collect();
    let speeds: Vec<(String, f64)> =
        rows.iter().map(|(name, f)| (name.clone(), f.speed_mph)).collect();
    let mut doubts = values::speeds(&speeds);
    let added = rows.iter().filter_map(|(name, f)| {
        let (half, lanes) = incoming_lanes(f);
        (lanes > half).then(|| format!("{name}: {lanes} instead of {half}"))
    });
    doubts.extend(Doubt::of(
        "turn lanes leave no lane to go straight, so more lanes lead to the signal than half of `lanes`",
        added.collect(),
    ));
    let busy = rows.iter().filter_map(|(name, f)| {
        let (_, lanes) = incoming_lanes(f);
        let most = BUSY_VPH_PER_LANE * f64::from(lanes);
        (f.inflow_vph > most).then(|| format!("{name}: {} veh/h on {lanes} lanes", f.inflow_vph))
    });
    doubts.extend(Doubt::of(
        format!(
            "inflow_vph above {BUSY_VPH_PER_LANE} per incoming lane, which no lane carries; it is per approach and \
             hour, not per day"
        ),
        busy.collect(),
    ));
    doubts
}
