//! Which days of a count stand for a working day.

use std::collections::BTreeSet;

use jiff::civil::{Date, Weekday};

/// Returns the days, as they are written, that are a Saturday or a Sunday; none where not every day is a date.
///
/// In `11/5/2026` the month comes first, unless a day of the count shows that it comes second.
pub(super) fn weekend<'a>(days: &BTreeSet<&'a str>) -> BTreeSet<&'a str> {
    let dates = |month_first: bool| -> Option<Vec<(&'a str, Date)>> {
        days.iter().map(|day| date(day, month_first).map(|date| (*day, date))).collect()
    };
    let dates = dates(true).or_else(|| dates(false)).unwrap_or_default();
    let free = |date: &Date| matches!(date.weekday(), Weekday::Saturday | Weekday::Sunday);
    let of_dates = dates.into_iter().filter(|(_, date)| free(date)).map(|(day, _)| day);
    let named = days.iter().filter(|day| {
        let first = day.split([' ', ',']).next().unwrap_or_default().to_uppercase();
        first.len() >= 3 && ["SATURDAY", "SUNDAY"].iter().any(|name| name.starts_with(&first))
    });
    of_dates.chain(named.copied()).collect()
}

/// Returns whether a text is a date or a weekday.
pub(super) fn is_day(text: &str) -> bool {
    let is_weekday = |word: &str| {
        let word = word.trim_end_matches(',').to_uppercase();
        let names = ["MONDAY", "TUESDAY", "WEDNESDAY", "THURSDAY", "FRIDAY", "SATURDAY", "SUNDAY"];
        word.len() >= 2 && names.iter().any(|name| name.starts_with(&word))
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_date = |word: &str| date(word, true).or_else(|| date(word, false)).is_some();
    !words.is_empty() && words.iter().all(|word| is_weekday(word) || is_date(word))
}

fn date(text: &str, month_first: bool) -> Option<Date> {
    let parts: Vec<&str> = text.split(['/', '-', '.']).collect();
    let number = |text: &str| text.parse::<i16>().ok();
    if let Some(serial) = text.parse::<i64>().ok().filter(|serial| *serial > 20_000) {
        // Days of a spreadsheet begin with 1899-12-30.
        let first = Date::constant(1899, 12, 30);
        return first.checked_add(jiff::Span::new().try_days(serial).ok()?).ok();
    }
    let [a, b, c] = parts[..] else { return None };
    let (a, b, c) = (number(a)?, number(b)?, number(c)?);
    let (year, month, day) = match (a > 99, text.contains('.')) {
        (true, _) => (a, b, c),
        (false, true) => (c, b, a),
        (false, false) if month_first => (c, a, b),
        (false, false) => (c, b, a),
    };
    let year = if year < 100 { 2000 + year } else { year };
    Date::new(year, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(days: &[&str]) -> usize {
        weekend(&days.iter().copied().collect()).len()
    }

    #[test]
    fn weekends_are_found_however_dates_are_written() {
        // The 7th of November 2026 is a Saturday.
        assert_eq!(free(&["11/6/2026", "11/7/2026", "11/8/2026", "11/9/2026"]), 2);
        assert_eq!(free(&["2026-11-06", "2026-11-07"]), 1);
        assert_eq!(free(&["7.11.2026", "9.11.26"]), 1);
        assert_eq!(free(&["46332", "46333"]), 1);
        // The 13 shows that the day comes first; the 7th of November then.
        assert_eq!(free(&["7/11/2026", "13/11/2026"]), 1);
        assert_eq!(free(&["SAT", "Tue", "Sunday, 8 Nov"]), 2);
        assert_eq!(free(&["first", "11/7/2026"]), 0);
    }
}
