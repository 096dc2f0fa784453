//! What a report says about a small results directory, word by word.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tsc_family::report::{self, ReportData, text};
use tsc_family::sample::{Draw, SamplePlan, Sampling};
use tsc_family::store::Layout;
use tsc_family::store::manifest::{FeatureColumn, Identity, Manifest, PointRow, Provenance};
use tsc_family::store::record::{Metrics, Record, Row, RowKind, TaskResult, Wall};
use tsc_family::store::results::Results;

const SEEDS: [u64; 2] = [1_073_741_825, 1_073_741_826];

/// A method's delays on one point MDP per seed, or the reason of a failure.
type Cell = Result<[f64; 2], &'static str>;

fn point(id: &str, importance: f64, inflow_vph: f64) -> PointRow {
    PointRow {
        point: id.to_owned(),
        importance,
        instances: 3,
        features: vec![2.0, inflow_vph],
        places: vec![[40.76, -111.89]],
        environment: format!("networks/{id}"),
        sha256: BTreeMap::from([("net.xml.gz".to_owned(), "ab".repeat(32))]),
    }
}

fn manifest(methods: &[&str]) -> Manifest {
    let draw = |point: &str, weight| Draw { point: point.to_owned(), weight, count: 1 };
    let feature = |name: &str, unit: &str| FeatureColumn { name: name.into(), unit: unit.into() };
    Manifest {
        identity: Identity {
            schema_version: 1,
            tsc_family: "0.1.0".into(),
            simulator: "SUMO 1.15.0".into(),
            scenario: "smoke".into(),
            settings: serde_json::json!({"demand": {"horizon_s": 3600.0}}),
            features: vec![feature("lanes", ""), feature("inflow_vph", "veh/h")],
            sample: SamplePlan {
                sampling: Sampling::All,
                budget: 2,
                family_size: 2,
                seed: 0,
                draws: vec![draw("quiet", 0.75), draw("busy", 0.25)],
            },
            points: vec![point("quiet", 0.75, 250.0), point("busy", 0.25, 900.0)],
            methods: methods.iter().map(|m| (*m).to_owned()).collect(),
            baseline: methods[0].to_owned(),
            objective: "delay_s".into(),
            replicates: 1,
            replicated: vec![],
            base_seed: 0,
            evaluation_seeds: SEEDS.to_vec(),
        },
        provenance: Provenance {
            command: "tsc-family run smoke".into(),
            git: "abc1234".into(),
            rustc: "rustc 1.95.0".into(),
            host: "Linux x86_64".into(),
            started: "2026-01-01T00:00:00Z".into(),
            networks: "networks/smoke".into(),
        },
    }
}

/// Writes a results directory; a cell that is `None` has no record.
fn write_results(root: &Path, methods: &[(&str, [Option<Cell>; 2])]) -> Layout {
    let layout = Layout::new(root);
    let names: Vec<&str> = methods.iter().map(|m| m.0).collect();
    let manifest = manifest(&names);
    fs::write(layout.manifest(), serde_json::to_string(&manifest).unwrap()).unwrap();
    let mut plan = String::new();
    let points = ["quiet", "busy"];
    for task in manifest.identity.tasks() {
        let (_, cells) = methods.iter().find(|(name, _)| *name == task.method).unwrap();
        let cell = &cells[points.iter().position(|p| *p == task.point).unwrap()];
        plan.push_str(&serde_json::to_string(&task).unwrap());
        plan.push('\n');
        let sha256 = manifest.sha256();
        match cell {
            None => {}
            Some(Ok(delays)) => {
                let rows = delays.iter().enumerate().map(row).collect();
                let result = TaskResult { rows, ..TaskResult::default() };
                Record::finished(&task, &sha256, result).commit(&layout).unwrap();
            }
            Some(Err(reason)) => {
                let reason = (*reason).to_owned();
                Record::failed(&task, &sha256, reason, Wall::default()).commit(&layout).unwrap();
            }
        }
    }
    fs::write(layout.plan(), plan).unwrap();
    layout
}

