//! The busiest hour of a count, and how its vehicles come in it.
//!
//! Of several days the mean counts, over the days that have the whole hour.
//!
//! Source: Highway Capacity Manual, peak hour factor of an approach, `V / (4 V15)`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::str::FromStr;

use jiff::civil::Date;

use super::Towards;
use super::layout::DAY_MIN;
use crate::family::approaches::MOST_VPH;
use crate::vocabulary::Heading;

/// Minutes of the hour that is simulated.
const HOUR_MIN: u32 = 60;

/// Hours of a leap year.
const HOURS_PER_YEAR: f64 = 8784.0;

/// Minutes of a quarter.
const QUARTER_MIN: u32 = 15;

/// A part of the day whose busiest hour is simulated, such as `am=07:00-09:00` or, with its hours per year,
/// `am=07:00-09:00,500`.
#[derive(Debug, Clone, PartialEq)]
pub struct Period {
    /// Its name.
    pub name: String,
    /// Minute of the day at which it begins.
    pub from_min: u32,
    /// Minute of the day at which it ends.
    pub to_min: u32,
    /// Hours per year for which its busiest hour stands.
    pub hours: Option<f64>,
}

impl FromStr for Period {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (name, rest) = text.split_once('=')?;
            let (times, hours) = rest.split_once(',').map_or((rest, None), |(t, h)| (t, Some(h)));
            let (from, to) = times.split_once('-')?;
            let from_min = minute(from.trim())?;
            let to_min = if to.trim() == "24:00" { DAY_MIN } else { minute(to.trim())? };
            let hours = hours.map(|hours| hours.trim().parse::<f64>().ok());
            let name = name.trim().to_owned();
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            let is_fit = !name.is_empty()
                && name.chars().all(is_plain)
                && to_min >= from_min + HOUR_MIN
                && hours.is_none_or(|hours| hours.is_some_and(|h| h > 0.0 && h <= HOURS_PER_YEAR));
            is_fit.then_some(Self { name, from_min, to_min, hours: hours.flatten() })
        };
        read().ok_or_else(|| {
            "expected NAME=FROM-TO of at least one hour before midnight, such as am=07:00-09:00, or with its hours per year \
             am=07:00-09:00,500; a name consists of letters, digits, - and _"
                .to_owned()
        })
    }
}

/// Returns the minute of the day of a time such as `07:15` or `0715`.
pub(super) fn minute(text: &str) -> Option<u32> {
    let at = text.len().checked_sub(2)?;
    let (hours, minutes) = text.split_once(':').or_else(|| text.split_at_checked(at))?;
    let (hours, minutes): (u32, u32) = (hours.parse().ok()?, minutes.parse().ok()?);
    (hours < 24 && minutes < 60).then_some(60 * hours + minutes)
}

/// Returns a minute of the day as a time.
fn written(minute: u32) -> String {
    format!("{:02}:{:02}", minute / 60, minute % 60)
}

/// One row of a count.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Interval {
    /// Line in its file.
    pub(super) line: u64,
    /// The day, where the table has dates.
    pub(super) day: Option<Date>,
    /// Minute of the day at which it begins; `None` in a table without times.
    pub(super) minute: Option<u32>,
    /// Minutes that it counts, where its time has both ends.
    pub(super) length_min: Option<u32>,
    /// Vehicles by movement; an empty field is missing.
    pub(super) vehicles: BTreeMap<(Heading, Towards), f64>,
    /// Heavy vehicles among them, by approach, where they were counted.
    pub(super) heavy: BTreeMap<Heading, f64>,
    /// People who cross the approach from which vehicles travel so, or any approach.
    pub(super) pedestrians: BTreeMap<Option<Heading>, f64>,
}

/// What was counted in an hour.
#[derive(Debug, Clone, PartialEq)]
pub struct Hour {
    /// Minute of the day at which it begins; `None` for a table without times.
    pub begin_min: Option<u32>,
    /// Days of which it is the mean.
    pub days: usize,
    /// Vehicles per hour by movement.
    pub vehicles: BTreeMap<(Heading, Towards), f64>,
    /// Vehicles in each quarter by approach; nothing where rows do not divide a quarter, and for an approach without
    /// vehicles.
    pub quarters: BTreeMap<Heading, [f64; 4]>,
    /// Share of heavy vehicles by approach.
    pub heavy: BTreeMap<Heading, f64>,
    /// People per hour who cross an approach, by how its vehicles travel; `None`: any approach of the intersection.
    pub pedestrians: BTreeMap<Option<Heading>, f64>,
    /// Whether nothing says how long a row is, so that it is taken for an hour.
    pub is_assumed: bool,
    /// Fields that are empty beside numbers of the same column, and count as nobody.
    pub empty: usize,
    /// Times of the period, such as `08:00 to 08:15`, that have no row between rows of their day: hours with them are not
    /// looked at on that day.
    pub missing: Vec<String>,
}

