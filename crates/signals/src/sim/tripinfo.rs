//! Reads SUMO's tripinfo output: one row per vehicle, unfinished and never inserted ones included.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::sim::error::SimError;
use basics::files::FileError;

/// What is read of a row.
const FIELDS: [&str; 6] =
    ["depart", "arrival", "departDelay", "waitingTime", "timeLoss", "waitingCount"];

/// What became of all vehicles of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TripTotals {
    /// Vehicles that were to depart before the end, however they fared.
    pub vehicles: u32,
    /// Vehicles that reached their destination.
    pub arrived: u32,
    /// Vehicles on the road at the end.
    pub running: u32,
    /// Vehicles that never found room to enter.
    pub undeparted: u32,
    /// Sum of time losses and departure delays, seconds; for a vehicle that never entered the time
    /// since its scheduled departure.
    pub delay_s: f64,
    /// Sum of the times at less than 0.1 m/s, departure delays excluded, seconds.
    pub waiting_s: f64,
}

/// What became of one vehicle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trip {
    /// SUMO's id.
    pub id: String,
    /// Time loss and departure delay, seconds.
    pub delay_s: f64,
    /// How often it came below 0.1 m/s.
    pub stops: f64,
    /// Whether it reached its destination.
    pub arrived: bool,
}

/// Reads a tripinfo file with all its vehicles.
///
/// Source: RESCO, utils/readXML.py, delay as `timeLoss + departDelay` over all vehicles.
/// Deviation: RESCO derives never-inserted vehicles from the route file and misses them where it
/// holds `<trip>` elements; here SUMO itself lists them (`--tripinfo-output.write-undeparted`).
/// Fails with [`SimError::CutOff`] when the file has no end, [`SimError::Tripinfo`] when it is not XML or lacks an attribute.
pub fn read(path: &Path) -> Result<(TripTotals, Vec<Trip>), SimError> {
    let file = BufReader::new(File::open(path).map_err(FileError::at("read", path))?);
    let mut trips = Vec::new();
    let totals = parse(file, path, &mut |trip| trips.push(trip))?;
    Ok((totals, trips))
}

/// Returns what a tripinfo file holds; the path is for messages.
/// * `each` — told every vehicle.
///
/// Fails as [`read`].
pub fn parse(
    file: impl BufRead,
    path: &Path,
    each: &mut dyn FnMut(Trip),
) -> Result<TripTotals, SimError> {
    let mut reader = Reader::from_reader(file);
    let fail = |reason: String| SimError::Tripinfo { path: path.to_path_buf(), reason };
    let mut totals = TripTotals::default();
    let mut complete = false;
    let mut buffer = Vec::new();
    loop {
        let event = reader.read_event_into(&mut buffer).map_err(|e| match e {
            // The end of the file within a tag.
            quick_xml::Error::Syntax(_) => SimError::CutOff(path.to_path_buf()),
            quick_xml::Error::Io(e) => {
                FileError { action: "read", path: path.into(), reason: std::io::Error::other(e) }
                    .into()
            }
            e => fail(e.to_string()),
        })?;
        match event {
            Event::Start(e) | Event::Empty(e) if e.name().as_ref() == "tripinfo" => {
                each(add(&mut totals, &e).map_err(&fail)?);
            }
            Event::End(e) if e.name().as_ref() == "tripinfos" => complete = true,
            Event::Empty(e) if e.name().as_ref() == "tripinfos" => complete = true,
            Event::Eof => break,
            _ => {}
        }
        buffer.clear();
    }
    if complete { Ok(totals) } else { Err(SimError::CutOff(path.to_path_buf())) }
}

fn add(totals: &mut TripTotals, row: &BytesStart) -> Result<Trip, String> {
    let mut values = [None; FIELDS.len()];
    let mut id = String::new();
    for attribute in row.attributes().with_checks(false) {
        let attribute = attribute.map_err(|e| e.to_string())?;
        let (name, text) = (attribute.key.as_ref(), attribute.value.as_ref());
        if name == "id" {
            text.clone_into(&mut id);
        } else if let Some(field) = FIELDS.iter().position(|field| *field == name) {
            values[field] = Some(text.parse::<f64>().map_err(|e| format!("{text:?}: {e}"))?);
        }
    }
    let get = |field: usize| values[field].ok_or(format!("a row without {}", FIELDS[field]));
    let (depart, arrival) = (get(0)?, get(1)?);
    totals.vehicles += 1;
    let delay_s = get(4)? + get(2)?;
    totals.delay_s += delay_s;
    totals.waiting_s += get(3)?;
    let arrived = depart >= 0.0 && arrival >= 0.0;
    let fate = match depart < 0.0 {
        true => &mut totals.undeparted,
        false if arrived => &mut totals.arrived,
        false => &mut totals.running,
    };
    *fate += 1;
    Ok(Trip { id, delay_s, stops: values[5].unwrap_or_default(), arrived })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<TripTotals, SimError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read(file.path()).map(|(totals, _)| totals)
    }

    #[test]
    fn unfinished_and_never_inserted_vehicles_count() {
        let totals = parsed(
            r#"<tripinfos>
            <tripinfo id="a" depart="1.00" arrival="30.00" departDelay="2.00" waitingTime="3.00" timeLoss="10.00"/>
            <tripinfo id="b" depart="5.00" arrival="-1.00" departDelay="0.00" waitingTime="9.00" timeLoss="20.00"/>
            <tripinfo id="c" depart="-1" arrival="-1.00" departDelay="50.00" waitingTime="0.00" timeLoss="0.00"/>
            </tripinfos>"#,
        )
        .unwrap();
        assert_eq!((totals.arrived, totals.running, totals.undeparted), (1, 1, 1));
        assert_eq!((totals.delay_s, totals.waiting_s), (82.0, 12.0));
    }

    #[test]
    fn a_file_is_cut_off_wherever_it_ends_too_early() {
        let text = "<?xml version=\"1.0\"?>\n\n<!-- by SUMO -->\n<tripinfos a=\"1\">\n    <tripinfo id=\"a\" \
                    depart=\"1.00\" arrival=\"3\" departDelay=\"0\" waitingTime=\"0\" timeLoss=\"1\"/>\n</tripinfos>\n";
        assert_eq!(parsed(text).unwrap().vehicles, 1);
        for length in 0..text.len() - 1 {
            let e = parsed(&text[..length]).unwrap_err();
            assert!(matches!(e, SimError::CutOff(_)), "{length}: {e}");
        }
    }

    #[test]
    fn a_row_that_is_no_row_of_sumo_s_is_refused() {
        for text in ["<tripinfos><tripinfo id=\"a\"/></tripinfos>", "<tripinfos></x></tripinfos>"] {
            assert!(matches!(parsed(text), Err(SimError::Tripinfo { .. })), "{text}");
        }
    }
}
