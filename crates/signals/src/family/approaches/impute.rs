//! Counts that are missing in a table of approaches.
//!
//! The counts of the source have holes, and a hole is no empty street. An arm without a count gets,
//! per lane, the mean of the other counted arms that lead to the same signal. Where there is none, it
//! gets the mean of the table's counted arms with as many incoming lanes, if they are at least three,
//! else of all counted arms. All means are over counts as they stand, before the cap of the inflow.
//!
//! Source: this project's rule.

use std::collections::BTreeMap;

use super::approach::{Approach, Intersection};

/// Fewest counted arms with as many lanes whose mean stands for the others.
const MIN_COUNTED: usize = 3;

/// Gives every arm of intersections a count. An arm that only leads away needs none and keeps 0 if it has
/// none; neither does an arm whose turns were counted, because nothing reads its daily count.
pub(super) fn impute(
    intersections: &mut [Intersection],
    otherwise: Option<f64>,
) -> Result<(), String> {
    let counted = |arm: &Approach| {
        let aadt = arm.aadt_veh_per_day_per_lane;
        (arm.lanes_in > 0 && !aadt.is_nan()).then_some(aadt)
    };
    let mut all = Vec::new();
    let mut of_lanes: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for arm in intersections.iter().flat_map(|i| &i.arms) {
        if let Some(aadt) = counted(arm) {
            all.push(aadt);
            of_lanes.entry(arm.lanes_in).or_default().push(aadt);
        }
    }
    let typical = |lanes_in: u32| match of_lanes.get(&lanes_in) {
        Some(similar) if similar.len() >= MIN_COUNTED => mean(similar),
        _ => mean(&all),
    };
    for intersection in intersections {
        let own: Vec<f64> = intersection.arms.iter().filter_map(counted).collect();
        for arm in intersection.arms.iter_mut().filter(|a| a.aadt_veh_per_day_per_lane.is_nan()) {
            arm.imputed = arm.lanes_in > 0 && arm.counted.is_none();
            intersection.imputed += u32::from(arm.imputed);
            arm.aadt_veh_per_day_per_lane = match arm.imputed {
                true => mean(&own).or_else(|| typical(arm.lanes_in)).or(otherwise).ok_or(
                    "aadt_veh_per_day_per_lane is empty on every approach that leads to a signal; \
                     give at least one count",
                )?,
                false => 0.0,
            };
        }
    }
    Ok(())
}

/// Returns the mean, or nothing of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An intersection of arms with so many incoming lanes and such counts.
    fn raw(arms: &[(u32, Option<f64>)]) -> Intersection {
        let arm = |(lanes_in, aadt): &(u32, Option<f64>)| Approach {
            lanes_in: *lanes_in,
            aadt_veh_per_day_per_lane: aadt.unwrap_or(f64::NAN),
            ..Approach::default()
        };
        Intersection { arms: arms.iter().map(arm).collect(), ..Intersection::default() }
    }

    fn imputed(table: &[&[(u32, Option<f64>)]]) -> Result<Vec<Intersection>, String> {
        let mut all = table.iter().map(|arms| raw(arms)).collect::<Vec<_>>();
        impute(&mut all, None).map(|()| all)
    }

    fn counts(table: &[&[(u32, Option<f64>)]]) -> Vec<Vec<f64>> {
        let of = |i: &Intersection| i.arms.iter().map(|a| a.aadt_veh_per_day_per_lane).collect();
        imputed(table).unwrap().iter().map(of).collect()
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
        let done = imputed(&[&[(1, Some(100.0)), (0, None)]]).unwrap();
        assert_eq!((done[0].arms[1].aadt_veh_per_day_per_lane, done[0].imputed), (0.0, 0));
    }

    #[test]
    fn a_table_without_counts_cannot_be_completed() {
        assert!(imputed(&[&[(1, None), (0, Some(100.0))]]).is_err());
    }
}