fn row((k, delay_s): (usize, &f64)) -> Row {
    let metrics: Metrics = [
        ("delay_s", *delay_s),
        ("waiting_s", delay_s / 2.0),
        ("queue_veh", 4.0),
        ("throughput_veh", 900.0),
        ("unfinished_veh", 2.0),
        ("teleports", 0.0),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect();
    Row { kind: RowKind::Evaluation, episode: k as u32, seed: SEEDS[k], metrics }
}

fn three_methods(root: &Path) -> Layout {
    write_results(
        root,
        &[
            ("fixed-time-untuned", [Some(Ok([20.0, 20.0])), Some(Ok([40.0, 60.0]))]),
            ("max-pressure", [Some(Ok([10.0, 12.0])), Some(Ok([30.0, 40.0]))]),
            ("idqn", [Some(Ok([16.0, 18.0])), Some(Err("sumo failed: <collision> & stuck"))]),
        ],
    )
}

fn report_of(layout: &Layout, file: &str) -> String {
    report::write(layout).unwrap();
    fs::read_to_string(layout.report().join(file)).unwrap()
}

#[test]
fn the_table_ranks_the_methods() {
    let dir = tempfile::tempdir().unwrap();
    let data = ReportData::new(&Results::load(&three_methods(dir.path())).unwrap());
    insta::assert_snapshot!(text::table(&data), @r#"
 rank   method                          score    95% interval   delay (s)   worst point MDP (score)   points   failed
----------------------------------------------------------------------------------------------------------------------
    1   max-pressure                     0.59    0.54 to 0.64        17.0   busy (0.70)                  2/2        0
    2   fixed-time-untuned (baseline)    1.00   by definition        27.5   -                            2/2        0
    -   idqn                             0.85               -        17.0   quiet (0.85)                 1/2        1
"#);
    insta::assert_snapshot!(text::notes(&data).join("\n"), @r#"
1 of 6 tasks failed; the reasons are in the report's section "Failed and missing".
Scores are over the point MDPs that both the method and the baseline finished; methods with different counts of points are not strictly comparable.
Without interval: it takes at least two evaluation seeds, and two point MDPs where others of the family have no result.
"#);
}

#[test]
fn the_json_rows_have_exactly_the_documented_fields() {
    let dir = tempfile::tempdir().unwrap();
    let data = ReportData::new(&Results::load(&three_methods(dir.path())).unwrap());
    insta::assert_snapshot!(serde_json::to_string(&data.json_rows()[1]).unwrap(), @r#"
{"method":"fixed-time-untuned","overall":1.0,"overall_low":1.0,"overall_high":1.0,"delay_s":27.5,"points":2,"failed":0}
"#);
}

#[test]
fn scores_csv_has_a_row_per_task_and_empty_metrics_for_a_failure() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(report_of(&three_methods(dir.path()), "scores.csv"), @r#"
method,point,importance,replicate,delay_s,baseline_delay_s,score,waiting_s,queue_veh,throughput_veh,unfinished_veh,teleports,level_of_service,lanes,inflow_vph,weight
fixed-time-untuned,quiet,0.75,0,20,20,1,10,4,900,2,0,B,2,250,0.75
max-pressure,quiet,0.75,0,11,20,0.55,5.5,4,900,2,0,B,2,250,0.75
idqn,quiet,0.75,0,17,20,0.85,8.5,4,900,2,0,B,2,250,0.75
fixed-time-untuned,busy,0.25,0,50,50,1,25,4,900,2,0,D,2,900,0.25
max-pressure,busy,0.25,0,35,50,0.7,17.5,4,900,2,0,C,2,900,0.25
idqn,busy,0.25,0,,,,,,,,,,2,900,0.25
"#);
}

#[test]
fn summary_csv_has_a_row_per_method() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(report_of(&three_methods(dir.path()), "summary.csv"), @r#"
method,rank,overall,overall_low,overall_high,delay_s,waiting_s,queue_veh,worst_point,worst_score,points,failed,missing,sampling,budget,family_size,evaluation_seeds
max-pressure,1,0.5875,0.5416666666666666,0.6375,17,8.5,4,busy,0.7,2,0,0,all,2,2,2
fixed-time-untuned,2,1,1,1,27.5,13.75,4,busy,1,2,0,0,all,2,2,2
idqn,,0.85,,,17,8.5,4,quiet,0.85,1,1,0,all,2,2,2
"#);
}

#[test]
fn the_words_of_the_page_are_these() {
    let dir = tempfile::tempdir().unwrap();
    let page = words(&report_of(&three_methods(dir.path()), "index.html"));
    // The manifest's own hash changes with every new field.
    insta::with_settings!({ filters => vec![("[0-9a-f]{64}", "[sha256]")] }, {
        insta::assert_snapshot!(page);
    });
}

#[test]
fn every_drawing_and_the_page_are_well_formed() {
    let dir = tempfile::tempdir().unwrap();
    let paths = report::write(&three_methods(dir.path())).unwrap();
    let names: Vec<_> =
        paths.figures.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["overall.svg", "distribution.svg", "level-of-service.svg", "map.svg"]);
    for path in &paths.figures {
        well_formed(&fs::read_to_string(path).unwrap());
    }
    let page = fs::read_to_string(&paths.html).unwrap();
    // The two elements that HTML leaves open.
    let page = page.replace("utf-8\">", "utf-8\"/>").replace("scale=1\">", "scale=1\"/>");
    well_formed(&page.replace("<!DOCTYPE html>", ""));
}

#[test]
fn the_page_loads_nothing_and_its_ids_are_unique() {
    let dir = tempfile::tempdir().unwrap();
    let page = report_of(&three_methods(dir.path()), "index.html");
    for forbidden in ["src=", "<link", "<script", "@import", "url(", "href=\"http"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    let mut ids: Vec<&str> =
        page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
    for link in page.split("href=\"#").skip(1).filter_map(|rest| rest.split('"').next()) {
        assert!(ids.contains(&link), "{link}");
    }
}

#[test]
fn a_report_is_a_function_of_the_records_and_leaves_no_drafts() {
    let dir = tempfile::tempdir().unwrap();
    let layout = three_methods(dir.path());
    let first = report_of(&layout, "index.html");
    assert_eq!(first, report_of(&layout, "index.html"));
    assert_eq!(fs::read_dir(layout.report()).unwrap().count(), 7);
}

#[test]
fn without_any_record_the_page_says_what_is_missing() {
    let dir = tempfile::tempdir().unwrap();
    let layout =
        write_results(dir.path(), &[("fixed-time-untuned", [None, None]), ("idqn", [None, None])]);
    let page = report_of(&layout, "index.html");
    assert!(page.contains("<h1>No method can be scored yet</h1>"));
    assert!(page.contains("Incomplete: 4 of 4 tasks have no record yet"));
}

#[test]
fn the_baseline_alone_is_a_report() {
    let dir = tempfile::tempdir().unwrap();
    let cells = [Some(Ok([20.0, 20.0])), Some(Ok([40.0, 60.0]))];
    let page =
        report_of(&write_results(dir.path(), &[("fixed-time-untuned", cells)]), "index.html");
    assert!(page.contains("Only the baseline fixed-time-untuned has results so far"));
}

#[test]
fn a_point_whose_baseline_failed_leaves_the_estimate() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(
        dir.path(),
        &[
            ("fixed-time-untuned", [Some(Ok([20.0, 20.0])), Some(Err("killed"))]),
            ("idqn", [Some(Ok([10.0, 10.0])), Some(Ok([30.0, 40.0]))]),
        ],
    );
    let data = ReportData::new(&Results::load(&layout).unwrap());
    let idqn = &data.methods[0];
    assert_eq!((idqn.overall, idqn.points, idqn.without_baseline), (Some(0.5), 1, 1));
    assert!(report_of(&layout, "index.html").contains("no score on 1 point MDP that a method"));
}

#[test]
fn a_gridlock_stays_on_the_page() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(
        dir.path(),
        &[
            ("fixed-time-untuned", [Some(Ok([20.0, 20.0])), Some(Ok([40.0, 60.0]))]),
            ("idqn", [Some(Ok([1000.0, 1040.0])), Some(Ok([2600.0, 2600.0]))]),
        ],
    );
    let page = report_of(&layout, "index.html");
    assert!(page.contains("No method beats the baseline fixed-time-untuned"));
    assert!(page.contains("\u{2265} 1.5"));
    for x in page.split(" x=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        let x: f64 = x.parse().unwrap();
        assert!((0.0..=900.0).contains(&x), "{x}");
    }
}

fn well_formed(xml: &str) {
    let mut reader = quick_xml::Reader::from_str(xml);
    let mut depth = 0i32;
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Start(_) => depth += 1,
            quick_xml::events::Event::End(_) => depth -= 1,
            quick_xml::events::Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(depth, 0);
}

/// Returns the text of a page: no style, no drawings, a line per paragraph or row.
fn words(page: &str) -> String {
    const BLOCKS: [&str; 10] =
        ["/p", "/tr", "/h1", "/h2", "/h3", "/li", "/dd", "/caption", "/summary", "/pre"];
    const CELLS: [&str; 3] = ["/td", "/th", "/dt"];
    let (_, mut rest) = page.split_once("<body>").unwrap();
    let mut body = String::new();
    while let Some((before, drawing)) = rest.split_once("<svg") {
        body.push_str(before);
        body.push_str("[drawing]\n");
        rest = drawing.split_once("</svg>").unwrap().1;
    }
    body.push_str(rest);
    let mut text = String::new();
    for piece in body.split('<') {
        let (tag, words) = piece.split_once('>').unwrap_or(("", piece));
        if BLOCKS.contains(&tag) {
            text.push('\n');
        } else if CELLS.contains(&tag) {
            text.push_str(" | ");
        }
        if tag.starts_with("span") {
            text.push(' ');
        }
        text.push_str(&words.replace('\n', " "));
    }
    let lines = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" "));
    lines.filter(|l| !l.is_empty()).collect::<Vec<_>>().join("\n")
}
