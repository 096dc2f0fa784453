//! Tables of what was written of an episode, as tools that read logs of controllers take them.
//!
//! Columns and functions of detectors are those of the Python package `atspm` (its `raw_data` and `detector_config`).

use std::iter;

use jiff::civil::{Date, DateTime, Time};
use jiff::{Span, ToSpan};

use super::env::high_resolution::Recording;
use basics::files::lines;

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
    let header = ["TimeStamp", "DeviceId", "EventId", "Parameter"].map(str::to_owned);
    let rows = recording.events.iter().map(|event| {
        let (code, parameter) = (event.code.to_string(), event.parameter.to_string());
        [stamp(start, event.at_ds), device(event.signal), code, parameter]
    });
    lines(&iter::once(header).chain(rows).collect::<Vec<_>>())
}

/// Returns the detectors: `DeviceId`, `Phase`, `Parameter` (the channel), `Function`, and where they are.
pub fn detectors(recording: &Recording) -> Vec<u8> {
    let header = [
        "DeviceId", "Phase", "Parameter", "Function", "signal", "lane", "movements", "distance_m",
        "length_m",
    ];
    let rows = recording.detectors.iter().map(|detector| {
        [
            device(detector.signal),
            detector.phase.to_string(),
            detector.channel.to_string(),
            detector.function.name().to_owned(),
            recording.signals[detector.signal].clone(),
            detector.lane.clone(),
            detector.movements.join(" "),
            rounded(detector.distance_m).to_string(),
            rounded(detector.length_m).to_string(),
        ]
    });
    lines(&iter::once(header.map(str::to_owned)).chain(rows).collect::<Vec<_>>())
}

/// Returns the phases: `DeviceId`, `Phase`, `signal`, `movements`.
pub fn phases(recording: &Recording) -> Vec<u8> {
    let header = ["DeviceId", "Phase", "signal", "movements"].map(str::to_owned);
    let rows = recording.phases.iter().map(|phase| {
        let signal = recording.signals[phase.signal].clone();
        [device(phase.signal), phase.number.to_string(), signal, phase.movements.join(" ")]
    });
    lines(&iter::once(header).chain(rows).collect::<Vec<_>>())
}

/// Returns the number of a signal as a device, from 1.
fn device(signal: usize) -> String {
    (signal + 1).to_string()
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
