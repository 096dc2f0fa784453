//! What a report says of how sure the ranking is: places, pairs, profiles, for few and many methods and with little to
//! go by.

use std::fs;
use std::path::Path;

use crate::made_up::{
    self, Ending, SEEDS, evaluations, reported, well_formed, well_linked, words, write_results,
};
use tsc_family::analysis::Decided;
use tsc_family::report::{self, Report};
use tsc_family::stats::Direction;
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::record::TaskResult;

/// All methods that the domain knows, and two that it does not.
const MANY: [&str; 12] = [
    "baseline", "fixed-time", "max-pressure", "max-pressure-resco", "actuated", "idqn", "ippo",
    "mplight", "mplight-star", "mplight-star-resco", "one-of-mine", "another-of-mine",
];

/// Returns a manifest with three evaluation seeds, the fewest for probabilities of places.
fn manifest(methods: &[&str]) -> Manifest {
    let mut manifest = made_up::manifest(methods);
    manifest.identity.evaluation_seeds = SEEDS.to_vec();
    manifest
}

fn ended(delays_s: [f64; 3]) -> Option<Ending> {
    Some(Ok(TaskResult { rows: evaluations(&delays_s), ..TaskResult::default() }))
}

/// A method that leads, one that is ahead of it at the busy point MDP only on one seed, and the baseline.
fn delays(task: &Task) -> [f64; 3] {
    match (task.method.as_str(), task.point.as_str()) {
        ("baseline", "quiet") => [20.0, 22.0, 21.0],
        ("baseline", _) => [200.0, 220.0, 210.0],
        ("fixed-time", "quiet") => [10.0, 12.0, 11.0],
        ("fixed-time", _) => [150.0, 170.0, 160.0],
        (_, "quiet") => [11.0, 13.0, 12.0],
        (_, _) => [140.0, 190.0, 165.0],
    }
}

/// Adds so many point MDPs that are like `busy`.
fn spread(mut manifest: Manifest, more: usize) -> Manifest {
    let identity = &mut manifest.identity;
    let of = |of: &str| format!("{of} again");
    for _ in 0..more {
        let mut point = identity.points[identity.points.len() - 1].clone();
        point.point = of(&point.point);
        let last = identity.sample.draws.len() - 1;
        let mut draw = identity.sample.draws[last].clone();
        draw.point.clone_from(&point.point);
        identity.points.push(point);
        identity.sample.draws.push(draw);
    }
    identity.sample.family_size += more;
    identity.sample.budget += more;
    manifest
}

fn few(root: &Path) -> Layout {
    let manifest = manifest(&["baseline", "fixed-time", "max-pressure"]);
    write_results(root, &manifest, |task| ended(delays(task)))
}

/// Methods that lie ever further behind, with noise.
fn many(root: &Path, missing: Option<&str>) -> Layout {
    write_results(root, &manifest(&MANY), |task| {
        if Some(task.method.as_str()) == missing && task.point == "busy" {
            return None;
        }
        let place = MANY.iter().position(|m| *m == task.method).unwrap() as f64;
        let level = if task.point == "busy" { 200.0 } else { 20.0 };
        ended([0.01, 0.02, 0.015].map(|less| level * (1.0 - less * place)))
    })
}

fn written(layout: &Layout) -> (String, String) {
    let paths = report::write(layout, &reported(layout)).unwrap();
    let page = fs::read_to_string(&paths.html).unwrap();
    well_formed(&page[page.find("<body>").unwrap()..page.find("</html>").unwrap()]);
    well_linked(&page);
    assert!(!page.contains("NaN"), "a number is none");
    let start = page.find("<section id=\"sure\"");
    let section = start.map_or("", |start| page[start..].split_once("</section>").unwrap().0);
    (words(&format!("<body>{section}")), section.to_owned())
}

fn file(layout: &Layout, name: &str) -> String {
    fs::read_to_string(layout.report().join(name)).unwrap()
}

#[test]
fn the_words_and_tables_on_few_methods_are_these() {
    let dir = tempfile::tempdir().unwrap();
    let layout = few(dir.path());
    insta::assert_snapshot!(written(&layout).0);
    insta::assert_snapshot!(file(&layout, "pairs.csv"));
    insta::assert_snapshot!(file(&layout, "ranks.csv"));
    insta::assert_snapshot!(file(&layout, "profiles.csv"));
}