impl Hour {
    /// Returns the vehicles of all movements.
    pub fn total(&self) -> f64 {
        self.vehicles.values().sum()
    }

    /// Returns the vehicles of an approach that turn so.
    pub fn of(&self, heading: Heading, towards: Towards) -> f64 {
        self.vehicles.get(&(heading, towards)).copied().unwrap_or_default()
    }

    /// Returns the approaches with vehicles.
    pub fn headings(&self) -> BTreeSet<Heading> {
        self.vehicles.iter().filter(|(_, n)| **n > 0.0).map(|((heading, _), _)| *heading).collect()
    }
}

impl Display for Hour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.begin_min {
            None => f.write_str("the hour of the table"),
            Some(minute) => write!(f, "{} to {}", written(minute), written(minute + HOUR_MIN)),
        }
    }
}

/// Why an intersection has no busiest hour: a line and what is wrong there.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Unfit {
    /// No hour of the period is complete.
    NoHour(u64, String),
    /// Rows are wrong.
    Wrong(u64, String),
}

impl From<(u64, String)> for Unfit {
    fn from((line, message): (u64, String)) -> Self {
        Self::Wrong(line, message)
    }
}

/// Returns the busiest hour of an intersection within a period, or of all that was counted.
pub(super) fn busiest(intervals: &[&Interval], period: Option<&Period>) -> Result<Hour, Unfit> {
    let first = *intervals.first().expect("an intersection of a count has a row");
    if intervals.iter().any(|i| i.minute.is_none()) {
        if let Some(second) = intervals.get(1) {
            let message = "a second row of the same intersection, and the table has no column with times; add a column \
                           Time";
            return Err((second.line, message.to_owned()).into());
        }
        if let Some(Period { name, .. }) = period {
            let message =
                format!("the table has no column with times, and the period {name} asks for some");
            return Err((first.line, message).into());
        }
        return Ok(Hour { is_assumed: true, ..sum(&[vec![first]], HOUR_MIN, None) });
    }
    let (from, to) = period.map_or((0, DAY_MIN), |p| (p.from_min, p.to_min));
    let mut by_time: BTreeMap<(Option<Date>, u32), &Interval> = BTreeMap::new();
    for &interval in intervals {
        let key = (interval.day, interval.minute.unwrap_or_default());
        if let Some(other) = by_time.insert(key, interval) {
            let message = format!("the same time as line {}; remove one of the two", other.line);
            return Err((interval.line, message).into());
        }
    }
    let found = step(&by_time)?.or(first.length_min);
    if let Some(row) = intervals.iter().find(|row| row.length_min.is_some_and(|l| Some(l) != found))
    {
        let message = "its time has another length than the time from row to row; give rows that do not overlap, such as \
                       one per quarter hour";
        return Err((row.line, message.to_owned()).into());
    }
    let (is_assumed, step) = (found.is_none(), found.unwrap_or(HOUR_MIN));
    let days: BTreeSet<Option<Date>> = by_time.keys().map(|(day, _)| *day).collect();
    let starts: BTreeSet<u32> = by_time.keys().map(|(_, minute)| *minute).collect();
    let within = starts.into_iter().filter(|start| *start >= from && start + HOUR_MIN <= to);
    let missing = gaps(&by_time, step, (from, to));
    let mut best: Option<Hour> = None;
    for start in within {
        let whole = |day: &Option<Date>| -> Option<Vec<&Interval>> {
            let times = (0..HOUR_MIN / step).map(|k| start + k * step);
            times.map(|minute| by_time.get(&(*day, minute)).copied()).collect()
        };
        let hours: Vec<Vec<&Interval>> = days.iter().filter_map(whole).collect();
        if hours.is_empty() {
            continue;
        }
        let missing = missing.clone();
        let hour = Hour { is_assumed, missing, ..sum(&hours, step, Some(start)) };
        if let Some(((heading, _), vph)) = hour.vehicles.iter().find(|(_, vph)| **vph > MOST_VPH) {
            let message = format!(
                "{vph:.0} vehicles of one {heading} movement in an hour: expected at most {MOST_VPH}; give counts of an hour, \
                 not of a day"
            );
            return Err((hours[0][0].line, message).into());
        }
        if best.as_ref().is_none_or(|best| hour.total() > best.total()) {
            best = Some(hour);
        }
    }
    best.ok_or_else(|| {
        let within = period.map_or_else(String::new, |p| {
            format!(" within {} ({} to {})", p.name, written(p.from_min), written(p.to_min))
        });
        let message = format!(
            "no hour{within} is complete: rows of {step} minutes were counted; add what is missing"
        );
        Unfit::NoHour(first.line, message)
    })
}

