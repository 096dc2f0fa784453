//! One file of a scenario, looked through before SUMO reads it: which files it names, what a private copy has in place of
//! what it would write, and what stands in the way.
//!
//! Networks, routes and additional files name further files: `<include href>` anywhere, a rerouter or a
//! speed sign its `file`. These are followed. Whatever else names a file is an output: detectors, edge data, probes, states
//! of signals, devices of single vehicles. SUMO gets a copy in which it goes nowhere (`NUL`). A file that
//! could hide a name is in the way: one with a document type and its entities, or in an encoding in which the
//! characters of XML are not those of ASCII.
//!
//! What would make runs of methods something else than runs of methods is found here too, because it stands
//! in the same files: programs that change by the clock, and what adds or removes vehicles depending on traffic.
//!
//! Source: what `sumo` 1.15 opens, tried, and its list of attributes.

mod found;
mod look;

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

pub use self::found::{Edit, Named, Scanned};

use self::found::Found;
use self::look::Look;
use super::obstacle::{Obstacle, Way};
use basics::files::FileError;

/// Most bytes of an element or of the text between two.
const ROOM: usize = 1 << 26;

/// Most elements within each other; SUMO's files have a handful.
const DEEP: usize = 1000;

/// Stands for every byte that is not ASCII; no XML may have it.
const OTHER: u8 = 0x1a;

/// Encodings whose first half is ASCII, by how their names begin.
const ENCODINGS: [&str; 5] = ["utf-8", "us-ascii", "ascii", "iso-8859", "windows-125"];

/// What switches signals to another program by the clock, whatever a method has installed.
const SWITCHES: [&str; 2] = ["WAUT", "wautJunction"];

/// Bytes with [`OTHER`] in place of what is not ASCII, so many at most until the room is renewed.
struct Ascii(Box<dyn BufRead>, Rc<Cell<usize>>);

impl Read for Ascii {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(buffer)?;
        let Some(room) = self.1.get().checked_sub(count) else {
            return Err(io::Error::other("one element or text of more than 64 MiB; shorten it"));
        };
        self.1.set(room);
        if buffer[..count].contains(&0) {
            return Err(io::Error::other("it has null bytes; save it as UTF-8"));
        }
        buffer[..count].iter_mut().filter(|b| !b.is_ascii()).for_each(|b| *b = OTHER);
        Ok(count)
    }
}

/// Looks through a file.
///
/// # Arguments
///
/// * `path` — for messages.
/// * `opened` — its content, from the beginning.
///
/// # Errors
///
/// [`FileError`] when it cannot be opened.
pub fn scan(
    path: &Path,
    opened: &dyn Fn() -> Result<Box<dyn BufRead>, FileError>,
) -> Result<Scanned, FileError> {
    let room = Rc::new(Cell::new(ROOM));
    let mut reader = Reader::from_reader(BufReader::new(Ascii(opened()?, Rc::clone(&room))));
    let mut buffer = Vec::new();
    let mut look = Look::default();
    let (mut depth, mut switch) = (0_usize, None);
    loop {
        let begin = reader.buffer_position();
        let (event, end) = (reader.read_event_into(&mut buffer), reader.buffer_position());
        let stop = match event {
            Ok(Event::Eof) => break,
            Ok(Event::Start(element)) => {
                depth += 1;
                if switch.is_none() && is_switch(&element) {
                    switch = Some((depth, begin));
                }
                look.element(&element, begin);
                (depth > DEEP).then(|| format!("elements within each other, more than {DEEP} deep"))
            }
            Ok(Event::Empty(element)) => {
                if switch.is_none() && is_switch(&element) {
                    look.scanned.day_plan.push(begin..end);
                }
                look.element(&element, begin);
                None
            }
            Ok(Event::End(_)) => {
                if let Some((_, start)) = switch.filter(|(at, _)| *at == depth) {
                    look.scanned.day_plan.push(start..end);
                    switch = None;
                }
                depth = depth.saturating_sub(1);
                None
            }
            Ok(Event::DocType(_)) => {
                Some("a <!DOCTYPE> can draw other files in; remove it".to_owned())
            }
            Ok(Event::Decl(declaration)) => match declaration.encoding() {
                Some(Ok(name)) => encoding(&name),
                _ => None,
            },
            Ok(_) => None,
            Err(e) => Some(format!("it is not XML that can be read: {e}")),
        };
        if let Some(reason) = stop {
            look.blocked(end, reason, Way::Change(""));
            break;
        }
        buffer.clear();
        room.set(ROOM);
    }
    let mut positions: Vec<u64> = look.found.iter().map(|found| found.position).collect();
    positions.extend(look.output);
    positions.sort_unstable();
    let lines = lines(opened()?, &positions);
    let at = |position: u64| {
        let line = positions.binary_search(&position).map_or(0, |at| lines[at]);
        format!("{}: line {line}", path.display())
    };
    let Look { mut scanned, found, outputs, output, first_output } = look;
    for Found { position, mut reason, way, count } in found {
        let place = at(position);
        if count > 1 {
            reason = format!("{reason} ({count} of the kind)");
        }
        match way {
            Some(way) => scanned.obstacles.push(Obstacle { place, reason, way }),
            None => scanned.notes.push(format!("{place}: {reason}")),
        }
    }
    scanned.outputs = output.map(|position| (outputs, format!("{}, {first_output}", at(position))));
    Ok(scanned)
}

fn is_switch(element: &BytesStart<'_>) -> bool {
    SWITCHES.contains(&element.local_name().as_ref())
}

/// Returns the numbers of the lines at ascending positions; those that cannot be read any more are of the last line.
fn lines(file: Box<dyn BufRead>, positions: &[u64]) -> Vec<usize> {
    let (mut lines, mut line, mut before) = (Vec::new(), 1, 0_u8);
    let mut left = positions.iter().peekable();
    if left.peek().is_none() {
        return lines;
    }
    for (at, byte) in (0_u64..).zip(file.bytes().map_while(Result::ok)) {
        while left.next_if(|position| **position <= at).is_some() {
            lines.push(line);
        }
        if left.peek().is_none() {
            return lines;
        }
        line += usize::from(byte == b'\r' || byte == b'\n' && before != b'\r');
        before = byte;
    }
    lines.resize(positions.len(), line);
    lines
}

/// Says why the characters of an encoding may hide a name.
fn encoding(name: &str) -> Option<String> {
    let name = name.to_lowercase();
    match ENCODINGS.iter().any(|known| name.starts_with(known)) {
        true => None,
        false => Some(format!("encoding {name:?}; save it as UTF-8")),
    }
}
