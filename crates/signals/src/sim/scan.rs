//! One file of a scenario, looked through before SUMO reads it: which files it names, what a private copy has in place of
//! what it would write, and what stands in the way.
//!
//! Networks, routes and additional files name further files: `<include href>` anywhere, a rerouter or a
//! speed sign its `file`. These are followed. Whatever else names a file is an output: detectors, edge data, probes, states
//! of signals, devices of single vehicles. SUMO gets a copy in which it goes nowhere (`NUL`). A file that
//! could hide a name is in the way: one with a document type and its entities, or in an encoding in which the
//! characters of XML are not those of ASCII.
//!
//! What else matters of a scenario is found on the way: programs that change by the clock, what adds or removes vehicles
//! depending on traffic, and when the last vehicle departs.
//!
//! Source: what `sumo` 1.15 opens, tried, and its list of attributes.

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::obstacle::{Accept, Obstacle};

/// Most bytes of an element or of the text between two.
const ROOM: usize = 1 << 26;

/// Stands for every byte that is not ASCII; no XML may have it.
const OTHER: u8 = 0x1a;

/// Encodings whose first half is ASCII, by how their names begin.
const ENCODINGS: [&str; 5] = ["utf-8", "us-ascii", "ascii", "iso-8859", "windows-125"];

/// What switches signals to another program by the clock, whatever a method has installed.
const SWITCHES: [&str; 2] = ["WAUT", "wautJunction"];

/// Files that swallow what is written.
const NOWHERE: [&str; 3] = ["NUL", "nul", "/dev/null"];

/// Pictures, which only SUMO's window reads.
const PICTURES: [&str; 2] = ["imgFile", "osgFile"];

/// What reads a file of its own.
const READERS: [&str; 2] = ["rerouter", "variableSpeedSign"];

/// What adds or removes vehicles as traffic is.
const CHANGERS: [&str; 2] = ["calibrator", "vaporizer"];

/// Emission class in place of one whose tables are no part of what is hashed: SUMO's default.
const EMISSION_CLASS: &str = "HBEFA3/PC_G_EU4";

/// Classes of vehicles that came after SUMO 1.15.
const NEWER_CLASSES: [&str; 7] =
    ["aircraft", "cable_car", "container", "drone", "scooter", "subway", "wheelchair"];

/// Attributes that list classes of vehicles.
const CLASSES: [&str; 5] = ["allow", "disallow", "prefer", "changeLeft", "changeRight"];

/// A class that no vehicle has, in place of a list that would be empty, and so name all.
const NO_CLASS: &str = "ignoring";

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
    /// The names of files as they are written, each with its bytes.
    pub named: Vec<(String, Range<u64>)>,
    /// What a private copy has otherwise.
    pub edits: Vec<Edit>,
    /// What a private copy has without classes of vehicles that SUMO 1.15 does not know.
    pub newer_classes: Vec<Edit>,
    /// Elements that switch programs by the clock.
    pub day_plan: Vec<Range<u64>>,
    /// What stands in the way.
    pub obstacles: Vec<Obstacle>,
    /// What goes nowhere, where something does: how many outputs, and the first one with its place.
    pub outputs: Option<(u32, String)>,
    /// Whether there is a vehicle, or something that SUMO may make one of.
    pub has_vehicles: bool,
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

/// Looks through a file that was opened; the path is for messages.
pub fn scan(path: &Path, opened: Box<dyn BufRead>) -> Scanned {
    let room = Rc::new(Cell::new(ROOM));
    let mut reader = Reader::from_reader(BufReader::new(Ascii(opened, Rc::clone(&room))));
    let mut buffer = Vec::new();
    let mut look = Look { path, line: 1, counts: Vec::new(), scanned: Scanned::default() };
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
                None
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
            Ok(Event::Decl(declaration)) => {
                let name = declaration.encoding().and_then(Result::ok);
                let name = name.map(|name| name.to_lowercase()).unwrap_or_default();
                let is_known = ENCODINGS.iter().any(|known| name.starts_with(known));
                (!is_known && !name.is_empty())
                    .then(|| format!("encoding {name:?}; save it as UTF-8"))
            }
            Ok(_) => None,
            Err(e) => Some(format!("it is not XML that can be read: {e}")),
        };
        look.line += buffer.iter().filter(|byte| **byte == b'\n').count();
        if let Some(reason) = stop {
            look.blocked(reason, None);
            break;
        }
        buffer.clear();
        room.set(ROOM);
    }
    let Look { counts, mut scanned, .. } = look;
    for (obstacle, count) in scanned.obstacles.iter_mut().zip(counts).filter(|(_, n)| *n > 1) {
        obstacle.reason = format!("{} ({count} of the kind)", obstacle.reason);
    }
    scanned
}

fn is_switch(element: &BytesStart<'_>) -> bool {
    SWITCHES.contains(&element.local_name().as_ref())
}

/// What was found so far.
struct Look<'a> {
    path: &'a Path,
    line: usize,
    /// How many of its kind each obstacle stands for.
    counts: Vec<u32>,
    scanned: Scanned,
}