/// Returns the times within a part of the day that lack rows, each shorter than an hour: longer ones lie between periods that
/// were counted.
fn gaps(
    by_time: &BTreeMap<(Option<Date>, u32), &Interval>,
    step: u32,
    (from, to): (u32, u32),
) -> Vec<String> {
    let keys: Vec<(Option<Date>, u32)> = by_time.keys().copied().collect();
    let several = keys.first().map(|k| k.0) != keys.last().map(|k| k.0);
    let gap = |pair: &[(Option<Date>, u32)]| {
        let ((day, before), (next_day, next)) = (pair[0], pair[1]);
        let begin = before + step;
        let is_gap = day == next_day && next > begin && next < begin + HOUR_MIN;
        let day = day.filter(|_| several).map_or_else(String::new, |day| format!("{day} "));
        (is_gap && begin < to && next > from)
            .then(|| format!("{day}{} to {}", written(begin), written(next)))
    };
    keys.windows(2).filter_map(gap).collect()
}

/// Returns the minutes of a row, up to an hour: the shortest time between two rows of a day; `None` for a single row.
fn step(by_time: &BTreeMap<(Option<Date>, u32), &Interval>) -> Result<Option<u32>, (u64, String)> {
    let keys: Vec<_> = by_time.iter().collect();
    let steps = || {
        keys.windows(2).filter(|w| w[0].0.0 == w[1].0.0).map(|w| (w[1].0.1 - w[0].0.1, w[1].1.line))
    };
    let Some((step, line)) = steps().min() else { return Ok(None) };
    let step = if step % HOUR_MIN == 0 { HOUR_MIN } else { step };
    if !HOUR_MIN.is_multiple_of(step) {
        return Err((
            line,
            format!(
                "{step} minutes after the row before it, which divide no hour; correct the times"
            ),
        ));
    }
    match steps().find(|(minutes, _)| minutes % step != 0) {
        None => Ok(Some(step)),
        Some((minutes, line)) => Err((
            line,
            format!(
                "{minutes} minutes after the row before it, beside rows of {step} minutes; correct the times"
            ),
        )),
    }
}

