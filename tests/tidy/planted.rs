//! Faults planted into small trees: the checker finds each, and finds none where there is none.

use std::collections::BTreeSet;
use std::fs;

use super::graph::{Graph, circles};
use super::read;
use super::table::Table;

/// Writes files below a new folder and reads the graph of what was written.
fn planted(files: &[(&str, &str)]) -> Graph {
    try_planted(files).unwrap()
}

fn try_planted(files: &[(&str, &str)]) -> Result<Graph, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("src")).unwrap();
    let manifest = "[package]\nname = \"tsc-family\"\n";
    fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
    for (path, text) in files {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    read(folder.path())
}

/// Returns each circle's files.
fn found(graph: &Graph) -> Vec<BTreeSet<String>> {
    let circles = circles(&graph.between_files());
    circles.iter().map(|c| c.iter().map(|f| graph.name(*f)).collect()).collect()
}

/// Asserts that `src/a.rs` and `src/b.rs` make the only circle.
fn assert_a_and_b(a: &str, b: &str) {
    let graph = planted(&[
        ("src/lib.rs", "pub mod a;\npub mod b;\npub mod c;\n"),
        ("src/a.rs", a),
        ("src/b.rs", b),
        ("src/c.rs", "use crate::a::A;\nuse crate::b::B;\npub fn c(_: A, _: B) {}\n"),
    ]);
    let expected = BTreeSet::from(["src/a.rs".to_owned(), "src/b.rs".to_owned()]);
    assert_eq!(found(&graph), [expected]);
}

#[test]
fn a_circle_through_a_type_that_a_macro_declares_is_found() {
    assert_a_and_b(
        "declared! { pub struct A { b: crate::b::B } }\n",
        "macro_rules! of { ($($f:ident)*) => { pub struct B { $(pub $f: A,)* } } }\n\
         use crate::a::A;\nof!(x y);\n",
    );
}

const TYPE_B_NAMES_A: &str = "use crate::a::A;\npub struct B(A);\n";

#[test]
fn a_circle_of_two_files_is_found_with_its_lines() {
    let graph = planted(&[
        ("src/lib.rs", "pub mod a;\npub mod b;\n"),
        ("src/a.rs", "//! A.\n\nuse crate::b::B;\npub struct A(Option<Box<B>>);\n"),
        ("src/b.rs", TYPE_B_NAMES_A),
    ]);
    let circles = circles(&graph.between_files());
    assert_eq!(
        graph.chain(&circles[0]),
        "circle of 2 files, the shortest way round:\n  \
         src/a.rs:3 names `crate::b::B` of src/b.rs\n  \
         src/b.rs:1 names `crate::a::A` of src/a.rs\n"
    );
}

#[test]
fn a_circle_through_a_group_of_imports_is_found() {
    assert_a_and_b("use crate::{b::{B, other}, c};\npub struct A(B);\n", TYPE_B_NAMES_A);
}

#[test]
fn a_circle_through_super_is_found() {
    assert_a_and_b("use super::b;\npub struct A(b::B);\n", TYPE_B_NAMES_A);
}

#[test]
fn a_circle_through_a_path_without_import_is_found() {
    assert_a_and_b("pub struct A;\nfn f() -> u8 { crate::b::B::new() }\n", TYPE_B_NAMES_A);
}

#[test]
fn a_circle_through_a_renamed_import_is_found() {
    assert_a_and_b("use crate::b as other;\npub struct A(other::B);\n", TYPE_B_NAMES_A);
}

#[test]
fn a_circle_through_a_glob_is_found() {
    assert_a_and_b("use crate::b::*;\npub struct A(B);\n", TYPE_B_NAMES_A);
}

#[test]
fn a_circle_through_arguments_of_a_macro_is_found() {
    let a = "pub struct A;\nfn f() { println!(\"{}\", crate::b::name()); }\n";
    assert_a_and_b(a, "use crate::a::A;\npub struct B(A);\npub fn name() {}\n");
}

#[test]
fn a_circle_through_an_attribute_is_found() {
    let a = "#[derive(Deserialize)]\npub struct A(#[serde(default = \"crate::b::one\")] u8);\n";
    assert_a_and_b(a, "use crate::a::A;\npub struct B(A);\npub fn one() -> u8 { 1 }\n");
}

#[test]
fn a_circle_through_an_import_within_a_function_is_found() {
    assert_a_and_b("pub struct A;\nfn f() { use crate::b::B; B::new(); }\n", TYPE_B_NAMES_A);
}

