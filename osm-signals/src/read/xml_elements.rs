//! The nodes, ways and relations of an XML file, one after the other.

use std::borrow::Cow;
use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Chain, Cursor, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use flate2::bufread::MultiGzDecoder;
use quick_xml::XmlVersion;
use quick_xml::events::attributes::AttrError;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::format::{Format, HEAD_BYTES, expect_root, expect_xml, without_mark};
use super::turns::{Kind, Member};
use super::xml_source::{Bounded, Counted};
use crate::OsmError;
use crate::oddities::Oddities;

/// Most elements within each other; an extract has three.
const MAX_DEPTH: usize = 64;

/// Most attributes of an XML element, since each is compared with all before it; nodes have ten.
const MAX_ATTRIBUTES: usize = 100;

/// Most memory of an element with its tags, nodes and members, bytes; OpenStreetMap allows 32,000
/// members, and 255 characters in a tag.
const MAX_ELEMENT_BYTES: usize = 32 * 1024 * 1024;

/// Encodings that are a part of UTF-8.
const ENCODINGS: [&str; 3] = ["utf-8", "us-ascii", "ascii"];

/// A node, way or relation.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) kind: Kind,
    pub(super) id: i64,
    /// Degrees; not a number if there is none.
    pub(super) latitude: f64,
    pub(super) longitude: f64,
    /// The nodes of a way.
    pub(super) refs: Vec<i64>,
    tags: Vec<(String, String)>,
    members: Vec<(Kind, i64, String)>,
    /// Memory that all this takes.
    bytes: usize,
}

impl Element {
    /// Returns the tags.
    pub(super) fn tags(&self) -> Vec<(&str, &str)> {
        self.tags.iter().map(|(key, value)| (&**key, &**value)).collect()
    }

    /// Returns the members of a relation.
    pub(super) fn members(&self) -> Vec<Member<'_>> {
        let members = self.members.iter();
        members.map(|(kind, id, role)| Member { kind: *kind, id: *id, role }).collect()
    }
}

type Source<'a> = Bounded<Chain<Cursor<Vec<u8>>, Box<dyn BufRead + 'a>>>;

/// The elements of a file.
pub(super) struct Elements<'a> {
    path: PathBuf,
    format: Format,
    reader: Reader<Source<'a>>,
    buffer: Vec<u8>,
    bytes: Rc<Cell<u64>>,
    depth: usize,
    rooted: bool,
    remark: bool,
    current: Option<Element>,
    seen: u64,
    last_node: u64,
    oddities: Oddities,
}

