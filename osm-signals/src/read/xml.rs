//! XML files, plain or gzipped.

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::rc::Rc;

use flate2::bufread::MultiGzDecoder;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use quick_xml::{XmlVersion, events::attributes::AttrError};

use super::collect::{Places, Streets, complete};
use super::turns::Kind;
use super::{Format, HEAD_BYTES, Progress, damaged, no_extract, no_streets};
use crate::OsmError;
use crate::extract::{Extract, Place};
use crate::oddities::Oddities;

/// Bytes after which the progress is told.
const TELL_BYTES: u64 = 1024 * 1024;

/// Most bytes of a tag or text, which has to fit into memory.
const MAX_EVENT_BYTES: u64 = 16 * 1024 * 1024;

/// Most elements within each other; an extract has three.
const MAX_DEPTH: usize = 64;

/// Most memory of an element with its tags, nodes and members, bytes; OpenStreetMap allows 32,000
/// members, and 255 characters in a tag.
const MAX_ELEMENT_BYTES: usize = 32 * 1024 * 1024;

#[derive(Debug, Default)]
struct Element {
    kind: Kind,
    id: i64,
    /// Latitude and longitude, degrees.
    degrees: Option<(f64, f64)>,
    tags: Vec<(String, String)>,
    /// The nodes of a way, and the members of a relation.
    members: Vec<(Kind, i64, String)>,
    bytes: usize,
}

impl Element {
    fn tags(&self) -> Vec<(&str, &str)> {
        self.tags.iter().map(|(key, value)| (&**key, &**value)).collect()
    }
}

/// Reads what is needed of an XML file of so many bytes, plain or gzipped; several gzip files one after the other are
/// read as one. `path` is for messages only.
pub fn read_xml(
    path: &Path,
    size: u64,
    file: impl Read,
    progress: Progress<'_>,
) -> Result<Extract, OsmError> {
    progress(0, size);
    let (mut streets, mut nodes, mut told) = (Streets::default(), Vec::new(), 0);
    let mut elements = Elements::open(path, file)?;
    while let Some(element) = elements.next()? {
        if elements.stored.get() >= told + TELL_BYTES {
            told = elements.stored.get();
            progress(told.min(size), size);
        }
        match element.kind {
            Kind::Node => nodes.push(element),
            Kind::Way => {
                let refs: Vec<i64> = element.members.iter().map(|(_, id, _)| *id).collect();
                streets.way(element.id, &element.tags(), &refs);
            }
            Kind::Relation => {
                let members = element.members.iter();
                let members = members.map(|(kind, id, role)| (*kind, *id, &**role));
                streets.relation(element.id, &element.tags(), &members.collect::<Vec<_>>());
            }
        }
    }
    let mut extract = streets.finish();
    extract.oddities.merge(elements.oddities);
    if extract.ways.is_empty() {
        return Err(no_streets(path));
    }
    let mut places = Places::default();
    for node in nodes {
        let place = || node.degrees.and_then(|(lat, lon)| Place::from_degrees(lat, lon));
        places.node(&extract.nodes, node.id, &node.tags(), place);
    }
    places.put(&mut extract);
    progress(size, size);
    complete(path, extract)
}

/// Counts what is read, and reads nothing beyond a limit.
struct Metered<R> {
    inner: R,
    bytes: Rc<Cell<u64>>,
    limit: Rc<Cell<u64>>,
}

impl<R> Metered<R> {
    fn new(inner: R) -> Self {
        Self { inner, bytes: Rc::default(), limit: Rc::new(Cell::new(u64::MAX)) }
    }
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.bytes.get() > self.limit.get() {
            let reason = format!("a tag or text of more than {MAX_EVENT_BYTES} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
        }
        let n = self.inner.read(buffer)?;
        self.bytes.set(self.bytes.get() + n as u64);
        Ok(n)
    }
}

struct Elements<'a> {
    path: &'a Path,
    reader: Reader<BufReader<Metered<Box<dyn Read + 'a>>>>,
    /// How many bytes of the file are used up.
    stored: Rc<Cell<u64>>,
    depth: usize,
    rooted: bool,
    remark: bool,
    current: Option<Element>,
    oddities: Oddities,
}

impl<'a> Elements<'a> {
    fn open(path: &'a Path, file: impl Read + 'a) -> Result<Self, OsmError> {
        let stored = Metered::new(file);
        let bytes = Rc::clone(&stored.bytes);
        let mut stored = BufReader::new(stored);
        let unreadable = |error| unreadable(path, bytes.get(), error);
        let text: Box<dyn Read> = match Format::of(path, stored.fill_buf().map_err(unreadable)?)? {
            Format::Gzip => Box::new(MultiGzDecoder::new(stored)),
            _ => Box::new(stored),
        };
        let mut text = BufReader::new(Metered::new(text));
        let head = text.fill_buf().map_err(unreadable)?;
        if Format::of(path, &head[..head.len().min(HEAD_BYTES)])? != Format::Xml {
            return Err(no_extract(path));
        }
        let mut reader = Reader::from_reader(text);
        reader.config_mut().expand_empty_elements = true;
        Ok(Self {
            path,
            reader,
            stored: bytes,
            depth: 0,
            rooted: false,
            remark: false,
            current: None,
            oddities: Oddities::default(),
        })
    }

