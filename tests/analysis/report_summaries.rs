//! What a report says beside the score: other summaries, gridlocks, and scores against a method that is
//! not the baseline.

use std::fs;
use std::path::Path;

use crate::common::succeed;
use crate::made_up::{
    Ending, evaluations, manifest, reported, well_formed, well_linked, words, write_results,
};
use tsc_family::domains;
use tsc_family::report::{self, Report, text};
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::record::{Metrics, Row, RowKind, TaskResult};
use tsc_family::store::results::Results;

/// Positions of what is measured of episodes.
const UNFINISHED: usize = 0;
const GRIDLOCKED: usize = 1;

/// Delays on `quiet` and `busy`, of which the second is at level of service F, seconds.
const BASELINE: [f64; 2] = [20.0, 200.0];

fn delays(task: &Task, quiet_s: f64, busy_s: f64) -> Ending {
    let delay_s = if task.point == "busy" { busy_s } else { quiet_s };
    Ok(TaskResult { rows: evaluations(&[delay_s, delay_s]), ..TaskResult::default() })
}

/// Gives one evaluation episode another number of unfinished vehicles, of 1000.
fn with_unfinished(ending: Ending, seed: usize, vehicles: f64) -> Ending {
    ending.map(|mut result| {
        result.rows[seed].metrics.insert("unfinished_veh".into(), vehicles);
        result
    })
}

/// Takes a metric out of every row, as records of an older version lack it.
fn without(ending: Ending, name: &str) -> Ending {
    ending.map(|mut result| {
        for row in &mut result.rows {
            let others = row.metrics.iter().filter(|(key, _)| *key != name);
            row.metrics = others.map(|(key, value)| (key.clone(), *value)).collect();
        }
        result
    })
}

/// Puts an episode of tuning before the evaluations.
fn tuned(ending: Ending) -> Ending {
    ending.map(|mut result| {
        let metrics = Metrics::from([("delay_s".to_owned(), 33.0)]);
        result.rows.insert(0, Row { kind: RowKind::Training, episode: 0, seed: 7, metrics });
        result
    })
}

/// A method that is better at the quiet point MDP, which weighs three quarters, and worse at the busy
/// one, which holds the delay; and a tuned one that is better at both.
fn heavy_tail(root: &Path) -> Layout {
    write_results(root, &manifest(&["baseline", "fixed-time", "max-pressure"]), |task| {
        Some(match task.method.as_str() {
            "fixed-time" => tuned(delays(task, 15.0, 100.0)),
            "max-pressure" => with_unfinished(delays(task, 10.0, 400.0), 1, 90.0),
            _ => delays(task, BASELINE[0], BASELINE[1]),
        })
    })
}

fn data_of(layout: &Layout) -> Report {
    reported(layout)
}

fn file_of(layout: &Layout, file: &str) -> String {
    report::write(layout, &reported(layout)).unwrap();
    fs::read_to_string(layout.report().join(file)).unwrap()
}

/// The methods of the registry with the longest names, on a point MDP each.
fn long_names() -> Manifest {
    let mut manifest = manifest(&["baseline", "nema-with-long-name", "max-pressure-resco"]);
    for (point, draw) in
        manifest.identity.points.iter_mut().zip(&mut manifest.identity.sample.draws)
    {
        point.point = format!("L4-S55-D100-Q500-l0-r1-{}", point.point);
        draw.point.clone_from(&point.point);
    }
    manifest
}

