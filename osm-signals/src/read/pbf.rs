//! The two passes over a PBF file.
//!
//! Blobs are inflated and decoded on all threads, some megabytes at a time, and put together in
//! the order of the file. The second pass reads only those blobs again that have nodes.

use std::io::{Read, Seek};
use std::path::Path;

use osmpbfreader::osmformat::HeaderBlock;
use protobuf::Message;
use rayon::prelude::*;

use super::block::Block;
use super::collect::{Streets, complete};
use super::format::no_streets;
use super::frame::{Blob, Blobs, Spot, content};
use super::{Fault, Progress};
use crate::OsmError;
use crate::extract::Extract;

/// Stored bytes that are decoded at a time.
const BATCH_BYTES: usize = 4 * 1024 * 1024;

/// Features that a file may ask of its reader.
const FEATURES: [&str; 2] = ["OsmSchema-V0.6", "DenseNodes"];

/// Reads what is needed of a PBF file; `path` is for messages only.
///
/// # Errors
///
/// [`OsmError::Damaged`] when it cannot be read to its end or needs what this reader does not have,
/// [`OsmError::Nothing`] without any drivable way, [`OsmError::Unreadable`] when reading fails.
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
        for part in decoded(path, batch, |block| block.places(&extract.nodes)) {
            part?.1.put(&mut extract);
        }
        progress(size + blobs.byte(), in_all);
        rest = later;
    }
    progress(in_all, in_all);
    complete(path, extract)
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
        match &*blob.kind {
            "OSMHeader" => check(&blob.bytes).map_err(|fault| fault.at(path, blob.spot.0))?,
            _ if first => return Err(Fault::from("no header of a PBF file").at(path, 0)),
            "OSMData" => {
                stored += blob.bytes.len();
                batch.push(blob);
            }
            _ => {}
        }
    }
    Ok(batch)
}

/// Checks that this reader has all that a file needs.
fn check(header: &[u8]) -> Result<(), Fault> {
    let header = HeaderBlock::parse_from_bytes(&content(header)?).map_err(|e| e.to_string())?;
    match header.required_features.iter().find(|feature| !FEATURES.contains(&feature.as_str())) {
        None => Ok(()),
        Some(feature) => Err(format!(
            "the file needs the feature `{feature}`, which this reader does not have; take an extract of the present \
             state, as Geofabrik and BBBike offer"
        )
        .into()),
    }
}

/// Returns what is found in each blob, in the order of the blobs.
fn decoded<T: Send>(
    path: &Path,
    batch: Vec<Blob>,
    decode: impl Fn(&Block) -> Result<T, Fault> + Sync,
) -> Vec<Result<(Spot, T), OsmError>> {
    let each = batch.into_par_iter().map(|blob| {
        let block = content(&blob.bytes).and_then(|bytes| Block::parse(&bytes));
        let found = block.and_then(|block| decode(&block));
        found.map(|found| (blob.spot, found)).map_err(|fault| fault.at(path, blob.spot.0))
    });
    each.collect()
}