/// Returns the mean of the hours of several days.
fn sum(hours: &[Vec<&Interval>], step: u32, begin_min: Option<u32>) -> Hour {
    let days = hours.len();
    let columns: BTreeSet<(Heading, Towards)> =
        hours.iter().flatten().flat_map(|i| i.vehicles.keys().copied()).collect();
    let mut vehicles = BTreeMap::new();
    let mut quarters: BTreeMap<Heading, [f64; 4]> = BTreeMap::new();
    let mut heavy: BTreeMap<Heading, (f64, f64)> = BTreeMap::new();
    let empty = hours.iter().flatten().map(|i| columns.len() - i.vehicles.len()).sum();
    let mut pedestrians: BTreeMap<Option<Heading>, f64> = BTreeMap::new();
    for (heading, count) in hours.iter().flatten().flat_map(|interval| &interval.pedestrians) {
        *pedestrians.entry(*heading).or_default() += count / days as f64;
    }
    for hour in hours {
        for (k, interval) in hour.iter().enumerate() {
            for (&(heading, towards), count) in &interval.vehicles {
                let mean = count / days as f64;
                *vehicles.entry((heading, towards)).or_insert(0.0) += mean;
                if QUARTER_MIN.is_multiple_of(step) {
                    let quarter = k * step as usize / QUARTER_MIN as usize;
                    quarters.entry(heading).or_default()[quarter] += mean;
                }
                if interval.heavy.contains_key(&heading) {
                    heavy.entry(heading).or_default().1 += count;
                }
            }
            for (heading, count) in &interval.heavy {
                heavy.entry(*heading).or_default().0 += count;
            }
        }
    }
    quarters.retain(|_, quarters| quarters.iter().sum::<f64>() > 0.0);
    let heavy = heavy
        .into_iter()
        .filter(|(_, (_, all))| *all > 0.0)
        .map(|(h, (of, all))| (h, of / all))
        .collect();
    Hour {
        begin_min,
        days,
        vehicles,
        quarters,
        heavy,
        pedestrians,
        is_assumed: false,
        empty,
        missing: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Unfit {
        fn into_parts(self) -> (u64, String) {
            match self {
                Self::NoHour(line, message) | Self::Wrong(line, message) => (line, message),
            }
        }
    }

    const NBT: (Heading, Towards) = (Heading::North, Towards::Through);

    fn rows(counts: &[(&str, u32, f64)]) -> Vec<Interval> {
        let row = |(line, (day, minute, count)): (usize, &(&str, u32, f64))| Interval {
            line: line as u64 + 2,
            day: day.parse().ok(),
            minute: Some(*minute),
            vehicles: BTreeMap::from([(NBT, *count)]),
            heavy: BTreeMap::from([(
                Heading::North,
                if *minute < 440 { 0.1 * count } else { 0.0 },
            )]),
            ..Interval::default()
        };
        counts.iter().enumerate().map(row).collect()
    }

    fn busiest(rows: &[Interval], period: Option<&Period>) -> Result<Hour, Unfit> {
        super::busiest(&rows.iter().collect::<Vec<_>>(), period)
    }

    #[test]
    fn the_busiest_hour_begins_at_any_row_and_keeps_its_quarters() {
        let counts = [10.0, 20.0, 40.0, 20.0, 20.0, 5.0];
        let rows = rows(
            &counts
                .iter()
                .enumerate()
                .map(|(k, n)| ("", 420 + 15 * k as u32, *n))
                .collect::<Vec<_>>(),
        );
        let hour = busiest(&rows, None).unwrap();
        assert_eq!((hour.to_string(), hour.total()), ("07:15 to 08:15".to_owned(), 100.0));
        assert_eq!(hour.quarters[&Heading::North], [20.0, 40.0, 20.0, 20.0]);
        assert_eq!(hour.heavy[&Heading::North], 0.02);
        let early: Period = "early=07:00-08:00".parse().unwrap();
        assert_eq!(busiest(&rows, Some(&early)).unwrap().total(), 90.0);
        let night: Period = "night=01:00-04:00,700".parse().unwrap();
        let (line, why) = busiest(&rows, Some(&night)).unwrap_err().into_parts();
        assert!(
            line == 2 && why.starts_with("no hour within night (01:00 to 04:00) is complete"),
            "{why}"
        );
    }

    #[test]
    fn a_row_that_is_missing_between_others_is_said_and_a_pause_between_periods_is_not() {
        let quarter = |k: u32| ("2026-11-03", 420 + 15 * k, f64::from(10 + k));
        let mut counts: Vec<_> = (0..8).filter(|k| *k != 4).map(quarter).collect();
        counts.extend((0..4).map(|k| ("2026-11-03", 960 + 15 * k, 1.0)));
        let hour = busiest(&rows(&counts), None).unwrap();
        assert_eq!(
            (hour.begin_min, &*hour.missing),
            (Some(420), &["08:00 to 08:15".to_owned()][..])
        );
        let evening: Period = "pm=16:00-17:00".parse().unwrap();
        assert!(busiest(&rows(&counts), Some(&evening)).unwrap().missing.is_empty());
        counts.push(("2026-11-04", 420, 1.0));
        let hour = busiest(&rows(&counts), None).unwrap();
        assert_eq!(hour.missing, ["2026-11-03 08:00 to 08:15"]);
    }

    #[test]
    fn days_are_averaged_and_a_day_without_the_whole_hour_does_not_count() {
        let mut counts = vec![
            ("2026-11-03", 420, 100.0),
            ("2026-11-03", 480, 300.0),
            ("2026-11-04", 480, 400.0),
        ];
        let hour = busiest(&rows(&counts), None).unwrap();
        assert_eq!((hour.begin_min, hour.days, hour.total()), (Some(480), 2, 350.0));
        assert!(hour.quarters.is_empty());
        counts.push(("2026-11-04", 480, 1.0));
        assert_eq!(
            busiest(&rows(&counts), None).unwrap_err().into_parts(),
            (5, "the same time as line 4; remove one of the two".into())
        );
    }

    #[test]
    fn an_hour_with_a_hole_is_no_hour() {
        let gap = [("", 420, 9.0), ("", 435, 9.0), ("", 450, 9.0), ("", 480, 9.0)];
        assert!(
            busiest(&rows(&gap), None).unwrap_err().into_parts().1.contains("rows of 15 minutes")
        );
        let mut missing = rows(&[("", 420, 9.0), ("", 435, 9.0), ("", 450, 9.0), ("", 465, 9.0)]);
        missing[2].vehicles.clear();
        let hour = busiest(&missing, None).unwrap();
        assert_eq!((hour.total(), hour.empty), (27.0, 1));
        let odd = [("", 420, 9.0), ("", 437, 9.0)];
        assert!(busiest(&rows(&odd), None).unwrap_err().into_parts().1.contains("17 minutes"));
    }

    #[test]
    fn periods_are_refused_with_what_they_have_to_be() {
        for text in [
            "am", "am=7-9", "am=09:00-07:00", "am=07:00-07:30", "am=07:00-09:00,many",
            "a/b=07:00-09:00",
        ] {
            let e = text.parse::<Period>().unwrap_err();
            assert!(e.starts_with("expected NAME=FROM-TO of at least one hour"), "{text}: {e}");
        }
        let late: Period = "late=22:00-24:00".parse().unwrap();
        assert_eq!((late.from_min, late.to_min, late.hours), (1320, 1440, None));
    }
}