#[test]
fn the_table_has_the_further_summaries_below_the_ranking() {
    let dir = tempfile::tempdir().unwrap();
    let data = data_of(&heavy_tail(dir.path()));
    insta::assert_snapshot!(text::table(&data), @r#"
 rank   method         score    95% interval   delay (s)   worst   points   failed
-----------------------------------------------------------------------------------
    1   fixed-time      0.69    0.69 to 0.69        36.2    0.75      2/2        0
    2   max-pressure    0.88    0.88 to 0.88         108    2.00      2/2        0
    3   baseline        1.00   by definition        65.0       -      2/2        0

ratio of mean delays, median and geometric mean of the scores, all relative to the baseline;
to E and at F: mean score where the baseline is at level of service A to E and at F
(1 point MDP is at level of service F, with 25% of the importance and 77% of the delay);
unfinished: share of the vehicles; gridlock: share of the evaluation episodes;
worst: longest delay in an evaluation episode relative to that of the same vehicles

 method         ratio   median   geometric   to E   at F   unfinished   gridlock   worst
-----------------------------------------------------------------------------------------
 fixed-time      0.56     0.75        0.68   0.75   0.50           2%         0%    0.75
 max-pressure    1.65     0.50        0.71   0.50   2.00           6%        50%    2.00
 baseline        1.00     1.00        1.00   1.00   1.00           2%         0%    1.00
"#);
    insta::assert_snapshot!(text::notes(&data).join("\n"), @r#"
The intervals of fixed-time exclude the luck of tuning: each was tuned once per point MDP; --replicates R includes it.
Summaries of max-pressure disagree: better than the baseline by score 0.88, median score 0.50, geometric mean 0.71, worse by ratio of mean delays 1.65, that is 65% more mean delay: it saves where delay is short and loses where it is long.
The order by ratio of mean delays differs from the order by score: fixed-time 0.56, baseline 1.00, max-pressure 1.65.
"#);
}

#[test]
fn no_line_of_the_table_is_longer_than_100_characters() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &long_names(), |task| {
        Some(match task.method.as_str() {
            "nema-with-long-name" => delays(task, 1234.5, 12.3),
            "max-pressure-resco" => delays(task, 2.0, 1234.5),
            _ => delays(task, 20.0, 30.0),
        })
    });
    let results = Results::load(&layout).unwrap();
    let against = Report::against(
        &results,
        "max-pressure-resco",
        domains::sections(&layout, &results).unwrap(),
    )
    .unwrap();
    for data in [reported(&layout), against] {
        let table = text::table(&data);
        for line in table.lines() {
            assert!(line.chars().count() <= 100, "{} characters: {line}", line.chars().count());
        }
    }
}

#[test]
fn the_words_about_summaries_are_these() {
    let dir = tempfile::tempdir().unwrap();
    let page = file_of(&heavy_tail(dir.path()), "index.html");
    well_linked(&page);
    let page = words(&page);
    let (_, section) = page.split_once("\nMore than one summary\nThe score").unwrap();
    insta::assert_snapshot!(section.split_once("\nSpread over point MDPs\n").unwrap().0);
}

#[test]
fn summary_csv_and_json_have_the_same_summaries() {
    let dir = tempfile::tempdir().unwrap();
    let layout = heavy_tail(dir.path());
    let csv = file_of(&layout, "summary.csv");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    for (row, json) in rows.iter().zip(data_of(&layout).json_rows()) {
        let json = serde_json::to_value(json).unwrap();
        let mut compared = 0;
        for (name, value) in json.as_object().unwrap() {
            let Some(column) = header.iter().position(|h| h == name) else { continue };
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            assert_eq!(row[column].parse::<f64>().ok(), text.parse::<f64>().ok(), "{name}");
            compared += 1;
        }
        assert!(compared > 20, "{compared}");
    }
    insta::assert_snapshot!(csv);
}