impl<'a> Elements<'a> {
    /// Opens a file.
    pub(super) fn open<R: Read + 'a>(
        path: &Path,
        format: Format,
        open: impl Fn() -> io::Result<R>,
    ) -> Result<Self, OsmError> {
        let bytes = Rc::new(Cell::new(0));
        let inner = BufReader::new(open().map_err(OsmError::unreadable(path))?);
        let stored = Counted { inner, bytes: Rc::clone(&bytes) };
        let mut text: Box<dyn BufRead + 'a> = match format {
            Format::Gzip => Box::new(BufReader::new(MultiGzDecoder::new(stored))),
            _ => Box::new(stored),
        };
        let mut head = Vec::new();
        let read = (&mut text).take(HEAD_BYTES as u64).read_to_end(&mut head);
        read.map_err(|error| unreadable(path, bytes.get(), error))?;
        expect_xml(path, format, &head)?;
        let head = Cursor::new(without_mark(&head).to_vec());
        let mut reader = Reader::from_reader(Bounded::new(head.chain(text)));
        reader.config_mut().expand_empty_elements = true;
        Ok(Self {
            path: path.to_path_buf(),
            format,
            reader,
            buffer: Vec::new(),
            bytes,
            depth: 0,
            rooted: false,
            remark: false,
            current: None,
            seen: 0,
            last_node: 0,
            oddities: Oddities::default(),
        })
    }

    /// Returns how many bytes of the file are used up.
    pub(super) fn byte(&self) -> u64 {
        self.bytes.get()
    }

    /// Returns how many elements were seen, wanted or not.
    pub(super) fn seen(&self) -> u64 {
        self.seen
    }

    /// Returns how many of the elements seen there were up to the last node.
    pub(super) fn last_node(&self) -> u64 {
        self.last_node
    }

    /// Returns what was skipped and why.
    pub(super) fn into_oddities(self) -> Oddities {
        self.oddities
    }

    /// Returns the next element of the wanted kinds; `None` at the end of the file.
    pub(super) fn next(
        &mut self,
        wanted: impl Fn(Kind) -> bool,
    ) -> Result<Option<Element>, OsmError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        loop {
            buffer.clear();
            self.reader.get_mut().reset();
            let event = self.reader.read_event_into(&mut buffer);
            let event = event.map_err(|error| self.garbled(error))?;
            match event {
                Event::Start(start) => self.start(&start, &wanted)?,
                Event::End(_) => {
                    self.depth = self.depth.saturating_sub(1);
                    self.remark = false;
                    if self.depth == 1
                        && let Some(element) = self.current.take()
                    {
                        self.buffer = buffer;
                        return Ok(Some(element));
                    }
                }
                // Overpass sends what it has so far when it has to give up.
                Event::Text(text) if self.remark && text.contains("error") => {
                    return Err(self.damaged(format!("the server gave up: {}", text.trim())));
                }
                Event::Decl(declaration) => {
                    let encoding = declaration.encoding().transpose();
                    let encoding = encoding.map_err(|error| self.garbled(error.into()))?;
                    self.check_encoding(encoding)?;
                }
                Event::Eof if self.depth > 0 || !self.rooted => {
                    return Err(self.damaged("the file ends before `</osm>`".to_owned()));
                }
                Event::Eof => return Ok(None),
                _ => {}
            }
        }
    }

    fn start(
        &mut self,
        start: &BytesStart<'_>,
        wanted: &impl Fn(Kind) -> bool,
    ) -> Result<(), OsmError> {
        let depth = self.depth;
        self.depth += 1;
        let name = start.name();
        let name = name.as_ref();
        match depth {
            0 if self.rooted => {
                Err(self
                    .damaged("the file goes on after `</osm>`, as if two were joined".to_owned()))
            }
            0 => {
                self.rooted = true;
                expect_root(&self.path, self.format, name)
            }
            1 => {
                self.remark = name == "remark";
                let Some(kind) = kind(name) else { return Ok(()) };
                self.seen += 1;
                if kind == Kind::Node {
                    self.last_node = self.seen;
                }
                if wanted(kind) {
                    self.current = self.element(kind, start)?;
                }
                Ok(())
            }
            2 => match self.current.take() {
                Some(mut element) => {
                    self.part(&mut element, name, start)?;
                    self.current = Some(element);
                    Ok(())
                }
                None => Ok(()),
            },
            MAX_DEPTH.. => Err(self.damaged("too many elements within each other".to_owned())),
            _ => Ok(()),
        }
    }

    /// Returns an element without its parts; `None` if it is deleted or has no id.
    fn element(&mut self, kind: Kind, start: &BytesStart<'_>) -> Result<Option<Element>, OsmError> {
        let [id, latitude, longitude, visible, action] =
            self.attributes(start, ["id", "lat", "lon", "visible", "action"])?;
        if visible.as_deref() == Some("false") || action.as_deref() == Some("delete") {
            return Ok(None);
        }
        let id = id.unwrap_or_default();
        let Ok(id) = id.trim().parse() else {
            self.oddities.add("element whose id is no number", || format!("{kind:?} `{id}`"));
            return Ok(None);
        };
        let degrees = |text: Option<Cow<'_, str>>| {
            text.and_then(|text| text.trim().parse().ok()).unwrap_or(f64::NAN)
        };
        Ok(Some(Element {
            kind,
            id,
            latitude: degrees(latitude),
            longitude: degrees(longitude),
            refs: Vec::new(),
            tags: Vec::new(),
            members: Vec::new(),
            bytes: 0,
        }))
    }

    /// Adds a tag, node or member to an element.
    fn part(
        &mut self,
        element: &mut Element,
        name: &str,
        start: &BytesStart<'_>,
    ) -> Result<(), OsmError> {
        // The tag in the file bounds the texts; without texts a member is the largest part.
        element.bytes += start.len() + size_of::<(Kind, i64, String)>();
        if element.bytes > MAX_ELEMENT_BYTES {
            let (kind, id) = (element.kind, element.id);
            return Err(self.damaged(format!("{kind:?} {id} is larger than it can be")));
        }
        let id = element.id;
        match (name, element.kind) {
            ("tag", _) => {
                let [key, value] = self.attributes(start, ["k", "v"])?;
                match (key, value) {
                    (Some(key), Some(value)) => {
                        element.tags.push((key.into_owned(), value.into_owned()));
                    }
                    _ => self.oddities.add("tag without a key or value", || format!("id {id}")),
                }
            }
            ("nd", Kind::Way) => {
                let [node] = self.attributes(start, ["ref"])?;
                match node.as_deref().unwrap_or_default().trim().parse() {
                    Ok(node) => element.refs.push(node),
                    Err(_) => {
                        let reason = "node of a way whose id is no number";
                        self.oddities.add(reason, || format!("way {id}"));
                    }
                }
            }
            ("member", Kind::Relation) => {
                let [what, member, role] = self.attributes(start, ["type", "ref", "role"])?;
                let member = member.as_deref().unwrap_or_default().trim().parse();
                match (kind(what.as_deref().unwrap_or_default()), member) {
                    (Some(kind), Ok(member)) => {
                        let role = role.unwrap_or_default().into_owned();
                        element.members.push((kind, member, role));
                    }
                    _ => {
                        let reason = "member of a relation without a type or id";
                        self.oddities.add(reason, || format!("relation {id}"));
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns the values of attributes, without entities.
    fn attributes<'s, const N: usize>(
        &self,
        start: &'s BytesStart<'_>,
        names: [&str; N],
    ) -> Result<[Option<Cow<'s, str>>; N], OsmError> {
        let mut values = [const { None }; N];
        for (count, attribute) in start.attributes().enumerate() {
            if count == MAX_ATTRIBUTES {
                return Err(self.damaged(format!("more than {MAX_ATTRIBUTES} attributes")));
            }
            let attribute = attribute.map_err(|error: AttrError| self.garbled(error.into()))?;
            if let Some(i) = names.iter().position(|name| *name == attribute.key.as_ref()) {
                let value = attribute.normalized_value(XmlVersion::Explicit1_0);
                values[i] = Some(value.map_err(|error| self.garbled(error))?);
            }
        }
        Ok(values)
    }

    fn check_encoding(&self, encoding: Option<Cow<'_, str>>) -> Result<(), OsmError> {
        let encoding = encoding.unwrap_or(Cow::Borrowed("utf-8"));
        if ENCODINGS.iter().any(|known| encoding.eq_ignore_ascii_case(known)) {
            return Ok(());
        }
        Err(OsmError::Malformed {
            path: self.path.clone(),
            place: "line 1".to_owned(),
            reason: format!("the text is in {encoding}; convert it to UTF-8 with `iconv`"),
        })
    }

    fn garbled(&self, error: quick_xml::Error) -> OsmError {
        match error {
            quick_xml::Error::Io(error) => {
                let error = io::Error::new(error.kind(), error.to_string());
                unreadable(&self.path, self.byte(), error)
            }
            error => self.damaged(error.to_string()),
        }
    }

    fn damaged(&self, reason: String) -> OsmError {
        OsmError::Damaged { path: self.path.clone(), byte: self.byte(), reason }
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

/// Returns the error for bytes that cannot be read or not be decompressed.
fn unreadable(path: &Path, byte: u64, error: io::Error) -> OsmError {
    use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    let path_buf = path.to_path_buf();
    match error.kind() {
        UnexpectedEof => {
            let reason = "the compressed data is cut off".to_owned();
            OsmError::Damaged { path: path_buf, byte, reason }
        }
        InvalidData | InvalidInput => {
            OsmError::Damaged { path: path_buf, byte, reason: error.to_string() }
        }
        _ => OsmError::unreadable(path)(error),
    }
}
