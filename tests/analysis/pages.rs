//! What the pages, tables and drawings of a report say, word by word, and the numbers behind them.

use std::fs;

use crate::made_up::{
    Ending, SEEDS, Written, done, ended, equal_points, evaluations, manifest, measured, written,
};
use tsc_family::analysis::Decided;
use tsc_family::domains;
use tsc_family::report::{CITATIONS, Report, text};
use tsc_family::sample::design::DesignPoint;
use tsc_family::sample::{Design, Input, Measure, Sampling};
use tsc_family::stats::Direction;
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::opaque::Opaque;
use tsc_family::store::own::{OwnKind, OwnMethod};
use tsc_family::store::record::{Metrics, Row, RowKind, TaskResult};
use tsc_family::store::results::Results;
use tsc_family::store::wall::Wall;
use tsc_family::traffic::existing::{Control, ExistingPlan, PlanPhase, Recall};
use tsc_family::traffic::places::{FILE, MappedIntersection, Places, StreetsOfRank};
use tsc_family::traffic::program::{ProgramKind, ProgramPhase, SignalProgram};

/// Delays on `quiet` and `busy`, seconds.
type Delays<'a> = (&'a str, [[f64; 2]; 2]);

fn is_busy(task: &Task) -> usize {
    usize::from(task.point == "busy")
}