#[test]
fn the_first_pair_is_the_lead_of_the_headline() {
    let dir = tempfile::tempdir().unwrap();
    let data = reported(&few(dir.path()));
    let (lead, pair) = (data.lead.clone().unwrap(), &data.comparison.pairs[0]);
    assert_eq!(lead.runner_up, data.methods[pair.second].method);
    let (low, high) = pair.ahead.interval.unwrap();
    for (a, b) in
        [(lead.difference, pair.ahead.value), (lead.interval.0, low), (lead.interval.1, high)]
    {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn drawings_have_words_for_those_who_do_not_see_them() {
    let dir = tempfile::tempdir().unwrap();
    let layout = few(dir.path());
    written(&layout);
    for name in ["ranks.svg", "profiles.svg"] {
        let svg = file(&layout, name);
        well_formed(&svg);
        let description = svg.split_once("<desc").unwrap().1.split_once("</desc>").unwrap().0;
        assert!(description.contains("fixed-time"), "{description}");
    }
    assert!(file(&layout, "profiles.svg").contains("lower is better; a higher curve is better"));
    assert!(file(&layout, "ranks.svg").contains("1 is the best"));
}

#[test]
fn of_many_methods_neighbours_are_shown_and_the_rest_is_folded() {
    let dir = tempfile::tempdir().unwrap();
    let layout = many(dir.path(), None);
    let (text, section) = written(&layout);
    assert!(text.contains("Neighbours in the ranking"), "{text}");
    assert!(section.contains("<summary>All 66 pairs</summary>"));
    let open = section.split_once("<details>").unwrap().0;
    assert_eq!(open.matches("<th scope=\"row\">").count(), 11);
    assert_eq!(file(&layout, "pairs.csv").lines().count(), 67);
    assert_eq!(file(&layout, "ranks.csv").lines().count(), 145);
    // Every place of every method has a cell, on telephones too.
    assert_eq!(file(&layout, "ranks.svg").matches("<rect").count(), 145);
    assert_eq!(
        reported(&layout).json_rows()[0]["rank_probabilities"].as_array().unwrap().len(),
        12
    );
}

#[test]
fn a_method_that_lacks_points_has_pairs_where_both_have_results_and_no_place() {
    let dir = tempfile::tempdir().unwrap();
    let layout = many(dir.path(), Some("ippo"));
    let (text, _) = written(&layout);
    assert!(
        text.contains("Not ranked, and therefore without places and profiles: ippo."),
        "{text}"
    );
    let data = reported(&layout);
    assert_eq!(data.comparison.ranks.as_ref().unwrap().len(), 11);
    let with_ippo = |p: &&tsc_family::analysis::Pair| data.methods[p.second].method == "ippo";
    let pairs: Vec<_> = data.comparison.pairs.iter().filter(with_ippo).collect();
    assert_eq!(pairs.len(), 11);
    assert!(pairs.iter().all(|p| p.points == 1));
    let row = data.json_rows().into_iter().find(|row| row["method"] == "ippo").unwrap();
    assert!(row["rank_probabilities"].is_null());
}

/// Returns a manifest with one evaluation seed.
fn one_seed(methods: &[&str]) -> Manifest {
    let mut manifest = manifest(methods);
    manifest.identity.evaluation_seeds.truncate(1);
    manifest
}

#[test]
fn one_seed_on_every_point_says_nothing_of_chance() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &one_seed(&["baseline", "fixed-time"]), |task| {
        let mut rows = evaluations(&delays(task));
        rows.truncate(1);
        Some(Ok(TaskResult { rows, ..TaskResult::default() }))
    });
    let (text, _) = written(&layout);
    insta::assert_snapshot!(text);
    let data: Report = reported(&layout);
    let pair = &data.comparison.pairs[0];
    assert_eq!((pair.decided(), pair.ahead.interval), (Decided::Unknown, None));
    assert_eq!(data.comparison.ranks, None);
    assert_eq!(file(&layout, "ranks.csv"), "method,rank,probability,against\n");
    assert!(!layout.report().join("ranks.svg").exists());
}

#[test]
fn with_two_seeds_places_have_no_probabilities_and_the_page_says_why() {
    let dir = tempfile::tempdir().unwrap();
    let mut manifest = manifest(&["baseline", "fixed-time", "max-pressure"]);
    manifest.identity.evaluation_seeds.truncate(2);
    let layout = write_results(dir.path(), &manifest, |task| {
        let rows = evaluations(&delays(task)[..2]);
        Some(Ok(TaskResult { rows, ..TaskResult::default() }))
    });
    assert_eq!(reported(&layout).comparison.ranks, None);
    let (text, _) = written(&layout);
    assert!(text.contains("Probabilities of places need at least 3 evaluation seeds."), "{text}");
}

#[test]
fn a_place_is_as_open_as_the_pair_although_the_method_is_ahead_on_every_seed() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &manifest(&["baseline", "fixed-time"]), |task| {
        let busy = task.point == "busy";
        ended(match task.method.as_str() {
            "fixed-time" => [100.0; 3],
            _ if busy => [101.0, 102.0, 109.0],
            _ => [100.0; 3],
        })
    });
    let comparison = reported(&layout).comparison.clone();
    assert_eq!(comparison.pairs[0].decided(), Decided::Open);
    // By Student's t with two degrees of freedom, 0.87.
    let first = comparison.ranks.unwrap()[0][0];
    assert!((0.8..0.95).contains(&first), "{first}");
}

#[test]
fn a_single_method_has_nothing_to_be_compared_with() {
    let dir = tempfile::tempdir().unwrap();
    let layout = write_results(dir.path(), &manifest(&["baseline"]), |task| ended(delays(task)));
    assert_eq!(written(&layout), (String::new(), String::new()));
    assert_eq!(file(&layout, "pairs.csv").lines().count(), 1);
}

#[test]
fn where_more_is_better_the_larger_value_is_ahead_and_its_profile_is_higher() {
    let dir = tempfile::tempdir().unwrap();
    let mut manifest = spread(manifest(&["baseline", "fixed-time", "max-pressure"]), 8);
    manifest.identity.direction = Direction::Higher;
    manifest.identity.baseline = String::new();
    // Few seeds decide only where the difference is the same on all.
    let steady = |task: &Task| match task.method.as_str() {
        "max-pressure" => delays(task).map(|_| 9.0),
        _ => delays(task),
    };
    let layout = write_results(dir.path(), &manifest, |task| ended(steady(task)));
    let data = reported(&layout);
    let pair = &data.comparison.pairs[0];
    assert_eq!(data.methods[pair.first].method, "baseline");
    assert!(pair.ahead.value > 0.0 && pair.improvement.value == 1.0);
    assert_eq!(pair.decided(), Decided::First);
    let first = &data.comparison.profiles[0];
    assert!(first.steps.is_sorted_by(|a, b| a.1 >= b.1), "{first:?}");
    written(&layout);
    assert!(file(&layout, "profiles.svg").contains("higher is better; a higher curve is better"));
}
