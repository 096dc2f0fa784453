//! What the elements of a file say: which other files they name, what they write, and what is in the way.

use std::ops::Range;

use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

use super::super::obstacle::{Accept, Way};
use super::found::{Edit, Found, Named, Scanned};

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

/// What was found so far.
#[derive(Default)]
pub(super) struct Look {
    pub(super) scanned: Scanned,
    pub(super) found: Vec<Found>,
    pub(super) outputs: u32,
    /// Where the first output stands.
    pub(super) output: Option<u64>,
    pub(super) first_output: String,
}

impl Look {
    /// Adds what is in the way.
    pub(super) fn blocked(&mut self, position: u64, reason: String, way: Way) {
        let is_full = self.found.iter().filter(|found| found.way.is_some()).count() >= NAMED;
        let way = Some(way);
        let same = |known: &&mut Found| known.way == way && (is_full || known.reason == reason);
        match self.found.iter_mut().find(same) {
            Some(known) => known.count += 1,
            None => self.found.push(Found { position, reason, way, count: 1 }),
        }
    }

    fn noted(&mut self, position: u64, reason: String) {
        self.found.push(Found { position, reason, way: None, count: 1 });
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
    pub(super) fn element(&mut self, element: &BytesStart<'_>, position: u64) {
        let tag = element.local_name().as_ref().to_owned();
        if CHANGERS.contains(&tag.as_str()) {
            let reason = format!(
                "<{tag}> adds or removes vehicles, and these differ between methods, so that delays are of different vehicles"
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
        self.scanned.departures.next(&tag, &|wanted| {
            attributes.iter().find(|a| a.name == wanted).map(|a| a.value.as_str())
        });
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
        } else if CLASSES.contains(&name.as_str()) {
            let is_known = |class: &&str| !NEWER_CLASSES.contains(class);
            let known: Vec<&str> = value.split_whitespace().filter(is_known).collect();
            if let Some(at) = at.filter(|_| known.len() < value.split_whitespace().count()) {
                let with = if known.is_empty() { NO_CLASS.to_owned() } else { known.join(" ") };
                self.scanned.newer_classes.push(Edit { at, with });
            }
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
