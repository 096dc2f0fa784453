//! Every reader of files from elsewhere, on the seeds of the fuzzer and on mutations of them: the same ones in every
//! run. What the fuzzer does with hours and a nightly compiler (`fuzz/README.md`), this does in seconds.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "common/nightly.rs"]
mod nightly;
#[path = "../fuzz/readers/mod.rs"]
mod readers;

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use nightly::is_nightly;
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use readers::{READERS, Reader};

fn mutations() -> usize {
    if is_nightly() { 12_000 } else { 150 }
}

const MOST_BYTES: usize = 1 << 17;

/// Time that a reader may take for one input, which has at most that many bytes, on a machine that is busy.
const PATIENCE: Duration = Duration::from_secs(10);

const WORDS: [&str; 24] = [
    "0", "-1", "1e308", "-1e308", "1e-320", "18446744073709551616", "4294967296",
    "9007199254740993", "NaN", "inf", "null", "true", "\"", "'", "{", "}", "[", "]]>", "<", "&lt;",
    "\0", "\u{feff}", "\n", "../",
];

fn fuzz() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

fn dictionary() -> Vec<Vec<u8>> {
    let files = fs::read_dir(fuzz()).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        files.filter(|p| p.extension().is_some_and(|e| e == "dict")).collect();
    files.sort();
    let mut words: Vec<Vec<u8>> = WORDS.map(|word| word.as_bytes().to_vec()).into();
    for file in files {
        for line in fs::read_to_string(file).unwrap().lines() {
            let word = line.strip_prefix('"').and_then(|l| l.strip_suffix('"'));
            words.extend(word.map(|word| word.replace("\\\"", "\"").into_bytes()));
        }
    }
    words
}

fn seeds(name: &str) -> Vec<Vec<u8>> {
    let folder = fuzz().join("seeds").join(name);
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

fn mutated(seeds: &[Vec<u8>], words: &[Vec<u8>], rng: &mut StdRng) -> Vec<u8> {
    let mut bytes = seeds.choose(rng).unwrap().clone();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..=bytes.len());
        let end = (at + rng.random_range(0..40)).min(bytes.len());
        match rng.random_range(0..9) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            1 if at < bytes.len() => bytes[at] = rng.random(),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => drop(bytes.splice(at..at, words.choose(rng).unwrap().clone())),
            5 => drop(bytes.splice(at..end, words.choose(rng).unwrap().clone())),
            6 => number(&mut bytes, at, words.choose(rng).unwrap()),
            7 => {
                // The same again and again, now and then as deep and as long as it gets.
                let most = MOST_BYTES / (end - at).max(1);
                let times = if rng.random_ratio(1, 8) { most } else { rng.random_range(1..400) };
                let part = bytes[at..end].repeat(times.max(1));
                bytes.splice(at..at, part);
            }
            _ => {
                let other = seeds.choose(rng).unwrap();
                let from = rng.random_range(0..=other.len());
                bytes.splice(at..end, other[from..].iter().copied());
            }
        }
        bytes.truncate(MOST_BYTES);
    }
    bytes
}

fn number(bytes: &mut Vec<u8>, at: usize, by: &[u8]) {
    let is_of_number = |b: &u8| b.is_ascii_digit() || *b == b'.';
    let Some(start) = bytes[at..].iter().position(is_of_number).map(|i| at + i) else { return };
    let length = bytes[start..].iter().position(|b| !is_of_number(b));
    bytes.splice(start..length.map_or(bytes.len(), |l| start + l), by.iter().copied());
}

/// Gives bytes to a reader; returns what is wrong with how it takes them.
fn tried(name: &str, reader: Reader, bytes: &[u8]) -> Option<String> {
    let start = Instant::now();
    let result = catch_unwind(|| reader(bytes));
    let what = match result {
        Err(_) => "panics".to_owned(),
        Ok(()) if start.elapsed() > PATIENCE => format!("takes {:?}", start.elapsed()),
        Ok(()) => return None,
    };
    let path = std::env::temp_dir().join(format!("reader-{name}-{}", bytes.len()));
    fs::write(&path, bytes).unwrap();
    Some(format!("{name} {what}; the input is in {}", path.display()))
}

#[test]
fn no_reader_panics_hangs_or_reads_back_otherwise() {
    let words = dictionary();
    let count = mutations();
    let wrong = READERS.par_iter().flat_map_iter(|(name, reader)| {
        let seeds = seeds(name);
        assert!(!seeds.is_empty(), "{name} has no seeds");
        let mut rng = StdRng::seed_from_u64(name.bytes().map(u64::from).sum());
        let start = Instant::now();
        let mutations: Vec<Vec<u8>> =
            (0..count).map(|_| mutated(&seeds, &words, &mut rng)).collect();
        let wrong: Vec<String> = seeds
            .iter()
            .chain(&mutations)
            .filter_map(|bytes| tried(name, *reader, bytes))
            .take(3)
            .collect();
        eprintln!("{name}: {} seeds, {count} mutations, {:?}", seeds.len(), start.elapsed());
        wrong
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_folder_of_seeds_has_a_reader_that_takes_one_of_them() {
    let mut folders: Vec<String> = fs::read_dir(fuzz().join("seeds"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    folders.sort();
    let mut names = READERS.map(|(name, _)| name.to_owned());
    names.sort();
    assert_eq!(folders, names);
}