fn methods(delays: &[Delays<'_>]) -> Written {
    with_methods(delays, |_| {})
}

fn with_methods(delays: &[Delays<'_>], change: impl Fn(&mut Manifest)) -> Written {
    let names: Vec<&str> = delays.iter().map(|(name, _)| *name).collect();
    let mut manifest = manifest(&names);
    change(&mut manifest);
    written(&manifest, |task| {
        let (_, of) = delays.iter().find(|(name, _)| *name == task.method)?;
        ended(&of[is_busy(task)])
    })
}

const BASELINE: Delays<'_> = ("baseline", [[20.0, 22.0], [90.0, 96.0]]);

/// One method is better, another failed on one of two point MDPs.
fn few() -> Written {
    written(&manifest(&["fixed-time-untuned", "max-pressure", "idqn"]), |task| {
        match (task.method.as_str(), is_busy(task)) {
            ("idqn", 1) => Some(Err("sumo failed: <collision> & stuck")),
            ("idqn", _) => ended(&[16.0, 18.0]),
            ("max-pressure", busy) => ended(&[[10.0, 12.0], [30.0, 40.0]][busy]),
            (_, busy) => ended(&[[20.0, 20.0], [40.0, 60.0]][busy]),
        }
    })
}

fn snapshot(name: &str, texts: &[String]) {
    // The manifest's own hash changes with every new field.
    insta::with_settings!({ filters => vec![("[0-9a-f]{64}", "[sha256]")] }, {
        insta::assert_snapshot!(name, texts.join("\n\n"));
    });
}

#[test]
fn the_page_and_the_tables_of_a_run_are_these() {
    let run = few();
    let tables = ["scores.csv", "summary.csv", "pairs.csv", "ranks.csv", "profiles.csv"];
    let mut texts = vec![run.words(), text::table(&run.data), run.notes()];
    texts.push(serde_json::to_string(&run.data.json_rows()[1]).unwrap());
    texts.extend(tables.map(|name| run.file(name)));
    texts.extend(["ranking.tex", "summaries.tex", "pairs.tex"].map(|name| run.file(name)));
    snapshot("run", &texts);
    // A report is a function of the records, and leaves no drafts.
    let files = fs::read_dir(run.layout.report()).unwrap().count();
    run.write_again();
    assert_eq!(fs::read_to_string(run.layout.report().join("index.html")).unwrap(), run.html);
    assert_eq!(fs::read_dir(run.layout.report()).unwrap().count(), files);
}

/// A learner that is better where it is quiet, which weighs three quarters, and worse where the delay is; and a tuned method
/// that is better on both.
fn heavy_tail() -> Written {
    written(&manifest(&["baseline", "fixed-time", "max-pressure"]), |task| {
        let busy = is_busy(task);
        Some(match task.method.as_str() {
            "fixed-time" => {
                let metrics = Metrics::from([("delay_s".to_owned(), 33.0)]);
                let mut rows = evaluations(&[[15.0; 2], [100.0; 2]][busy]);
                rows.insert(0, Row { kind: RowKind::Training, episode: 0, seed: 7, metrics });
                done(rows)
            }
            "max-pressure" => {
                let mut rows = evaluations(&[[10.0; 2], [400.0; 2]][busy]);
                rows[1].metrics.insert("unfinished_veh".into(), 90.0);
                done(rows)
            }
            _ => ended(&[[20.0; 2], [200.0; 2]][busy])?,
        })
    })
}

fn against(run: &Written, method: &str) -> Report {
    let results = Results::load(&run.layout).unwrap();
    Report::against(&results, method, domains::sections(&run.layout, &results).unwrap()).unwrap()
}

#[test]
fn the_page_against_another_method_says_so_everywhere() {
    let run = heavy_tail();
    let other = run.rewritten(against(&run, "fixed-time"));
    let folder = run.layout.report().join("against-fixed-time");
    assert!(folder.join("index.html").is_file());
    let mut texts = vec![other.words(), text::table(&other.data), other.notes()];
    texts.extend([text::table(&run.data), run.notes(), run.file("summary.csv")]);
    texts.extend(run.file("episodes.csv").lines().take(5).map(str::to_owned));
    snapshot("against", &texts);
    assert!(other.data.json_rows().iter().all(|row| row["against"] == "fixed-time"));
    assert_eq!(against(&run, "baseline").analysis, run.data.analysis);
}

const UNFINISHED: usize = 0;
const GRIDLOCKED: usize = 1;

#[test]
fn vehicles_that_are_left_behind_make_a_gridlock_beyond_those_of_the_baseline() {
    let run = heavy_tail();
    let of = |name: &str| run.method(name).episodes.clone();
    assert_eq!(of("max-pressure").shares[GRIDLOCKED], Some(0.5));
    assert_eq!(of("fixed-time").shares[GRIDLOCKED], Some(0.0));
    assert!((of("fixed-time").shares[UNFINISHED].unwrap() - 0.02).abs() < 1e-12);
    assert_eq!(of("max-pressure").worst, Some(400.0));
    // What the baseline leaves behind too is none up to one half.
    for (vehicles, expected) in [(450.0, 0.0), (510.0, 1.0)] {
        let run = written(&manifest(&["baseline", "actuated"]), |_| {
            Some(measured(&[20.0, 20.0], "unfinished_veh", Some(vehicles)))
        });
        for m in &run.data.methods {
            assert_eq!(m.episodes.shares[GRIDLOCKED], Some(expected), "{}", m.method);
        }
    }
}

#[test]
fn a_metric_that_was_not_recorded_is_a_gap_and_never_0() {
    for lacking in ["baseline", "max-pressure"] {
        for metric in ["vehicles_veh", "unfinished_veh", "waiting_s"] {
            let run = written(&manifest(&["baseline", "max-pressure"]), |task| {
                match task.method == lacking {
                    true => Some(measured(&[20.0, 20.0], metric, None)),
                    false => ended(&[20.0, 20.0]),
                }
            });
            let m = run.method(lacking);
            assert_eq!(m.overall, Some(1.0));
            let counted = metric != "waiting_s";
            assert_eq!(m.episodes.shares[UNFINISHED].is_none(), counted, "{lacking} {metric}");
            assert_eq!(m.episodes.shares[GRIDLOCKED].is_none(), counted, "{lacking} {metric}");
            assert!(!m.metrics.contains_key(metric));
            for row in run.rows("episodes.csv").iter().filter(|row| row["method"] == lacking) {
                assert_eq!(row[metric], "");
            }
            // Without the baseline's vehicles a gridlock of others is not known.
            if lacking == "baseline" && metric == "vehicles_veh" {
                let all = &run.data.methods;
                assert!(all.iter().all(|m| m.episodes.shares[GRIDLOCKED].is_none()));
            }
        }
    }
}

/// Three intersections of `quiet` and one of `busy`, an hour with a tenth of the day's traffic.
fn city(manifest: &mut Manifest) {
    manifest.identity.points[1].instances = 1;
    manifest.identity.settings["family"] =
        serde_json::json!({"approaches": "a.csv", "hourly_share": 0.1});
}

const CITY: [Delays<'_>; 3] = [
    BASELINE,
    ("max-pressure", [[10.0, 12.0], [60.0, 66.0]]),
    ("actuated", [[12.0, 11.0], [84.0, 85.0]]),
];

fn sample(manifest: &mut Manifest) {
    city(manifest);
    let sample = &mut manifest.identity.sample;
    (sample.sampling, sample.family_size) = (Sampling::Balanced, 4);
    sample.draws.iter_mut().for_each(|draw| draw.inclusion = Some(draw.weight));
}

/// The family of [`sample`], with the baseline's delays.
fn design() -> Design {
    let point = |(i, name): (usize, &&str)| DesignPoint {
        point: (*name).to_owned(),
        importance: 0.25,
        describing: vec![2.0, [250.0, 900.0, 1200.0, 1500.0][i]],
        inputs: vec![[21.0, 93.0, 120.0, 400.0][i]],
    };
    let names = ["quiet", "busy", "full", "fuller"];
    let inputs = vec![Input { method: "baseline".into(), measure: Measure::Objective }];
    let points = names.iter().enumerate().map(point).collect();
    Design { inputs, points, ..Design::default() }
}

fn sampled(change: impl Fn(&mut Manifest)) -> Written {
    let mut manifest = manifest(&CITY.map(|(name, _)| name));
    sample(&mut manifest);
    manifest.identity.sample.design = design().sha256();
    change(&mut manifest);
    Written::new(
        &manifest,
        &[("design.json", String::from_utf8(design().to_json()).unwrap())],
        |task| {
            let (_, of) = CITY.iter().find(|(name, _)| *name == task.method)?;
            ended(&of[is_busy(task)])
        },
    )
}

#[test]
fn the_first_paragraphs_say_what_a_family_and_a_sample_hold_for() {
    let short = |manifest: &mut Manifest| {
        city(manifest);
        manifest.identity.settings["demand"]["horizon_s"] = 300.0.into();
    };
    let unlisted = |manifest: &mut Manifest| {
        sample(manifest);
        manifest.identity.sample.sampling = Sampling::KMeans;
    };
    let pages = [with_methods(&CITY, city), with_methods(&CITY, short), sampled(|_| {})];
    let last = with_methods(&CITY, unlisted);
    let pages = pages.iter().chain([&last]);
    snapshot("first", &pages.map(Written::first).collect::<Vec<_>>());
    // What is not known of a day or of counts is left out.
    let page = with_methods(&CITY, |m| {
        city(m);
        m.identity.settings["family"]["approaches"] = serde_json::Value::Null;
    });
    assert!(page.first().contains("in the simulated hour.") && !page.first().contains("the day"));
    // Importance that is no share of the instances.
    let page = with_methods(&CITY, |m| m.identity.points[1].instances = 7);
    assert!(!page.first().contains("vehicle-hours"));
}

#[test]
fn a_coordinated_plan_of_today_that_was_simulated_alone_is_named_beside_the_gain() {
    let said = |control: Control| {
        let phase = PlanPhase {
            number: 2,
            also: None,
            ring: 1,
            barrier: 1,
            position: 1,
            movements: vec!["NBT".to_owned()],
            yielding: Vec::new(),
            min_green_s: 5.0,
            max_green_s: 55.0,
            min_split_s: None,
            passage_s: 3.0,
            yellow_s: 4.0,
            all_red_s: 1.0,
            walk_s: None,
            recall: Recall::Max,
            dual_entry: true,
            inhibit_max: false,
            detectors: String::new(),
        };
        let other =
            PlanPhase { number: 4, barrier: 2, movements: vec!["EBT".to_owned()], ..phase.clone() };
        let plan = ExistingPlan {
            cycle_s: Some(120.0),
            reference: vec![2],
            ..ExistingPlan::new(control, vec![phase, other])
        };
        plan.check().unwrap();
        let today = [BASELINE, CITY[1], ("existing", CITY[2].1)];
        with_methods(&today, |manifest| {
            let busy = &mut manifest.identity.points[1];
            busy.environment = "network".to_owned();
            let plan = serde_json::to_value(&plan).unwrap();
            busy.given.insert("existing".to_owned(), plan);
        })
        .first()
    };
    let sentence = "On 1 of 2 point MDPs existing is a coordinated plan. Each intersection was simulated alone";
    assert!(said(Control::Coordinated).contains(sentence));
    assert!(!said(Control::Pretimed).contains("is a coordinated plan"));
}

#[test]
fn what_chance_alone_may_explain_is_no_title() {
    let title = |delays| methods(&[BASELINE, ("max-pressure", delays)]).title();
    assert_eq!(
        title([[10.0, 12.0], [60.0, 66.0]]),
        "max-pressure: 44% less delay than the baseline"
    );
    // Much better with one seed, much worse with the other.
    assert_eq!(
        title([[2.0, 30.0], [9.0, 150.0]]),
        "max-pressure: perhaps 21% less delay than the baseline (open: it may be chance)"
    );
}

#[test]
fn a_first_place_of_one_training_that_rests_on_five_point_mdps_is_open_and_names_them() {
    let said = |ahead: usize| {
        let mut manifest = manifest(&["baseline", "max-pressure", "idqn"]);
        equal_points(&mut manifest, 24, |i| (format!("p{i:02}"), vec![2.0, 250.0]));
        let run = written(&manifest, |task| {
            let place: usize = task.point[1..].parse().unwrap();
            match task.method.as_str() {
                "idqn" => Some(trained(task, if place < ahead { 0.2 } else { 0.51 }, "return")),
                "max-pressure" => untrained(task, 0.5),
                _ => untrained(task, 1.0),
            }
        });
        let named = "(p00; p01; p02; p03; p04) max-pressure would be ahead";
        let is_said = run.notes().contains(named);
        assert_eq!(is_said, run.first().contains(named));
        assert!(!is_said || run.data.comparison.pairs[0].decided() == Decided::Open);
        (run.method("idqn").rank, is_said)
    };
    assert_eq!([5, 12].map(said), [(Some(1), true), (Some(1), false)]);
}

#[test]
fn without_results_without_scores_and_alone_a_method_has_a_page() {
    let run = written(&manifest(&["baseline", "idqn"]), |_| None);
    assert_eq!(run.title(), "No method can be scored yet");
    let run = methods(&[BASELINE]);
    assert!(run.words().contains("Only the baseline has results so far"));
    assert_eq!(run.file("pairs.csv").lines().count(), 1);
    // A point MDP whose baseline failed leaves the estimate.
    let run = written(&manifest(&["baseline", "idqn"]), |task| {
        match (task.method.as_str(), is_busy(task)) {
            ("baseline", 1) => Some(Err("killed")),
            ("baseline", _) => ended(&[20.0, 20.0]),
            _ => ended(&[10.0, 10.0]),
        }
    });
    let idqn = run.method("idqn");
    assert_eq!((idqn.overall, idqn.points, idqn.without_reference), (Some(0.5), 1, 1));
    // A road without vehicles has no score.
    let run = methods(&[("baseline", [[0.0; 2], [40.0; 2]]), ("idqn", [[0.0; 2], [20.0; 2]])]);
    assert!(run.notes().contains("No score on quiet: the baseline has no delay there"));
    // A gridlock stays within the drawings.
    let run =
        methods(&[("baseline", [[20.0; 2], [50.0; 2]]), ("idqn", [[1000.0; 2], [2600.0; 2]])]);
    assert_eq!(run.title(), "No method beats the baseline");
}

/// Every method but the first two falls ever further behind.
const MANY: [&str; 12] = [
    "baseline", "fixed-time", "max-pressure", "max-pressure-resco", "actuated", "idqn", "ippo",
    "mplight", "mplight-star", "a", "one-of-mine", "another-of-mine",
];

fn many(missing: &str) -> Written {
    let mut manifest = manifest(&MANY);
    manifest.identity.evaluation_seeds = SEEDS.to_vec();
    written(&manifest, |task| {
        if task.method == missing && task.point == "busy" {
            return None;
        }
        let place = MANY.iter().position(|m| *m == task.method)? as f64;
        ended(&[0.01, 0.02, 0.015].map(|less| [20.0, 200.0][is_busy(task)] * (1.0 - less * place)))
    })
}

#[test]
fn every_pair_and_every_place_of_many_methods_is_shown() {
    let run = many("");
    assert!(run.html.contains("By how much the method of a row is ahead of that of a column"));
    assert_eq!(run.file("pairs.csv").lines().count(), 67);
    assert_eq!(run.file("ranks.csv").lines().count(), 145);
    assert_eq!(run.file("ranks.svg").matches("<rect").count(), 145);
    // A method that lacks points has pairs where both have results and no place.
    let run = many("ippo");
    assert_eq!(run.data.comparison.ranks.as_ref().unwrap().len(), 11);
    let pairs = run.data.comparison.pairs.iter();
    let with_ippo = pairs.filter(|p| run.data.methods[p.second].method == "ippo");
    assert!(with_ippo.map(|p| p.points).eq([1; 11]));
}

#[test]
fn a_place_is_as_open_as_its_pair() {
    let mut manifest = manifest(&["baseline", "fixed-time"]);
    manifest.identity.evaluation_seeds = SEEDS.to_vec();
    let run = written(&manifest, |task| match (task.method.as_str(), is_busy(task)) {
        ("baseline", 1) => ended(&[101.0, 102.0, 109.0]),
        _ => ended(&[100.0; 3]),
    });
    let pair = &run.data.comparison.pairs[0];
    assert_eq!(pair.decided(), Decided::Open);
    // By Student's t with two degrees of freedom, 0.87, although the method is ahead on every seed.
    let first = run.data.comparison.ranks.as_ref().unwrap()[0][0];
    assert!((0.8..0.95).contains(&first), "{first}");
    // One seed says nothing of chance, and has no places.
    manifest.identity.evaluation_seeds.truncate(1);
    let run = written(&manifest, |task| ended(&[[20.0, 200.0][is_busy(task)]]));
    let pair = &run.data.comparison.pairs[0];
    assert_eq!((pair.decided(), pair.ahead.interval), (Decided::Unknown, None));
    assert_eq!(run.data.comparison.ranks, None);
}

#[test]
fn a_method_that_lacks_points_is_never_ranked_whatever_else_runs() {
    let ranks = |lacks: &[(&str, &str)]| {
        let run = written(&manifest(&["baseline", "a", "b"]), |task| {
            match lacks.contains(&(task.method.as_str(), task.point.as_str())) {
                true => None,
                false => ended(&[if task.method == "a" { 10.0 } else { 20.0 }; 2]),
            }
        });
        let rows = run.rows("summary.csv");
        let ranked = rows.iter().filter(|row| !row["rank"].is_empty()).count();
        let of = |name: &str| run.method(name).rank;
        let ranks = ["baseline", "a", "b"].map(of);
        assert_eq!(ranked, ranks.iter().flatten().count());
        (ranks, run.data.common.is_some())
    };
    assert_eq!(ranks(&[("a", "busy")]), ([Some(1), None, Some(2)], true));
    // Where the baseline lacks a point MDP, whoever has it does not lack it; the baseline does.
    assert_eq!(ranks(&[("baseline", "quiet")]), ([None, Some(1), Some(2)], true));
    let all = [("baseline", "quiet"), ("a", "quiet"), ("b", "quiet")];
    assert_eq!(ranks(&all).0, [None; 3]);
    // Methods that lack different points are not ranked against each other.
    assert_eq!(ranks(&[("a", "busy"), ("b", "quiet")]), ([Some(1), None, None], false));
}

const EPISODES: u32 = 12;

fn named(metrics: &[(&str, f64)]) -> Metrics {
    metrics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

/// A tuning or training that ends with a score, and whose episodes have a figure of this name; its delay falls from twice
/// the baseline's to the baseline's.
fn trained(task: &Task, score: f64, figure: &str) -> Ending {
    let unit = [20.0, 50.0][is_busy(task)];
    let training = |episode: u32| {
        let delay_s = unit * (2.0 - f64::from(episode + 1) / f64::from(EPISODES));
        let metrics = named(&[("delay_s", delay_s), (figure, -3.0)]);
        Row { kind: RowKind::Training, episode, seed: u64::from(episode), metrics }
    };
    let mut rows: Vec<Row> = (0..EPISODES).map(training).collect();
    rows.extend(evaluations(&[score * unit, score * unit]));
    let training = named(&[("resco_best_delay_s", unit), ("resco_last_ten_delay_s", 1.375 * unit)]);
    let wall = Wall { wall_s: 90.0, simulator_s: 80.0, attempts: 1, ..Wall::default() };
    Ok(TaskResult { rows, training, wall, ..TaskResult::default() })
}

/// The ending of a training of which validation chose the policy after row 8, unless the last one is as good.
fn validated(task: &Task, score: f64, last: f64, more: &[(&str, f64)]) -> Ending {
    let row = if score == last { f64::from(EPISODES) } else { 8.0 };
    let last_s = last * [20.0, 50.0][is_busy(task)];
    trained(task, score, "return").map(|mut result| {
        let chosen = [("policy_row", row), ("last_delay_s", last_s), ("validation_episodes", 4.0)];
        result.training.extend(named(&chosen));
        result.training.extend(named(more));
        result
    })
}

fn untrained(task: &Task, score: f64) -> Option<Ending> {
    ended(&[score * [20.0, 50.0][is_busy(task)]; 2])
}

#[test]
fn the_words_and_tables_about_training_are_these() {
    let mut manifest = manifest(&["baseline", "fixed-time", "idqn", "mplight-star", "ippo"]);
    manifest.identity.replicates = 2;
    manifest.identity.replicated = ["idqn", "mplight-star", "ippo"].map(str::to_owned).to_vec();
    let run = written(&manifest, |task| {
        let restarted = [("restarts", 2.0), ("dead", 0.0)];
        Some(match (task.method.as_str(), task.point.as_str(), task.replicate) {
            ("fixed-time", ..) => trained(task, 0.5, "cycle_s"),
            ("idqn", "busy", 1) => trained(task, 3.5, "return").map(|mut result| {
                let last = result.rows.last_mut().unwrap();
                last.metrics.insert("unfinished_veh".to_owned(), 110.0);
                result
            }),
            ("idqn", ..) => trained(task, 0.75, "return"),
            ("mplight-star", "busy", 1) => Err(
                "training diverged in episode 4: the return is infinite; try a smaller learning rate",
            ),
            ("mplight-star", ..) => trained(task, 1.25, "return"),
            ("ippo", "busy", 0) => validated(task, 0.5, 4.5, &[]),
            ("ippo", "busy", _) => validated(task, 0.5, 0.5, &restarted),
            ("ippo", ..) => validated(task, 0.5, 0.5, &[("restarts", 3.0), ("dead", 1.0)]),
            _ => return untrained(task, 1.0),
        })
    });
    let tables = ["training.csv", "learning.csv", "training.tex"].map(|name| run.file(name));
    snapshot(
        "training",
        &[&[run.section("Training", "Level of service"), run.notes()], &tables[..]].concat(),
    );
    let learners = run.data.learners();
    let of = |name: &str| learners.iter().find(|l| l.method.method == name).unwrap();
    let (idqn, ippo) = (of("idqn"), of("ippo"));
    assert_eq!(idqn.method.overall, Some(0.75 * 0.75 + 0.25 * (0.75 + 3.5) / 2.0));
    assert_eq!((ippo.method.overall, ippo.last_policy), (Some(0.5), Some(0.75 * 0.5 + 0.25 * 2.5)));
    assert_eq!((ippo.validated, ippo.replaced, ippo.restarted, ippo.dead), (4, 1, 3, 2));
}

#[test]
fn without_a_learner_there_is_nothing_about_training_and_one_of_your_own_learns() {
    let run = written(&manifest(&["baseline", "fixed-time"]), |task| match task.method.as_str() {
        "fixed-time" => Some(trained(task, 0.5, "cycle_s")),
        _ => untrained(task, 1.0),
    });
    assert!(!run.html.contains("raining</h2>"));
    assert!(!run.layout.report().join("training.csv").exists());
    let of = |figure: &str| {
        let mut manifest = manifest(&["baseline", "mine"]);
        let own = OwnMethod::new("mine", OwnKind::Python, "mine.py:Mine".to_owned());
        manifest.identity.controllers = vec![OwnMethod { learns: true, ..own }];
        let run = written(&manifest, |task| match task.method.as_str() {
            "mine" => Some(trained(task, [0.75, 0.5][is_busy(task)], figure)),
            _ => untrained(task, 1.0),
        });
        run.method("mine").interval.unwrap()
    };
    let (low, high) = of("return");
    assert!(high - low > 0.01, "{low} {high}");
    assert_eq!(of("loss"), (low, high));
}

fn place(
    id: &str,
    streets: &[&str],
    at: (f64, f64),
    point: &str,
    stands: Option<&str>,
) -> MappedIntersection {
    MappedIntersection {
        id: id.to_owned(),
        streets: streets.iter().map(|s| (*s).to_owned()).collect(),
        latitude: at.0,
        longitude: at.1,
        point: point.to_owned(),
        stands: stands.map(str::to_owned),
    }
}

/// Five intersections: two of `quiet`, one of `busy`, one that `quiet` stands for, one of nobody.
fn places() -> Places {
    let main = ["Main Street", "3rd Avenue"];
    let line = vec![[-111.90, 40.76], [-111.88, 40.76]];
    Places {
        intersections: vec![
            place("n1", &main, (40.76, -111.89), "quiet", Some("quiet")),
            place("n2", &[], (40.765, -111.89), "quiet", Some("quiet")),
            place("n3", &["State & 4th"], (40.76, -111.88), "busy", Some("busy")),
            place("n4", &["Elm Street"], (40.765, -111.88), "middling", Some("quiet")),
            place("n5", &[], (40.77, -111.88), "far", None),
        ],
        streets: vec![StreetsOfRank { rank: 3, lines: vec![line] }],
        drawings: vec![],
    }
}

/// What the signals of a method ran: a green, which may be longer, and a second one of 20 s.
fn program(method: &str) -> Opaque {
    let (kind, green_s, max_s) = match method {
        "baseline" => (ProgramKind::Static, 42.0, None),
        "fixed-time" => (ProgramKind::Static, 30.0, None),
        "actuated" => (ProgramKind::Actuated, 7.0, Some(50.0)),
        _ => return Opaque::default(),
    };
    let fixed = |(state, duration_s): (&str, f64)| ProgramPhase::fixed(state, duration_s);
    let mut phases =
        [("Gr", green_s), ("yr", 4.0), ("rr", 1.0), ("rG", 20.0), ("ry", 3.0)].map(fixed).to_vec();
    phases[0].min_s = max_s.map(|_| green_s);
    phases[0].max_s = max_s;
    let program = SignalProgram::new("c", kind, phases);
    Opaque::of(&[SignalProgram { own: method == "baseline", ..program }])
}

const TITLE: &str = "Main St / 5th <old>";

/// On `quiet`, fixed time has the worst mean but for the baseline, and is the best on the second seed; `busy` has ten times
/// the vehicles.
fn with_places(change: impl Fn(&mut Manifest), files: &[(&str, String)]) -> Written {
    let all = [
        ("baseline", [[80.0, 82.0], [90.0, 96.0]]),
        ("max-pressure", [[10.0, 12.0], [60.0, 66.0]]),
        ("actuated", [[12.0, 14.0], [84.0, 85.0]]),
        ("fixed-time", [[40.0, 9.0], [88.0, 89.0]]),
    ];
    let mut manifest = manifest(&all.map(|(name, _)| name));
    city(&mut manifest);
    manifest.identity.points.iter_mut().for_each(|point| point.environment = "network".to_owned());
    manifest.provenance.networks = "no/such/folder".to_owned();
    change(&mut manifest);
    Written::new(&manifest, files, |task| {
        let busy = is_busy(task);
        let (name, of) = all.iter().find(|(name, _)| *name == task.method)?;
        let ending = measured(&of[busy], "vehicles_veh", Some([100.0, 1000.0][busy]));
        Some(ending.map(|result| TaskResult { programs: program(name), ..result }))
    })
}

#[test]
fn intersections_have_names_winners_plans_and_a_map() {
    let run = with_places(|_| {}, &[(FILE, places().to_json())]);
    let map = run.file("map.svg");
    let tips = map.split("<title>").skip(1).filter_map(|rest| rest.split("</title>").next());
    let mut tips: Vec<&str> = tips.collect();
    tips.dedup();
    let tables = ["intersections.csv", "plans.csv", "plans/quiet.add.xml"];
    let words = run.section("Map", "Method notes");
    snapshot(
        "places",
        &[&[words, tips.join("\n")], &tables.map(|name| run.file(name))[..]].concat(),
    );
    // Points on the map have the columns of the table.
    let geojson: serde_json::Value = serde_json::from_str(&run.file("results.geojson")).unwrap();
    let features = geojson["features"].as_array().unwrap();
    assert_eq!(features[0]["geometry"]["coordinates"], serde_json::json!([-111.89, 40.76]));
    for (row, feature) in run.rows("intersections.csv").iter().zip(features) {
        for (name, cell) in row.iter().filter(|(name, _)| !name.ends_with("itude")) {
            match &feature["properties"][name] {
                serde_json::Value::Null => assert_eq!(cell, "", "{name}"),
                serde_json::Value::String(text) => assert_eq!(cell, text, "{name}"),
                serde_json::Value::Bool(is) => assert_eq!(*cell, is.to_string(), "{name}"),
                number => assert_eq!(cell.parse::<f64>().unwrap(), number.as_f64().unwrap()),
            }
        }
    }
    assert_eq!(features.len(), 5);
}

#[test]
fn point_mdps_have_titles_and_need_no_coordinates() {
    let run = with_places(
        |manifest| {
            manifest.identity.points[1].title = TITLE.to_owned();
            manifest.identity.points.iter_mut().for_each(|point| point.places.clear());
        },
        &[],
    );
    assert!(!run.layout.report().join("map.svg").exists());
    for file in ["scores.csv", "episodes.csv", "plans.csv"] {
        for row in run.rows(file) {
            let title = if row["point"] == "busy" { TITLE } else { "quiet" };
            assert_eq!(row["title"], title, "{file}");
        }
    }
    assert!(run.html.contains("Main St &#x2f; 5th &lt;old&gt;") && !run.html.contains("<old>"));
}

#[test]
fn a_task_of_another_kind_knows_neither_baseline_nor_traffic() {
    let distances = [("drift", [0.0, 0.25]), ("stroke", [8.0, 2.0]), ("dive", [5.0, 20.0])];
    let mut manifest = manifest(&distances.map(|(name, _)| name));
    let identity = &mut manifest.identity;
    identity.domain = "river".into();
    identity.simulator = "water".into();
    identity.scenario = "swimmer".into();
    identity.settings = serde_json::json!({"viscosity": 0.1});
    identity.baseline = String::new();
    identity.objective = "distance_m".into();
    identity.direction = Direction::Higher;
    manifest.provenance.command = "tsc-family run swimmer".into();
    manifest.provenance.networks = String::new();
    let run = written(&manifest, |task| {
        let (_, distances) = distances.iter().find(|(name, _)| *name == task.method)?;
        let distance = distances[is_busy(task)];
        let mut rows = evaluations(&[distance, distance + 0.5]);
        for row in &mut rows {
            let distance = row.metrics["delay_s"];
            row.metrics = named(&[("distance_m", distance), ("strokes", 30.0)]);
        }
        Some(done(rows))
    });
    snapshot("river", &[run.words(), text::table(&run.data), run.file("summary.csv")]);
    for strange in ["delay", "vehicle", "intersection", "signal", "traffic", "SUMO"] {
        assert!(!run.html.contains(strange), "{strange}");
    }
    let expected = [("dive", 9.0), ("stroke", 6.75), ("drift", 0.3125)];
    for (method, (name, overall)) in run.data.methods.iter().zip(expected) {
        assert_eq!((method.method.as_str(), method.overall), (name, Some(overall)));
    }
}

#[test]
fn what_to_cite_is_what_the_citation_file_says() {
    let cff = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/CITATION.cff")).unwrap();
    let version = format!("version: {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(cff.matches(&version).count(), 2, "of the software and of what to cite");
    let year = cff.lines().find_map(|line| line.strip_prefix("  year: ")).unwrap();
    assert!(CITATIONS.contains(&format!("year = {{{year}}},\n  version")), "{CITATIONS}");
}
