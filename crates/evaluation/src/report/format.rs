//! Numbers as people read them: as many digits as mean something.

/// Width of an interval of scores below which two decimals would hide it.
const NARROW: f64 = 0.02;

/// Most decimals of a lead.
const MOST_DECIMALS: usize = 6;

/// Returns a score: two decimals, three significant digits from 10 on.
pub fn score(value: f64) -> String {
    match value.abs() {
        v if v < 9.995 => format!("{value:.2}"),
        v if v < 99.95 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}

/// Returns a score with as many decimals as its interval allows: two, or three when the interval is
/// narrower than `NARROW`.
pub fn score_within(value: f64, interval: Option<(f64, f64)>) -> String {
    match interval {
        Some((low, high)) if high - low < NARROW && high < 10.0 && high > low => {
            format!("{value:.3}")
        }
        _ => score(value),
    }
}

/// Returns an interval of scores, such as `0.54 to 0.58`.
pub fn interval((low, high): (f64, f64)) -> String {
    let within = |value| score_within(value, Some((low, high)));
    format!("{} to {}", within(low), within(high))
}

/// Returns a lead and its interval. Where the interval excludes 0 but an end would be written as 0, all three have as many
/// more decimals as keep it from that: a decided lead does not look open.
pub fn lead(value: f64, ends: Option<(f64, f64)>) -> (String, Option<String>) {
    let plain = (score_within(value, ends), ends.map(interval));
    let Some((low, high)) = ends.filter(|(low, high)| *low > 0.0 || *high < 0.0) else {
        return plain;
    };
    let nearest = low.abs().min(high.abs());
    let is_zero = |text: &str| text.chars().all(|c| matches!(c, '0' | '.'));
    if !is_zero(&score_within(nearest, ends)) {
        return plain;
    }
    let shows = |decimals: usize| !is_zero(&format!("{nearest:.decimals$}"));
    let decimals = (3..MOST_DECIMALS).find(|decimals| shows(*decimals)).unwrap_or(MOST_DECIMALS);
    let text = |value: f64| format!("{value:.decimals$}");
    (text(value), Some(format!("{} to {}", text(low), text(high))))
}

/// Returns an amount, such as a delay in seconds or a queue in vehicles: one decimal, none from 100 on.
pub fn amount(value: f64) -> String {
    if value.abs() < 99.95 { format!("{value:.1}") } else { format!("{value:.0}") }
}

/// Returns a large amount with three significant digits and its thousands apart, such as `29,600`; as an amount below
/// 1000.
pub fn thousands(value: f64) -> String {
    if value.abs() < 999.5 {
        return amount(value);
    }
    let unit = 10f64.powi(value.abs().log10().floor() as i32 - 2);
    let digits = format!("{:.0}", (value / unit).round() * unit);
    let first = digits.len() % 3;
    let groups: Vec<&str> = [&digits[..first]]
        .into_iter()
        .filter(|group| !group.is_empty())
        .chain((first..digits.len()).step_by(3).map(|at| &digits[at..at + 3]))
        .collect();
    groups.join(",")
}

/// Returns a share as per cent; more than nothing is never "0%".
pub fn percent(share: f64) -> String {
    match share * 100.0 {
        p if p <= 0.0 => "0%".to_owned(),
        p if p < 1.0 => "<1%".to_owned(),
        p => format!("{p:.0}%"),
    }
}

/// Returns a time in the largest unit of which it has at least two, such as `90 s` or `2.5 min`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{} min", amount(s / 60.0)),
        s => format!("{} h", amount(s / 3600.0)),
    }
}

/// Returns a feature's value without decimals that it does not have; more than nothing is never "0".
pub fn feature(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    match rounded == 0.0 && value != 0.0 {
        true => format!("{value:.0e}"),
        false => rounded.to_string(),
    }
}

/// Returns a count with its noun, in the plural unless it is one.
pub fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

/// Returns a text with a capital letter.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase).into_iter().flatten();
    first.chain(letters).collect()
}

/// Returns a feature's name as words, without the suffix that repeats its unit.
pub fn words(name: &str, unit: &str) -> String {
    let name = match name.rsplit_once('_') {
        Some((stem, suffix)) if !unit.is_empty() && suffix.len() <= 4 => stem,
        _ => name,
    };
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_interval_has_three_decimals() {
        assert_eq!(interval((0.5217, 0.5257)), "0.522 to 0.526");
        assert_eq!(interval((0.5217, 0.6257)), "0.52 to 0.63");
        assert_eq!(score_within(1.0, Some((1.0, 1.0))), "1.00");
    }

    #[test]
    fn a_decided_lead_does_not_end_at_zero() {
        let texts = |value, low, high| {
            let (value, interval) = lead(value, Some((low, high)));
            (value, interval.unwrap())
        };
        let of = |value: &str, interval: &str| (value.to_owned(), interval.to_owned());
        assert_eq!(texts(0.015, 0.0029, 0.029), of("0.015", "0.003 to 0.029"));
        assert_eq!(texts(-0.2, -0.4, -0.0002), of("-0.2000", "-0.4000 to -0.0002"));
        assert_eq!(texts(0.016, -0.0029, 0.029), of("0.02", "-0.00 to 0.03"));
        assert_eq!(texts(0.2, 0.1, 0.3), of("0.20", "0.10 to 0.30"));
        assert_eq!(lead(0.2, None), ("0.20".to_owned(), None));
    }

    #[test]
    fn large_amounts_keep_three_digits_and_have_their_thousands_apart() {
        let texts = [12.34, 999.4, 999.6, 29_649.0, 123_456.0, 9_999_999.0].map(thousands);
        assert_eq!(texts, ["12.3", "999", "1,000", "29,600", "123,000", "10,000,000"]);
    }

    #[test]
    fn a_small_share_is_not_nothing() {
        assert_eq!([0.0, 0.004, 0.126].map(percent), ["0%", "<1%", "13%"]);
    }

    #[test]
    fn a_feature_s_name_loses_the_suffix_that_its_unit_repeats() {
        assert_eq!(words("speed_mph", "mph"), "speed");
        assert_eq!(words("gravity_mps2", "m/s²"), "gravity");
        assert_eq!(words("left_turn_lanes", "lanes per approach"), "left turn lanes");
        assert_eq!(words("mass_kg", ""), "mass kg");
    }
}
