//! Times at which a turn restriction holds, in the syntax of `opening_hours`
//! (<https://wiki.openstreetmap.org/wiki/Conditional_restrictions>), and whether they hold in the simulated hour.

use chrono::{NaiveDate, NaiveDateTime, NaiveTime};
use opening_hours::OpeningHours;

/// A Tuesday without a holiday, which stands for any working day of the year.
const WORKING_DAY: (i32, u32, u32) = (2025, 10, 14);

/// Minutes of an hour.
const MINUTES: f64 = 60.0;

/// Times at which a restriction holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hours {
    text: String,
}

impl Hours {
    /// Returns the times that a text says; `None` if it says something else, such as a weight.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        text.parse::<OpeningHours>().ok().map(|_| Self { text: text.to_owned() })
    }

    /// Returns whether they hold in the middle of an hour of a working day.
    ///
    /// # Arguments
    ///
    /// * `time_of_day` — when the hour begins, hours after midnight.
    pub fn hold(&self, time_of_day: f64) -> bool {
        let hours = self.text.parse::<OpeningHours>().ok();
        middle(time_of_day).zip(hours).is_some_and(|(at, hours)| hours.is_open(at))
    }
}

/// Returns the middle of an hour of a working day.
fn middle(time_of_day: f64) -> Option<NaiveDateTime> {
    let (year, month, day) = WORKING_DAY;
    let minutes = (time_of_day.rem_euclid(24.0) * MINUTES + MINUTES / 2.0) as u32 % (24 * 60);
    let time = NaiveTime::from_hms_opt(minutes / 60, minutes % 60, 0)?;
    Some(NaiveDate::from_ymd_opt(year, month, day)?.and_time(time))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_hold_on_a_working_day() {
        let at = |text: &str, time_of_day| Hours::parse(text).unwrap().hold(time_of_day);
        let peaks = "Mo-Fr 07:00-09:00,16:00-18:00";
        assert_eq!(
            [7.0, 8.0, 10.0, 16.5, 18.0].map(|t| at(peaks, t)),
            [true, true, false, true, false]
        );
        assert!(at("07:00-23:00", 8.0) && at("Mo-Su 07:00-23:00", 21.0) && at("24/7", 3.0));
        assert!(!at("Sa,Su 07:00-23:00", 8.0));
        assert!(at("22:00-06:00", 0.0) && at("Mo-Fr 06:00-10:00; PH off", 8.0));
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in ["weight>3.5", "Mo-Fr 07:00-09:00 AND weight>3.5", "", "sometimes"] {
            assert_eq!(Hours::parse(text), None, "{text}");
        }
    }
}
