//! The frame of a PBF file: blobs one after the other, each with a header, and their compression.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::ZlibDecoder;
use osmpbfreader::fileformat::BlobHeader;
use protobuf::Message;

use super::Fault;
use super::wire::{Fields, Value};
use crate::OsmError;

/// Most bytes of a blob's header, by the specification.
const MAX_HEADER_BYTES: u32 = 64 * 1024;

/// Most bytes of a blob, stored and inflated, by the specification.
pub(super) const MAX_BLOB_BYTES: usize = 32 * 1024 * 1024;

/// Most times its size that a larger blob inflates to. Of maps it is two to ten times; what inflates a thousand times is
/// made to fill a memory.
const MOST_INFLATED: usize = 64;

/// Bytes of an inflated blob that are taken however small it was.
const SMALL_BLOB_BYTES: usize = 1 << 20;

/// What a blob is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// What the file needs of its reader.
    Header,
    /// Nodes, ways and relations.
    Data,
    /// Something that readers may skip.
    Other,
}

/// A blob as it is stored.
#[derive(Debug)]
pub(super) struct Blob {
    /// What it is for.
    pub(super) purpose: Purpose,
    /// Where it begins in the file, after its header.
    pub(super) byte: u64,
    /// Its bytes.
    pub(super) bytes: Vec<u8>,
}

/// The blobs of a file.
pub(super) struct Blobs<'a, R> {
    path: &'a Path,
    source: &'a mut R,
    byte: u64,
}

impl<'a, R: Read + Seek> Blobs<'a, R> {
    /// Returns the blobs of a file and the size of that.
    pub(super) fn of(path: &'a Path, source: &'a mut R) -> Result<(Self, u64), OsmError> {
        let size = source.seek(SeekFrom::End(0)).and_then(|size| source.rewind().map(|()| size));
        let size = size.map_err(OsmError::unreadable(path))?;
        Ok((Self { path, source, byte: 0 }, size))
    }

    /// Returns where reading has come to.
    pub(super) fn byte(&self) -> u64 {
        self.byte
    }

    /// Returns the next blob; `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<Blob>, OsmError> {
        let start = self.byte;
        let mut length = [0; 4];
        match self.fill(&mut length)? {
            0 => return Ok(None),
            4 => {}
            _ => return Err(self.damaged(start, "the file ends within the length of a header")),
        }
        let length = u32::from_be_bytes(length);
        if length > MAX_HEADER_BYTES {
            let reason = format!("a header of {length} bytes, more than a PBF file can have");
            return Err(self.damaged(start, &reason));
        }
        let header = self.take(length as usize)?;
        let header = BlobHeader::parse_from_bytes(&header)
            .map_err(|e| self.damaged(start, &format!("the header of a blob is garbled ({e})")))?;
        let size = usize::try_from(header.datasize()).ok().filter(|size| *size <= MAX_BLOB_BYTES);
        let Some(size) = size else {
            let size = header.datasize();
            return Err(self.damaged(start, &format!("a blob of impossible size, {size} bytes")));
        };
        let purpose = match header.type_() {
            "OSMHeader" => Purpose::Header,
            "OSMData" => Purpose::Data,
            _ => Purpose::Other,
        };
        let byte = self.byte;
        Ok(Some(Blob { purpose, byte, bytes: self.take(size)? }))
    }

    /// Returns a blob of data again.
    pub(super) fn again(&mut self, (byte, size): (u64, usize)) -> Result<Blob, OsmError> {
        self.source.seek(SeekFrom::Start(byte)).map_err(OsmError::unreadable(self.path))?;
        self.byte = byte;
        Ok(Blob { purpose: Purpose::Data, byte, bytes: self.take(size)? })
    }

    /// Returns so many bytes.
    fn take(&mut self, size: usize) -> Result<Vec<u8>, OsmError> {
        let start = self.byte;
        let mut bytes = vec![0; size];
        if self.fill(&mut bytes)? < size {
            let reason = format!("the file ends within a blob, {size} bytes were announced");
            return Err(self.damaged(start, &reason));
        }
        Ok(bytes)
    }

    /// Fills a buffer as far as the file lasts and returns how far.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<usize, OsmError> {
        let mut filled = 0;
        while filled < buffer.len() {
            match self.source.read(&mut buffer[filled..]) {
                Ok(0) => break,
                Ok(n) => filled += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(OsmError::unreadable(self.path)(e)),
            }
        }
        self.byte += filled as u64;
        Ok(filled)
    }

    fn damaged(&self, byte: u64, reason: &str) -> OsmError {
        OsmError::Damaged { path: self.path.to_path_buf(), byte, reason: reason.to_owned() }
    }
}

/// Returns the content of a blob, inflated into `buffer` if need be.
pub(super) fn content<'a>(blob: &'a [u8], buffer: &'a mut Vec<u8>) -> Result<&'a [u8], Fault> {
    let (mut declared, mut packed) = (None, None);
    for field in Fields::of(blob) {
        match field? {
            (1, Value::Bytes(raw)) => return Ok(raw),
            (2, Value::Number(size)) => declared = Some(size),
            (3, Value::Bytes(zlib)) => packed = Some(zlib),
            (4, Value::Bytes(_)) => return Err(compression("LZMA")),
            (5, Value::Bytes(_)) => return Err(compression("bzip2")),
            (6, Value::Bytes(_)) => return Err(compression("LZ4")),
            (7, Value::Bytes(_)) => return Err(compression("zstd")),
            _ => {}
        }
    }
    let packed = packed.ok_or("a blob without data")?;
    let limit = match declared {
        None => MAX_BLOB_BYTES,
        Some(size) => match usize::try_from(size).ok().filter(|size| *size <= MAX_BLOB_BYTES) {
            Some(size) => size,
            None => return Err("a blob that is to inflate to more than 32 MiB".into()),
        },
    };
    let most = packed.len().saturating_mul(MOST_INFLATED).max(SMALL_BLOB_BYTES);
    let made_to_fill = || {
        Fault::Damaged(format!("a blob that inflates to more than {MOST_INFLATED} times its size"))
    };
    if declared.is_some() && limit > most {
        return Err(made_to_fill());
    }
    let limit = limit.min(most);
    buffer.clear();
    let mut inflated = ZlibDecoder::new(packed).take(limit as u64 + 1);
    let size = inflated
        .read_to_end(buffer)
        .map_err(|e| Fault::Damaged(format!("the compressed data is garbled ({e})")))?;
    if declared.is_none() && size > limit && limit == most {
        return Err(made_to_fill());
    }
    if size > limit || declared.is_some_and(|_| size != limit) {
        return Err("a blob inflates to another size than announced".into());
    }
    Ok(buffer)
}

fn compression(name: &str) -> Fault {
    Fault::Unsupported(format!(
        "the data is compressed by {name}, of which no reader is built in; rewrite the file with \
         `osmium cat in.osm.pbf -o out.osm.pbf`"
    ))
}
