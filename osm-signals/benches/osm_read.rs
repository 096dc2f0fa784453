//! The benchmark of reading extracts: speed, memory and growth.
//!
//! `cargo bench -p osm-signals --bench osm_read [-- FILE.osm.pbf]`; prints Markdown. Without a file it takes the
//! largest extract beside the repository, or writes a town of its own. The file is repeated with
//! other ids and places, so that the cost of a larger one shows; every measure is taken in a
//! process of its own, interleaved, because memory adds up and machines are shared and noisy.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark may panic and print")]

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use osm_signals::read::read;
use osmpbfreader::fileformat::{Blob, BlobHeader};
use osmpbfreader::osmformat::{DenseNodes, PrimitiveBlock, PrimitiveGroup, Way};
use osmpbfreader::{OsmPbfReader, primitive_block_from_blob};
use protobuf::Message;

/// How often the file is repeated.
const COPIES: [i64; 4] = [1, 4, 16, 64];

/// Interleaved rounds.
const ROUNDS: usize = 3;

/// What is added to the ids of a copy; more than any id of OpenStreetMap.
const ID_SHIFT: i64 = 20_000_000_000;

/// What is added to the longitudes of a copy, nanodegrees.
const PLACE_SHIFT: i64 = 100_000_000;

/// Speed to reach, megabytes of PBF per minute and core.
const LEAST_MB_PER_MINUTE: f64 = 40.0;

/// Memory to stay below: so many times what is kept, and so many megabytes beside it.
const MOST_MEMORY: (f64, f64) = (6.0, 300.0);

/// Argument that makes this program read one file and print its measures.
const CHILD: &str = "--measure";

/// Bytes of a megabyte.
const MB: f64 = 1e6;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, path] = &*args
        && flag == CHILD
    {
        return measure(Path::new(path));
    }
    // `cargo test --benches` builds and starts this too; only `cargo bench` passes `--bench`.
    if !args.iter().any(|arg| arg == "--bench") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let given = args.iter().find(|arg| !arg.starts_with("--")).map(PathBuf::from);
    let source = given.or_else(largest);
    let name = source.as_deref().and_then(Path::file_name).map(|n| n.display().to_string());
    let blocks = source.as_deref().map_or_else(synthetic, blocks);
    let files = COPIES.map(|copies| {
        let path = folder.path().join(format!("{copies}.osm.pbf"));
        write(&path, &blocks, copies);
        path
    });

    let cores = std::thread::available_parallelism().unwrap().get();
    let mut measures = vec![(Vec::new(), Vec::new()); COPIES.len()];
    for _ in 0..ROUNDS {
        for (path, (one, all)) in files.iter().zip(&mut measures) {
            one.push(child(path, 1));
            all.push(child(path, cores));
        }
    }
    println!("### Reading {}\n", name.as_deref().unwrap_or("a town made for this"));
    println!(
        "Repeated with other ids and places, median of {ROUNDS} interleaved rounds, each in a \
         process of its own; memory is VmHWM on {cores} threads.\n"
    );
    println!(
        "| copies | PBF, MB | ways | one thread, s | MB/min | {cores} threads, s | MB/min | kept, \
         MB | peak, MB | allowed, MB |"
    );
    println!("|{}", " ---: |".repeat(10));
    let (mut slowest, mut fits) = (f64::INFINITY, true);
    let mut cost = Vec::new();
    for ((copies, path), (one, all)) in COPIES.iter().zip(&files).zip(&mut measures) {
        let size = fs::metadata(path).unwrap().len() as f64 / MB;
        let (single, several) = (median(one, |m| m.seconds), median(all, |m| m.seconds));
        let (kept, peak) = (all[0].kept / MB, median(all, |m| m.peak) / MB);
        let allowed = MOST_MEMORY.0 * kept + MOST_MEMORY.1;
        let ways = all[0].ways;
        println!(
            "| {copies} | {size:.2} | {ways:.0} | {single:.3} | {:.0} | {several:.3} | {:.0} | \
             {kept:.2} | {peak:.1} | {allowed:.1} |",
            size / single * 60.0,
            size / several * 60.0
        );
        slowest = slowest.min(size / single * 60.0);
        fits &= peak <= allowed;
        cost.push(single / size);
    }
    let word = |met| if met { "met" } else { "MISSED" };
    let growth = cost[cost.len() - 1] / cost[1];
    println!();
    println!(
        "- At least {LEAST_MB_PER_MINUTE} MB per minute and core: {}, {slowest:.0} at worst",
        word(slowest >= LEAST_MB_PER_MINUTE)
    );
    println!("- Memory of at most {} x kept + {} MB: {}", MOST_MEMORY.0, MOST_MEMORY.1, word(fits));
    println!(
        "- Linear: a megabyte of {} copies costs {growth:.2} times one of {}\n",
        COPIES[COPIES.len() - 1],
        COPIES[1]
    );
}

/// What one reading took.
#[derive(Debug, Clone, Copy)]
struct Measure {
    seconds: f64,
    peak: f64,
    kept: f64,
    ways: f64,
}

/// Reads a file and prints what it took.
fn measure(path: &Path) {
    let start = Instant::now();
    let extract = read(path, &|_, _| {}).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak: f64 = peak.trim().trim_end_matches("kB").trim().parse().unwrap();
    println!("{seconds} {} {} {}", peak * 1024.0, extract.kept_bytes(), extract.ways.len());
}

