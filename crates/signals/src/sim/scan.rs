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
//! in the same files: programs that change by the clock, what adds or removes vehicles depending on traffic, and when the
//! vehicles depart.
//!
//! Source: what `sumo` 1.15 opens, tried, and its list of attributes.

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::obstacle::{Accept, Obstacle, Way};
use super::sumocfg::seconds;

/// Most bytes of an element or of the text between two.
const ROOM: usize = 1 << 26;

/// Stands for every byte that is not ASCII; no XML may have it.
const OTHER: u8 = 0x1a;

/// Encodings whose first half is ASCII, by how their names begin.
const ENCODINGS: [&str; 5] = ["utf-8", "us-ascii", "ascii", "iso-8859", "windows-125"];

/// What switches signals to another program by the clock, whatever a method has installed.
const SWITCHES: [&str; 2] = ["WAUT", "wautJunction"];

/// Most obstacles of a file that are named; more of a kind count with the first.
const NAMED: usize = 20;

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

/// What departs and is no vehicle.
const OTHERS: [&str; 4] = ["person", "personFlow", "container", "containerFlow"];

/// Ways to travel for which SUMO makes a vehicle of the person's own.
const OWN_VEHICLES: [&str; 2] = ["car", "bicycle"];

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
    /// What counts in place of what it says, in words.
    pub notes: Vec<String>,
    /// Whether there is a vehicle, or something that SUMO makes one of.
    pub has_vehicles: bool,
    /// Whether there are people or containers.
    pub has_others: bool,
    /// The first flow whose vehicles SUMO draws from the seed.
    pub first_drawn: Option<String>,
    /// Earliest departure of a vehicle, seconds.
    pub first_s: Option<f64>,
    /// Latest departure of a vehicle or end of a flow, seconds.
    pub last_s: Option<f64>,
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
            look.blocked(reason, Way::Change(""));
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

/// An attribute, with the bytes of its value and where its name begins.
struct Attribute {
    name: String,
    value: String,
    at: Option<Range<u64>>,
    begin: Option<u64>,
}

