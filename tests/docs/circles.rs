//! The modules of a crate use each other in one direction, and the page of files names the events that commands print.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const CRATES: &str = ". crates/basics crates/control-tasks crates/evaluation crates/learners crates/signals \
    crates/signals-report osm-signals";

/// Module to modules of its crate that it names.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// Returns the Rust files beneath a folder of the repository, with their texts but for tests and comments.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap().lines();
            let code = code.filter(|line| !line.trim_start().starts_with("//"));
            files.push((path, code.collect::<Vec<_>>().join("\n")));
        }
    }
    files
}

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
        let (source, mut uses) = (PathBuf::from(name).join("src"), Uses::new());
        for (path, code) in sources(&source) {
            let first = path.strip_prefix(&source).unwrap().iter().next().unwrap();
            let module = first.to_str().unwrap().trim_end_matches(".rs");
            for path in code.split("crate::").skip(1).filter(|_| !["lib", "main"].contains(&module))
            {
                let name: String =
                    path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if name.chars().all(char::is_lowercase) || name.contains('_') {
                    uses.entry(module.to_owned()).or_default().insert(name);
                }
            }
        }
        assert!(!uses.is_empty(), "{name} has no modules");
        assert_eq!(circle(uses), Vec::<String>::new(), "modules of {name} in a circle");
    }
}

#[test]
fn a_controller_sees_observations_and_nothing_else() {
    for (path, code) in sources(Path::new("crates/signals/src/control")) {
        let hidden = ["crate::sim", "crate::env"].iter().any(|hidden| code.contains(hidden));
        assert!(!hidden, "{} names the simulator or the environment", path.display());
    }
}

#[test]
fn the_page_of_files_has_every_event_that_the_commands_print() {
    let words = |text: &str, mark: &str| -> Vec<String> {
        text.split(mark).skip(1).map(|rest| rest.split('"').next().unwrap().to_owned()).collect()
    };
    let mut printed = BTreeSet::new();
    for folder in ["src/cli", "crates/evaluation/src/report"] {
        for (_, code) in sources(Path::new(folder)) {
            for mark in
                ["\"event\": \"", "[\"event\"] = \"", "events(\"", "\"event\".to_owned(), \""]
            {
                printed.extend(words(&code, mark));
            }
        }
    }
    let page = fs::read_to_string("docs/files.md").unwrap();
    assert_eq!(printed, words(&page, "\"event\":\"").into_iter().collect());
}