fn child(path: &Path, threads: usize) -> Measure {
    let output = Command::new(std::env::current_exe().unwrap())
        .args([CHILD.as_ref(), path.as_os_str()])
        .env("RAYON_NUM_THREADS", threads.to_string())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let numbers: Vec<f64> = text.split_whitespace().map(|n| n.parse().unwrap()).collect();
    let [seconds, peak, kept, ways] = numbers[..] else { panic!("{text}") };
    Measure { seconds, peak, kept, ways }
}

fn median(measures: &mut [Measure], of: impl Fn(&Measure) -> f64) -> f64 {
    measures.sort_by(|a, b| of(a).total_cmp(&of(b)));
    of(&measures[measures.len() / 2])
}

/// Returns the largest extract that lies beside the repository.
fn largest() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/osm");
    let files = fs::read_dir(folder).ok()?.map(|entry| entry.unwrap().path());
    let pbf = files.filter(|path| path.extension().is_some_and(|e| e == "pbf"));
    pbf.max_by_key(|path| fs::metadata(path).unwrap().len())
}

/// Returns the blocks of a file.
fn blocks(path: &Path) -> Vec<PrimitiveBlock> {
    let mut reader = OsmPbfReader::new(File::open(path).unwrap());
    reader.blobs().map(|blob| primitive_block_from_blob(&blob.unwrap()).unwrap()).collect()
}

/// Returns the blocks of a town of 200 by 200 streets with a signal at every fourth crossing.
fn synthetic() -> Vec<PrimitiveBlock> {
    const SIDE: i64 = 200;
    const TEXTS: [&str; 7] =
        ["", "highway", "traffic_signals", "residential", "lanes", "2", "name"];
    let block = |group: PrimitiveGroup| {
        let mut block = PrimitiveBlock::new();
        let texts = TEXTS.map(|text| text.as_bytes().to_vec());
        block.stringtable.mut_or_insert_default().s = texts.to_vec();
        block.primitivegroup.push(group);
        block
    };
    let mut blocks = Vec::new();
    for row in 0..SIDE {
        let mut nodes = DenseNodes::new();
        for column in 0..SIDE {
            let first = column == 0;
            nodes.id.push(if first { 1 + row * SIDE } else { 1 });
            nodes.lat.push(if first { 400_000_000 + row * 10_000 } else { 0 });
            nodes.lon.push(if first { -1_000_000_000 } else { 10_000 });
            let signal = row % 2 == 0 && column % 2 == 0;
            nodes.keys_vals.extend_from_slice(if signal { &[1, 2, 0] } else { &[0] });
        }
        blocks.push(block(PrimitiveGroup { dense: Some(nodes).into(), ..PrimitiveGroup::new() }));
    }
    for line in 0..SIDE {
        let ways = [(line * SIDE, 1), (line, SIDE)].into_iter().enumerate();
        let ways = ways.map(|(i, (start, step))| Way {
            id: Some(1 + 2 * line + i as i64),
            keys: vec![1, 4, 6],
            vals: vec![3, 5, 3],
            refs: std::iter::once(1 + start)
                .chain(std::iter::repeat_n(step, SIDE as usize - 1))
                .collect(),
            ..Way::new()
        });
        blocks.push(block(PrimitiveGroup { ways: ways.collect(), ..PrimitiveGroup::new() }));
    }
    blocks
}

/// Writes the blocks several times, nodes before ways before relations, as extracts have them.
fn write(path: &Path, blocks: &[PrimitiveBlock], copies: i64) {
    let mut file = BufWriter::new(File::create(path).unwrap());
    blob(&mut file, "OSMHeader", b"");
    let kind = |block: &PrimitiveBlock| {
        let group = block.primitivegroup.first();
        let has = |has: fn(&PrimitiveGroup) -> bool| group.is_some_and(has);
        usize::from(has(|g| !g.ways.is_empty())) + 2 * usize::from(has(|g| !g.relations.is_empty()))
    };
    for wanted in 0..3 {
        for copy in 0..copies {
            for block in blocks.iter().filter(|block| kind(block) == wanted) {
                let mut block = block.clone();
                shift(&mut block, copy);
                blob(&mut file, "OSMData", &block.write_to_bytes().unwrap());
            }
        }
    }
    file.flush().unwrap();
}

/// Gives a block other ids and places; of differences only the first changes.
fn shift(block: &mut PrimitiveBlock, copy: i64) {
    let ids = copy * ID_SHIFT;
    let first = |differences: &mut Vec<i64>| {
        if let Some(first) = differences.first_mut() {
            *first += ids;
        }
    };
    block.lon_offset = Some(block.lon_offset() + copy * PLACE_SHIFT);
    for group in &mut block.primitivegroup {
        group.nodes.iter_mut().for_each(|node| node.id = node.id.map(|id| id + ids));
        if let Some(dense) = group.dense.as_mut() {
            first(&mut dense.id);
        }
        for way in &mut group.ways {
            way.id = way.id.map(|id| id + ids);
            first(&mut way.refs);
        }
        for relation in &mut group.relations {
            relation.id = relation.id.map(|id| id + ids);
            first(&mut relation.memids);
        }
    }
}

/// Writes a blob with its header.
fn blob(file: &mut impl Write, kind: &str, content: &[u8]) {
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
    zlib.write_all(content).unwrap();
    let mut blob = Blob::new();
    blob.raw_size = Some(content.len() as i32);
    blob.zlib_data = Some(zlib.finish().unwrap());
    let blob = blob.write_to_bytes().unwrap();
    let mut header = BlobHeader::new();
    header.set_type(kind.to_owned());
    header.set_datasize(blob.len() as i32);
    let header = header.write_to_bytes().unwrap();
    file.write_all(&(header.len() as u32).to_be_bytes()).unwrap();
    file.write_all(&header).unwrap();
    file.write_all(&blob).unwrap();
}
