//! Times of day as count tables have them.

/// Minutes of a day.
pub const DAY_MIN: u32 = 1440;

/// Returns the day, as it is written, and the minute of the day at which an interval begins.
///
/// Understood are `07:15`, `0715`, `7:15 AM`, `07:15:00`, the first of two times (`07:15 - 07:30`), a date before the
/// time, and days with their fraction as spreadsheets keep them (`45986.302`).
pub fn begin(text: &str) -> Option<(String, u32)> {
    if let Some(serial) = serial(text) {
        return Some(serial);
    }
    let upper = text.to_uppercase().replace('T', " ");
    let (first, second) = first_of_two(&upper);
    let mut words: Vec<&str> = first.split_whitespace().collect();
    let own = match words.last() {
        Some(&("AM" | "PM")) => words.pop(),
        _ => None,
    };
    // The first of two times may leave the half of the day to the second: 4:00 - 4:15 PM.
    let half = own.or_else(|| {
        ["AM", "PM"].into_iter().find(|half| second.is_some_and(|s| s.ends_with(half)))
    });
    let minute = time(words.pop()?, half)?;
    Some((words.join(" "), minute))
}

/// Returns the first of two times that stand in one field, and the second; a text with one time stays.
fn first_of_two(text: &str) -> (&str, Option<&str>) {
    let is_time = |text: &str| match text.trim().rsplit_once(' ') {
        Some((before, half @ ("AM" | "PM"))) => time(before, Some(half)).is_some(),
        Some(_) => false,
        None => time(text.trim(), None).is_some(),
    };
    let splits =
        [" - ", "-", "\u{2013}"].into_iter().filter_map(|between| text.rsplit_once(between));
    let mut splits = splits.filter(|(first, second)| {
        let last = first.trim_end().trim_end_matches("AM").trim_end_matches("PM").trim_end();
        is_time(second)
            && last.rsplit(' ').next().is_some_and(|word| time(word, Some("AM")).is_some())
    });
    splits.next().map_or((text, None), |(first, second)| (first, Some(second.trim_end())))
}

/// Returns the minute of the day of a time that may end with the half of the day.
fn time(text: &str, half: Option<&str>) -> Option<u32> {
    for own in ["AM", "PM"] {
        if let Some(digits) = text.strip_suffix(own) {
            return of_day(digits, Some(own));
        }
    }
    of_day(text, half)
}

/// Returns the day and minute of a spreadsheet's number.
fn serial(text: &str) -> Option<(String, u32)> {
    let (days, fraction) = text.split_once('.')?;
    let fraction: f64 = format!("0.{fraction}").parse().ok()?;
    let days: u32 = days.parse().ok().filter(|days| *days < 100_000)?;
    // Seconds that rounding has lost.
    let minute = (fraction * f64::from(DAY_MIN) + 0.02).floor() as u32;
    let day = if days == 0 { String::new() } else { days.to_string() };
    Some((day, minute.min(DAY_MIN - 1)))
}

/// Returns the minute of the day of `7:15`, `07:15:00`, `715` or `7`, with the half of the day if it has one.
fn of_day(text: &str, half: Option<&str>) -> Option<u32> {
    let number = |digits: &str| -> Option<u32> {
        digits.chars().all(|c| c.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
    };
    let (hour, minute) = match text.split(':').collect::<Vec<_>>()[..] {
        [digits] if (3..=4).contains(&digits.len()) => {
            let all = number(digits)?;
            (all / 100, all % 100)
        }
        // Only with AM or PM is a single number an hour.
        [digits] if half.is_some() => (number(digits)?, 0),
        [hour, minute] => (number(hour)?, number(minute)?),
        [hour, minute, second] => {
            number(second.split('.').next()?)?;
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
            ("07:00-07:15", "", "07:00"),
            ("2026-11-05 16:30", "2026-11-05", "16:30"),
            ("2026-11-05T16:30:00.000", "2026-11-05", "16:30"),
            ("11/5/2026 4:30 PM", "11/5/2026", "16:30"),
            ("0.302083333333333", "", "07:15"),
            ("45986.302083333", "45986", "07:15"),
        ] {
            let (found, minute) = begin(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((&*found, &*written(minute)), (day, time), "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in ["", "Total", "25:00", "07:75", "7", "AM", "12", "Peak hour"] {
            assert_eq!(begin(text), None, "{text}");
        }
    }
}
