//! What SUMO reads because a file of a scenario names it, and what it would write.
//!
//! Networks, routes and additional files name further files: `<include href>` anywhere, a rerouter or a
//! speed sign its `file`, detectors and edge data what they write. The first two are followed. An output is
//! allowed to go nowhere (`NUL`, `/dev/null`). Whatever else names a file is refused with its place, and
//! so is what could hide a name: document types with their entities, and encodings in which the
//! characters of XML are not those of ASCII.
//!
//! What would make runs of methods something else than runs of methods is refused here too, because it stands
//! in the same files: programs that change by the clock, what adds or removes vehicles depending on traffic, and vehicles
//! that SUMO would leave out for their place in the file (`departures.rs`).
//!
//! Source: what `sumo` 1.15 opens, tried, and its list of attributes.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use flate2::read::MultiGzDecoder;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::SimError;
use super::departures::Departures;
use super::sumocfg::SumoConfig;
use crate::files::{self, FileError};

/// First bytes of a compressed file.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Most bytes that are read of a file once it is unpacked.
const UNPACKED: u64 = 1 << 34;

/// Most bytes of an element or of the text between two.
const ROOM: usize = 1 << 26;

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

/// Returns every file of a scenario besides its configuration: name as seen from the folder of the
/// configuration, path. First those that the configuration names, then those that they name.
///
/// # Errors
///
/// [`SimError::Config`] naming the file and the line when something else is read or written.
pub fn sources(config: &SumoConfig) -> Result<Vec<(String, PathBuf)>, SimError> {
    let mut all = config.files.clone();
    let mut known: BTreeSet<PathBuf> = all.iter().map(|(_, path)| path.clone()).collect();
    let mut next = 0;
    while let Some((name, path)) = all.get(next).cloned() {
        next += 1;
        if path.metadata().is_err() {
            let reason = "the scenario names it, but it cannot be read; add it".to_owned();
            return Err(SimError::Config { path, reason });
        }
        for named in scan(&path, &|| open(&path), config.has_routes(&path))? {
            let file = path.parent().unwrap_or(Path::new("")).join(&named);
            if known.insert(file.clone()) {
                let name = Path::new(&name).parent().unwrap_or(Path::new("")).join(named);
                all.push((name.display().to_string(), file));
            }
        }
    }
    Ok(all)
}

