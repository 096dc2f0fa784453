//! The two passes over a PBF file.
//!
//! Blobs are inflated and decoded on all threads, some megabytes at a time, and put together in
//! the order of the file. The second pass reads only those blobs again that have nodes.

use std::io::{Read, Seek};
use std::path::Path;

use rayon::prelude::*;

use super::block::Block;
use super::collect::{Streets, complete};
use super::fault::{no_streets, placed};
use super::format::{Content, Format, expect};
use super::frame::{Blob, Blobs, Purpose, content};
use super::wire::{Fields, Value};
use super::{Fault, Progress};
use crate::OsmError;
use crate::extract::Extract;

/// Stored bytes that are decoded at a time.
const BATCH_BYTES: usize = 4 * 1024 * 1024;

/// Features that a file may ask of its reader.
const FEATURES: [&[u8]; 2] = [b"OsmSchema-V0.6", b"DenseNodes"];

/// Field of the file's header that names such a feature.
const REQUIRED_FEATURE: u32 = 4;

/// Where a blob lies, and its size.
type Spot = (u64, usize);

/// Reads what is needed of a PBF file; `path` is for messages only.
///
/// # Errors
///
/// [`OsmError::Damaged`] when it cannot be read to its end, [`OsmError::Malformed`] when it needs
/// something that this reader does not have, [`OsmError::Nothing`] without any drivable way,
/// [`OsmError::Unreadable`] when reading fails.
pub fn read_pbf<R: Read + Seek>(
    path: &Path,
    source: &mut R,
    progress: Progress<'_>,
) -> Result<Extract, OsmError> {
    let (mut blobs, size) = Blobs::of(path, source)?;
    if size == 0 {
        expect(path, Format::Pbf, Content::Empty)?;
    }
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
        for part in decoded(path, batch, |block| block.places(&extract.nodes)) {
            part?.1.put(&mut extract);
        }
        progress(size + blobs.byte(), in_all);
        rest = later;
    }
    complete(&mut extract);
    progress(in_all, in_all);
    placed(path, extract)
}

/// Returns what the first pass keeps, and where the blobs with nodes lie.
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
        for part in decoded(path, batch, |block| block.streets()) {
            let (spot, (part, nodes)) = part?;
            streets.append(part);
            if nodes {
                with_nodes.push(spot);
            }
        }
        progress(blobs.byte());
    }
}

/// Returns the next blobs of data; none at the end of the file.
fn next_batch<R: Read + Seek>(
    path: &Path,
    blobs: &mut Blobs<'_, R>,
) -> Result<Vec<Blob>, OsmError> {
    let (mut batch, mut stored) = (Vec::new(), 0);
    while stored < BATCH_BYTES {
        let first = blobs.byte() == 0;
        let Some(blob) = blobs.next()? else { break };
        match blob.purpose {
            Purpose::Header => check(&blob.bytes).map_err(|fault| fault.at(path, blob.byte))?,
            _ if first => return Err(Fault::from("no header of a PBF file").at(path, 0)),
            Purpose::Other => {}
            Purpose::Data => {
                stored += blob.bytes.len();
                batch.push(blob);
            }
        }
    }
    Ok(batch)
}

/// Checks that this reader has all that a file needs.
fn check(header: &[u8]) -> Result<(), Fault> {
    let mut buffer = Vec::new();
    for field in Fields::of(content(header, &mut buffer)?) {
        let (REQUIRED_FEATURE, Value::Bytes(feature)) = field? else { continue };
        if !FEATURES.contains(&feature) {
            let feature = String::from_utf8_lossy(feature);
            return Err(Fault::Unsupported(format!(
                "the file needs the feature `{feature}`, which this reader does not have; take an \
                 extract of the present state without it, as Geofabrik and BBBike offer"
            )));
        }
    }
    Ok(())
}

/// Returns what is found in each blob, in the order of the blobs.
fn decoded<T: Send>(
    path: &Path,
    batch: Vec<Blob>,
    decode: impl Fn(&Block<'_>) -> Result<T, Fault> + Sync,
) -> Vec<Result<(Spot, T), OsmError>> {
    let each = batch.into_par_iter().map_init(Vec::new, |buffer, blob| {
        let block = content(&blob.bytes, buffer).and_then(Block::parse);
        let found = block.and_then(|block| decode(&block));
        let found = found.map_err(|fault| fault.at(path, blob.byte))?;
        Ok(((blob.byte, blob.bytes.len()), found))
    });
    each.collect()
}
