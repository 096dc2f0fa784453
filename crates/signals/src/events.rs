//! Tables of what was written of an episode, as tools that read logs of controllers take them.
//!
//! Columns and functions of detectors are those of the Python package `atspm` (its `raw_data` and `detector_config`).

use jiff::civil::{Date, DateTime, Time};
use jiff::{Span, ToSpan};

use super::env::high_resolution::Recording;
use basics::files::Lines;

/// Milliseconds in a tenth of a second.
const MS_PER_DS: i64 = 100;

/// Reads when simulated time is 0: a day, or a day and a time.
///
/// # Errors
///
/// What is expected.
pub fn start(text: &str) -> Result<DateTime, String> {
    let expected =
        || format!("expected a day, such as 2026-01-31, or \"2026-01-31 07:00\", not {text:?}");
    let (day, time) = text.split_once([' ', 'T']).unwrap_or((text, "00:00"));
    let day: Date = day.parse().map_err(|_| expected())?;
    let time: Time = time.parse().map_err(|_| expected())?;
    let is_usual = (1970..=2200).contains(&day.year());
    is_usual.then(|| day.to_datetime(time)).ok_or_else(expected)
}

fn stamp(start: DateTime, at_ds: i64) -> String {
    let span: Span = (at_ds * MS_PER_DS).milliseconds();
    let at = start.saturating_add(span);
    at.strftime("%Y-%m-%d %H:%M:%S.%1f").to_string()
}

/// Returns the events: `TimeStamp`, `DeviceId`, `EventId`, `Parameter`.
///
/// # Arguments
///
/// * `start` — when simulated time is 0.
pub fn events(recording: &Recording, start: DateTime) -> Vec<u8> {
    let mut lines = Lines::default();
    ["TimeStamp", "DeviceId", "EventId", "Parameter"].iter().for_each(|name| lines.text(name));
    lines.end();
    for event in &recording.events {
        lines.text(&stamp(start, event.at_ds));
        lines.whole(device(event.signal));
        lines.whole(event.code.into());
        lines.whole(event.parameter.into());
        lines.end();
    }
    lines.into_bytes()
}

/// Returns the detectors: `DeviceId`, `Phase`, `Parameter` (the channel), `Function`, and where they are.
pub fn detectors(recording: &Recording) -> Vec<u8> {
    let mut lines = Lines::default();
    let names = [
        "DeviceId", "Phase", "Parameter", "Function", "signal", "lane", "movements", "distance_m",
        "length_m",
    ];
    names.iter().for_each(|name| lines.text(name));
    lines.end();
    for detector in &recording.detectors {
        lines.whole(device(detector.signal));
        lines.whole(detector.phase.into());
        lines.whole(detector.channel.into());
        lines.text(detector.function.name());
        lines.text(&recording.signals[detector.signal]);
        lines.text(&detector.lane);
        lines.text(&detector.movements.join(" "));
        lines.number(Some(rounded(detector.distance_m)));
        lines.number(Some(rounded(detector.length_m)));
        lines.end();
    }
    lines.into_bytes()
}

/// Returns the phases: `DeviceId`, `Phase`, `signal`, `movements`.
pub fn phases(recording: &Recording) -> Vec<u8> {
    let mut lines = Lines::default();
    ["DeviceId", "Phase", "signal", "movements"].iter().for_each(|name| lines.text(name));
    lines.end();
    for phase in &recording.phases {
        lines.whole(device(phase.signal));
        lines.whole(phase.number.into());
        lines.text(&recording.signals[phase.signal]);
        lines.text(&phase.movements.join(" "));
        lines.end();
    }
    lines.into_bytes()
}

/// Returns the number of a signal as a device, from 1.
fn device(signal: usize) -> u64 {
    signal as u64 + 1
}

fn rounded(metres: f64) -> f64 {
    (metres * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::super::env::high_resolution::{DetectorSpec, Event, Function, PhaseSpec};
    use super::*;

    #[test]
    fn tables_have_the_columns_of_atspm() {
        let detector = DetectorSpec {
            signal: 0,
            channel: 2,
            function: Function::Advance,
            phase: 6,
            lane: "n_0".into(),
            movements: vec!["SBT".into(), "SBR".into()],
            distance_m: 99.96,
            length_m: 0.0,
        };
        let recording = Recording {
            programs: Vec::new(),
            signals: vec!["c".into()],
            events: vec![Event { at_ds: 36_001, signal: 0, code: 82, parameter: 2 }],
            detectors: vec![detector],
            phases: vec![PhaseSpec { signal: 0, number: 6, movements: vec!["SBT".into()] }],
        };
        let text = |bytes| String::from_utf8(bytes).unwrap();
        assert_eq!(
            text(events(&recording, start("2026-01-31 07:00").unwrap())),
            "TimeStamp,DeviceId,EventId,Parameter\n2026-01-31 08:00:00.1,1,82,2\n"
        );
        let row = "1,6,2,Advance,c,n_0,SBT SBR,100,0\n";
        assert!(text(detectors(&recording)).ends_with(row));
        assert_eq!(text(phases(&recording)), "DeviceId,Phase,signal,movements\n1,6,c,SBT\n");
    }

    #[test]
    fn what_is_no_day_is_refused() {
        assert!(start("2026-01-31").is_ok());
        for text in ["07:00", "31.1.2026", "2026-02-30", "1-1-1", ""] {
            assert!(start(text).unwrap_err().starts_with("expected a day"), "{text}");
        }
    }
}