/// Returns a file that may be compressed, opened; more than 16 GiB are not read of it.
///
/// # Errors
///
/// [`FileError`] when it cannot be read or is no regular file.
pub fn open(path: &Path) -> Result<Box<dyn BufRead>, FileError> {
    let mut start = Vec::new();
    let mut file = files::open(path)?;
    (&mut file)
        .take(GZIP.len() as u64)
        .read_to_end(&mut start)
        .and_then(|_| file.rewind())
        .map_err(FileError::at("read", path))?;
    Ok(if start == GZIP {
        Box::new(BufReader::new(MultiGzDecoder::new(file).take(UNPACKED)))
    } else {
        Box::new(BufReader::new(file.take(UNPACKED)))
    })
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

/// Returns the files that a file names, as they are written there.
///
/// # Arguments
///
/// * `path` — for messages.
/// * `opened` — its content, from the beginning.
/// * `is_route_file` — whether SUMO reads it as time goes on, so that its vehicles have to be in order.
///
/// # Errors
///
/// [`SimError::Config`] naming the line when something else is read or written, or SUMO would leave a vehicle out.
pub fn scan(
    path: &Path,
    opened: &dyn Fn() -> Result<Box<dyn BufRead>, FileError>,
    is_route_file: bool,
) -> Result<Vec<String>, SimError> {
    let fail = |reason: String| SimError::Config { path: path.to_path_buf(), reason };
    let room = Rc::new(Cell::new(ROOM));
    let mut reader = Reader::from_reader(BufReader::new(Ascii(opened()?, Rc::clone(&room))));
    let (mut named, mut buffer) = (Vec::new(), Vec::new());
    let mut departures = is_route_file.then(Departures::default);
    loop {
        let result = match reader.read_event_into(&mut buffer) {
            Ok(Event::Eof) => return Ok(named),
            Ok(Event::Start(element) | Event::Empty(element)) => {
                look(&element, &mut named, departures.as_mut())
            }
            Ok(Event::DocType(_)) => Err("a <!DOCTYPE> can draw other files in; remove it".into()),
            Ok(Event::Decl(declaration)) => match declaration.encoding() {
                Some(Ok(name)) => encoding(&name),
                _ => Ok(()),
            },
            Ok(_) => Ok(()),
            Err(e) => Err(format!("it is not XML that can be read: {e}")),
        };
        if let Err(reason) = result {
            let line = line(opened()?, reader.buffer_position());
            return Err(fail(format!("line {line}: {reason}")));
        }
        buffer.clear();
        room.set(ROOM);
    }
}

/// Returns the number of the line at a position.
fn line(mut file: Box<dyn BufRead>, position: u64) -> usize {
    let mut buffer = Vec::new();
    // What cannot be read any more has no lines to count.
    let _ = file.by_ref().take(position).read_to_end(&mut buffer);
    let ends = |at: &usize| match buffer[*at] {
        b'\r' => buffer.get(at + 1) != Some(&b'\n'),
        byte => byte == b'\n',
    };
    1 + (0..buffer.len()).filter(ends).count()
}

fn encoding(name: &str) -> Result<(), String> {
    let name = name.to_lowercase();
    match ENCODINGS.iter().any(|known| name.starts_with(known)) {
        true => Ok(()),
        false => Err(format!("encoding {name:?}; save it as UTF-8")),
    }
}

/// Adds the files that an element names, and looks at what it has depart.
fn look(
    element: &BytesStart<'_>,
    named: &mut Vec<String>,
    departures: Option<&mut Departures>,
) -> Result<(), String> {
    let tag = element.local_name().as_ref().to_owned();
    if SWITCHES.contains(&tag.as_str()) {
        return Err(format!(
            "<{tag}> takes signals away from every method when it switches their programs; remove \
             every <WAUT> and <wautJunction>"
        ));
    }
    if CHANGERS.contains(&tag.as_str()) {
        return Err(format!(
            "<{tag}> adds or removes vehicles, under each method others, so that their delays cannot \
             be compared; remove it"
        ));
    }
    let mut attributes = Vec::new();
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|e| e.to_string())?;
        let value =
            attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|e| e.to_string())?;
        attributes.push((attribute.key.local_name().as_ref().to_owned(), value.into_owned()));
    }
    departures.map_or(Ok(()), |departures| departures.next(&tag, &attributes))?;
    if tag == "param" {
        let of = |wanted: &str| attributes.iter().find(|(name, _)| name == wanted);
        let value = of("value").map_or("", |(_, value)| value);
        return of("key").map_or(Ok(()), |(_, key)| parameter(key, value));
    }
    for (name, value) in &attributes {
        if PICTURES.contains(&name.as_str()) || NOWHERE.contains(&value.as_str()) {
            continue;
        }
        let is_input = (tag == "include" && name == "href")
            || (READERS.contains(&tag.as_str()) && name == "file");
        if is_input {
            named.push(file_name(&tag, name, value)?);
        } else if name == "href" || name.starts_with("commandPosix") {
            return Err(format!("<{tag} {name}=\"{value}\"> is none that is followed; remove it"));
        } else if name == "edgesFile" {
            let way_out = "write the edges into the attribute `edges`";
            return Err(format!(
                "<{tag} {name}=\"{value}\"> is read from wherever SUMO runs; {way_out}"
            ));
        } else if names_a_file(name) || name == "output" || (tag == "timedEvent" && name == "dest")
        {
            return Err(format!(
                "<{tag} {name}=\"{value}\"> would be read or written by every simulation; give \
                 {name}=\"NUL\" or remove it"
            ));
        } else if name == "emissionClass" && value.to_lowercase().starts_with("phemlight") {
            return Err(format!(
                "emissionClass=\"{value}\" reads tables that are no part of what is hashed; remove it"
            ));
        }
    }
    Ok(())
}

