//! Times of day as count tables have them.

use super::days;

/// Minutes of a day.
pub const DAY_MIN: u32 = 1440;

/// Days after 1899-12-30 from which on a spreadsheet's number is a date of our time.
const FIRST_SERIAL: f64 = 20_000.0;

/// What stands between the first and the last time of an interval.
const BETWEEN: [&str; 7] = [" - ", " TO ", " AND ", " \u{2013} ", "\u{2013}", "-", "/"];

/// Minutes of the longest interval that a row counts.
const LONGEST_INTERVAL_MIN: u32 = 60;

/// What may follow a time without changing it: words, and the zone of universal time.
const AFTER: [&str; 9] = [" HRS", "HRS", " HR", "HR", " H", "H", "Z", "UTC", "GMT"];

/// Names of universal time.
const UNIVERSAL: [&str; 3] = ["Z", "UTC", "GMT"];

/// Returns the day, as it is written, and the minute of the day at which an interval begins; `None` for what is no time,
/// or has something before it that is no day.
///
/// Understood are `07:15`, `0715`, `7:15 AM`, `7:15 a.m.`, `07:15:00`, `7.15`, the first of two times (`07:15 - 07:30`,
/// `7:15 to 7:30`), a date or weekday before the time, and days with their fraction as spreadsheets keep them
/// (`46331.302`). A date alone is no time, also with points (`5.11.2026`). Of a time with an offset (`07:15-06:00`) the
/// clock time stands, which is the local one unless its [`zone`] [is universal](is_universal).
pub fn begin(text: &str) -> Option<(String, u32)> {
    if let Some(serial) = serial(text) {
        return Some(serial);
    }
    let upper = upper(text);
    let (first, second) = first_of_two(&upper);
    let mut words: Vec<&str> = bare(first).split_whitespace().collect();
    let own = match words.last() {
        Some(&("AM" | "PM")) => words.pop(),
        _ => None,
    };
    // The first of two times may leave the half of the day to the second: 4:00 - 4:15 PM.
    let half = own.or_else(|| {
        ["AM", "PM"].into_iter().find(|half| second.is_some_and(|s| s.ends_with(half)))
    });
    let minute = time(words.pop()?, half)?;
    let day = words.join(" ");
    (day.is_empty() || days::is_day(&day)).then_some((day, minute))
}

/// Returns a text in capital letters, with a space for the letter between date and time (`2026-11-05T16:30`).
fn upper(text: &str) -> String {
    let upper = text.trim().to_uppercase().replace("A.M.", "AM").replace("P.M.", "PM");
    match upper.split_once('T') {
        Some((date, time)) if date.ends_with(|c: char| c.is_ascii_digit()) => {
            format!("{date} {time}")
        }
        _ => upper,
    }
}

/// Returns the zone that a time names, such as `Z` or `-0600`; `None` for a time without one.
///
/// `05:15-06:00` is a time with an offset or three quarters of an hour, and counts as the latter.
pub fn zone(text: &str) -> Option<String> {
    let text = upper(text);
    let (before, second) = first_of_two(&text);
    let first = before.trim_end();
    let (_, start) = begin(first)?;
    if let Some(name) = UNIVERSAL.into_iter().find(|name| first.ends_with(*name)) {
        return Some(name.to_owned());
    }
    let offset = match split_offset(first) {
        Some((_, offset)) => offset,
        // West of Greenwich an offset looks like a second time: 01:15-06:00.
        None => {
            let length = (time(second?, None)? + DAY_MIN - start) % DAY_MIN;
            let offset = text[before.len()..].trim_end();
            let is_interval = (1..=LONGEST_INTERVAL_MIN).contains(&length);
            (!is_interval && is_offset(offset)).then_some(offset)?
        }
    };
    let digits = offset.replace(':', "");
    Some(if digits.len() == "-06".len() { digits + "00" } else { digits })
}

/// Returns the minutes of an interval whose text has both its ends, such as `7:00-8:00`; `None` for a single time.
pub fn length_min(text: &str) -> Option<u32> {
    if zone(text).is_some() {
        return None;
    }
    let upper = upper(text);
    let (_, second) = first_of_two(&upper);
    let (_, end) = begin(second?)?;
    let (_, start) = begin(text)?;
    let length = (end + DAY_MIN - start) % DAY_MIN;
    (1..=LONGEST_INTERVAL_MIN).contains(&length).then_some(length)
}

/// Returns whether a zone is universal time, and so not the local time: `Z`, `UTC`, `Etc/UTC`, `+00:00`.
pub fn is_universal(zone: &str) -> bool {
    let upper = zone.trim().to_uppercase();
    let zone = upper.strip_prefix("ETC/").unwrap_or(&upper);
    let is_zero = |offset: &str| offset.chars().all(|c| matches!(c, '+' | '-' | '0' | ':'));
    match ["UTC", "GMT"].into_iter().find_map(|name| zone.strip_prefix(name)) {
        Some(offset) => is_zero(offset),
        None => zone == "Z" || zone.contains('0') && is_zero(zone),
    }
}

