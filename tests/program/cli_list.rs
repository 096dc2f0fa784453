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

/// A scenario with a table of point MDPs of its own, and the error that listing it gives.
fn error_of(scenario: &str, table: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("city.toml"), scenario).unwrap();
    fs::write(folder.path().join("points.csv"), table).unwrap();
    let output = run(folder.path(), "list city.toml");
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    stderr(&output)
}

const SCENARIO: &str = "name = \"city\"\n[family]\npoints = \"points.csv\"\n";

#[test]
fn bad_families_are_refused_with_file_and_place() {
    let header = "point,importance,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,\
                  right_turn_lanes\n";
    let row = |start: &str| format!("{header}{start},200,500,0,0\n");
    let without = "point,importance,lanes,speed,length_m\na,1,4,30,200\n".to_owned();
    let cases = [
        ("bad_empty_csv", SCENARIO, "".to_owned()),
        ("bad_no_rows", SCENARIO, header.to_owned()),
        ("bad_no_column", SCENARIO, without),
        ("bad_nan", SCENARIO, row("a,1,NaN,30")),
        ("bad_negative", SCENARIO, row("a,1,4,-30")),
        ("bad_importance", SCENARIO, format!("{header}a,0.5,4,30,200,500,0,0\n")),
        ("bad_short_row", SCENARIO, format!("# by hand\n\n{header}a,1\n")),
        ("bad_semicolons", SCENARIO, row("a,1,4,30").replace(',', ";").replace("200", "1,200")),
        ("bad_toml", "name = \"city\"\n[family\n", header.to_owned()),
        ("bad_empty_toml", "", header.to_owned()),
        (
            "bad_field",
            "name = \"city\"\nhorizon = 3\n[family]\npoints = \"p\"\n",
            header.to_owned(),
        ),
    ];
    for (name, scenario, table) in cases {
        insta::assert_snapshot!(name, error_of(scenario, &table));
    }
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

#[test]
fn bad_settings_from_the_command_line_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("set_without_value", "--set demand.horizon_s"),
        ("set_without_name", "--set =600"),
        ("set_unknown", "--set demand.horizon=600"),
        ("set_unknown_value", "--set baseline.program=netconver"),
        ("set_unknown_table", "--set dqn.learning_rate=5e-4"),
        ("set_wrong_type", "--set demand.horizon_s=soon"),
        ("set_out_of_range", "--set demand.horizon_s=5"),
        ("set_out_of_another_s_range", "--set title=x --set fixed_time.max_cycle_s=15"),
        ("set_no_such_table", "--set family.approaches=nowhere.csv"),
    ];
    for (name, args) in cases {
        let output = run(folder.path(), &format!("list salt-lake-city {args}"));
        assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
        insta::assert_snapshot!(name, stderr(&output));
    }
}

#[test]
fn an_unknown_scenario_names_the_embedded_ones() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), "list atlantis");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("salt-lake-city, salt-lake-city-peak, smoke"),
        "{}",
        stderr(&output)
    );
}
