//! PBF files: the frame of blobs one after the other, the blocks in them, and the two passes over them.
//!
//! Blobs are inflated and decoded on all threads, some megabytes at a time, and put together in
//! the order of the file. The second pass reads only those blobs again that have nodes. Everything is checked: positions
//! in the table of strings, sums of differences, lengths of columns that belong together.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::ZlibDecoder;
use osmpbfreader::fileformat::{self, BlobHeader};
use osmpbfreader::osmformat::{DenseNodes, HeaderBlock, PrimitiveBlock, Relation};
use protobuf::Message;
use rayon::prelude::*;

use super::collect::{Places, Streets, complete};
use super::turns::{Kind, Member};
use super::{Fault, Progress, damaged, no_streets};
use crate::OsmError;
use crate::extract::{Extract, Nodes, Place};

/// Most bytes of a blob's header, by the specification.
const MAX_HEADER_BYTES: usize = 64 * 1024;

/// Most bytes of a blob, stored and inflated, by the specification.
const MAX_BLOB_BYTES: usize = 32 * 1024 * 1024;

/// Most times its size that a larger blob inflates to. Of maps it is two to ten times; what inflates a thousand times is
/// made to fill a memory.
const MOST_INFLATED: usize = 64;

/// Bytes of an inflated blob that are taken however small it was.
const SMALL_BLOB_BYTES: usize = 1 << 20;

/// Where a blob lies, after its header, and its size.
type Spot = (u64, usize);

/// Units of coordinates per degree.
const NANODEGREES: f64 = 1e9;

/// Most nodes of a way and members of a relation; OpenStreetMap takes 2,000 and 32,000.
const MOST_REFS: usize = 1 << 20;

/// Stored bytes that are decoded at a time.
const BATCH_BYTES: usize = 4 * 1024 * 1024;

/// Features that a file may ask of its reader.
const FEATURES: [&str; 2] = ["OsmSchema-V0.6", "DenseNodes"];

#[derive(Debug)]
struct Blob {
    /// `OSMHeader`, `OSMData`, or something that readers may skip.
    kind: String,
    spot: Spot,
    bytes: Vec<u8>,
}

struct Blobs<'a, R> {
    path: &'a Path,
    source: &'a mut R,
    byte: u64,
    size: u64,
}

impl<'a, R: Read + Seek> Blobs<'a, R> {
    fn of(path: &'a Path, source: &'a mut R) -> Result<Self, OsmError> {
        let size = source.seek(SeekFrom::End(0)).and_then(|size| source.rewind().map(|()| size));
        let size = size.map_err(OsmError::unreadable(path))?;
        Ok(Self { path, source, byte: 0, size })
    }

    fn next(&mut self) -> Result<Option<Blob>, OsmError> {
        let (path, start) = (self.path, self.byte);
        let refuse = |reason: String| Err(damaged(path, start, reason));
        if start == self.size {
            return Ok(None);
        }
        let length = self.take(4)?;
        let length = length.into_iter().fold(0, |length, byte| length << 8 | usize::from(byte));
        if length > MAX_HEADER_BYTES {
            return refuse(format!("a header of {length} bytes, more than one can have"));
        }
        let header = match BlobHeader::parse_from_bytes(&self.take(length)?) {
            Ok(header) => header,
            Err(e) => return refuse(format!("the header of a blob is garbled ({e})")),
        };
        let size = header.datasize();
        let Some(size) = usize::try_from(size).ok().filter(|size| *size <= MAX_BLOB_BYTES) else {
            return refuse(format!("a blob of impossible size, {size} bytes"));
        };
        self.blob(header.type_().to_owned(), size).map(Some)
    }

