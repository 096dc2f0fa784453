//! What no compiler checks: the order of the modules within a crate, what controllers may see, where `unsafe`
//! is, that every file says what it is, and which events the documentation names. The borders between crates need no test.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates that consist of modules.
const CRATES: &str = ". crates/basics crates/control-tasks crates/evaluation crates/learners crates/signals \
    crates/signals-report osm-signals";
/// The only files of ours that may contain `unsafe`.
const UNSAFE: [&str; 4] = [
    "libsumo-sys/src/lib.rs",
    "libsumo-sys/tests/abi.rs",
    "crates/signals/src/sim/libsumo/api.rs",
    "crates/control-tasks/src/mujoco.rs",
];

/// Module to modules of its crate that it names.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// Returns the Rust files beneath a folder of the repository, with their texts.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut open = vec![PathBuf::from(folder)];
    let mut files = Vec::new();
    while let Some(path) = open.pop() {
        if root.join(&path).is_dir() {
            let entries = fs::read_dir(root.join(&path)).unwrap();
            open.extend(entries.map(|entry| path.join(entry.unwrap().file_name())));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push((path.clone(), fs::read_to_string(root.join(path)).unwrap()));
        }
    }
    assert!(!files.is_empty(), "{folder} has no Rust files");
    files
}

/// Returns the lines of a file without its tests and comments.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    code.lines().filter(|line| !line.trim_start().starts_with("//"))
}

/// Adds the modules of its crate that a file's code names.
fn add(uses: &mut Uses, module: &str, text: &str) {
    for path in code(text).flat_map(|line| line.split("crate::").skip(1)) {
        let name: String = path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if name.chars().all(char::is_lowercase) || name.contains('_') {
            uses.entry(module.to_owned()).or_default().insert(name);
        }
    }
}

/// Returns the modules that use themselves by way of others.
fn circle(mut uses: Uses) -> Vec<String> {
    uses.iter_mut().for_each(|(module, used)| used.retain(|name| name != module));
    loop {
        let modules: BTreeSet<String> = uses.keys().cloned().collect();
        let before = uses.len();
        uses.retain(|_, used| used.iter().any(|name| modules.contains(name)));
        if uses.len() == before {
            return uses.into_keys().collect();
        }
    }
}

#[test]
fn modules_of_a_crate_use_each_other_in_one_direction() {
    for name in CRATES.split(' ') {
        let mut uses = Uses::new();
        for (path, text) in sources(&format!("{name}/src")) {
            let within = path.strip_prefix(format!("{name}/src")).unwrap();
            let module = within.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
            if !["lib", "main"].contains(&module) {
                add(&mut uses, module, &text);
            }
        }
        assert_eq!(circle(uses), Vec::<String>::new(), "modules of {name} in a circle");
    }
}

#[test]
fn a_planted_circle_is_found() {
    let mut uses = Uses::new();
    add(&mut uses, "a", "use crate::b::B;");
    add(&mut uses, "b", "// crate::a\nfn b() -> crate::c::C {}");
    assert_eq!(circle(uses.clone()), Vec::<String>::new());
    add(&mut uses, "c", "use crate::a;");
    assert_eq!(circle(uses), ["a", "b", "c"]);
}

#[test]
fn a_controller_sees_observations_and_nothing_else() {
    for (path, text) in sources("crates/signals/src/control") {
        for hidden in ["crate::sim", "crate::env"] {
            let mut lines = code(&text);
            assert!(!lines.any(|l| l.contains(hidden)), "{} names {hidden}", path.display());
        }
    }
}

#[test]
fn every_file_says_what_it_is_and_unsafe_is_in_one_place() {
    for folder in
        ["src", "crates", "osm-signals", "sheet", "libsumo-sys", "python", "tests", "benches"]
    {
        for (path, text) in sources(folder) {
            let name = path.to_str().unwrap();
            assert!(text.starts_with("//!"), "{name} does not start with `//!`");
            // The lint denies unsafe code wherever this is not said.
            assert!(
                !text.contains("unsafe_code") || UNSAFE.contains(&name) || name == "tests/tidy.rs"
            );
        }
    }
}

#[test]
fn the_page_of_files_has_every_event_that_the_commands_print() {
    let words = |text: &str, mark: &str| -> Vec<String> {
        text.split(mark).skip(1).map(|rest| rest.split('"').next().unwrap().to_owned()).collect()
    };
    let mut printed = BTreeSet::new();
    for (_, text) in ["src/cli", "crates/evaluation/src/report"].into_iter().flat_map(sources) {
        let code: String = code(&text).collect();
        for mark in ["\"event\": \"", "\"event\".to_owned(), \""] {
            printed.extend(words(&code, mark));
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/files.md")).unwrap();
    let told: BTreeSet<String> = words(&page, "\"event\":\"").into_iter().collect();
    assert_eq!(printed, told);
}
