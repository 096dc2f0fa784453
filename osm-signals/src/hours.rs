//! Times at which a turn restriction holds: one range of days with ranges of hours, such as
//! `Mo-Fr 07:00-09:00,16:00-18:00; PH off`, and whether they hold in the simulated hour of a working day.
//!
//! Source: <https://wiki.openstreetmap.org/wiki/Conditional_restrictions>.

const DAYS: [&str; 7] = ["Mo", "Tu", "We", "Th", "Fr", "Sa", "Su"];

/// A Tuesday stands for any working day, and its night begins on Monday.
const MONDAY: usize = 0;
const TUESDAY: usize = 1;

/// Minutes of a day.
const DAY_MIN: u32 = 24 * 60;

/// Times at which a restriction holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hours {
    /// Whether a range may begin on Monday, and on Tuesday.
    begins: [bool; 2],
    /// Begin and end, minutes after midnight; one that ends before it begins lasts into the next day.
    ranges: Vec<(u32, u32)>,
}

impl Hours {
    /// Returns the times that a text says; `None` if it says something else, such as a weight.
    pub fn parse(text: &str) -> Option<Self> {
        let mut rules = text.split(';').map(str::trim).filter(|r| !matches!(*r, "" | "PH off"));
        let (rule, None) = (rules.next()?, rules.next()) else { return None };
        let rule = if rule == "24/7" { "00:00-24:00" } else { rule };
        let (days, hours) = rule.split_at(rule.find(|c: char| c.is_ascii_digit())?);
        let mut begins = [days.trim().is_empty(); 2];
        for range in days.split(',').map(str::trim).filter(|range| !range.is_empty()) {
            let (first, last) = range.split_once('-').unwrap_or((range, range));
            let is = |day: &str, of| day.get(..2).is_some_and(|d| d.eq_ignore_ascii_case(of));
            let at = |day: &str| DAYS.iter().position(|known| is(day.trim(), known));
            let (first, last) = (at(first)?, at(last)?);
            let after = |day: usize| (day + DAYS.len() - first) % DAYS.len();
            for (begins, day) in begins.iter_mut().zip([MONDAY, TUESDAY]) {
                *begins |= after(day) <= after(last);
            }
        }
        let ranges = hours.split(',').map(|range| {
            let (begin, end) = range.trim().split_once('-')?;
            Some((minute(begin)?, minute(end)?))
        });
        Some(Self { begins, ranges: ranges.collect::<Option<_>>()? })
    }

    /// Returns whether they hold in the middle of an hour of a working day.
    ///
    /// # Arguments
    ///
    /// * `time_of_day` — when the hour begins, hours after midnight.
    pub fn hold(&self, time_of_day: f64) -> bool {
        let now = (time_of_day.rem_euclid(24.0) * 60.0 + 30.0) as u32 % DAY_MIN;
        let [monday, tuesday] = self.begins;
        self.ranges.iter().any(|(begin, end)| match begin < end {
            true => tuesday && (*begin..*end).contains(&now),
            false => (tuesday && now >= *begin) || (monday && now < *end),
        })
    }
}

/// Returns the minute that a time such as `07:30` is.
fn minute(time: &str) -> Option<u32> {
    let (hour, minute) = time.trim().split_once(':')?;
    let minute = 60 * hour.parse::<u32>().ok()? + minute.parse::<u32>().ok().filter(|m| *m < 60)?;
    (minute <= DAY_MIN).then_some(minute)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_hold_on_a_working_day() {
        for (text, hours) in [
            ("Mo-Fr 07:00-09:00,16:00-18:00", &[7.0, 8.0, 16.5][..]),
            ("07:00-23:00", &[7.0, 8.0, 10.0, 16.5, 18.0]),
            ("Sa,Su 07:00-23:00", &[]),
            ("24/7", &[3.0, 7.0, 8.0, 10.0, 16.5, 18.0]),
            ("22:00-06:00", &[3.0]),
            ("Su-Mo 22:00-06:00", &[3.0]),
            ("Fr-Tu 06:00-10:00; PH off", &[7.0, 8.0]),
        ] {
            let parsed = Hours::parse(text).unwrap();
            let held = [3.0, 7.0, 8.0, 10.0, 16.5, 18.0].into_iter().filter(|t| parsed.hold(*t));
            assert_eq!(held.collect::<Vec<_>>(), hours, "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_none() {
        let weight = "Mo-Fr 07:00-09:00 AND weight>3.5";
        for text in ["weight>3.5", weight, "", "sometimes", "Mo-Fr 07:00-09:00; Sa 08:00-09:00"] {
            assert_eq!(Hours::parse(text), None, "{text}");
        }
    }
}
