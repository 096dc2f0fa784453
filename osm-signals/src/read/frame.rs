//! The frame of a PBF file: blobs one after the other, each with a header, and their compression.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::ZlibDecoder;
use osmpbfreader::fileformat::{self, BlobHeader};
use protobuf::Message;

use super::Fault;
use crate::OsmError;

/// Most bytes of a blob's header, by the specification.
const MAX_HEADER_BYTES: usize = 64 * 1024;

/// Most bytes of a blob, stored and inflated, by the specification.
pub(super) const MAX_BLOB_BYTES: usize = 32 * 1024 * 1024;

/// Most times its size that a larger blob inflates to. Of maps it is two to ten times; what inflates a thousand times is
/// made to fill a memory.
const MOST_INFLATED: usize = 64;

/// Bytes of an inflated blob that are taken however small it was.
const SMALL_BLOB_BYTES: usize = 1 << 20;

/// Where a blob lies, after its header, and its size.
pub(super) type Spot = (u64, usize);

/// A blob as it is stored.
#[derive(Debug)]
pub(super) struct Blob {
    /// `OSMHeader`, `OSMData`, or something that readers may skip.
    pub(super) kind: String,
    pub(super) spot: Spot,
    pub(super) bytes: Vec<u8>,
}

/// The blobs of a file.
pub(super) struct Blobs<'a, R> {
    path: &'a Path,
    source: &'a mut R,
    byte: u64,
    pub(super) size: u64,
}

impl<'a, R: Read + Seek> Blobs<'a, R> {
    pub(super) fn of(path: &'a Path, source: &'a mut R) -> Result<Self, OsmError> {
        let size = source.seek(SeekFrom::End(0)).and_then(|size| source.rewind().map(|()| size));
        let size = size.map_err(OsmError::unreadable(path))?;
        Ok(Self { path, source, byte: 0, size })
    }

    /// Returns where reading has come to.
    pub(super) fn byte(&self) -> u64 {
        self.byte
    }

    /// Returns the next blob; `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<Blob>, OsmError> {
        let (path, start) = (self.path, self.byte);
        let damaged = |reason: String| Err(Fault::from(reason).at(path, start));
        if start == self.size {
            return Ok(None);
        }
        let length = self.take(4)?;
        let length = length.into_iter().fold(0, |length, byte| length << 8 | usize::from(byte));
        if length > MAX_HEADER_BYTES {
            return damaged(format!("a header of {length} bytes, more than one can have"));
        }
        let header = match BlobHeader::parse_from_bytes(&self.take(length)?) {
            Ok(header) => header,
            Err(e) => return damaged(format!("the header of a blob is garbled ({e})")),
        };
        let size = header.datasize();
        let Some(size) = usize::try_from(size).ok().filter(|size| *size <= MAX_BLOB_BYTES) else {
            return damaged(format!("a blob of impossible size, {size} bytes"));
        };
        self.blob(header.type_().to_owned(), size).map(Some)
    }

    /// Returns a blob of data again.
    pub(super) fn again(&mut self, (byte, size): Spot) -> Result<Blob, OsmError> {
        self.seek(byte)?;
        self.blob("OSMData".to_owned(), size)
    }

    fn blob(&mut self, kind: String, size: usize) -> Result<Blob, OsmError> {
        Ok(Blob { kind, spot: (self.byte, size), bytes: self.take(size)? })
    }

    fn seek(&mut self, byte: u64) -> Result<(), OsmError> {
        self.byte = byte;
        let at = self.source.seek(SeekFrom::Start(byte));
        at.map(drop).map_err(OsmError::unreadable(self.path))
    }

    /// Returns so many bytes.
    fn take(&mut self, size: usize) -> Result<Vec<u8>, OsmError> {
        let mut bytes = Vec::new();
        let read = self.source.by_ref().take(size as u64).read_to_end(&mut bytes);
        if read.map_err(OsmError::unreadable(self.path))? < size {
            let reason = format!("the file ends within a blob, {size} bytes were announced");
            return Err(Fault::from(reason).at(self.path, self.byte));
        }
        self.byte += size as u64;
        Ok(bytes)
    }
}

/// Returns the content of a blob.
pub(super) fn content(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    let blob = fileformat::Blob::parse_from_bytes(bytes).map_err(|e| e.to_string())?;
    if let Some(raw) = blob.raw {
        return Ok(raw);
    }
    let packed = blob.zlib_data.as_deref();
    let packed = packed.ok_or(
        "a blob that zlib did not compress; rewrite the file with `osmium cat in.osm.pbf -o out.osm.pbf`",
    )?;
    let most = packed.len().saturating_mul(MOST_INFLATED).max(SMALL_BLOB_BYTES);
    let limit = most.min(MAX_BLOB_BYTES);
    let mut inflated = Vec::new();
    ZlibDecoder::new(packed)
        .take(limit as u64 + 1)
        .read_to_end(&mut inflated)
        .map_err(|e| format!("the compressed data is garbled ({e})"))?;
    if inflated.len() > limit {
        return Err("a blob that inflates to more than it can have".into());
    }
    if blob.raw_size.is_some_and(|size| usize::try_from(size) != Ok(inflated.len())) {
        return Err("a blob inflates to another size than announced".into());
    }
    Ok(inflated)
}
