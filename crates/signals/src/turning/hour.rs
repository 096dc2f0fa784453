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
use crate::family::approaches::MOST_VPH;
use crate::vocabulary::Heading;

/// Minutes of the hour that is simulated, and of a day.
const HOUR_MIN: u32 = 60;
pub(super) const DAY_MIN: u32 = 1440;

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

impl Display for Period {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} to {})", self.name, written(self.from_min), written(self.to_min))
    }
}

/// Returns the minute of the day of a time such as `07:15` or `0715`.
fn minute(text: &str) -> Option<u32> {
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
    /// Vehicles by movement; an empty field is missing.
    pub(super) vehicles: BTreeMap<(Heading, Towards), f64>,
    /// Heavy vehicles among them, by approach, where they were counted.
    pub(super) heavy: BTreeMap<Heading, f64>,
    /// People who cross the approach from which vehicles travel so, or any approach.
    pub(super) pedestrians: BTreeMap<Option<Heading>, f64>,
}

/// What was counted in an hour.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Hour {
    /// Minute of the day at which it begins; `None` for a table without times.
    pub(super) begin_min: Option<u32>,
    /// Days of which it is the mean.
    pub(super) days: usize,
    /// Vehicles per hour by movement.
    pub(super) vehicles: BTreeMap<(Heading, Towards), f64>,
    /// Vehicles in each quarter by approach; nothing where rows do not divide a quarter, and for an approach without
    /// vehicles.
    pub(super) quarters: BTreeMap<Heading, [f64; 4]>,
    /// Share of heavy vehicles by approach.
    pub(super) heavy: BTreeMap<Heading, f64>,
    /// People per hour who cross an approach, by how its vehicles travel; `None`: any approach of the intersection.
    pub(super) pedestrians: BTreeMap<Option<Heading>, f64>,
    /// Whether nothing says how long a row is, so that it is taken for an hour.
    pub(super) is_assumed: bool,
    /// Lines with fields that are empty beside numbers of the same column, and count as nobody.
    pub(super) empty: Vec<u64>,
}