impl Look<'_> {
    fn place(&self) -> String {
        format!("{}: line {}", self.path.display(), self.line)
    }

    fn blocked(&mut self, reason: String, way: Way) {
        let is_full = self.counts.len() >= NAMED;
        let mut known = self.scanned.obstacles.iter();
        match known.position(|o| o.way == way && (is_full || o.reason == reason)) {
            Some(known) => self.counts[known] += 1,
            None => {
                self.scanned.obstacles.push(Obstacle { place: self.place(), reason, way });
                self.counts.push(1);
            }
        }
    }

    fn noted(&mut self, note: &str) {
        self.scanned.notes.push(format!("{}: {note}", self.place()));
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
            None => {
                let reason = "an attribute that cannot be replaced".to_owned();
                self.blocked(reason, Way::Change("write it plainly"));
            }
        }
    }

    /// Looks at an element that begins at a position.
    fn element(&mut self, element: &BytesStart<'_>, position: u64) {
        let tag = element.local_name().as_ref().to_owned();
        if CHANGERS.contains(&tag.as_str()) {
            let reason = format!(
                "<{tag}> adds or removes vehicles, and these differ between methods, so that delays are of different vehicles"
            );
            self.blocked(reason, Way::Accept(Accept::Calibrators));
        }
        let mut attributes = Vec::new();
        for attribute in element.attributes() {
            let read = attribute.map_err(|e| e.to_string()).and_then(|attribute| {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0);
                Ok(Attribute {
                    name: attribute.key.local_name().as_ref().to_owned(),
                    value: value.map_err(|e| e.to_string())?.into_owned(),
                    at: within(element, &attribute.value, position),
                    begin: within(element, attribute.key.as_ref(), position).map(|at| at.start),
                })
            });
            match read {
                Ok(attribute) => attributes.push(attribute),
                Err(e) => return self.blocked(e, Way::Change("")),
            }
        }
        self.departures(&tag, &|wanted| {
            attributes.iter().find(|a| a.name == wanted).map(|a| a.value.as_str())
        });
        if tag == "param" {
            return self.parameter(&attributes);
        }
        for attribute in attributes {
            self.attribute(&tag, attribute);
        }
    }

    /// Looks at what an element says of vehicles, given its attributes by name.
    fn departures<'a>(&mut self, tag: &str, of: &dyn Fn(&str) -> Option<&'a str>) {
        let found = &mut self.scanned;
        found.has_others |= OTHERS.contains(&tag);
        if tag == "personTrip" {
            let modes = of("modes").unwrap_or_default();
            found.has_vehicles |= OWN_VEHICLES.iter().any(|mode| modes.contains(mode));
            found.has_vehicles |= of("vTypes").is_some();
        }
        let when = match tag {
            "vehicle" | "trip" => "depart",
            "flow" => "begin",
            _ => return,
        };
        found.has_vehicles = true;
        let is_random = of("period").is_some_and(|period| period.starts_with("exp"));
        if tag == "flow" && (is_random || of("probability").is_some()) {
            let id = of("id").unwrap_or_default();
            found.first_drawn.get_or_insert_with(|| format!("<flow id={id:?}>"));
        }
        let time = |name: &str| of(name).and_then(|text| seconds(text).ok());
        // What waits for something else has no time.
        let Some(depart_s) = time(when) else { return };
        let last_s = time("end").map_or(depart_s, |end_s| end_s.max(depart_s));
        found.first_s = Some(found.first_s.map_or(depart_s, |known| known.min(depart_s)));
        found.last_s = Some(found.last_s.map_or(last_s, |known| known.max(last_s)));
    }

    fn attribute(&mut self, tag: &str, attribute: Attribute) {
        let Attribute { name, value, at, begin } = attribute;
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
                None => self.blocked(shown, Way::Change("give the name of a file in ASCII")),
            }
        } else if name == "href" || name.starts_with("commandPosix") {
            self.blocked(format!("{shown} is none that is followed"), Way::Change("remove it"));
        } else if name == "edgesFile" {
            // A list of edges whose figures are written, which are not.
            let whole = begin.zip(at).map(|(begin, at)| begin..at.end + 1);
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
            self.noted(&format!(
                "emissionClass {value} is taken as {EMISSION_CLASS}: its tables are not hashed"
            ));
            self.edit(at, EMISSION_CLASS.to_owned());
        }
    }

    /// Looks at a parameter; tags of a map have colons, `whetherOutputState` says how a NEMA program computes.
    fn parameter(&mut self, attributes: &[Attribute]) {
        let of = |wanted: &str| attributes.iter().find(|attribute| attribute.name == wanted);
        let (Some(key), Some(value)) = (of("key"), of("value")) else { return };
        let (key, at, value) = (&key.value, value.at.clone(), &value.value);
        if key.contains("tripinfo") {
            self.noted(&format!(
                "parameter {key} = {value} is taken as true: every vehicle counts"
            ));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn scanned(text: &str) -> Scanned {
        scan(Path::new("r.xml"), Box::new(io::Cursor::new(text.as_bytes().to_vec())))
    }

    #[test]
    fn a_flow_lasts_to_its_end_and_is_named_where_its_vehicles_follow_from_the_seed() {
        let found = scanned(
            "<r><flow id='f' begin='0' end='0:30:00' period='9'/><trip depart='9'/>\
             <flow id='g' period='exp(0.1)'/><flow id='h' probability='0.2'/></r>",
        );
        assert_eq!((found.first_s, found.last_s), (Some(0.0), Some(1800.0)));
        assert_eq!(found.first_drawn.as_deref(), Some("<flow id=\"g\">"));
        assert_eq!(scanned("<r><person depart='9'/></r>").last_s, None);
    }

    #[test]
    fn people_are_no_vehicles_unless_they_drive() {
        let of = |text: &str| {
            let found = scanned(&format!("<r>{text}</r>"));
            (found.has_vehicles, found.has_others)
        };
        assert_eq!(of("<person depart='9'><walk edges='x y'/></person>"), (false, true));
        assert_eq!(of("<person/><personTrip modes='public'/>"), (false, true));
        assert_eq!(of("<person/><personTrip modes='public car'/>"), (true, true));
        assert_eq!(of("<flow number='9'/>"), (true, false));
        assert_eq!(of("<route edges='x y'/>"), (false, false));
    }
}
