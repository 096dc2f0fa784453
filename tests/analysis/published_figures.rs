//! What the pages say of published results is what their records give.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Map, Value};

use crate::common::succeed;
use tsc_family::domains;
use tsc_family::store::Layout;
use tsc_family::store::results::Results;

/// A page with a table of scores: what stands before the name of a method, the decimals of the table, and the results.
type Table = (&'static str, &'static str, usize, &'static str);

const TABLES: [Table; 12] = [
    ("docs/results.md", "| `resco` | ", 3, "resco"),
    ("docs/results.md", "| `resco` | ", 3, "nema-resco"),
    ("docs/results.md", "| `field` | ", 3, "field-0.2.0"),
    ("docs/results.md", "| `field` | ", 3, "nema-field-0.2.0"),
    ("docs/results.md", "| `resco` | ", 3, "intersections-resco"),
    ("docs/results.md", "| `resco` | ", 3, "nema-intersections-resco"),
    ("docs/results.md", "| `field` | ", 3, "intersections-field-0.2.1"),
    ("results/salt-lake-city/analyses.md", "| ", 3, "field-all-pairs-0.2.1"),
    ("docs/results.md", "| ", 3, "resco"),
    ("docs/results.md", "| ", 3, "nema-resco"),
    ("docs/results.md", "| ", 3, "learners-validated"),
    ("results/salt-lake-city/analyses.md", "| ", 3, "learners-validated-field-20"),
];

/// Columns of the README's table of changes of delay, and the results that they are from.
const README: [(usize, &str); 4] =
    [(2, "intersections-field-0.2.1"), (3, "resco"), (3, "nema-resco"), (3, "learners-validated")];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn results(name: &str) -> PathBuf {
    repository().join("results/salt-lake-city").join(name)
}

fn methods(name: &str) -> Vec<Map<String, Value>> {
    let layout = Layout::new(results(name));
    let report = domains::report(&layout, &Results::load(&layout).unwrap()).unwrap();
    let mut rows = report.json_rows();
    rows.retain(|row| row["method"] != "baseline");
    rows
}

/// The methods of all results of [`TABLES`], each of which is read once.
fn methods_of_tables() -> BTreeMap<&'static str, Vec<Map<String, Value>>> {
    let names: BTreeSet<&str> = TABLES.iter().map(|&(_, _, _, name)| name).collect();
    names.into_par_iter().map(|name| (name, methods(name))).collect()
}

/// A score with its interval, as tables have it.
fn cell(row: &Map<String, Value>, decimals: usize) -> String {
    let number = |name: &str| format!("{:.decimals$}", row[name].as_f64().unwrap());
    format!("{} ({} to {})", number("overall"), number("overall_low"), number("overall_high"))
}

#[test]
fn scores_on_the_pages_are_those_of_the_records() {
    let mut wrong = Vec::new();
    let methods = methods_of_tables();
    for (page, before, decimals, name) in TABLES {
        let text = fs::read_to_string(repository().join(page)).unwrap();
        let mut found = 0;
        for row in &methods[name] {
            let method = row["method"].as_str().unwrap();
            if method == "mix" {
                continue;
            }
            found += 1;
            let cell = cell(row, decimals);
            let says = |line: &str| {
                let rest = line.strip_prefix(&format!("{before}{method}"));
                let cells = rest
                    .filter(|rest| rest.starts_with(" |"))
                    .into_iter()
                    .flat_map(|rest| rest.split('|'));
                cells.map(str::trim).any(|other| other == cell)
            };
            if !text.lines().any(says) {
                wrong.push(format!("{page} has no row of {method} with {cell}, as {name} gives"));
            }
        }
        assert!(found > 0, "{page}: {name} has no method for the table");
    }
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    for (column, name) in README {
        // The mix of the literature's setting is over methods of three runs.
        for row in methods[name].iter().filter(|row| column == 2 || row["method"] != "mix") {
            let method = format!("| {} ", row["method"].as_str().unwrap());
            let change = format!("{:.0}%", 100.0 * (row["overall"].as_f64().unwrap() - 1.0));
            let Some(line) = readme.lines().find(|line| line.starts_with(&method)) else {
                continue;
            };
            if line.split('|').nth(column).unwrap().trim_matches([' ', '*']) != change {
                wrong.push(format!("README.md: {line} has not {change}, as {name} gives"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn ranks_across_families_on_the_page_are_those_of_the_command() {
    let args = format!(
        "across {} {} --json",
        results("resco").display(),
        results("field-0.2.0").display()
    );
    let said = succeed(repository(), &args);
    let lines: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let page = fs::read_to_string(results("analyses.md")).unwrap();
    let percent =
        |value: &Value, decimals: usize| format!("{:.decimals$}%", 100.0 * value.as_f64().unwrap());
    for line in lines.iter().filter(|line| line["event"] == "method") {
        let ranks = ["rank_1", "rank_2", "rank_3", "rank_4"].map(|rank| percent(&line[rank], 2));
        let row = format!("| {} | {} |", line["method"].as_str().unwrap(), ranks.join(" | "));
        assert!(page.contains(&row), "results/salt-lake-city/analyses.md lacks {row}");
    }
    let said = succeed(repository(), args.trim_end_matches(" --json"));
    let holds = said.split("holds in ").nth(1).and_then(|text| text.split('%').next()).unwrap();
    let holds = format!("overall order holds in {:.1}% of them", holds.parse::<f64>().unwrap());
    let summary = fs::read_to_string(repository().join("docs/results.md")).unwrap();
    assert!(page.contains(&holds) && summary.contains(&holds), "{holds}");
}