#[test]
fn a_circle_through_a_method_of_another_file_is_found() {
    let b = "use crate::a::A;\npub struct B;\nimpl A { pub fn help(&self) {} }\n";
    assert_a_and_b("pub struct A;\nimpl A { fn f(&self) { self.help(); } }\n", b);
}

#[test]
fn a_circle_of_three_through_a_reexport_is_found() {
    let graph = planted(&[
        ("src/lib.rs", "pub mod a;\npub mod b;\npub mod d;\n"),
        ("src/a/mod.rs", "mod inner;\npub use inner::Inner;\n"),
        ("src/a/inner.rs", "use crate::b::B;\npub struct Inner(B);\n"),
        ("src/b.rs", "use crate::d::D;\npub struct B(D);\n"),
        ("src/d.rs", "use crate::a::Inner;\npub struct D(Box<Inner>);\n"),
    ]);
    let expected = ["src/a/inner.rs", "src/b.rs", "src/d.rs"].map(str::to_owned);
    assert_eq!(found(&graph), [BTreeSet::from(expected)]);
}

#[test]
fn types_of_a_parent_that_uses_its_children_are_a_circle() {
    let graph = planted(&[
        ("src/lib.rs", "pub mod a;\n"),
        (
            "src/a/mod.rs",
            "mod child;\npub use child::Child;\npub struct A(Child);\npub struct T;\n",
        ),
        ("src/a/child.rs", "use super::T;\npub struct Child(T);\n"),
    ]);
    let expected = ["src/a/child.rs", "src/a/mod.rs"].map(str::to_owned);
    assert_eq!(found(&graph), [BTreeSet::from(expected)]);
}

#[test]
fn reexports_declarations_tests_and_local_names_are_no_circle() {
    let graph = planted(&[
        ("src/lib.rs", "//! See [`a::A`].\npub mod a;\npub mod b;\npub use a::{T, child};\n"),
        (
            "src/a/mod.rs",
            "mod child;\npub mod score;\npub use child::Child;\npub use score::score;\npub struct T;\n\
             fn f(child: u8) -> u8 { let score = child; score }\n\
             #[cfg(test)]\nmod tests { use super::child::Child; }\n",
        ),
        ("src/a/child.rs", "use super::T;\npub struct Child(T);\n"),
        ("src/a/score.rs", "use crate::a::T;\npub fn score(_: T) {}\n"),
        ("src/b.rs", "use crate::{T, a};\npub fn b(t: T) { a::score(t) }\n"),
    ]);
    assert_eq!(found(&graph), Vec::<BTreeSet<String>>::new());
}

#[test]
fn a_file_of_no_module_is_refused() {
    let refused = try_planted(&[("src/lib.rs", ""), ("src/left.rs", "")]).err();
    assert_eq!(refused.unwrap(), "src/left.rs belongs to no module");
}

/// `family` and `run` use `stats`, `run` also `family` and `units`, which any may; `traffic/env` uses `family`.
const CLEAN: [(&str, &str); 7] = [
    ("src/lib.rs", "mod family;\nmod run;\nmod stats;\nmod traffic;\nmod units;\n"),
    ("src/stats.rs", "pub fn mean() {}\n"),
    ("src/units.rs", "pub struct Metres;\n"),
    ("src/family.rs", "fn f() { crate::stats::mean(); }\npub struct Family;\n"),
    ("src/run.rs", "use crate::{family::Family, stats::mean, units::Metres};\n"),
    ("src/traffic/mod.rs", "pub mod env;\n"),
    ("src/traffic/env.rs", "use crate::family::Family;\npub struct Env(Family);\n"),
];

const PAGE: &str = "# Page\n\n## Arrows\n\n```text\nstats -> nothing\nfamily -> stats\n\
                    run -> family stats\ntraffic -> nothing\ntraffic/env -> family\nlib -> nothing\n\
                    any -> units\n```\n";

fn differences(files: &[(&str, &str)], page: &str) -> Vec<String> {
    Table::read(page).unwrap().differences(&planted(files))
}

#[test]
fn a_clean_tree_has_no_difference_and_no_circle() {
    assert_eq!(differences(&CLEAN, PAGE), Vec::<String>::new());
    assert_eq!(found(&planted(&CLEAN)), Vec::<BTreeSet<String>>::new());
}

#[test]
fn the_table_is_made_from_the_sources() {
    let table = Table::read(PAGE).unwrap();
    let made = table.remade(&planted(&CLEAN));
    assert_eq!(Table::read(&format!("\n## Arrows\n\n```text\n{made}```\n")).unwrap(), table);
}

