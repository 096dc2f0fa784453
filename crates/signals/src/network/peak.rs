//! A peak within the horizon: the arrivals of an even flow, moved in time.
//!
//! The horizon has four quarters. One, the peak, has the volume that the peak hour factor says, the
//! other three share the rest evenly. The peak is the **second** quarter: the first fills the empty
//! road, and in the two after it the queue dissolves, so that the delay that it causes is counted.
//!
//! Source: Highway Capacity Manual, peak hour factor `V / (4 V15)`.

/// Quarters of a horizon, of which one is the peak.
const QUARTERS: f64 = 4.0;

/// Quarters before the peak.
const BEFORE_PEAK: f64 = 1.0;

/// Returns when a vehicle arrives that would arrive at the time `even_s` of an even flow, seconds:
/// when as large a share of the horizon's vehicles has arrived.
///
/// # Arguments
///
/// * `even_s` — from 0 up to but without `horizon_s`, as the result is.
/// * `factor` — the peak hour factor, above 1/4; 1 changes nothing.
pub(super) fn peaked_s(even_s: f64, horizon_s: f64, factor: f64) -> f64 {
    if factor >= 1.0 {
        return even_s;
    }
    let quarter_s = horizon_s / QUARTERS;
    // Rates relative to the even flow, in the peak and in the other quarters.
    let peak = 1.0 / factor;
    let other = (QUARTERS - peak) / (QUARTERS - 1.0);
    let begins_s = BEFORE_PEAK * quarter_s;
    let since_s = even_s - begins_s * other;
    let time_s = if since_s < 0.0 {
        even_s / other
    } else if since_s < quarter_s * peak {
        begins_s + since_s / peak
    } else {
        begins_s + quarter_s + (since_s - quarter_s * peak) / other
    };
    // Rounding must not make a vehicle come at the end or after it.
    time_s.min(horizon_s.next_down())
}

/// Returns when a vehicle arrives that would arrive at the time `even_s` of an even flow, seconds, if the quarters of
/// the horizon have these vehicles, up to a common factor.
///
/// # Arguments
///
/// * `even_s` — from 0 up to but without `horizon_s`, as the result is.
/// * `quarters` — not negative, their sum above 0.
pub(super) fn quartered_s(even_s: f64, horizon_s: f64, quarters: [f64; 4]) -> f64 {
    let quarter_s = horizon_s / QUARTERS;
    let mut rest = even_s / horizon_s * quarters.iter().sum::<f64>();
    for (i, vehicles) in quarters.iter().enumerate() {
        if rest < *vehicles {
            let time_s = quarter_s * (i as f64 + rest / vehicles);
            return time_s.min((quarter_s * (i + 1) as f64).next_down());
        }
        rest -= vehicles;
    }
    // Rounding has carried the last vehicle past the last quarter that has any.
    let last =
        quarters.iter().rposition(|vehicles| *vehicles > 0.0).map_or(QUARTERS, |i| (i + 1) as f64);
    (quarter_s * last).next_down()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR_S: f64 = 3600.0;

    #[test]
    fn the_second_quarter_has_the_volume_divided_by_the_peak_hour_factor() {
        let vehicles = 60_000;
        let mut quarters = [0.0; 4];
        for k in 0..vehicles {
            let even_s = HOUR_S * f64::from(k) / f64::from(vehicles);
            let quarter = peaked_s(even_s, HOUR_S, 0.8) / (HOUR_S / QUARTERS);
            quarters[quarter as usize] += QUARTERS / f64::from(vehicles);
        }
        let expected = [2.75 / 3.0, 1.25, 2.75 / 3.0, 2.75 / 3.0];
        for (quarter, expected) in quarters.iter().zip(expected) {
            assert!((quarter - expected).abs() < 1e-3, "{quarters:?}");
        }
    }

    #[test]
    fn quarters_have_what_was_counted_and_an_empty_one_nobody() {
        let quarters = [100.0, 0.0, 300.0, 0.0];
        let times: Vec<f64> =
            (0..4000).map(|k| quartered_s(0.9 * f64::from(k), HOUR_S, quarters)).collect();
        assert!(times.is_sorted());
        let within =
            |low: f64, high: f64| times.iter().filter(|t| (low..high).contains(*t)).count();
        assert_eq!(
            [within(0.0, 900.0), within(900.0, 1800.0), within(1800.0, 2700.0)],
            [1000, 0, 3000]
        );
        assert!(quartered_s(HOUR_S.next_down(), HOUR_S, quarters) < 2700.0);
        let even = [250.0; 4];
        assert!((quartered_s(1234.5, HOUR_S, even) - 1234.5).abs() < 1e-9);
    }

    #[test]
    fn an_even_flow_stays_as_it_is_to_the_last_bit() {
        assert!([0.0, 899.999, 1800.1, 3599.9].iter().all(|t| peaked_s(*t, HOUR_S, 1.0) == *t));
    }

    #[test]
    fn vehicles_keep_their_order_and_come_before_the_end() {
        for factor in [0.26, 0.5, 0.92, 0.999] {
            let times: Vec<f64> =
                (0..36_000).map(|k| peaked_s(f64::from(k) / 10.0, HOUR_S, factor)).collect();
            assert!(times.is_sorted() && times[0] == 0.0);
            assert!(peaked_s(HOUR_S.next_down(), HOUR_S, factor) < HOUR_S);
        }
    }
}
