//! What a report says about a small results directory, word by word.

use std::fs;
use std::path::Path;

use crate::made_up::{evaluations, manifest, reported, well_formed, well_linked, words};
use tsc_family::report::{self, text};
use tsc_family::store::Layout;
use tsc_family::store::record::TaskResult;

/// A method's delays on one point MDP per seed, or the reason of a failure.
type Cell = Result<[f64; 2], &'static str>;

/// Writes a results directory; a cell that is `None` has no record.
fn write_results(root: &Path, methods: &[(&str, [Option<Cell>; 2])]) -> Layout {
    let names: Vec<&str> = methods.iter().map(|m| m.0).collect();
    crate::made_up::write_results(root, &manifest(&names), |task| {
        let (_, cells) = methods.iter().find(|(name, _)| *name == task.method).unwrap();
        let result = |delays| TaskResult { rows: evaluations(delays), ..TaskResult::default() };
        cells[usize::from(task.point == "busy")].as_ref().map(|cell| match cell {
            Ok(delays) => Ok(result(delays)),
            Err(reason) => Err(*reason),
        })
    })
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
    report::write(layout, &reported(layout)).unwrap();
    fs::read_to_string(layout.report().join(file)).unwrap()
}

#[test]
fn the_table_ranks_the_methods() {
    let dir = tempfile::tempdir().unwrap();
    let data = reported(&three_methods(dir.path()));
    insta::assert_snapshot!(text::table(&data), @r#"
 rank   method                          score    95% interval   delay (s)   worst   points   failed
----------------------------------------------------------------------------------------------------
    1   max-pressure                     0.59    0.35 to 0.82        17.0    0.70      2/2        0
    2   fixed-time-untuned (baseline)    1.00   by definition        27.5       -      2/2        0
    -   idqn                             0.85               -        17.0    0.85      1/2        1

ratio of mean delays, median and geometric mean of the scores, all relative to the baseline;
to E and at F: mean score where the baseline is at level of service A to E and at F
(no point MDP is at level of service F);
unfinished: share of the vehicles; gridlock: share of the evaluation episodes;
worst: longest delay in an evaluation episode relative to that of the same vehicles

 method               ratio   median   geometric   to E   at F   unfinished   gridlock   worst
-----------------------------------------------------------------------------------------------
 max-pressure          0.62     0.55        0.58   0.59      -           2%         0%    0.75
 fixed-time-untuned    1.00     1.00        1.00   1.00      -           2%         0%    1.00
 idqn                  0.85     0.85        0.85   0.85      -           2%         0%    0.90

On the 1 point MDP that all 3 methods with results finished:

 rank   method                          score    95% interval   delay (s)   worst   points   failed
----------------------------------------------------------------------------------------------------
    1   max-pressure                     0.55               -        11.0    0.55      1/1        0
    2   idqn                             0.85               -        17.0    0.85      1/1        0
    3   fixed-time-untuned (baseline)    1.00   by definition        20.0       -      1/1        0
"#);
    insta::assert_snapshot!(text::notes(&data).join("\n"), @r#"
1 of 6 tasks failed; the reasons are in the report's section "Failed and missing".
Not ranked, because they have no results on some point MDPs: idqn (1 of 2). Their scores are over other point MDPs than those above them; a second table compares all methods where all have results.
Without interval: this needs at least two evaluation seeds, and two point MDPs where others of the family have no result.
"#);
}

#[test]
fn the_json_rows_have_exactly_the_documented_fields() {
    let dir = tempfile::tempdir().unwrap();
    let data = reported(&three_methods(dir.path()));
    insta::assert_snapshot!(serde_json::to_string(&data.json_rows()[1]).unwrap(), @r#"
{"against":"fixed-time-untuned","at_f":null,"at_f_high":null,"at_f_low":null,"delay_s":27.5,"episode_median":1.0,"episode_median_delay_s":20.0,"episode_worst":1.0,"episode_worst_delay_s":60.0,"failed":0,"geometric_mean":1.0,"geometric_mean_high":1.0,"geometric_mean_low":1.0,"gridlock_share":0.0,"iqm":1.0,"iqm_high":1.0,"iqm_low":1.0,"median":1.0,"median_high":1.0,"median_low":1.0,"method":"fixed-time-untuned","overall":1.0,"overall_high":1.0,"overall_low":1.0,"points":2,"rank_probabilities":null,"ratio_of_means":1.0,"ratio_of_means_high":1.0,"ratio_of_means_low":1.0,"unfinished_share":0.019999999999999997,"up_to_e":1.0,"up_to_e_high":1.0,"up_to_e_low":1.0}
"#);
}

#[test]
fn scores_csv_has_a_row_per_task_and_empty_metrics_for_a_failure() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(report_of(&three_methods(dir.path()), "scores.csv"), @r#"
method,point,importance,replicate,delay_s,baseline_delay_s,score,waiting_s,queue_veh,throughput_veh,unfinished_veh,teleports,level_of_service,lanes,inflow_vph,weight,against
fixed-time-untuned,quiet,0.75,0,20,20,1,10,4,900,20,0,B,2,250,0.75,fixed-time-untuned
max-pressure,quiet,0.75,0,11,20,0.55,5.5,4,900,20,0,B,2,250,0.75,fixed-time-untuned
idqn,quiet,0.75,0,17,20,0.85,8.5,4,900,20,0,B,2,250,0.75,fixed-time-untuned
fixed-time-untuned,busy,0.25,0,50,50,1,25,4,900,20,0,D,2,900,0.25,fixed-time-untuned
max-pressure,busy,0.25,0,35,50,0.7,17.5,4,900,20,0,C,2,900,0.25,fixed-time-untuned
idqn,busy,0.25,0,,,,,,,,,,2,900,0.25,fixed-time-untuned
"#);
}

#[test]
fn summary_csv_has_a_row_per_method() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(report_of(&three_methods(dir.path()), "summary.csv"), @r#"
method,rank,overall,overall_low,overall_high,delay_s,waiting_s,queue_veh,worst_point,worst_score,points,failed,missing,sampling,budget,family_size,evaluation_seeds,against,ratio_of_means,ratio_of_means_low,ratio_of_means_high,median,median_low,median_high,geometric_mean,geometric_mean_low,geometric_mean_high,up_to_e,up_to_e_low,up_to_e_high,at_f,at_f_low,at_f_high,points_at_f,importance_at_f,delay_share_at_f,unfinished_share,gridlock_share,episode_median_delay_s,episode_worst_delay_s,episode_median,episode_worst,iqm,iqm_low,iqm_high,points_tuned,points_not_improved
max-pressure,1,0.5875,0.3523110563269707,0.8181319996621422,17,8.5,4,busy,0.7,2,0,0,all,2,2,2,fixed-time-untuned,0.6181818181818182,0.4425956768627487,0.8152524315308859,0.55,0.5,0.6,0.584179788476757,0.34845049429657216,0.8206120731557527,0.5875,0.3523110563269707,0.8181319996621422,,,,0,0,0,0.019999999999999997,0,12,40,0.6,0.75,0.5875,0.5416666666666666,0.6375,,
fixed-time-untuned,2,1,1,1,27.5,13.75,4,busy,1,2,0,0,all,2,2,2,fixed-time-untuned,1,1,1,1,1,1,1,1,1,1,1,1,,,,0,0,0,0.019999999999999997,0,20,60,1,1,1,1,1,,
idqn,,0.85,,,17,8.5,4,quiet,0.85,1,1,0,all,2,2,2,fixed-time-untuned,0.85,,,0.85,,,0.85,,,0.85,,,,,,0,0,0,0.02,0,17,18,0.8500000000000001,0.9,0.85,,,,
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
    let paths = {
        let layout = three_methods(dir.path());
        report::write(&layout, &reported(&layout)).unwrap()
    };
    let names: Vec<_> =
        paths.figures.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    let general = ["overall.svg", "profiles.svg", "distribution.svg"];
    assert_eq!(names, [&general[..], &["level-of-service.svg", "map.svg"]].concat());
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
    assert!(!page.contains("href=\"http"));
    well_linked(&page);
}

#[test]
fn a_report_is_a_function_of_the_records_and_leaves_no_drafts() {
    let dir = tempfile::tempdir().unwrap();
    let layout = three_methods(dir.path());
    let first = report_of(&layout, "index.html");
    assert_eq!(first, report_of(&layout, "index.html"));
    assert_eq!(fs::read_dir(layout.report()).unwrap().count(), 29);
}

#[test]
fn without_any_record_the_page_says_what_is_missing() {
    let dir = tempfile::tempdir().unwrap();
    let layout =
        write_results(dir.path(), &[("fixed-time-untuned", [None, None]), ("idqn", [None, None])]);
    let page = report_of(&layout, "index.html");
    assert!(page.contains("<h1>No method can be scored yet</h1>"));
    assert!(page.contains("Incomplete: 0 of 4 tasks are done, 4 have no record yet"));
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
    let data = reported(&layout);
    let idqn = &data.methods[0];
    assert_eq!((idqn.overall, idqn.points, idqn.without_reference), (Some(0.5), 1, 1));
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

#[test]
fn a_point_without_delay_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(
        dir.path(),
        &[
            ("fixed-time-untuned", [Some(Ok([0.0, 0.0])), Some(Ok([40.0, 60.0]))]),
            ("idqn", [Some(Ok([0.0, 0.0])), Some(Ok([20.0, 30.0]))]),
        ],
    );
    let data = reported(&layout);
    let note = "No score on quiet: the baseline has no delay there, as on a road without vehicles; \
                give it demand.";
    assert!(text::notes(&data).iter().any(|n| n == note), "{:?}", text::notes(&data));
}