/// `CLEAN` with one file replaced.
fn with(path: &'static str, text: &'static str) -> Vec<(&'static str, &'static str)> {
    let mut files = CLEAN.to_vec();
    files.iter_mut().filter(|(p, _)| *p == path).for_each(|f| f.1 = text);
    files
}

#[test]
fn a_forbidden_arrow_is_found() {
    let files = with("src/stats.rs", "\nuse crate::{run as other};\npub fn mean() {}\n");
    let expected = "src/stats.rs:2 names `crate::run`: no arrow `stats -> run` in ARCHITECTURE.md";
    assert_eq!(differences(&files, PAGE), [expected]);
}

#[test]
fn traffic_named_from_statistics_is_found() {
    let files = with("src/stats.rs", "pub fn mean() -> crate::traffic::env::Env { todo!() }\n");
    let graph = planted(&files);
    let traffic = |m: &str| m.starts_with("traffic");
    let named = graph.named_from_outside(traffic, |m| m == "cli");
    assert_eq!(named["src/stats.rs"], ["src/stats.rs:1 names `crate::traffic::env::Env`"]);
    assert_eq!(named.len(), 1);
    assert!(graph.named_from_outside(traffic, |m| m == "stats").is_empty());
}

#[test]
fn an_arrow_between_parts_of_traffic_is_found() {
    let mut files = with("src/traffic/mod.rs", "pub mod env;\npub mod sim;\n");
    files.push(("src/traffic/sim.rs", "use super::env::Env;\n"));
    let page = PAGE.replace("lib ->", "traffic/sim -> nothing\nlib ->");
    let expected = "src/traffic/sim.rs:1 names `super::env::Env`: no arrow `traffic/sim -> traffic/env` in \
                    ARCHITECTURE.md";
    assert_eq!(differences(&files, &page), [expected]);
}

#[test]
fn an_arrow_of_the_table_that_nothing_needs_is_found() {
    let page = PAGE.replace("family -> stats\n", "family -> stats run\n");
    let expected = "ARCHITECTURE.md has `family -> run`, which nothing needs";
    assert_eq!(differences(&CLEAN, &page), [expected]);
}

#[test]
fn an_arrow_against_the_order_of_the_table_is_found() {
    assert_eq!(Table::read(PAGE).unwrap().against_the_order(), Vec::<String>::new());
    let page = PAGE.replace("stats -> nothing", "stats -> run");
    assert_eq!(Table::read(&page).unwrap().against_the_order(), ["stats -> run"]);
}

#[test]
fn what_any_may_use_uses_nothing_else() {
    let files = with("src/units.rs", "use crate::stats::mean;\npub struct Metres;\n");
    let found = differences(&files, PAGE);
    let expected = "src/units.rs:1 names `crate::stats::mean`: `units` may be used by any and so may not use \
                    `stats`";
    assert_eq!(found, [expected]);
}

#[test]
fn a_crate_beside_is_a_module() {
    let manifest = |rest: &str| format!("[package]\nname = {rest}\n");
    let top = manifest("\"tsc-family\"\n[workspace]\nmembers = [\"beside\", \"far\"]");
    let (beside, far) = (manifest("\"beside\""), manifest("\"far-off\""));
    let graph = planted(&[
        ("Cargo.toml", &top),
        ("beside/Cargo.toml", &beside),
        ("far/Cargo.toml", &far),
        ("src/lib.rs", "mod a;\npub mod cli;\n"),
        ("src/main.rs", "fn main() { tsc_family::cli::run(); }\n"),
        ("src/cli.rs", "pub fn run() {}\n"),
        ("src/a.rs", "use beside::inner::B;\npub struct A(B, far_off::C);\n"),
        ("beside/src/lib.rs", "pub mod inner;\n"),
        ("beside/src/inner.rs", "use crate::other;\npub struct B(far_off::C);\n"),
        ("far/src/lib.rs", "pub struct C;\n"),
    ]);
    let arrows: Vec<_> =
        graph.between_modules().into_keys().map(|(from, to)| format!("{from} -> {to}")).collect();
    assert_eq!(arrows, ["a -> beside", "a -> far", "beside -> far", "main -> cli"]);
}

#[test]
fn a_module_without_a_line_and_a_line_without_a_module_are_found() {
    let page = PAGE.replace("traffic -> nothing", "trafic -> nothing");
    let expected = [
        "ARCHITECTURE.md has `trafic`, which is no module",
        "ARCHITECTURE.md has no line for `traffic`",
    ];
    assert_eq!(differences(&CLEAN, &page), expected);
}
