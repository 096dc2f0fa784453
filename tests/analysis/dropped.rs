//! Methods that drop out of a sample that grows: what is to be done, what counts, what a damaged list of them leads to.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::made_up::{ended, equal_points, manifest, reported, words, write_results};

use tsc_family::report::{self, findings};
use tsc_family::sample::{Draw, Growth, Look, Sampling, Until};
use tsc_family::store::dropped::{Dropped, write_dropped};
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::results::Results;
use tsc_family::store::{Layout, Remedy, StoreError};

pub(crate) fn growing(until: Until) -> Manifest {
    let mut manifest = manifest(&["baseline", "fixed-time", "idqn", "ippo"]);
    equal_points(&mut manifest, 8, |i| (format!("p{i}"), vec![2.0, 100.0 * i as f64]));
    let sample = &mut manifest.identity.sample;
    let look = |budget: usize| {
        let draw = |d: &Draw| Draw { weight: 1.0 / budget as f64, ..d.clone() };
        Look { budget, draws: sample.draws[..budget].iter().map(draw).collect() }
    };
    sample.growth = Some(Growth { until, looks: vec![look(4), look(8)] });
    (sample.sampling, sample.family_size) = (Sampling::Balanced, 40);
    manifest
}

/// ippo is far behind, fixed-time and idqn are close.
pub(crate) fn delays(task: &Task) -> [f64; 2] {
    let place = f64::from(task.point.as_bytes()[1] - b'0');
    match task.method.as_str() {
        "baseline" => [100.0, 101.0],
        "fixed-time" => [50.0 + place, 50.0 - place],
        "idqn" => [50.0 - place, 51.0 + place],
        _ => [300.0 + place, 301.0],
    }
}

/// The first look is complete; of the second some methods are.
pub(crate) fn written(root: &Path, until: Until, second: &[&str]) -> Layout {
    write_results(root, &growing(until), |task| {
        let is_first = task.point.as_str() < "p4";
        ended(&delays(task)).filter(|_| is_first || second.contains(&task.method.as_str()))
    })
}

fn first_place() -> Until {
    Until::FirstPlace(["fixed-time", "idqn", "ippo"].map(str::to_owned).to_vec())
}

#[test]
fn who_is_surely_behind_drops_out_and_the_others_go_on() {
    let dir = tempfile::tempdir().unwrap();
    let layout = written(dir.path(), first_place(), &[]);
    let standing = reported(&layout).standing().unwrap();
    assert!(standing.goes_on() && standing.open.len() == 1, "{standing:?}");
    let named: Vec<&str> = standing.behind.iter().map(|d| d.method.as_str()).collect();
    assert_eq!((named, standing.behind[0].look), (vec!["ippo"], 1));

    write_dropped(&layout, &standing.behind).unwrap();
    let all = Results::load_all(&layout).unwrap();
    let next = all.at_look(1).unwrap();
    let missing: BTreeSet<&str> = next.missing().map(|t| t.method.as_str()).collect();
    assert_eq!(missing, BTreeSet::from(["baseline", "fixed-time", "idqn"]));
    assert_eq!((next.missing().count(), next.plan().len()), (12, 28));
    let begun = all.under_way(|_| false);
    assert_eq!(begun.missing().count(), 0, "the second look has not begun");
}

#[test]
fn a_look_is_complete_without_what_was_dropped() {
    let dir = tempfile::tempdir().unwrap();
    let layout = written(dir.path(), first_place(), &["baseline", "fixed-time", "idqn"]);
    let points = || Results::load(&layout).unwrap().manifest.identity.points.len();
    assert_eq!(points(), 4, "ippo lacks the second look");
    let ippo = Dropped { method: "ippo".into(), look: 1, behind: "idqn".into() };
    write_dropped(&layout, &[ippo]).unwrap();
    assert_eq!(points(), 8);
    let data = reported(&layout);
    let ippo = data.methods.iter().find(|m| m.method == "ippo").unwrap();
    assert_eq!((ippo.rank, ippo.points, ippo.missing), (None, 4, 0));
    let said = findings::growth(&data).unwrap();
    let out = "Dropped out, because another method was ahead: ippo (after look 1, behind idqn).";
    assert!(said.ends_with(out), "{said}");
    report::write(&layout, &data).unwrap();
    let page = words(&fs::read_to_string(layout.report().join("index.html")).unwrap());
    assert!(page.contains("; 1 method dropped out"), "{page}");
    let standing = data.standing().unwrap();
    assert!(
        standing.behind.is_empty() && standing.open.iter().all(|(a, b)| a != "ippo" && b != "ippo")
    );
}