impl Hour {
    /// Returns the vehicles of all movements.
    pub(super) fn total(&self) -> f64 {
        self.vehicles.values().sum()
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

/// Returns the busiest hour of an intersection within a period, or of all that was counted; `None` if none there is complete.
/// The error is a line and what is wrong in it.
pub(super) fn busiest(
    intervals: &[&Interval],
    period: Option<&Period>,
) -> Result<Option<Hour>, (u64, String)> {
    let first = *intervals.first().expect("an intersection of a count has a row");
    if intervals.iter().any(|i| i.minute.is_none()) {
        let line = match (intervals.get(1), period) {
            (Some(second), _) => second.line,
            (None, Some(_)) => first.line,
            (None, None) => {
                let hour = sum(&[vec![first]], HOUR_MIN, None);
                return Ok(Some(Hour { is_assumed: true, ..hour }));
            }
        };
        let message = "several rows of one intersection, and periods, need a column Time";
        return Err((line, message.to_owned()));
    }
    let mut by_time: BTreeMap<(Option<Date>, u32), &Interval> = BTreeMap::new();
    for &interval in intervals {
        let key = (interval.day, interval.minute.unwrap_or_default());
        if let Some(other) = by_time.insert(key, interval) {
            let message = format!("the same time as line {}; remove one of the two", other.line);
            return Err((interval.line, message));
        }
    }
    let found = step(&by_time)?;
    let (is_assumed, step) = (found.is_none(), found.unwrap_or(HOUR_MIN));
    let days: BTreeSet<Option<Date>> = by_time.keys().map(|(day, _)| *day).collect();
    let starts: BTreeSet<u32> = by_time.keys().map(|(_, minute)| *minute).collect();
    let (from, to) = period.map_or((0, DAY_MIN), |p| (p.from_min, p.to_min));
    let mut best: Option<Hour> = None;
    for start in starts.into_iter().filter(|start| *start >= from && start + HOUR_MIN <= to) {
        let whole = |day: &Option<Date>| -> Option<Vec<&Interval>> {
            let times = (0..HOUR_MIN / step).map(|k| start + k * step);
            times.map(|minute| by_time.get(&(*day, minute)).copied()).collect()
        };
        let hours: Vec<Vec<&Interval>> = days.iter().filter_map(whole).collect();
        if hours.is_empty() {
            continue;
        }
        let hour = sum(&hours, step, Some(start));
        if let Some(((heading, _), vph)) = hour.vehicles.iter().find(|(_, vph)| **vph > MOST_VPH) {
            let message = format!(
                "{vph:.0} vehicles of one {heading} movement in an hour: expected at most {MOST_VPH}; give counts of an hour, \
                 not of a day"
            );
            return Err((hours[0][0].line, message));
        }
        if best.as_ref().is_none_or(|best| hour.total() > best.total()) {
            best = Some(hour);
        }
    }
    Ok(best.map(|hour| Hour { is_assumed, ..hour }))
}

/// Returns the minutes of a row, up to an hour: the shortest time between two rows of a day; `None` for a single row.
fn step(by_time: &BTreeMap<(Option<Date>, u32), &Interval>) -> Result<Option<u32>, (u64, String)> {
    let keys: Vec<_> = by_time.iter().collect();
    let steps = || {
        keys.windows(2).filter(|w| w[0].0.0 == w[1].0.0).map(|w| (w[1].0.1 - w[0].0.1, w[1].1.line))
    };
    let Some((shortest, line)) = steps().min() else { return Ok(None) };
    let step = if shortest % HOUR_MIN == 0 { HOUR_MIN } else { shortest };
    let uneven = steps().find(|(minutes, _)| minutes % step != 0);
    match uneven.or((!HOUR_MIN.is_multiple_of(step)).then_some((step, line))) {
        None => Ok(Some(step)),
        Some((minutes, line)) => Err((
            line,
            format!(
                "{minutes} minutes after the row before it: expected rows of equal length that divide an hour"
            ),
        )),
    }
}

/// Returns the mean of the hours of several days.
fn sum(hours: &[Vec<&Interval>], step: u32, begin_min: Option<u32>) -> Hour {
    let days = hours.len();
    let intervals = || hours.iter().flatten();
    let columns: BTreeSet<_> = intervals().flat_map(|i| i.vehicles.keys()).collect();
    let empty = intervals().filter(|i| i.vehicles.len() < columns.len()).map(|i| i.line).collect();
    let mut hour = Hour { begin_min, days, empty, ..Hour::default() };
    let mut heavy: BTreeMap<Heading, (f64, f64)> = BTreeMap::new();
    for (heading, count) in intervals().flat_map(|interval| &interval.pedestrians) {
        *hour.pedestrians.entry(*heading).or_default() += count / days as f64;
    }
    for (k, interval) in hours.iter().flat_map(|hour| hour.iter().enumerate()) {
        for (&(heading, towards), count) in &interval.vehicles {
            let mean = count / days as f64;
            *hour.vehicles.entry((heading, towards)).or_insert(0.0) += mean;
            if QUARTER_MIN.is_multiple_of(step) {
                let quarter = k * step as usize / QUARTER_MIN as usize;
                hour.quarters.entry(heading).or_default()[quarter] += mean;
            }
            if interval.heavy.contains_key(&heading) {
                heavy.entry(heading).or_default().1 += count;
            }
        }
        for (heading, count) in &interval.heavy {
            heavy.entry(*heading).or_default().0 += count;
        }
    }
    hour.quarters.retain(|_, quarters| quarters.iter().sum::<f64>() > 0.0);
    let counted = heavy.into_iter().filter(|(_, (_, all))| *all > 0.0);
    hour.heavy = counted.map(|(heading, (of, all))| (heading, of / all)).collect();
    hour
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn busiest(rows: &[Interval], period: Option<&Period>) -> Result<Option<Hour>, (u64, String)> {
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
        let hour = busiest(&rows, None).unwrap().unwrap();
        assert_eq!((hour.to_string(), hour.total()), ("07:15 to 08:15".to_owned(), 100.0));
        assert_eq!(hour.quarters[&Heading::North], [20.0, 40.0, 20.0, 20.0]);
        assert_eq!(hour.heavy[&Heading::North], 0.02);
        let early: Period = "early=07:00-08:00".parse().unwrap();
        assert_eq!(busiest(&rows, Some(&early)).unwrap().unwrap().total(), 90.0);
        let night: Period = "night=01:00-04:00,700".parse().unwrap();
        assert_eq!(busiest(&rows, Some(&night)), Ok(None));
    }

    #[test]
    fn days_are_averaged_and_a_day_without_the_whole_hour_does_not_count() {
        let mut counts = vec![
            ("2026-11-03", 420, 100.0),
            ("2026-11-03", 480, 300.0),
            ("2026-11-04", 480, 400.0),
        ];
        let hour = busiest(&rows(&counts), None).unwrap().unwrap();
        assert_eq!((hour.begin_min, hour.days, hour.total()), (Some(480), 2, 350.0));
        assert!(hour.quarters.is_empty());
        counts.push(("2026-11-04", 480, 1.0));
        assert_eq!(
            busiest(&rows(&counts), None).unwrap_err(),
            (5, "the same time as line 4; remove one of the two".into())
        );
    }

    #[test]
    fn an_hour_with_a_hole_is_no_hour() {
        let gap = [("", 420, 9.0), ("", 435, 9.0), ("", 450, 9.0), ("", 480, 9.0)];
        assert_eq!(busiest(&rows(&gap), None), Ok(None));
        let mut missing = rows(&[("", 420, 9.0), ("", 435, 9.0), ("", 450, 9.0), ("", 465, 9.0)]);
        missing[2].vehicles.clear();
        let hour = busiest(&missing, None).unwrap().unwrap();
        assert_eq!((hour.total(), hour.empty), (27.0, vec![4]));
        let odd = [("", 420, 9.0), ("", 437, 9.0)];
        assert!(busiest(&rows(&odd), None).unwrap_err().1.contains("17 minutes"));
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
