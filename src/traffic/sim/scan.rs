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

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::departures::Departures;
use super::obstacle::{Accept, Obstacle, Way};
use crate::files::FileError;

/// Most bytes of an element or of the text between two.
const ROOM: usize = 1 << 26;

/// Most elements within each other; SUMO's files have a handful.
const DEEP: usize = 1000;

/// Most obstacles of a file that are named.
const NAMED: usize = 20;

/// Stands for every byte that is not ASCII; no XML may have it.
const OTHER: u8 = 0x1a;

/// Encodings whose first half is ASCII, by how their names begin.
const ENCODINGS: [&str; 5] = ["utf-8", "us-ascii", "ascii", "iso-8859", "windows-125"];

/// Files that swallow what is written.
const NOWHERE: [&str; 3] = ["NUL", "nul", "/dev/null"];

/// Pictures, which only SUMO's window reads.
const PICTURES: [&str; 2] = ["imgFile", "osgFile"];

/// What reads a file of its own.
const READERS: [&str; 2] = ["rerouter", "variableSpeedSign"];

/// What switches signals to another program by the clock, whatever a method has installed.
const SWITCHES: [&str; 2] = ["WAUT", "wautJunction"];

/// What adds or removes vehicles as traffic is.
const CHANGERS: [&str; 2] = ["calibrator", "vaporizer"];

/// Emission class in place of one whose tables are no part of what is hashed: SUMO's default.
const EMISSION_CLASS: &str = "HBEFA3/PC_G_EU4";

/// A name of a file, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// The name as it is written.
    pub name: String,
    /// Its bytes.
    pub at: Range<u64>,
}

/// What a private copy has in place of some bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Edit {
    /// The bytes.
    pub at: Range<u64>,
    /// What stands there instead.
    pub with: String,
}

/// What is found in a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scanned {
    /// The files that it names.
    pub named: Vec<Named>,
    /// What a private copy has otherwise.
    pub edits: Vec<Edit>,
    /// Elements that switch programs by the clock.
    pub day_plan: Vec<Range<u64>>,
    /// What stands in the way.
    pub obstacles: Vec<Obstacle>,
    /// What goes nowhere, where something does: how many outputs, and the first one with its place.
    pub outputs: Option<(u32, String)>,
    /// What counts in place of what it says, in words.
    pub notes: Vec<String>,
    /// Latest departure, seconds.
    pub last_s: Option<f64>,
    /// Vehicles that SUMO leaves out for their place in the file, and what is said of the first.
    pub left_out: Option<(u32, String)>,
}

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

/// Something of a file before its line is known.
struct Found {
    position: u64,
    reason: String,
    way: Option<Way>,
}

