//! Checks ranges that types cannot express: of a scenario's settings and of tables.

use super::demand::{MAX_APPROACH_SPREAD, MIN_PEAK_HOUR_FACTOR};
use super::inflow::{EVEN_SPLIT, InflowSources};
use super::{Detail, Scenario, SixFeatures};
use crate::family::error::FamilyError;
use crate::settings::setting::{Ranged, Section};
use crate::settings::within;

/// Longest green that can be asked for, seconds.
const MAX_GREEN_S: f64 = 3600.0;

/// How far shares that were rounded may be from 1 in total.
const SHARES_SUM: f64 = 0.01;

/// Checks the settings of a scenario.
///
/// # Errors
///
/// [`FamilyError::Setting`] naming file and field.
pub fn check(scenario: &Scenario, file: &str) -> Result<(), FamilyError> {
    let fail = |field: &str, value: String, expected: &str| {
        Err(FamilyError::Setting {
            file: file.to_owned(),
            field: field.to_owned(),
            value,
            expected: expected.to_owned(),
        })
    };
    let name = &scenario.name;
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)) {
        return fail("name", format!("{name:?}"), "expected letters, digits, `-` and `_`");
    }
    let (f, n, d) = (&scenario.family, &scenario.network, &scenario.demand);
    let (t, a, b) = (&scenario.fixed_time, &scenario.actuated, &scenario.baseline);
    let s = &scenario.signal;
    let ranges = [
        ("version", f64::from(scenario.version), 1.0, 1e6),
        ("family.hourly_share", f.hourly_share, 1e-6, 1.0),
        ("family.directional_split", f.directional_split, EVEN_SPLIT, 1.0),
        ("family.peak_heading_deg", f.peak_heading_deg, 0.0, 360.0),
        ("family.inflow_cap_vph_per_lane", f.inflow_cap_vph_per_lane, 1.0, 3600.0),
        ("family.min_inflow_vph", f.min_inflow_vph, 1.0, 3600.0),
        ("family.length_scale", f.length_scale, 0.01, 100.0),
        ("network.exit_length_m", n.exit_length_m, 10.0, 10_000.0),
        ("network.phase_green_s", n.phase_green_s, 1.0, 300.0),
        ("network.default_cycle_s", n.default_cycle_s, 20.0, 600.0),
        ("network.default_left_green_s", n.default_left_green_s, 1.0, 100.0),
        ("demand.horizon_s", d.horizon_s, 10.0, 86_400.0),
        ("demand.approach_spread", d.approach_spread, 0.0, MAX_APPROACH_SPREAD),
        ("signal.delta_time_s", f64::from(s.delta_time_s), 1.0, 300.0),
        ("signal.detection_m", s.detection_m, 1.0, 10_000.0),
        ("signal.yellow_time_s", f64::from(s.yellow_time_s), 0.0, 10.0),
        ("signal.all_red_s", f64::from(s.all_red_s), 0.0, 30.0),
        ("signal.min_green_s", f64::from(s.min_green_s), 1.0, 100.0),
        ("signal.min_left_green_s", f64::from(s.min_left_green_s), 1.0, 100.0),
        ("signal.max_green_s", s.max_green_s.map_or(MAX_GREEN_S, f64::from), 1.0, MAX_GREEN_S),
        ("signal.min_cycle_s", f64::from(s.min_cycle_s), 1.0, 600.0),
        ("signal.max_cycle_s", f64::from(s.max_cycle_s), 10.0, 600.0),
        ("simulation.time_to_teleport_s", scenario.simulation.time_to_teleport_s, -1.0, 86_400.0),
        ("baseline.green_s", b.green_s, 1.0, 300.0),
        ("fixed_time.simulations", f64::from(t.simulations), 1.0, 10_000.0),
        ("fixed_time.lost_time_s", t.lost_time_s, 0.0, 30.0),
        ("fixed_time.saturation_flow_vph", t.saturation_flow_vph, 100.0, 5000.0),
        ("actuated.max_green_s", a.max_green_s, 1.0, 600.0),
        ("training.episodes", f64::from(scenario.training.episodes), 1.0, 1e6),
    ];
    let methods: [(&str, &dyn Section); 6] = [
        ("max_pressure", &scenario.max_pressure),
        ("idqn", &scenario.idqn),
        ("ippo", &scenario.ippo),
        ("mplight", &scenario.mplight),
        ("mplight_star", &scenario.mplight_star),
        ("mplight_star_resco", &scenario.mplight_star_resco),
    ];
    let methods = methods.into_iter().flat_map(|(section, settings)| {
        let named = move |r: Ranged| (format!("{section}.{}", r.name), r.value, r.low, r.high);
        settings.ranges().into_iter().map(named)
    });
    let bins = SixFeatures::COLUMNS
        .iter()
        .zip(f.bins.to_array())
        .map(|((name, _), v)| (format!("family.bins.{name}"), v, 1e-3, 1e6));
    let ranges = ranges.into_iter().map(|(field, v, low, high)| (field.to_owned(), v, low, high));
    for (field, value, low, high) in ranges.chain(methods).chain(bins) {
        if let Err(expected) = within(value, low, high) {
            return fail(&field, shortest(value), &expected);
        }
    }
    if let Err((field, value, expected)) = s.check() {
        return fail(field, value, expected);
    }
    if !(d.peak_hour_factor > MIN_PEAK_HOUR_FACTOR && d.peak_hour_factor <= 1.0) {
        let expected = format!("expected a number above {MIN_PEAK_HOUR_FACTOR}, at most 1");
        return fail("demand.peak_hour_factor", d.peak_hour_factor.to_string(), &expected);
    }
    let shares = [d.turn_shares.left, d.turn_shares.through, d.turn_shares.right];
    if shares.iter().any(|s| !s.is_finite() || *s < 0.0) || shares.iter().sum::<f64>() <= 0.0 {
        let value = format!("{shares:?}");
        return fail("demand.turn_shares", value, "expected shares that are not negative");
    }
    if let Some(shares) = f.inflows.map(InflowSources::to_array) {
        let sum: f64 = shares.iter().sum();
        if !shares.iter().all(|s| (0.0..=1.0).contains(s)) || (sum - 1.0).abs() > SHARES_SUM {
            let value = format!("{shares:?}");
            return fail("family.inflows", value, "expected shares from 0 to 1 that sum to 1");
        }
    }
    if f.points.is_some() && f.detail == Detail::PerApproach {
        let expected = "per-approach detail needs family.approaches";
        return fail("family.detail", "per-approach".into(), expected);
    }
    Ok(())
}