    fn again(&mut self, (byte, size): Spot) -> Result<Blob, OsmError> {
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

    fn take(&mut self, size: usize) -> Result<Vec<u8>, OsmError> {
        let mut bytes = Vec::new();
        let read = self.source.by_ref().take(size as u64).read_to_end(&mut bytes);
        if read.map_err(OsmError::unreadable(self.path))? < size {
            let reason = format!("the file ends within a blob, {size} bytes were announced");
            return Err(damaged(self.path, self.byte, reason));
        }
        self.byte += size as u64;
        Ok(bytes)
    }
}

fn content(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
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

/// Returns what the first pass keeps, and whether there are nodes for the second one.
fn streets_of(block: &PrimitiveBlock) -> Result<(Streets, bool), Fault> {
    let (mut streets, mut nodes) = (Streets::default(), false);
    for group in &block.primitivegroup {
        nodes |= !group.nodes.is_empty() || group.dense.is_some();
        for way in group.ways.iter().filter(|way| way.info.visible != Some(false)) {
            let refs = sums(&way.refs)?;
            streets.way(way.id(), &tags(block, &way.keys, &way.vals)?, &refs);
        }
        for relation in group.relations.iter().filter(|r| r.info.visible != Some(false)) {
            let tags = tags(block, &relation.keys, &relation.vals)?;
            streets.relation(relation.id(), &tags, &members(block, relation)?);
        }
    }
    Ok((streets, nodes))
}

fn places_of(block: &PrimitiveBlock, wanted: &Nodes) -> Result<Places, Fault> {
    let mut places = Places::default();
    for group in &block.primitivegroup {
        for node in group.nodes.iter().filter(|node| node.info.visible != Some(false)) {
            let tags = tags(block, &node.keys, &node.vals)?;
            places.node(wanted, node.id(), &tags, || place(block, node.lat(), node.lon()));
        }
        dense(block, &group.dense, wanted, &mut places)?;
    }
    Ok(places)
}

fn dense(
    block: &PrimitiveBlock,
    dense: &DenseNodes,
    wanted: &Nodes,
    to: &mut Places,
) -> Result<(), Fault> {
    let (rows, visible) = (dense.id.len(), &dense.denseinfo.visible);
    let as_long = visible.is_empty() || visible.len() == rows;
    if dense.lat.len() != rows || dense.lon.len() != rows || !as_long {
        return Err("columns of nodes differ in length".into());
    }
    let (mut id, mut lat, mut lon) = (0, 0, 0);
    let mut texts = dense.keys_vals.iter();
    let mut tags = Vec::new();
    for row in 0..rows {
        id = sum(id, dense.id[row])?;
        lat = sum(lat, dense.lat[row])?;
        lon = sum(lon, dense.lon[row])?;
        tags.clear();
        // No texts at all stand for nodes without tags.
        while !dense.keys_vals.is_empty() {
            let key = texts.next().ok_or("the tags of nodes end too early")?;
            if *key == 0 {
                break;
            }
            let value = texts.next().ok_or("the tags of nodes end too early")?;
            tags.push((text(block, *key)?, text(block, *value)?));
        }
        if visible.get(row) != Some(&false) {
            to.node(wanted, id, &tags, || place(block, lat, lon));
        }
    }
    Ok(())
}

fn place(block: &PrimitiveBlock, lat: i64, lon: i64) -> Option<Place> {
    let degrees = |offset: i64, value: i64| {
        let scaled = value.checked_mul(i64::from(block.granularity()))?;
        Some(scaled.checked_add(offset)? as f64 / NANODEGREES)
    };
    Place::from_degrees(degrees(block.lat_offset(), lat)?, degrees(block.lon_offset(), lon)?)
}

fn text(block: &PrimitiveBlock, index: impl TryInto<usize>) -> Result<&str, Fault> {
    let text = index.try_into().ok().and_then(|index| block.stringtable.s.get(index));
    let text = text.ok_or("a text that is not in the table of texts")?;
    Ok(str::from_utf8(text).map_err(|_| "text that is not UTF-8")?)
}

fn tags<'a>(
    block: &'a PrimitiveBlock,
    keys: &[u32],
    values: &[u32],
) -> Result<Vec<(&'a str, &'a str)>, Fault> {
    if keys.len() != values.len() {
        return Err("more keys than values or the reverse".into());
    }
    keys.iter().zip(values).map(|(k, v)| Ok((text(block, *k)?, text(block, *v)?))).collect()
}

fn members<'a>(block: &'a PrimitiveBlock, relation: &Relation) -> Result<Vec<Member<'a>>, Fault> {
    let Relation { roles_sid, types, .. } = relation;
    let ids = sums(&relation.memids)?;
    if roles_sid.len() != ids.len() || types.len() != ids.len() {
        return Err("columns of members differ in length".into());
    }
    let member = |((id, role), kind): ((i64, &i32), &protobuf::EnumOrUnknown<_>)| {
        let kind = match kind.value() {
            0 => Kind::Node,
            1 => Kind::Way,
            2 => Kind::Relation,
            _ => return Err("a member of an unknown kind".into()),
        };
        Ok((kind, id, text(block, *role)?))
    };
    ids.into_iter().zip(roles_sid).zip(types).map(member).collect()
}