#[test]
fn a_list_that_is_not_of_the_run_is_named_with_the_way_out() {
    let dir = tempfile::tempdir().unwrap();
    let layout = written(dir.path(), first_place(), &[]);
    for (text, reason) in [
        ("[{\"method\":\"mine\",\"look\":1,\"behind\":\"idqn\"}]", "mine"),
        ("[{\"method\":\"baseline\",\"look\":1,\"behind\":\"idqn\"}]", "baseline"),
        ("[{\"method\":\"ippo\",\"look\":2,\"behind\":\"idqn\"}]", "look 2 of 2"),
        ("[", "EOF"),
    ] {
        fs::write(layout.dropped(), text).unwrap();
        let e = Results::load(&layout).unwrap_err();
        let said = e.to_string();
        assert!(said.contains(reason) && said.contains("writes it again"), "{said}");
        let StoreError::Damaged(damage) = e else { panic!("{said}") };
        assert_eq!(damage.iter().map(|d| d.remedy).collect::<Vec<_>>(), [Remedy::Renew]);
    }
}

#[test]
fn who_dropped_out_weighs_point_mdps_as_in_its_last_look() {
    let mut manifest = growing(first_place());
    let sample = &mut manifest.identity.sample;
    // What is in every sample of eight, but not in every one of four, weighs more beside the others of the eight.
    let weigh = |draws: &mut Vec<Draw>| {
        let of = |i: usize| if i == 0 { 0.65 } else { 0.05 };
        draws.iter_mut().enumerate().for_each(|(i, draw)| draw.weight = of(i));
    };
    weigh(&mut sample.draws);
    sample.growth.iter_mut().for_each(|growth| weigh(&mut growth.looks[1].draws));
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &manifest, |task| {
        let is_done = task.method.as_str() != "ippo" || task.point.as_str() < "p4";
        ended(&delays(task)).filter(|_| is_done)
    });
    let ippo = Dropped { method: "ippo".into(), look: 1, behind: "idqn".into() };
    write_dropped(&layout, &[ippo]).unwrap();
    let data = reported(&layout);
    let position = |name: &str| data.methods.iter().position(|m| m.method == name).unwrap();
    let (ippo, fixed_time) = (position("ippo"), position("fixed-time"));
    let pairs = &data.comparison.pairs;
    let pair = pairs.iter().find(|p| (p.first, p.second) == (fixed_time, ippo)).unwrap();
    // 300.5, 301, 301.5 and 302 s; fixed-time has 50 s, and the baseline 100.5 s.
    let summary = &data.methods[ippo];
    let near = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-9, "{a:?} {b}");
    near(summary.overall, 301.25 / 100.5);
    near(summary.objective, 301.25);
    near(Some(pair.ahead.value), 251.25 / 100.5);
}

#[test]
fn a_training_that_failed_may_be_what_decides() {
    let behind = |fails: bool| -> Vec<String> {
        let mut manifest = growing(first_place());
        (manifest.identity.replicates, manifest.identity.replicated) = (2, vec!["ippo".into()]);
        let dir = tempfile::tempdir().unwrap();
        let layout = write_results(dir.path(), &manifest, |task| {
            if fails && (task.point.as_str(), task.replicate) == ("p0", 1) {
                return Some(Err("it failed"));
            }
            ended(&delays(task)).filter(|_| task.point.as_str() < "p4")
        });
        let standing = reported(&layout).standing().unwrap();
        standing.behind.into_iter().map(|dropped| dropped.method).collect()
    };
    assert_eq!(behind(false), ["ippo"]);
    assert!(behind(true).is_empty(), "the other training says nothing of the one that failed");
}