/// Whether an attribute or a parameter is the name of a file.
fn names_a_file(name: &str) -> bool {
    let name = name.to_lowercase();
    name.contains("file") && !name.contains("profile")
}

/// Says whether a parameter may stay; tags of a map have colons, `whetherOutputState` says how a NEMA program computes.
fn parameter(key: &str, value: &str) -> Result<(), String> {
    if key.contains("tripinfo") {
        return Err(format!("parameter {key:?} leaves vehicles out of the delay; remove it"));
    }
    let writes = names_a_file(key) || key.to_lowercase().contains("output");
    let writes = writes && !key.contains(':') && key != "whetherOutputState";
    if writes && !NOWHERE.contains(&value) && value != "false" && value != "0" {
        return Err(format!(
            "parameter {key:?} = {value:?} would be read or written by every simulation; give value=\"NUL\" or remove it"
        ));
    }
    Ok(())
}

fn file_name(tag: &str, name: &str, value: &str) -> Result<String, String> {
    // A reference such as `&#252;` is a character beyond ASCII too, which SUMO writes as the machine's locale has it.
    let plain = value.bytes().all(|b| b.is_ascii() && !b.is_ascii_control());
    if value.is_empty() || value.contains("${") || !plain {
        let way_out = "give the name of a file in ASCII";
        return Err(format!("<{tag} {name}=\"{}\">: {way_out}", value.replace('\u{1a}', "?")));
    }
    Ok(value.to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;

    use super::*;

    /// What is read with additional files of these names and texts, the first of which is named.
    fn with(files: &[(&str, &[u8])]) -> Result<Vec<String>, String> {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("sub")).unwrap();
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        let config = folder.path().join("a.sumocfg");
        let text = format!("<c><n v='n.xml'/><a v='{}'/></c>", files[0].0);
        fs::write(&config, text).unwrap();
        fs::write(folder.path().join("n.xml"), "<net/>").unwrap();
        let found = sources(&SumoConfig::read(&config).unwrap());
        let names = found.map(|found| found.into_iter().map(|(name, _)| name).collect());
        names.map_err(|e| e.to_string().replace(&folder.path().display().to_string(), "."))
    }

    #[test]
    fn files_that_files_name_are_followed_from_where_they_lie() {
        let mut zipped = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        zipped.write_all(b"<a><include href='c.xml'/><include href='a.xml'/></a>").unwrap();
        let found = with(&[
            ("a.xml", b"<a><include href='sub/b.xml'/><rerouter id='r' file='d.xml'/></a>"),
            ("sub/b.xml", &zipped.finish().unwrap()),
            ("sub/c.xml", b"<a/>"),
            ("sub/a.xml", b"<a/>"),
            ("d.xml", b"<rerouter/>"),
        ]);
        let expected = ["n.xml", "a.xml", "sub/b.xml", "d.xml", "sub/c.xml", "sub/a.xml"];
        assert_eq!(found.unwrap(), expected);
    }

    #[test]
    fn circles_end_and_what_goes_nowhere_or_is_a_picture_may_stay() {
        let text = b"<?xml version='1.0' encoding='ISO-8859-1'?>\n<a><include href='a.xml'/>\
            <edge name='Stra\xdfe'/><e1Detector file='NUL'/><instantInductionLoop file='/dev/null'/>\
            <vType imgFile='b.png'><param key='profile' value='x'/></vType>\
            <param key='file' value='NUL'/></a>";
        assert_eq!(with(&[("a.xml", text)]).unwrap(), ["n.xml", "a.xml"]);
    }

    #[test]
    fn networks_are_looked_through_too() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("a.sumocfg");
        fs::write(&config, "<c><n v='n.xml'/></c>").unwrap();
        fs::write(folder.path().join("n.xml"), "<net>\n\n<WAUT id='w'/></net>").unwrap();
        let e = sources(&SumoConfig::read(&config).unwrap()).unwrap_err().to_string();
        assert!(e.contains("n.xml: line 3: <WAUT> takes signals away"), "{e}");
    }

    #[test]
    fn vehicles_are_in_order_in_route_files_and_in_any_order_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("a.sumocfg");
        fs::write(folder.path().join("n.xml"), "<net/>").unwrap();
        let routes = "<r>\n<trip id='a' depart='9'/>\n<trip id='b' depart='8'/></r>";
        fs::write(folder.path().join("r.xml"), routes).unwrap();
        let read = |option: &str| {
            fs::write(&config, format!("<c><n v='n.xml'/><{option} v='r.xml'/></c>")).unwrap();
            sources(&SumoConfig::read(&config).unwrap()).map_err(|e| e.to_string())
        };
        assert!(read("a").is_ok());
        let e = read("r").unwrap_err();
        assert!(e.contains("r.xml: line 3: <trip id=\"b\"> departs at 8 s, after <trip"), "{e}");
    }

    #[test]
    fn whatever_else_names_a_file_is_refused_with_its_place() {
        for (text, expected) in [
            (
                "<a>\n\n<e1Detector file='o.xml'/></a>",
                "a.xml: line 3: <e1Detector file=\"o.xml\"> would be",
            ),
            ("<a><location output='o.xml'/></a>", "line 1: <location output="),
            ("<a><calibrator output='NUL'/></a>", "line 1: <calibrator> adds or removes vehicles"),
            ("<a><vaporizer id='e'/></a>", "line 1: <vaporizer> adds or removes vehicles"),
            ("<a><timedEvent dest='o.xml'/></a>", "line 1: <timedEvent dest="),
            ("<a><engine xmlFile='e.xml'/></a>", "line 1: <engine xmlFile="),
            ("<a><edgeData edgesFile='e.txt'/></a>", "write the edges into the attribute `edges`"),
            ("<a><location href='e.txt'/></a>", "none that is followed"),
            ("<a><include href='&#36;{HOME}/b.xml'/></a>", "give the name of a file in ASCII"),
            ("<a><include href='\u{fc}.xml'/></a>", "<include href=\"??.xml\">: give the name"),
            ("<a><include href='&#252;.xml'/></a>", "<include href=\"ü.xml\">: give the name"),
            ("<a><include href='b&#10;.xml'/></a>", "give the name of a file in ASCII"),
            (
                "<a><include href='b.xml'/></a>",
                "b.xml: the scenario names it, but it cannot be read",
            ),
            ("<a><include href='sub'/></a>", "sub: it is a folder; give a regular file"),
            (
                "<a>\n<WAUT id='w' refTime='0' startProg='0'/></a>",
                "a.xml: line 2: <WAUT> takes signals away from every method",
            ),
            ("<a><wautJunction wautID='w' junctionID='c'/></a>", "line 1: <wautJunction> takes"),
            ("<a><vType emissionClass='PHEMlight/PC'/></a>", "reads tables"),
            (
                "<a><param key='device.ssm.file' value='s.xml'/></a>",
                "parameter \"device.ssm.file\"",
            ),
            ("<a><param key='has.tripinfo.device' value='false'/></a>", "leaves vehicles out"),
            (
                "<!DOCTYPE a [<!ENTITY x SYSTEM 'b'>]><a>&x;</a>",
                "a <!DOCTYPE> can draw other files in",
            ),
            ("<?xml version='1.0' encoding='UTF-7'?><a/>", "encoding \"utf-7\"; save it as UTF-8"),
            ("<\0a\0/\0>\0", "it has null bytes; save it as UTF-8"),
            ("<a><b></a>", "it is not XML that can be read"),
        ] {
            let e = with(&[("a.xml", text.as_bytes())]).unwrap_err();
            assert!(e.contains(expected), "{e}");
        }
    }
}