#[test]
fn episodes_csv_has_a_row_per_episode_of_training_and_evaluation() {
    let dir = tempfile::tempdir().unwrap();
    let csv = file_of(&heavy_tail(dir.path()), "episodes.csv");
    let lines: Vec<&str> = csv.lines().take(5).collect();
    insta::assert_snapshot!(lines.join("\n"), @r#"
method,point,replicate,kind,episode,seed,delay_s,waiting_s,unfinished_veh,undeparted_veh,vehicles_veh,return,loss
baseline,quiet,0,evaluation,0,1073741825,20,10,20,5,1000,,
baseline,quiet,0,evaluation,1,1073741826,20,10,20,5,1000,,
fixed-time,quiet,0,training,0,7,33,,,,,,
fixed-time,quiet,0,evaluation,0,1073741825,15,7.5,20,5,1000,,
"#);
    assert_eq!(csv.lines().count(), 1 + 6 * 2 + 2);
}

#[test]
fn one_seed_with_vehicles_left_behind_is_a_gridlock_of_that_episode() {
    let dir = tempfile::tempdir().unwrap();
    let data = data_of(&heavy_tail(dir.path()));
    let of = |name: &str| &data.methods.iter().find(|m| m.method == name).unwrap().episodes;
    // One of two seeds on both point MDPs.
    assert_eq!(of("max-pressure").shares[GRIDLOCKED], Some(0.5));
    assert_eq!(of("fixed-time").shares[GRIDLOCKED], Some(0.0));
    assert!((of("fixed-time").shares[UNFINISHED].unwrap() - 0.02).abs() < 1e-12);
    assert_eq!(of("max-pressure").worst, Some(400.0));
}

#[test]
fn what_the_baseline_leaves_behind_too_is_no_gridlock_up_to_one_half() {
    for (vehicles, expected) in [(450.0, 0.0), (510.0, 1.0)] {
        let dir = tempfile::tempdir().unwrap();
        let manifest = manifest(&["baseline", "actuated"]);
        let layout = write_results(dir.path(), &manifest, |task| {
            let ending = delays(task, BASELINE[0], BASELINE[1]);
            Some(with_unfinished(with_unfinished(ending, 0, vehicles), 1, vehicles))
        });
        for m in &data_of(&layout).methods {
            assert_eq!(m.episodes.shares[GRIDLOCKED], Some(expected), "{}", m.method);
        }
    }
}

#[test]
fn a_metric_that_was_not_recorded_is_a_gap_and_never_0() {
    for lacking in ["baseline", "max-pressure"] {
        for metric in ["vehicles_veh", "unfinished_veh", "waiting_s"] {
            let dir = tempfile::tempdir().unwrap();
            let manifest = manifest(&["baseline", "max-pressure"]);
            let layout = write_results(dir.path(), &manifest, |task| {
                let ending = delays(task, BASELINE[0], BASELINE[1]);
                Some(if task.method == lacking { without(ending, metric) } else { ending })
            });
            let data = data_of(&layout);
            let m = data.methods.iter().find(|m| m.method == lacking).unwrap();
            assert_eq!(m.overall, Some(1.0));
            let counted = metric != "waiting_s";
            assert_eq!(m.episodes.shares[UNFINISHED].is_none(), counted, "{lacking} {metric}");
            assert_eq!(m.episodes.shares[GRIDLOCKED].is_none(), counted, "{lacking} {metric}");
            assert!(!m.metrics.contains_key(metric));
            let csv = file_of(&layout, "episodes.csv");
            let mut reader = csv::Reader::from_reader(csv.as_bytes());
            let column = reader.headers().unwrap().iter().position(|h| h == metric).unwrap();
            for row in reader.records().map(Result::unwrap).filter(|row| &row[0] == lacking) {
                assert_eq!(&row[column], "");
            }
        }
    }
}

#[test]
fn without_the_baseline_s_vehicles_a_gridlock_of_others_is_not_known() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &manifest(&["baseline", "max-pressure"]), |task| {
        let ending = delays(task, BASELINE[0], BASELINE[1]);
        Some(if task.method == "baseline" { without(ending, "vehicles_veh") } else { ending })
    });
    assert!(data_of(&layout).methods.iter().all(|m| m.episodes.shares[GRIDLOCKED].is_none()));
    assert!(
        words(&file_of(&layout, "index.html")).contains("max-pressure | 4 | 2.0% | \u{2013} |")
    );
}