fn sums(differences: &[i64]) -> Result<Vec<i64>, Fault> {
    if differences.len() > MOST_REFS {
        return Err("a way or relation of more nodes or members than one can have".into());
    }
    let mut last = 0;
    let add = |difference: &i64| {
        last = sum(last, *difference)?;
        Ok(last)
    };
    differences.iter().map(add).collect()
}

fn sum(last: i64, difference: i64) -> Result<i64, Fault> {
    Ok(last.checked_add(difference).ok_or("a number that is too large")?)
}

/// Reads what is needed of a PBF file; `path` is for messages only.
pub fn read_pbf<R: Read + Seek>(
    path: &Path,
    source: &mut R,
    progress: Progress<'_>,
) -> Result<Extract, OsmError> {
    let mut blobs = Blobs::of(path, source)?;
    let size = blobs.size;
    let in_all = 2 * size;
    progress(0, in_all);
    let (streets, with_nodes) = first_pass(path, &mut blobs, &|byte| progress(byte, in_all))?;
    let mut extract = streets.finish();
    if extract.ways.is_empty() {
        return Err(no_streets(path));
    }
    let mut rest = &*with_nodes;
    while !rest.is_empty() {
        let mut stored = 0;
        let now = rest.iter().take_while(|(_, size)| {
            let fits = stored < BATCH_BYTES;
            stored += size;
            fits
        });
        let (now, later) = rest.split_at(now.count());
        let batch = now.iter().map(|spot| blobs.again(*spot)).collect::<Result<_, _>>()?;
        for part in decoded(path, batch, |block| places_of(block, &extract.nodes)) {
            part?.1.put(&mut extract);
        }
        progress(size + blobs.byte, in_all);
        rest = later;
    }
    progress(in_all, in_all);
    complete(path, extract)
}

fn first_pass<R: Read + Seek>(
    path: &Path,
    blobs: &mut Blobs<'_, R>,
    progress: &dyn Fn(u64),
) -> Result<(Streets, Vec<Spot>), OsmError> {
    let (mut streets, mut with_nodes) = (Streets::default(), Vec::new());
    loop {
        let batch = next_batch(path, blobs)?;
        if batch.is_empty() {
            return Ok((streets, with_nodes));
        }
        for part in decoded(path, batch, streets_of) {
            let (spot, (part, nodes)) = part?;
            streets.append(part);
            if nodes {
                with_nodes.push(spot);
            }
        }
        progress(blobs.byte);
    }
}

/// Returns the next blobs of data; none at the end of the file.
fn next_batch<R: Read + Seek>(
    path: &Path,
    blobs: &mut Blobs<'_, R>,
) -> Result<Vec<Blob>, OsmError> {
    let (mut batch, mut stored) = (Vec::new(), 0);
    while stored < BATCH_BYTES {
        let first = blobs.byte == 0;
        let Some(blob) = blobs.next()? else { break };
        match &*blob.kind {
            "OSMHeader" => check(&blob.bytes).map_err(|fault| damaged(path, blob.spot.0, fault))?,
            _ if first => return Err(damaged(path, 0, "no header of a PBF file".to_owned())),
            "OSMData" => {
                stored += blob.bytes.len();
                batch.push(blob);
            }
            _ => {}
        }
    }
    Ok(batch)
}

fn check(header: &[u8]) -> Result<(), Fault> {
    let header = HeaderBlock::parse_from_bytes(&content(header)?).map_err(|e| e.to_string())?;
    match header.required_features.iter().find(|feature| !FEATURES.contains(&feature.as_str())) {
        None => Ok(()),
        Some(feature) => Err(format!(
            "the file needs the feature `{feature}`, which this reader does not have; take an extract of the present \
             state, as Geofabrik and BBBike offer"
        )),
    }
}

fn decoded<T: Send>(
    path: &Path,
    batch: Vec<Blob>,
    decode: impl Fn(&PrimitiveBlock) -> Result<T, Fault> + Sync,
) -> Vec<Result<(Spot, T), OsmError>> {
    let each = batch.into_par_iter().map(|blob| {
        let block = content(&blob.bytes)
            .and_then(|bytes| PrimitiveBlock::parse_from_bytes(&bytes).map_err(|e| e.to_string()));
        let found = block.and_then(|block| decode(&block));
        found.map(|found| (blob.spot, found)).map_err(|fault| damaged(path, blob.spot.0, fault))
    });
    each.collect()
}
