//! Counts that are missing in a table of approaches.
//!
//! The counts of the source have holes, and a hole is no empty street. An arm without a count gets,
//! per lane, the mean of the other counted arms that lead to the same signal. Where there is none, it
//! gets the mean of the table's counted arms with as many incoming lanes, if they are at least three,
//! else of all counted arms. All means are over counts as they stand, before the cap of the inflow.
//!
//! Source: this project's rule.

use std::collections::BTreeMap;

use super::approach::{Approach, Intersection, RawIntersection};

/// Fewest counted arms with as many lanes whose mean stands for the others.
const MIN_COUNTED: usize = 3;

/// Returns the intersections with a count on every arm. An arm that only leads away needs none and keeps 0 if it has
/// none; neither does an arm whose turns were counted, because nothing reads its daily count.
///
/// # Arguments
///
/// * `otherwise` — the count of an arm where the table has none at all; without it that is an error.
///
/// # Errors
///
/// What to do when a count is missing and no arm is counted.
pub(super) fn impute(
    raw: Vec<RawIntersection>,
    otherwise: Option<f64>,
) -> Result<Vec<Intersection>, String> {
    let counted =
        |arm: &Approach<Option<f64>>| arm.aadt_veh_per_day_per_lane.filter(|_| arm.lanes_in > 0);
    let mut all = Vec::new();
    let mut of_lanes: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for arm in raw.iter().flat_map(|i| &i.arms) {
        if let Some(aadt) = counted(arm) {
            all.push(aadt);
            of_lanes.entry(arm.lanes_in).or_default().push(aadt);
        }
    }
    let typical = |lanes_in: u32| match of_lanes.get(&lanes_in) {
        Some(similar) if similar.len() >= MIN_COUNTED => mean(similar),
        _ => mean(&all),
    };
    raw.into_iter()
        .map(|RawIntersection { id, period, line, arms }| {
            let own: Vec<f64> = arms.iter().filter_map(counted).collect();
            let (latitude, longitude) = (arms[0].latitude, arms[0].longitude);
            let mut imputed = 0;
            let complete = |arm: Approach<Option<f64>>| {
                let aadt = match arm.aadt_veh_per_day_per_lane {
                    Some(aadt) => Some(aadt),
                    None if arm.lanes_in == 0 || arm.counted.is_some() => Some(0.0),
                    None => {
                        imputed += 1;
                        mean(&own).or_else(|| typical(arm.lanes_in)).or(otherwise)
                    }
                };
                let missing = arm.aadt_veh_per_day_per_lane.is_none()
                    && arm.lanes_in > 0
                    && arm.counted.is_none();
                aadt.map(|aadt| Approach { imputed: missing, ..with_count(arm, aadt) })
            };
            let arms: Option<Vec<Approach>> = arms.into_iter().map(complete).collect();
            let arms = arms.ok_or(
                "aadt_veh_per_day_per_lane is empty on every approach that leads to a signal; give \
                 at least one count",
            )?;
            Ok(Intersection { id, period, latitude, longitude, arms, imputed, line })
        })
        .collect()
}

/// Returns the mean, or nothing of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn with_count(arm: Approach<Option<f64>>, aadt_veh_per_day_per_lane: f64) -> Approach {
    Approach {
        intersection: arm.intersection,
        arm: arm.arm,
        latitude: arm.latitude,
        longitude: arm.longitude,
        bearing_deg: arm.bearing_deg,
        lanes_in: arm.lanes_in,
        lanes_out: arm.lanes_out,
        left_turn_lanes: arm.left_turn_lanes,
        right_turn_lanes: arm.right_turn_lanes,
        left_storage_m: arm.left_storage_m,
        right_storage_m: arm.right_storage_m,
        speed_mph: arm.speed_mph,
        length_m: arm.length_m,
        aadt_veh_per_day_per_lane,
        movements: arm.movements,
        period: arm.period,
        counted: arm.counted,
        line: arm.line,
        imputed: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An intersection of arms with so many incoming lanes and such counts.
    fn raw(arms: &[(u32, Option<f64>)]) -> RawIntersection {
        let arm = |&(lanes_in, aadt_veh_per_day_per_lane): &(u32, Option<f64>)| Approach {
            intersection: "1".into(),
            arm: "A".into(),
            latitude: 40.0,
            longitude: -111.0,
            bearing_deg: 0.0,
            lanes_in,
            lanes_out: 1,
            left_turn_lanes: 0,
            right_turn_lanes: 0,
            left_storage_m: None,
            right_storage_m: None,
            speed_mph: 30.0,
            length_m: 200.0,
            aadt_veh_per_day_per_lane,
            movements: String::new(),
            period: String::new(),
            counted: None,
            line: 2,
            imputed: false,
        };
        RawIntersection {
            id: "1".into(),
            period: String::new(),
            line: 2,
            arms: arms.iter().map(arm).collect(),
        }
    }

    fn counts(table: &[&[(u32, Option<f64>)]]) -> Vec<Vec<f64>> {
        let done = impute(table.iter().map(|arms| raw(arms)).collect(), None).unwrap();
        let of = |i: &Intersection| i.arms.iter().map(|a| a.aadt_veh_per_day_per_lane).collect();
        done.iter().map(of).collect()
    }

    #[test]
    fn a_missing_count_is_the_mean_of_the_arms_that_lead_to_the_same_signal() {
        let arms = [(1, Some(100.0)), (2, None), (2, Some(400.0)), (0, Some(9000.0))];
        assert_eq!(counts(&[&arms])[0], [100.0, 250.0, 400.0, 9000.0]);
    }

    #[test]
    fn an_intersection_without_counts_gets_the_mean_of_arms_with_as_many_lanes() {
        let counted = [(1, Some(10.0)), (2, Some(300.0)), (2, Some(400.0)), (2, Some(500.0))];
        assert_eq!(counts(&[&counted, &[(2, None)]])[1], [400.0]);
    }

    #[test]
    fn fewer_than_three_arms_with_as_many_lanes_give_way_to_all_arms() {
        let counted = [(1, Some(100.0)), (2, Some(200.0)), (2, Some(600.0))];
        assert_eq!(counts(&[&counted, &[(2, None)]])[1], [300.0]);
    }

    #[test]
    fn an_arm_that_leads_away_needs_no_count() {
        let done = impute(vec![raw(&[(1, Some(100.0)), (0, None)])], None).unwrap();
        assert_eq!((done[0].arms[1].aadt_veh_per_day_per_lane, done[0].imputed), (0.0, 0));
    }

    #[test]
    fn a_table_without_counts_cannot_be_completed() {
        assert!(impute(vec![raw(&[(1, None), (0, Some(100.0))])], None).is_err());
    }
}