/// Returns a number as it was written, also one that was read in single precision.
fn shortest(value: f64) -> String {
    let single = value as f32;
    if f64::from(single) == value { single.to_string() } else { value.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(extra: &str) -> Scenario {
        toml::from_str(&format!("name = \"x\"\nfamily.points = \"p.csv\"\n{extra}")).unwrap()
    }

    #[test]
    fn defaults_pass_the_check() {
        check(&scenario(""), "t.toml").unwrap();
    }

    #[test]
    fn a_setting_out_of_range_names_field_value_and_range() {
        let e = check(&scenario("demand.horizon_s = 0.0"), "t.toml").unwrap_err();
        assert_eq!(
            e.to_string(),
            "t.toml: demand.horizon_s = 0: expected a number from 10 to 86400"
        );
    }

    #[test]
    fn how_unevenly_vehicles_come_has_limits() {
        for (extra, expected) in [
            ("demand.peak_hour_factor = 0.25", "above 0.25, at most 1"),
            ("demand.peak_hour_factor = 1.01", "above 0.25, at most 1"),
            ("demand.peak_hour_factor = nan", "above 0.25, at most 1"),
            ("demand.approach_spread = 0.75", "from 0 to 0.745"),
        ] {
            let e = check(&scenario(extra), "t.toml").unwrap_err().to_string();
            assert!(e.ends_with(&format!("expected a number {expected}")), "{e}");
        }
        check(&scenario("demand = {peak_hour_factor = 0.26, approach_spread = 0.745}"), "t")
            .unwrap();
    }

    #[test]
    fn settings_of_learners_and_bins_are_named_in_full() {
        let e = check(&scenario("idqn.learning_rate = 2.1"), "t.toml").unwrap_err();
        let expected = "t.toml: idqn.learning_rate = 2.1: expected a number from 0.00000001 to 1";
        assert_eq!(e.to_string(), expected);
        let mut scenario = scenario("");
        scenario.family.bins.lanes = 0.0;
        let e = check(&scenario, "t.toml").unwrap_err();
        let expected = "t.toml: family.bins.lanes = 0: expected a number from 0.001 to 1000000";
        assert_eq!(e.to_string(), expected);
    }

    #[test]
    fn a_number_that_is_none_lies_nowhere() {
        assert!(within(f64::NAN, 0.0, 1.0).is_err());
        assert!(within(1.0, 0.0, 1.0).is_ok());
    }

    #[test]
    fn numbers_are_shown_as_they_were_written() {
        assert_eq!([shortest(f64::from(2.1f32)), shortest(86_400.001)], ["2.1", "86400.001"]);
    }

    #[test]
    fn limits_of_timing_that_contradict_each_other_are_refused() {
        let e = check(&scenario("signal.min_cycle_s = 200"), "t.toml").unwrap_err();
        let expected = "t.toml: signal.min_cycle_s = 200: expected at most signal.max_cycle_s";
        assert_eq!(e.to_string(), expected);
        let e = check(&scenario("signal.max_green_s = 10"), "t.toml").unwrap_err();
        assert!(e.to_string().starts_with("t.toml: signal.max_green_s = 10: expected"), "{e}");
    }

    #[test]
    fn negative_turn_shares_are_refused() {
        let toml = "demand.turn_shares = { left = -1.0, through = 1.0, right = 1.0 }";
        assert!(check(&scenario(toml), "t.toml").is_err());
    }
}