/// Looks through a file.
///
/// # Arguments
///
/// * `path` — for messages.
/// * `opened` — its content, from the beginning.
/// * `is_route_file` — whether SUMO reads it as time goes on, so that its vehicles have to be in order.
///
/// # Errors
///
/// [`FileError`] when it cannot be opened.
pub fn scan(
    path: &Path,
    opened: &dyn Fn() -> Result<Box<dyn BufRead>, FileError>,
    is_route_file: bool,
) -> Result<Scanned, FileError> {
    let room = Rc::new(Cell::new(ROOM));
    let mut reader = Reader::from_reader(BufReader::new(Ascii(opened()?, Rc::clone(&room))));
    let mut buffer = Vec::new();
    let mut look = Look { departures: Departures::new(is_route_file), ..Look::default() };
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
    positions.extend(look.late);
    positions.sort_unstable();
    let lines = lines(opened()?, &positions);
    let at = |position: u64| {
        let line = positions.binary_search(&position).map_or(0, |at| lines[at]);
        format!("{}: line {line}", path.display())
    };
    let Look { mut scanned, found, departures, outputs, output, first_output, late, more, .. } =
        look;
    for Found { position, reason, way } in found {
        let place = at(position);
        match way {
            Some(way) => scanned.obstacles.push(Obstacle { place, reason, way }),
            None => scanned.notes.push(format!("{place}: {reason}")),
        }
    }
    if more > 0 {
        let reason = format!("{more} more of the kind");
        let place = path.display().to_string();
        scanned.obstacles.push(Obstacle { place, reason, way: Way::Change("") });
    }
    scanned.outputs = output.map(|position| (outputs, format!("{}, {first_output}", at(position))));
    scanned.last_s = departures.last_s();
    let first = departures.first_left_out().zip(late);
    scanned.left_out =
        first.map(|(said, position)| (departures.left_out(), format!("{}, {said}", at(position))));
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

/// What was found so far.
#[derive(Default)]
struct Look {
    scanned: Scanned,
    found: Vec<Found>,
    /// Obstacles that are not named.
    more: usize,
    departures: Departures,
    /// Where the first vehicle stands that SUMO leaves out.
    late: Option<u64>,
    outputs: u32,
    /// Where the first output stands.
    output: Option<u64>,
    first_output: String,
}

impl Look {
    fn blocked(&mut self, position: u64, reason: String, way: Way) {
        let obstacles = self.found.iter().filter(|found| found.way.is_some()).count();
        match obstacles < NAMED {
            true => self.found.push(Found { position, reason, way: Some(way) }),
            false => self.more += 1,
        }
    }

    fn noted(&mut self, position: u64, reason: String) {
        self.found.push(Found { position, reason, way: None });
    }

    /// Has a value go nowhere.
    fn output(&mut self, position: u64, at: Option<Range<u64>>, what: String) {
        self.outputs += 1;
        if self.output.is_none() {
            (self.output, self.first_output) = (Some(position), what);
        }
        self.edit(position, at, NOWHERE[0].to_owned());
    }

    fn edit(&mut self, position: u64, at: Option<Range<u64>>, with: String) {
        match at {
            Some(at) => self.scanned.edits.push(Edit { at, with }),
            None => {
                let reason = "an attribute that cannot be replaced".to_owned();
                self.blocked(position, reason, Way::Change("write it plainly"));
            }
        }
    }

    /// Looks at an element that begins at a position.
    fn element(&mut self, element: &BytesStart<'_>, position: u64) {
        let tag = element.local_name().as_ref().to_owned();
        if CHANGERS.contains(&tag.as_str()) {
            let reason = format!(
                "<{tag}> adds or removes vehicles, under each method others, so that their delays are of other vehicles"
            );
            self.blocked(position, reason, Way::Accept(Accept::Calibrators));
        }
        let mut attributes = Vec::new();
        for attribute in element.attributes() {
            let read = attribute.map_err(|e| e.to_string()).and_then(|attribute| {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0);
                let value = value.map_err(|e| e.to_string())?.into_owned();
                let name = attribute.key.local_name().as_ref().to_owned();
                let whole = within(element, attribute.key.as_ref(), position)
                    .zip(within(element, &attribute.value, position))
                    .map(|(key, value)| key.start..value.end + 1);
                Ok(Attribute {
                    name,
                    value,
                    at: within(element, &attribute.value, position),
                    whole,
                })
            });
            match read {
                Ok(attribute) => attributes.push(attribute),
                Err(e) => return self.blocked(position, e, Way::Change("")),
            }
        }
        if self.departures.next(&tag, &|wanted| {
            attributes.iter().find(|a| a.name == wanted).map(|a| a.value.as_str())
        }) {
            self.late.get_or_insert(position);
        }
        if tag == "param" {
            return self.parameter(position, &attributes);
        }
        for attribute in attributes {
            self.attribute(position, &tag, attribute);
        }
    }

    fn attribute(&mut self, position: u64, tag: &str, attribute: Attribute) {
        let Attribute { name, value, at, whole } = attribute;
        if PICTURES.contains(&name.as_str()) || NOWHERE.contains(&value.as_str()) {
            return;
        }
        let is_input =
            (tag == "include" && name == "href") || (READERS.contains(&tag) && name == "file");
        let shown = format!("<{tag} {name}=\"{}\">", value.replace('\u{1a}', "?"));
        if is_input {
            // A reference such as `&#252;` is a character beyond ASCII too, which SUMO writes as the machine's locale has it.
            let plain = value.bytes().all(|b| b.is_ascii() && !b.is_ascii_control());
            match at.filter(|_| !value.is_empty() && !value.contains("${") && plain) {
                Some(at) => self.scanned.named.push(Named { name: value, at }),
                None => {
                    let way = Way::Change("give the name of a file in ASCII");
                    self.blocked(position, shown, way);
                }
            }
        } else if name == "href" || name.starts_with("commandPosix") {
            let reason = format!("{shown} is none that is followed");
            self.blocked(position, reason, Way::Change("remove it"));
        } else if name == "edgesFile" {
            // A list of edges whose figures are written, which are not.
            self.outputs += 1;
            let blank = whole.as_ref().map(|at| " ".repeat((at.end - at.start) as usize));
            self.edit(position, whole, blank.unwrap_or_default());
            if self.output.is_none() {
                (self.output, self.first_output) = (Some(position), shown);
            }
        } else if names_a_file(&name) || name == "output" || (tag == "timedEvent" && name == "dest")
        {
            self.output(position, at, shown);
        } else if name == "emissionClass" && value.to_lowercase().starts_with("phemlight") {
            self.noted(
                position,
                format!(
                    "emissionClass {value} is taken as {EMISSION_CLASS}: its tables are not hashed"
                ),
            );
            self.edit(position, at, EMISSION_CLASS.to_owned());
        }
    }

    /// Looks at a parameter; tags of a map have colons, `whetherOutputState` says how a NEMA program computes.
    fn parameter(&mut self, position: u64, attributes: &[Attribute]) {
        let of = |wanted: &str| attributes.iter().find(|attribute| attribute.name == wanted);
        let (Some(key), Some(value)) = (of("key"), of("value")) else { return };
        let (key, at, value) = (&key.value, value.at.clone(), &value.value);
        if key.contains("tripinfo") {
            self.noted(
                position,
                format!("parameter {key} = {value} is taken as true: every vehicle counts"),
            );
            return self.edit(position, at, "true".to_owned());
        }
        let writes = names_a_file(key) || key.to_lowercase().contains("output");
        let writes = writes && !key.contains(':') && key != "whetherOutputState";
        let harmless = ["", "false", "0"].contains(&value.as_str());
        if writes && !harmless && !NOWHERE.contains(&value.as_str()) {
            self.output(position, at, format!("parameter {key} = {value}"));
        }
    }
}

/// An attribute, with the bytes of its value and of all of it.
struct Attribute {
    name: String,
    value: String,
    at: Option<Range<u64>>,
    whole: Option<Range<u64>>,
}

/// Returns where a part of an element that begins at a position stands in the file.
fn within(element: &BytesStart<'_>, part: &str, position: u64) -> Option<Range<u64>> {
    let offset = part.as_ptr().addr().checked_sub(element.as_ptr().addr())?;
    let fits = offset + part.len() <= element.len();
    let begin = position + 1 + offset as u64;
    fits.then_some(begin..begin + part.len() as u64)
}

/// Whether an attribute or a parameter is the name of a file.
fn names_a_file(name: &str) -> bool {
    let name = name.to_lowercase();
    name.contains("file") && !name.contains("profile")
}
