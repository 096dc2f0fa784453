//! Checks ranges that types cannot express: of a scenario's settings and of tables.

use super::InflowSources;
use super::demand::MIN_PEAK_HOUR_FACTOR;
use super::{Detail, Scenario, SixFeatures};
use evaluation::family::error::FamilyError;
use evaluation::settings::{all_within, default_name, shortest, within};

/// How far shares that were rounded may be from 1 in total.
const SHARES_SUM: f64 = 0.01;

/// Largest share of a turn, which is divided by the sum of all.
const LARGEST_SHARE: f64 = 1e6;

/// Smallest sum that is divided by.
const SMALLEST_SHARES: f64 = 1e-6;

/// Checks the settings of a scenario.
/// Fails with [`FamilyError::Setting`] naming file and field.
pub fn check(scenario: &Scenario, file: &str) -> Result<(), FamilyError> {
    let fail = |field: &str, value: String, expected: &str| {
        Err(FamilyError::setting(file, field, value, expected))
    };
    let name = &scenario.name;
    default_name::check(name).or_else(|expected| fail("name", format!("{name:?}"), expected))?;
    let (f, d) = (&scenario.family, &scenario.demand);
    within(f64::from(scenario.version), 1.0, 1e6)
        .or_else(|expected| fail("version", scenario.version.to_string(), &expected))?;
    all_within(file, &scenario.sections())?;
    for ((name, _), width) in SixFeatures::COLUMNS.iter().zip(f.bins.to_array()) {
        let field = format!("family.bins.{name}");
        within(width, 1e-3, 1e6).or_else(|expected| fail(&field, shortest(width), &expected))?;
    }
    scenario.signal.check().or_else(|(field, value, expected)| fail(field, value, expected))?;
    if !(d.peak_hour_factor > MIN_PEAK_HOUR_FACTOR && d.peak_hour_factor <= 1.0) {
        let expected = format!("expected a number above {MIN_PEAK_HOUR_FACTOR}, at most 1");
        return fail("demand.peak_hour_factor", d.peak_hour_factor.to_string(), &expected);
    }
    let shares = [d.turn_shares.left, d.turn_shares.through, d.turn_shares.right];
    let in_range = shares.iter().all(|s| (0.0..=LARGEST_SHARE).contains(s));
    if !in_range || shares.iter().sum::<f64>() < SMALLEST_SHARES {
        let value = format!("{shares:?}");
        let expected = format!(
            "expected numbers from 0 to {LARGEST_SHARE}, {SMALLEST_SHARES} or more together; what counts is how they \
             compare"
        );
        return fail("demand.turn_shares", value, &expected);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(extra: &str) -> Scenario {
        toml::from_str(&format!("name = \"x\"\nfamily.points = \"p.csv\"\n{extra}")).unwrap()
    }

    #[test]
    fn a_setting_out_of_range_names_field_value_and_range() {
        for (extra, expected) in [
            ("demand.horizon_s = 0.0", "demand.horizon_s = 0: expected a number from 10 to 86400"),
            ("demand.peak_hour_factor = 0.25", "= 0.25: expected a number above 0.25, at most 1"),
            ("demand.peak_hour_factor = 1.01", "= 1.01: expected a number above 0.25, at most 1"),
            ("demand.peak_hour_factor = nan", "= NaN: expected a number above 0.25, at most 1"),
            ("demand.approach_spread = 0.75", "expected a number from 0 to 0.745"),
            ("idqn.learning_rate = 2.1", "rate = 2.1: expected a number from 0.00000001 to 1"),
            ("signal.min_cycle_s = 200", "= 200: expected at most signal.max_cycle_s"),
            ("signal.max_green_s = 10", "so that there is something to decide"),
        ] {
            let e = check(&scenario(extra), "t.toml").unwrap_err().to_string();
            assert!(e.starts_with("t.toml: ") && e.ends_with(expected), "{e}");
        }
        let mut bins = scenario("");
        bins.family.bins.lanes = 0.0;
        let e = check(&bins, "t.toml").unwrap_err().to_string();
        assert_eq!(e, "t.toml: family.bins.lanes = 0: expected a number from 0.001 to 1000000");
        check(&scenario("demand = {peak_hour_factor = 0.26, approach_spread = 0.745}"), "t")
            .unwrap();
    }

    #[test]
    fn turn_shares_that_overflow_or_vanish_are_refused_with_their_range() {
        for (left, right) in [("1e308", "1e308"), ("nan", "1"), ("inf", "1"), ("1e-309", "0")] {
            let toml =
                format!("demand.turn_shares = {{ left = {left}, through = 0.0, right = {right} }}");
            let toml = toml.replace("= 1 }", "= 1.0 }").replace("= 0 }", "= 0.0 }");
            let e = check(&scenario(&toml), "t.toml").unwrap_err().to_string();
            assert!(e.contains("expected numbers from 0 to 1000000, 0.000001 or more"), "{e}");
        }
    }
}