#[test]
fn scores_against_another_method_say_so_everywhere() {
    let dir = tempfile::tempdir().unwrap();
    let layout = heavy_tail(dir.path());
    let data = {
        let results = Results::load(&layout).unwrap();
        Report::against(&results, "fixed-time", domains::sections(&layout, &results).unwrap())
            .unwrap()
    };
    let paths = report::write(&layout, &data).unwrap();
    assert!(paths.html.ends_with("report/against-fixed-time/index.html"), "{:?}", paths.html);
    assert!(!layout.report().join("index.html").exists());
    let page = fs::read_to_string(&paths.html).unwrap();
    well_linked(&page);
    insta::with_settings!({ filters => vec![("[0-9a-f]{64}", "[sha256]")] }, {
        insta::assert_snapshot!(words(&page));
    });
    paths.figures.iter().for_each(|path| well_formed(&fs::read_to_string(path).unwrap()));
    insta::assert_snapshot!(text::table(&data), @r#"
Scores against fixed-time, not against the baseline:

 rank   method                 score    95% interval   delay (s)   worst   points   failed
-------------------------------------------------------------------------------------------
    1   fixed-time (divisor)    1.00   by definition        36.2       -      2/2        0
    2   baseline                1.50    1.50 to 1.50        65.0    2.00      2/2        0
    3   max-pressure            1.50    1.50 to 1.50         108    4.00      2/2        0

ratio of mean delays, median and geometric mean of the scores, all relative to fixed-time;
to E and at F: mean score where the baseline is at level of service A to E and at F
(1 point MDP is at level of service F, with 25% of the importance and 77% of the delay);
unfinished: share of the vehicles; gridlock: share of the evaluation episodes;
worst: longest delay in an evaluation episode relative to that of the same vehicles

 method         ratio   median   geometric   to E   at F   unfinished   gridlock   worst
-----------------------------------------------------------------------------------------
 fixed-time      1.00     1.00        1.00   1.00   1.00           2%         0%    1.00
 baseline        1.79     1.33        1.48   1.33   2.00           2%         0%    2.00
 max-pressure    2.97     0.67        1.04   0.67   4.00           6%        50%    4.00
"#);
    let scores = fs::read_to_string(&paths.scores).unwrap();
    assert!(scores.starts_with("method,point,importance,replicate,delay_s,against_delay_s,score"));
    assert!(data.json_rows().iter().all(|row| row["against"] == "fixed-time"));
}

#[test]
fn a_report_against_another_method_can_be_written_to_its_folder_again() {
    let dir = tempfile::tempdir().unwrap();
    let results = dir.path().join("results");
    fs::create_dir(&results).unwrap();
    heavy_tail(&results);
    for _ in 0..2 {
        succeed(dir.path(), "report results --against fixed-time --out pages");
    }
    assert!(dir.path().join("pages/against-fixed-time/scores.csv").is_file());
}

#[test]
fn scores_against_the_baseline_by_name_are_the_usual_ones() {
    let dir = tempfile::tempdir().unwrap();
    let layout = heavy_tail(dir.path());
    let results = Results::load(&layout).unwrap();
    let against =
        Report::against(&results, "baseline", domains::sections(&layout, &results).unwrap())
            .unwrap();
    assert_eq!(against.analysis, reported(&layout).analysis);
}

#[test]
fn scores_against_a_method_that_lacks_results_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &manifest(&["baseline", "fixed-time"]), |task| {
        match (task.method.as_str(), task.point.as_str()) {
            ("fixed-time", "busy") => None,
            _ => Some(delays(task, 20.0, 30.0)),
        }
    });
    let results = Results::load(&layout).unwrap();
    let refusal = |method: &str| {
        Report::against(&results, method, domains::sections(&layout, &results).unwrap())
            .unwrap_err()
            .to_string()
    };
    insta::assert_snapshot!(refusal("fixed-time"), @r#"
no scores against `fixed-time`: it has no delay above 0 on 1 of 2 point MDPs (busy); finish the run, or leave --against out
"#);
    insta::assert_snapshot!(refusal("actuated"), @r#"
no scores against `actuated`, which is not in the run; its methods are baseline, fixed-time
"#);
}
