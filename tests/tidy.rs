//! Keeps the shape of the source: who may depend on whom, where `unsafe` is, how long files are.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Most lines of a source file.
const MAX_LINES: usize = 400;

/// Modules that each module may use, besides `files`, `hash`, `suggest`, `units` and itself.
const ARROWS: [(&str, &[&str]); 19] = [
    ("stats", &[]),
    ("seed", &[]),
    ("units", &[]),
    ("files", &[]),
    ("hash", &[]),
    ("sheet", &[]),
    ("suggest", &[]),
    ("family", &["sheet"]),
    ("settings", &["family", "traffic"]),
    ("sample", &["family", "seed"]),
    ("nn", &["seed"]),
    ("rl", &["nn", "seed"]),
    ("osm", &["family", "settings", "sheet", "traffic"]),
    ("store", &["family", "sample", "seed"]),
    ("run", &["cli", "family", "nn", "sample", "seed", "settings", "store", "traffic"]),
    ("traffic", &["family", "nn", "rl", "run", "seed", "settings", "sheet", "store"]),
    ("report", &["store", "stats", "sample", "seed", "osm", "settings", "family", "traffic"]),
    ("cli", &["family", "osm", "report", "run", "sample", "settings", "store", "traffic"]),
    ("cartpole", &["family", "nn", "rl", "run", "seed"]),
];

/// Files that may contain `unsafe`.
const UNSAFE: [&str; 1] = ["src/traffic/sim/libsumo/api.rs"];

/// Files that may name the raw declarations.
const RAW: [&str; 2] = ["src/traffic/sim/libsumo/api.rs", "src/traffic/sim/libsumo.rs"];

fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    let mut folders = vec![PathBuf::from(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                files.push((path, text));
            }
        }
    }
    assert!(!files.is_empty(), "no sources in {folder}");
    files.sort();
    files
}

/// The code of a file without its tests and without comments.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

fn module(path: &Path) -> String {
    let part = path.iter().nth(1).unwrap().to_string_lossy();
    part.trim_end_matches(".rs").to_owned()
}

#[test]
fn modules_depend_only_along_the_arrows() {
    let arrows: BTreeMap<_, _> = ARROWS.into_iter().collect();
    for (path, text) in sources("src") {
        let module = module(&path);
        if ["lib", "main"].contains(&module.as_str()) {
            continue;
        }
        let allowed = arrows.get(module.as_str());
        let allowed = allowed.unwrap_or_else(|| panic!("{module} is missing in ARROWS"));
        for (position, _) in code(&text).match_indices("crate::") {
            let code = code(&text);
            let rest = &code[position + "crate::".len()..];
            let used: String =
                rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
            let fine = used == module
                || ["files", "hash", "suggest", "units"].contains(&used.as_str())
                || allowed.contains(&used.as_str())
                || !arrows.contains_key(used.as_str());
            assert!(fine, "{} uses {used}, which {module} may not", path.display());
        }
    }
}

#[test]
fn unsafe_is_in_one_place() {
    for (path, text) in sources("src") {
        let name = path.to_string_lossy().into_owned();
        let code = code(&text);
        if !UNSAFE.contains(&name.as_str()) {
            assert!(!code.contains("unsafe "), "{name} contains unsafe code");
        }
        if !RAW.contains(&name.as_str()) {
            assert!(!code.contains("libsumo_sys"), "{name} names libsumo_sys");
        }
    }
}

#[test]
fn every_file_says_what_it_is_and_is_not_too_long() {
    for folder in ["src", "tests", "libsumo-sys/src"] {
        for (path, text) in sources(folder) {
            let name = path.display();
            assert!(text.starts_with("//!"), "{name} does not start with `//!`");
            let lines = text.lines().count();
            assert!(lines <= MAX_LINES, "{name} has {lines} lines, more than {MAX_LINES}");
        }
    }
}