/// Returns a text without what may follow a time, such as a word or the offset of its zone.
fn bare(text: &str) -> &str {
    let text = AFTER.iter().find_map(|after| text.strip_suffix(after)).unwrap_or(text).trim_end();
    split_offset(text).map_or(text, |(time, _)| time)
}

/// Returns a time and the offset after it, such as `-06:00`; `None` for a time without one.
fn split_offset(text: &str) -> Option<(&str, &str)> {
    let (time, offset) = text.split_at(text.rfind(['+', '-'])?);
    (time.contains(':') && is_offset(offset)).then_some((time, offset))
}

/// Returns whether a text is the offset of a zone: a sign and two or four digits.
fn is_offset(text: &str) -> bool {
    text.strip_prefix(['+', '-']).is_some_and(|digits| {
        let digits = digits.replace(':', "");
        matches!(digits.len(), 2 | 4) && digits.chars().all(|c| c.is_ascii_digit())
    })
}

/// Returns the first of two times that stand in one field, and the second; a text with one time stays.
fn first_of_two(text: &str) -> (&str, Option<&str>) {
    let is_time = |text: &str| {
        let text = text.trim();
        // The second time may repeat the day.
        let (day, last) = match text.rsplit_once(' ') {
            Some((before, half @ ("AM" | "PM"))) => match before.rsplit_once(' ') {
                Some((day, time)) => (day, (time, Some(half))),
                None => ("", (before, Some(half))),
            },
            Some((day, time)) => (day, (time, None)),
            None => ("", (text, None)),
        };
        (day.is_empty() || days::is_day(day)) && time(last.0, last.1).is_some()
    };
    let splits = BETWEEN.into_iter().flat_map(|between| {
        text.match_indices(between).map(move |(at, _)| (&text[..at], &text[at + between.len()..]))
    });
    let mut splits = splits.filter(|(first, second)| is_time(second) && is_time(first));
    splits.next().map_or((text, None), |(first, second)| (first, Some(second.trim_end())))
}

/// Returns the minute of the day of a time that may end with the half of the day.
fn time(text: &str, half: Option<&str>) -> Option<u32> {
    let text = bare(text);
    for (own, half) in [("AM", "AM"), ("PM", "PM"), ("A", "AM"), ("P", "PM")] {
        if let Some(digits) = text.strip_suffix(own) {
            return of_day(digits, Some(half));
        }
    }
    of_day(text, half)
}

/// Returns the day and minute of a spreadsheet's number: a fraction of a day, or a day with one.
fn serial(text: &str) -> Option<(String, u32)> {
    let value: f64 = text.trim().parse().ok()?;
    let has_fraction = text.contains(['.', 'e', 'E']);
    let is_fraction =
        (0.0..1.0).contains(&value) && has_fraction && !is_after_midnight(text.trim());
    let is_day = (FIRST_SERIAL..5.0 * FIRST_SERIAL).contains(&value) && has_fraction;
    if !is_fraction && !is_day {
        return None;
    }
    // Seconds that rounding has lost.
    let minute = (value.fract() * f64::from(DAY_MIN) + 0.02).floor() as u32;
    let day = if is_fraction { String::new() } else { value.trunc().to_string() };
    Some((day, minute.min(DAY_MIN - 1)))
}

/// Returns whether a text is a time of the first hour of a day, such as `0.15`: fractions of a day have more decimals,
/// except those of 6:00, 12:00 and 18:00.
fn is_after_midnight(text: &str) -> bool {
    let is_short = text
        .split_once('.')
        .is_some_and(|(hour, minute)| hour.chars().all(|c| c == '0') && minute.len() <= 2);
    is_short && !["0.25", "0.5", "0.75"].contains(&text)
}