    fn next(&mut self) -> Result<Option<Element>, OsmError> {
        let mut buffer = Vec::new();
        loop {
            buffer.clear();
            let text = self.reader.get_ref().get_ref();
            text.limit.set(text.bytes.get() + MAX_EVENT_BYTES);
            let event = self.reader.read_event_into(&mut buffer);
            match event.map_err(|error| self.garbled(error))? {
                Event::Start(start) => self.start(&start)?,
                Event::End(_) => {
                    self.depth = self.depth.saturating_sub(1);
                    self.remark = false;
                    if self.depth == 1
                        && let Some(element) = self.current.take()
                    {
                        return Ok(Some(element));
                    }
                }
                // Overpass sends what it has so far when it has to give up.
                Event::Text(text) if self.remark && text.contains("error") => {
                    return Err(self.damaged(format!("the server gave up: {}", text.trim())));
                }
                Event::Eof if self.depth > 0 || !self.rooted => {
                    return Err(self.damaged("the file ends before `</osm>`".to_owned()));
                }
                Event::Eof => return Ok(None),
                _ => {}
            }
        }
    }

    fn start(&mut self, start: &BytesStart<'_>) -> Result<(), OsmError> {
        let depth = self.depth;
        self.depth += 1;
        let name = start.name();
        let name = name.as_ref();
        match depth {
            0 if self.rooted => {
                let reason = "the file goes on after `</osm>`, as if two were joined";
                return Err(self.damaged(reason.to_owned()));
            }
            0 if name != "osm" => return Err(no_extract(self.path)),
            0 => self.rooted = true,
            1 => {
                self.remark = name == "remark";
                if let Some(kind) = kind(name) {
                    self.current = self.element(kind, start)?;
                }
            }
            2 => {
                if let Some(mut element) = self.current.take() {
                    self.part(&mut element, name, start)?;
                    self.current = Some(element);
                }
            }
            MAX_DEPTH.. => {
                return Err(self.damaged("too many elements within each other".to_owned()));
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns an element without its parts; `None` if it is deleted or has no id.
    fn element(&mut self, kind: Kind, start: &BytesStart<'_>) -> Result<Option<Element>, OsmError> {
        let [id, latitude, longitude, visible, action] =
            self.attributes(start, ["id", "lat", "lon", "visible", "action"])?;
        if visible.as_deref() == Some("false") || action.as_deref() == Some("delete") {
            return Ok(None);
        }
        let Some(id) = number(id.as_deref()) else {
            let id = id.unwrap_or_default();
            self.oddities.add("element whose id is no number", || format!("{kind:?} `{id}`"));
            return Ok(None);
        };
        let degrees = number(latitude.as_deref()).zip(number(longitude.as_deref()));
        Ok(Some(Element { kind, id, degrees, ..Element::default() }))
    }

    fn part(
        &mut self,
        element: &mut Element,
        name: &str,
        start: &BytesStart<'_>,
    ) -> Result<(), OsmError> {
        // The tag in the file bounds the texts; without texts a member is the largest part.
        element.bytes += start.len() + size_of::<(Kind, i64, String)>();
        let id = element.id;
        if element.bytes > MAX_ELEMENT_BYTES {
            return Err(self.damaged(format!("{:?} {id} is larger than it can be", element.kind)));
        }
        match (name, element.kind) {
            ("tag", _) => {
                let [key, value] = self.attributes(start, ["k", "v"])?;
                match key.zip(value) {
                    Some(tag) => element.tags.push(tag),
                    None => self.oddities.add("tag without a key or value", || format!("id {id}")),
                }
            }
            ("nd", Kind::Way) => {
                let [node] = self.attributes(start, ["ref"])?;
                match number(node.as_deref()) {
                    Some(node) => element.members.push((Kind::Node, node, String::new())),
                    None => {
                        let reason = "node of a way whose id is no number";
                        self.oddities.add(reason, || format!("way {id}"));
                    }
                }
            }
            ("member", Kind::Relation) => {
                let [what, member, role] = self.attributes(start, ["type", "ref", "role"])?;
                match what.as_deref().and_then(kind).zip(number(member.as_deref())) {
                    Some((kind, member)) => {
                        element.members.push((kind, member, role.unwrap_or_default()));
                    }
                    None => {
                        let reason = "member of a relation without a type or id";
                        self.oddities.add(reason, || format!("relation {id}"));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn attributes<const N: usize>(
        &self,
        start: &BytesStart<'_>,
        names: [&str; N],
    ) -> Result<[Option<String>; N], OsmError> {
        let mut values = [const { None }; N];
        // A check for duplicates would compare each attribute with all before it.
        for attribute in start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error: AttrError| self.garbled(error.into()))?;
            if let Some(i) = names.iter().position(|name| *name == attribute.key.as_ref()) {
                let value = attribute.normalized_value(XmlVersion::Explicit1_0);
                values[i] = Some(value.map_err(|error| self.garbled(error))?.into_owned());
            }
        }
        Ok(values)
    }

    fn garbled(&self, error: quick_xml::Error) -> OsmError {
        match error {
            quick_xml::Error::Io(error) => {
                let error = io::Error::new(error.kind(), error.to_string());
                unreadable(self.path, self.stored.get(), error)
            }
            error => self.damaged(error.to_string()),
        }
    }

    /// Returns the error at the present place; of a gzipped file that is where its buffer ends.
    fn damaged(&self, reason: String) -> OsmError {
        let byte = self.stored.get().min(self.reader.buffer_position());
        damaged(self.path, byte, reason)
    }
}

fn kind(name: &str) -> Option<Kind> {
    match name {
        "node" => Some(Kind::Node),
        "way" => Some(Kind::Way),
        "relation" => Some(Kind::Relation),
        _ => None,
    }
}

fn number<T: std::str::FromStr>(text: Option<&str>) -> Option<T> {
    text?.trim().parse().ok()
}

fn unreadable(path: &Path, byte: u64, error: io::Error) -> OsmError {
    use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    let reason = match error.kind() {
        UnexpectedEof => "the compressed data is cut off".to_owned(),
        InvalidData | InvalidInput => error.to_string(),
        _ => return OsmError::unreadable(path)(error),
    };
    damaged(path, byte, reason)
}
