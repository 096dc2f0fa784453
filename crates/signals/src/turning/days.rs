//! Which days of a count stand for a working day.

use jiff::civil::{Date, Weekday};

/// Days of the week, of which at least two letters are written.
const WEEKDAYS: [(&str, Weekday); 7] = [
    ("MONDAY", Weekday::Monday),
    ("TUESDAY", Weekday::Tuesday),
    ("WEDNESDAY", Weekday::Wednesday),
    ("THURSDAY", Weekday::Thursday),
    ("FRIDAY", Weekday::Friday),
    ("SATURDAY", Weekday::Saturday),
    ("SUNDAY", Weekday::Sunday),
];

/// Months, of which at least three letters are written.
const MONTHS: [&str; 12] = [
    "JANUARY", "FEBRUARY", "MARCH", "APRIL", "MAY", "JUNE", "JULY", "AUGUST", "SEPTEMBER",
    "OCTOBER", "NOVEMBER", "DECEMBER",
];

/// Returns whether the month comes first in dates such as `11/5/2026`: unless one of all days shows that it comes second.
pub(super) fn month_first<'a>(mut days: impl Iterator<Item = &'a str>) -> bool {
    !days.any(|day| weekday_of(day, true).is_none() && weekday_of(day, false).is_some())
}

/// Returns whether a day, as it is written, is a Saturday or a Sunday; `None` for what is no day.
pub(super) fn is_weekend(day: &str, month_first: bool) -> Option<bool> {
    // Sunday, 8 Nov: a date without its year.
    let named = || weekday(day.split([' ', ',']).next().unwrap_or_default());
    let weekday = weekday_of(day, month_first).or_else(named)?;
    Some(matches!(weekday, Weekday::Saturday | Weekday::Sunday))
}

/// Returns whether a text is a date or a weekday.
pub(super) fn is_day(text: &str) -> bool {
    weekday_of(text, true).or_else(|| weekday_of(text, false)).is_some()
}

/// Returns the day of the week of a date, or of the name of a weekday; `None` for what is neither.
fn weekday_of(text: &str, month_first: bool) -> Option<Weekday> {
    let words = text.split([' ', ',']).filter(|word| !word.is_empty());
    let (named, date_words): (Vec<&str>, Vec<&str>) =
        words.partition(|word| weekday(word).is_some());
    if date_words.is_empty() {
        return weekday(named.first()?);
    }
    date(&date_words.join(" "), month_first).map(Date::weekday)
}

fn weekday(word: &str) -> Option<Weekday> {
    let word = word.to_uppercase();
    let (_, weekday) =
        WEEKDAYS.into_iter().find(|(name, _)| word.len() >= 2 && name.starts_with(&word))?;
    Some(weekday)
}

/// Returns the number of a month from its name.
fn month(word: &str) -> Option<i16> {
    let word = word.to_uppercase();
    (1..).zip(MONTHS).find(|(_, name)| word.len() >= 3 && name.starts_with(&word)).map(|(n, _)| n)
}

fn date(text: &str, month_first: bool) -> Option<Date> {
    let number = |text: &str| text.parse::<i16>().ok();
    let of = |year: i16, month: i16, day: i16| {
        let year = if year < 100 { 2000 + year } else { year };
        Date::new(year, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok()
    };
    if text.len() == 8 && text.chars().all(|c| c.is_ascii_digit()) {
        return of(number(&text[..4])?, number(&text[4..6])?, number(&text[6..])?);
    }
    if let Some(serial) = text.parse::<i64>().ok().filter(|serial| *serial > 20_000) {
        // Days of a spreadsheet begin with 1899-12-30.
        let first = Date::constant(1899, 12, 30);
        return first.checked_add(jiff::Span::new().try_days(serial).ok()?).ok();
    }
    let parts: Vec<&str> =
        text.split(['/', '-', '.', ' ']).filter(|part| !part.is_empty()).collect();
    let [a, b, c] = parts[..] else { return None };
    match (month(a), month(b)) {
        (Some(month), _) => return of(number(c)?, month, number(b)?),
        (None, Some(month)) if number(a)? > 99 => return of(number(a)?, month, number(c)?),
        (None, Some(month)) => return of(number(c)?, month, number(a)?),
        // Numbers with blanks between are no date.
        (None, None) if text.contains(' ') => return None,
        (None, None) => {}
    }
    let (a, b, c) = (number(a)?, number(b)?, number(c)?);
    match (a > 99, text.contains('.')) {
        (true, _) => of(a, b, c),
        (false, true) => of(c, b, a),
        (false, false) if month_first => of(c, a, b),
        (false, false) => of(c, b, a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of some days are a weekend, and how many are no day.
    fn free(days: &[&str]) -> (usize, usize) {
        let month_first = month_first(days.iter().copied());
        let told = days.iter().map(|day| is_weekend(day, month_first));
        let count = |wanted| told.clone().filter(|told| *told == wanted).count();
        (count(Some(true)), count(None))
    }

    #[test]
    fn weekends_are_found_however_dates_are_written() {
        // The 7th of November 2026 is a Saturday.
        assert_eq!(free(&["11/6/2026", "11/7/2026", "11/8/2026", "11/9/2026"]), (2, 0));
        assert_eq!(free(&["2026-11-06", "2026-11-07"]), (1, 0));
        assert_eq!(free(&["20261106", "20261107"]), (1, 0));
        assert_eq!(free(&["7.11.2026", "9.11.26"]), (1, 0));
        assert_eq!(free(&["46332", "46333"]), (1, 0));
        assert_eq!(free(&["6-Nov-2026", "7-NOV-26", "2026-nov-8", "Nov 9, 2026"]), (2, 0));
        assert_eq!(free(&["7 November 2026", "Fri 11/6/2026"]), (1, 0));
        assert_eq!(free(&["SAT", "Tue", "Sunday, 8 Nov"]), (2, 0));
        assert_eq!(free(&["first", "11/7/2026"]), (1, 1));
    }

    #[test]
    fn a_day_that_comes_first_in_one_date_comes_first_in_all() {
        // The 13 shows it: the 8th of November is a Sunday, and the 11th of August is none.
        assert_eq!(free(&["8/11/2026", "13/11/2026"]), (1, 0));
        assert_eq!(free(&["8/11/2026", "12/11/2026"]), (0, 0));
    }
}
