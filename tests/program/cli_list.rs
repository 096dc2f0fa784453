//! `tsc-family list`: the form that others script against.

use std::fs;

use crate::common::{run, stderr, succeed};

#[test]
fn salt_lake_city_is_embedded_and_works_from_any_folder() {
    let folder = tempfile::tempdir().unwrap();
    let text = succeed(folder.path(), "list salt-lake-city --json");
    let rows: Vec<serde_json::Value> =
        text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(rows.len(), 164);
    let importance: f64 = rows.iter().map(|r| r["importance"].as_f64().unwrap()).sum();
    assert!((importance - 1.0).abs() < 1e-9);
    let intersections: u64 = rows.iter().map(|r| r["intersections"].as_u64().unwrap()).sum();
    assert_eq!(intersections, 282);
    insta::assert_snapshot!("list_json_first", text.lines().next().unwrap());
}

#[test]
fn features_stand_beside_the_paper_s_table() {
    let folder = tempfile::tempdir().unwrap();
    insta::assert_snapshot!("list_features", succeed(folder.path(), "list --features"));
}

#[test]
fn a_small_family_is_a_table() {
    let folder = tempfile::tempdir().unwrap();
    insta::assert_snapshot!("list_smoke", succeed(folder.path(), "list smoke"));
}

#[test]
fn a_folder_called_like_an_embedded_scenario_is_not_taken_and_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("smoke")).unwrap();
    let output = run(folder.path(), "list smoke");
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("smoke is the embedded scenario") && said.contains("write ./smoke"),
        "{said}"
    );
    assert!(!stderr(&run(folder.path(), "list salt-lake-city")).contains("embedded"));
}

#[test]
fn a_setting_from_the_command_line_replaces_the_file_s() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |args: &str| succeed(folder.path(), args).lines().count();
    assert_eq!(rows("list --json"), 164);
    assert_eq!(rows("list --json --set family.detail=per-approach"), 282);
    let wider = rows("list --json --set family.bins.length_m=200 --set family.bins.inflow_vph=500");
    assert!(wider < 164, "{wider}");
}
