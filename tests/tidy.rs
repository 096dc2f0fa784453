//! Keeps the shape of the source: who may depend on whom, where `unsafe` is, how long files are.
//!
//! `cargo test --test tidy -- --nocapture` prints the graph's figures and each circle.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "tidy/mod.rs"]
mod checker;

use std::fs;
use std::path::{Path, PathBuf};

use checker::graph::{Graph, circles};
use checker::modules::crates;
use checker::table::Table;

/// Where the repository is.
const REPO: &str = env!("CARGO_MANIFEST_DIR");

/// Modules outside traffic that may name it: arguments and terminal, the start, what the crate gives out, the list of
/// domains. All others get it through a trait.
const MAY_NAME_TRAFFIC: [&str; 5] = ["cli", "main", "lib", "domains", "python"];

/// Files that may contain `unsafe`.
const UNSAFE: [&str; 1] = ["src/traffic/sim/libsumo/api.rs"];

/// Files that may name the raw declarations.
const RAW: [&str; 3] = [
    "src/traffic/sim/libsumo.rs",
    "src/traffic/sim/libsumo/api.rs",
    "src/traffic/sim/libsumo/place.rs",
];

fn graph() -> Graph {
    checker::read(Path::new(REPO)).unwrap()
}

fn architecture() -> Table {
    let page = fs::read_to_string(Path::new(REPO).join("ARCHITECTURE.md")).unwrap();
    Table::read(&page).unwrap()
}

#[test]
fn no_circle_between_files() {
    let graph = graph();
    let between = graph.between_files();
    let circles = circles(&between);
    let inside: usize = circles.iter().map(|c| c.len()).sum();
    let mut text = String::new();
    for circle in &circles {
        text += &graph.chain(circle);
        text += "  all arrows within:\n";
        text += &graph.inner_arrows(circle);
    }
    let arrows: usize = between.values().map(|to| to.len()).sum();
    let (files, count) = (graph.files(), circles.len());
    println!("{files} files, {arrows} arrows between them, {count} circles with {inside} files");
    print!("{text}");
    assert!(files > 200, "only {files} files: are all sources read?");
    assert!(circles.is_empty(), "{inside} files in circles:\n{text}");
}

#[test]
fn modules_use_those_above_them() {
    let graph = graph();
    let against = architecture().against_the_order();
    let (modules, arrows) = (graph.modules().len(), graph.between_modules().len());
    let count = against.len();
    println!("{modules} modules, {arrows} arrows between them, {count} against the order");
    assert!(
        against.is_empty(),
        "{count} arrows of ARCHITECTURE.md go to a module further below:\n{}",
        against.join("\n")
    );
}

#[test]
fn modules_depend_exactly_along_the_arrows_of_the_architecture() {
    let (graph, table) = (graph(), architecture());
    let wrong = table.differences(&graph);
    assert!(
        wrong.is_empty(),
        "{}\n\nThe table of ARCHITECTURE.md as the sources have it:\n\n{}",
        wrong.join("\n"),
        table.remade(&graph)
    );
}

#[test]
fn only_the_terminal_names_traffic() {
    let graph = graph();
    let traffic = |m: &str| m == "traffic" || m.starts_with("traffic/");
    let named = graph.named_from_outside(traffic, |m| MAY_NAME_TRAFFIC.contains(&m));
    let places: Vec<_> = named.values().flatten().map(String::as_str).collect();
    let count = named.len();
    println!("{count} files outside name traffic, at {} places", places.len());
    assert!(named.is_empty(), "{count} files name traffic:\n{}", places.join("\n"));
}

/// Returns the files in these folders of every crate, with their paths from the root and their texts.
fn sources(folders: &[&str]) -> Vec<(PathBuf, String)> {
    let root = Path::new(REPO);
    let mut files = Vec::new();
    let crates = crates(root).unwrap();
    let mut open: Vec<PathBuf> =
        crates.iter().flat_map(|(path, _)| folders.iter().map(|f| path.join(f))).collect();
    while let Some(folder) = open.pop() {
        let Ok(entries) = fs::read_dir(root.join(&folder)) else { continue };
        for entry in entries {
            let path = folder.join(entry.unwrap().file_name());
            if root.join(&path).is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(root.join(&path)).unwrap();
                files.push((path, text));
            }
        }
    }
    assert!(files.len() > 200, "only {} files in {folders:?}", files.len());
    files.sort();
    files
}

/// The code of a file without its tests and without comments.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

#[test]
fn unsafe_is_in_one_place() {
    // A crate of declarations is there for it.
    let rest = |path: &PathBuf| !path.starts_with("libsumo-sys");
    for (path, text) in sources(&["src"]).into_iter().filter(|(path, _)| rest(path)) {
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
fn every_file_says_what_it_is() {
    for (path, text) in sources(&["src", "tests", "benches", "examples"]) {
        let name = path.display();
        assert!(text.starts_with("//!"), "{name} does not start with `//!`");
    }
}