/// Returns the minute of the day of `7:15`, `7.15`, `07:15:00`, `715` or `7`, with the half of the day if it has one.
fn of_day(text: &str, half: Option<&str>) -> Option<u32> {
    let number = |digits: &str| -> Option<u32> {
        digits.chars().all(|c| c.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
    };
    // Seconds of a time are 00, and no year of a count is.
    if !text.contains(':') && !text.ends_with(".00") && days::is_day(text) {
        return None;
    }
    let (hour, minute) = match text.split([':', '.']).collect::<Vec<_>>()[..] {
        [digits] if (3..=4).contains(&digits.len()) => {
            let all = number(digits)?;
            (all / 100, all % 100)
        }
        // Only with AM or PM is a single number an hour.
        [digits] if half.is_some() => (number(digits)?, 0),
        [hour, minute] if minute.len() == 2 => (number(hour)?, number(minute)?),
        [hour, minute, second] | [hour, minute, second, _] => {
            number(second)?;
            (number(hour)?, number(minute)?)
        }
        _ => return None,
    };
    let hour = match half {
        Some("PM") if hour < 12 => hour + 12,
        Some("AM") if hour == 12 => 0,
        _ => hour,
    };
    (hour < 24 && minute < 60).then_some(hour * 60 + minute)
}

/// Returns a minute of the day as `07:15`.
pub fn written(minute: u32) -> String {
    format!("{:02}:{:02}", minute / 60 % 24, minute % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_times_say_how_long_an_interval_is() {
        for (text, length) in [
            ("7:00-8:00", Some(60)),
            ("4:00 - 4:15 PM", Some(15)),
            ("0700-0715", Some(15)),
            ("07:15", None),
            ("07:15+01:00", None),
        ] {
            assert_eq!(length_min(text), length, "{text}");
        }
    }

    #[test]
    fn times_are_read_as_people_write_them() {
        for (text, day, time) in [
            ("07:15", "", "07:15"),
            ("0715", "", "07:15"),
            ("715", "", "07:15"),
            ("7:15 AM", "", "07:15"),
            ("7:15PM", "", "19:15"),
            ("12:00 AM", "", "00:00"),
            ("12:45 pm", "", "12:45"),
            ("4:00 - 4:15 PM", "", "16:00"),
            ("07:15:00", "", "07:15"),
            ("0700-0715", "", "07:00"),
            ("7:00 to 7:15", "", "07:00"),
            ("4:00 PM to 4:15 PM", "", "16:00"),
            ("16:00/16:15", "", "16:00"),
            ("11/3/2026 16:00 - 11/3/2026 16:15", "11/3/2026", "16:00"),
            ("7:00 a.m.", "", "07:00"),
            ("7:00P", "", "19:00"),
            ("1600 hrs", "", "16:00"),
            ("7.15", "", "07:15"),
            ("0.00", "", "00:00"),
            ("0.45", "", "00:45"),
            ("0.5", "", "12:00"),
            ("0.75", "", "18:00"),
            ("7.05.00", "", "07:05"),
            ("7-Nov-2026 7:15", "7-NOV-2026", "07:15"),
            ("Nov 7, 2026 7:00 - 7:15", "NOV 7, 2026", "07:00"),
            ("20261107 0715", "20261107", "07:15"),
            ("Tue 16:00", "TUE", "16:00"),
            ("2026-11-05T16:30:00Z", "2026-11-05", "16:30"),
            ("2026-11-05T16:30:00-06:00", "2026-11-05", "16:30"),
            ("2026-11-05T16:30:00+05:30", "2026-11-05", "16:30"),
            ("2026-11-05 16:30:00-06", "2026-11-05", "16:30"),
            ("07:00+01:00 - 07:15+01:00", "", "07:00"),
            ("1.04166666666667E-2", "", "00:15"),
            ("07:00-07:15", "", "07:00"),
            ("2026-11-05 16:30 UTC", "2026-11-05", "16:30"),
            ("2026-11-05 16:30", "2026-11-05", "16:30"),
            ("2026-11-05T16:30:00.000", "2026-11-05", "16:30"),
            ("11/5/2026 4:30 PM", "11/5/2026", "16:30"),
            ("0.302083333333333", "", "07:15"),
            ("46331.302083333", "46331", "07:15"),
        ] {
            let (found, minute) = begin(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((&*found, &*written(minute)), (day, time), "{text}");
        }
    }

    #[test]
    fn universal_time_is_told_from_local_time_with_an_offset() {
        for text in [
            "2026-11-05T16:30:00Z",
            "16:30Z",
            "16:30 UTC",
            "2026-11-05 16:30:00+00",
            "2026-11-05T16:30:00.000+00:00",
            "16:30Z/16:45Z",
        ] {
            assert!(zone(text).is_some_and(|zone| is_universal(&zone)), "{text}");
        }
        for text in ["16:30", "2026-11-05T16:30:00-06:00", "16:30+01:00", "Plaza", "4:00 PM", ""] {
            assert!(zone(text).is_none_or(|zone| !is_universal(&zone)), "{text}");
        }
        for name in ["utc", "GMT", "Etc/UTC", "UTC+00:00", "0", "+0000"] {
            assert!(is_universal(name), "{name}");
        }
        for name in ["", "-", "UTC-7", "-06:00", "MDT", "America/Denver"] {
            assert!(!is_universal(name), "{name}");
        }
    }

    #[test]
    fn an_offset_is_told_from_the_end_of_an_interval() {
        for (text, offset) in [
            ("2026-11-01T01:15:00-06:00", Some("-0600")),
            ("2026-11-01 01:15:00-07", Some("-0700")),
            ("01:15-0700", Some("-0700")),
            ("02:45+02:00 - 02:00+01:00", Some("+0200")),
            ("01:15-01:30", None),
            ("2300-0000", None),
            ("7:00 - 9:00", None),
            ("1.04166666666667E-2", None),
        ] {
            assert_eq!(zone(text).as_deref(), offset, "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in [
            "", "Total", "25:00", "07:75", "7", "AM", "12", "Peak hour", "Total 07:15", "3 04:15",
            "5.11.2026", "5.11.26", "2026-11-05", "7 Nov 2026", "0.3",
        ] {
            assert_eq!(begin(text), None, "{text}");
        }
    }
}
