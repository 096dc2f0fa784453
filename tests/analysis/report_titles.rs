//! What a report calls point MDPs whose names are free text: by these, with the id where it is needed.

use std::fs;

use crate::made_up::{evaluations, manifest, reported, well_formed, well_linked, words};
use tsc_family::report;
use tsc_family::store::Layout;
use tsc_family::store::record::TaskResult;

const TITLE: &str = "Main St / 5th <old>";

/// Writes the report on two point MDPs, the second called otherwise than by its id.
fn titled(root: &std::path::Path, title: &str) -> Layout {
    let mut manifest = manifest(&["baseline", "max-pressure"]);
    manifest.identity.points[1].title = title.to_owned();
    let layout =
        crate::made_up::write_results(root, &manifest, |task| match task.method.as_str() {
            "max-pressure" if task.point == "busy" => Some(Err("it broke")),
            _ => Some(Ok(TaskResult { rows: evaluations(&[60.0, 62.0]), ..TaskResult::default() })),
        });
    report::write(&layout, &reported(&layout)).unwrap();
    layout
}

fn last_cells(layout: &Layout, file: &str) -> Vec<String> {
    let mut builder = csv::ReaderBuilder::new();
    let mut reader = builder.has_headers(false).from_path(layout.report().join(file)).unwrap();
    reader.records().map(|row| row.unwrap().iter().next_back().unwrap().to_owned()).collect()
}

#[test]
fn tables_have_a_column_for_titles_where_they_differ_from_ids() {
    let dir = tempfile::tempdir().unwrap();
    let layout = titled(dir.path(), TITLE);
    for file in ["scores.csv", "episodes.csv", "plans.csv"] {
        let cells = last_cells(&layout, file);
        assert_eq!(cells[0], "title", "{file}");
        assert!(cells.contains(&TITLE.to_owned()), "{file}: {cells:?}");
        assert!(cells.contains(&"quiet".to_owned()), "{file}: {cells:?}");
        let others = cells[1..].iter().filter(|c| *c != TITLE && *c != "quiet");
        assert_eq!(others.count(), 0, "{file}: {cells:?}");
    }
    let plain = tempfile::tempdir().unwrap();
    let layout = titled(plain.path(), "");
    for (file, last) in [("scores.csv", "against"), ("plans.csv", "remark")] {
        assert_eq!(last_cells(&layout, file)[0], last, "{file}");
    }
}

#[test]
fn map_and_page_show_titles() {
    let dir = tempfile::tempdir().unwrap();
    let layout = titled(dir.path(), TITLE);
    let map = fs::read_to_string(layout.report().join("map.svg")).unwrap();
    well_formed(&map);
    assert!(map.contains("Main St / 5th &lt;old&gt; (busy): "), "{map}");
    assert!(map.contains(">quiet: "), "{map}");
    let page = fs::read_to_string(layout.report().join("index.html")).unwrap();
    well_linked(&page);
    assert!(!page.contains("<old>"), "markup of a name");
    let words = words(&page).replace("&#x2f;", "/").replace("&lt;", "<").replace("&gt;", ">");
    assert!(words.contains("Main St / 5th <old> busy "), "the worst: {words}");
    assert!(words.contains("Main St / 5th <old> (busy) | 0 | it broke"), "failures: {words}");
}
