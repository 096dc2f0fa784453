//! Writes the seeds: the small town of the unit tests in all formats.

#[path = "../osm-signals/src/read/sample.rs"]
mod sample;

use std::path::{Path, PathBuf};
use std::{fs, io};

use protobuf::Message;
use sample::{Columns, Packing, Town};

fn main() -> io::Result<()> {
    let town = Town::small();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds");
    for (packing, columns, name) in [
        (Packing::Raw, Columns::Dense, "raw-dense"),
        (Packing::Raw, Columns::Plain, "raw-plain"),
        (Packing::Zlib, Columns::Dense, "zlib-dense"),
    ] {
        write(folder.join("pbf").join(name), &town.pbf(packing, columns))?;
    }
    let dense = &["block-nodes", "block-ways", "block-relations"][..];
    for (columns, names) in [(Columns::Dense, dense), (Columns::Plain, &["block-nodes-plain"])] {
        for (block, name) in town.blocks(columns).iter().zip(names) {
            write(folder.join("pbf").join(name), &block.write_to_bytes()?)?;
        }
    }
    write(folder.join("xml/town"), town.xml().as_bytes())?;
    write(folder.join("gz/town"), &town.gz())
}

fn write(path: PathBuf, bytes: &[u8]) -> io::Result<()> {
    fs::create_dir_all(path.parent().unwrap_or(&path))?;
    fs::write(path, bytes)
}