/// An attribute, with the bytes of its value and of all of it.
struct Attribute {
    name: String,
    value: String,
    at: Option<Range<u64>>,
    whole: Option<Range<u64>>,
}

impl Look<'_> {
    fn place(&self) -> String {
        format!("{}: line {}", self.path.display(), self.line)
    }

    /// Adds an obstacle, or counts it with an equal one.
    fn blocked(&mut self, reason: String, accept: Option<Accept>) {
        let obstacle = Obstacle::new(self.place(), reason, accept);
        let mut known = self.scanned.obstacles.iter();
        match known.position(|o| (&o.reason, &o.way) == (&obstacle.reason, &obstacle.way)) {
            Some(known) => self.counts[known] += 1,
            None => {
                self.scanned.obstacles.push(obstacle);
                self.counts.push(1);
            }
        }
    }

    /// Has a value go nowhere.
    fn output(&mut self, at: Option<Range<u64>>, with: String, what: &str) {
        let first = format!("{}, {what}", self.place());
        self.scanned.outputs.get_or_insert((0, first)).0 += 1;
        self.edit(at, with);
    }

    fn edit(&mut self, at: Option<Range<u64>>, with: String) {
        match at {
            Some(at) => self.scanned.edits.push(Edit { at, with }),
            None => self.blocked("an attribute is not written plainly".to_owned(), None),
        }
    }

    /// Looks at an element that begins at a position.
    fn element(&mut self, element: &BytesStart<'_>, position: u64) {
        let tag = element.local_name().as_ref().to_owned();
        if CHANGERS.contains(&tag.as_str()) {
            let reason = format!(
                "<{tag}> adds or removes vehicles, and these differ between methods, so that delays are of different vehicles"
            );
            self.blocked(reason, Some(Accept::Calibrators));
        }
        let mut attributes = Vec::new();
        for attribute in element.attributes() {
            let read = attribute.map_err(|e| e.to_string()).and_then(|attribute| {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0);
                let at = within(element, &attribute.value, position);
                let key = within(element, attribute.key.as_ref(), position);
                Ok(Attribute {
                    name: attribute.key.local_name().as_ref().to_owned(),
                    value: value.map_err(|e| e.to_string())?.into_owned(),
                    whole: key.zip(at.clone()).map(|(key, at)| key.start..at.end + 1),
                    at,
                })
            });
            match read {
                Ok(attribute) => attributes.push(attribute),
                Err(e) => return self.blocked(e, None),
            }
        }
        // The person of a personTrip may drive.
        let vehicles = ["vehicle", "trip", "flow", "personTrip"];
        self.scanned.has_vehicles |= vehicles.contains(&tag.as_str());
        if tag == "param" {
            return self.parameter(&attributes);
        }
        for attribute in attributes {
            self.attribute(&tag, attribute);
        }
    }

    fn attribute(&mut self, tag: &str, attribute: Attribute) {
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
                Some(at) => self.scanned.named.push((value, at)),
                None => {
                    self.blocked(format!("{shown}; give the name of a file in ASCII"), None);
                }
            }
        } else if name == "href" || name.starts_with("commandPosix") {
            self.blocked(format!("{shown} is none that is followed; remove it"), None);
        } else if name == "edgesFile" {
            // A list of edges whose figures are written, which are not.
            let blank = whole.as_ref().map(|at| " ".repeat((at.end - at.start) as usize));
            self.output(whole, blank.unwrap_or_default(), &shown);
        } else if names_a_file(&name) || name == "output" || (tag == "timedEvent" && name == "dest")
        {
            self.output(at, NOWHERE[0].to_owned(), &shown);
        } else if CLASSES.contains(&name.as_str()) {
            let is_known = |class: &&str| !NEWER_CLASSES.contains(class);
            let known: Vec<&str> = value.split_whitespace().filter(is_known).collect();
            if let Some(at) = at.filter(|_| known.len() < value.split_whitespace().count()) {
                let with = if known.is_empty() { NO_CLASS.to_owned() } else { known.join(" ") };
                self.scanned.newer_classes.push(Edit { at, with });
            }
        } else if name == "emissionClass" && value.to_lowercase().starts_with("phemlight") {
            self.edit(at, EMISSION_CLASS.to_owned());
        }
    }

    /// Looks at a parameter; tags of a map have colons, `whetherOutputState` says how a NEMA program computes.
    fn parameter(&mut self, attributes: &[Attribute]) {
        let of = |wanted: &str| attributes.iter().find(|attribute| attribute.name == wanted);
        let (Some(key), Some(value)) = (of("key"), of("value")) else { return };
        let (key, at, value) = (&key.value, value.at.clone(), &value.value);
        if key.contains("tripinfo") {
            // Every vehicle counts.
            return self.edit(at, "true".to_owned());
        }
        let writes = names_a_file(key) || key.to_lowercase().contains("output");
        let writes = writes && !key.contains(':') && key != "whetherOutputState";
        let harmless = ["", "false", "0"].contains(&value.as_str());
        if writes && !harmless && !NOWHERE.contains(&value.as_str()) {
            self.output(at, NOWHERE[0].to_owned(), &format!("parameter {key} = {value}"));
        }
    }
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
