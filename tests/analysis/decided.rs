//! How often `--until-decided` is wrong: samples of the published family, each with another luck of training.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use crate::made_up::write_results;
use crate::nightly::is_nightly;
use tsc_family::domains;
use tsc_family::sample::looks::{halves, looks};
use tsc_family::sample::{Design, Growth, Sampling, Until, choose_over};
use tsc_family::store::Layout;
use tsc_family::store::record::{Metrics, Row, RowKind, TaskResult};
use tsc_family::store::results::Results;
use tsc_family::study::Recorded;

const WITHIN: f64 = 0.03;

/// The evaluation of every method on every point MDP.
type Known = BTreeMap<(String, String), Vec<Row>>;

fn published(run: &str) -> (Layout, Results, Known) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/salt-lake-city").join(run);
    let layout = Layout::new(&root);
    let results = Results::load(&layout).unwrap();
    let rows = results.done().map(|(task, record)| {
        ((task.method.clone(), task.point.clone()), record.evaluations().cloned().collect())
    });
    let rows = rows.collect();
    (layout, results, rows)
}

fn mean(rows: &[Row]) -> f64 {
    rows.iter().map(|row| row.metrics["delay_s"]).sum::<f64>() / rows.len() as f64
}

#[test]
fn a_run_that_stops_is_seldom_wrong() {
    let (runs, budget) = if is_nightly() { (500, 80) } else { (1, 20) };
    let (layout, learned, mut known) = published("learners-validated");
    let learners = learned.manifest.identity.methods[1..].to_vec();
    let analysis = domains::analysis(&layout, &learned).unwrap();
    let family = Recorded::of(&analysis, "learners-validated").unwrap().family;
    let design = Design::of(&family).for_sampling(Sampling::Balanced);
    // By what factor a second training of a learner on a point MDP differed from the first, and the other way round.
    let again = published("ten-methods-resco").2;
    let second = known.iter().filter(|(key, _)| learners.contains(&key.0));
    let factors = second.filter_map(|(key, rows)| Some(mean(again.get(key)?) / mean(rows)));
    let mut luck: Vec<f64> = factors.filter(|f| *f != 1.0).flat_map(|f| [f, 1.0 / f]).collect();
    luck.sort_by(f64::total_cmp);
    let mut manifest = (*learned.manifest).clone();
    for run in ["nema-resco", "resco"] {
        let (_, cheap, rows) = published(run);
        manifest.identity.methods.extend(cheap.manifest.identity.methods[1..].to_vec());
        known.extend(rows);
    }
    let methods = manifest.identity.methods[1..].to_vec();
    let score = |method: &String| -> f64 {
        let of = |m: &str, point: &str| mean(&known[&(m.to_owned(), point.to_owned())]);
        let score = |point: &str| of(method, point) / of("baseline", point);
        let luck = luck.iter().sum::<f64>() / luck.len() as f64;
        let factor = if learners.contains(method) { luck } else { 1.0 };
        family.points.iter().map(|p| p.importance * factor * score(&p.id)).sum()
    };
    let truth: BTreeMap<String, f64> = methods.iter().map(|m| (m.clone(), score(m))).collect();
    let best = truth.values().copied().fold(f64::INFINITY, f64::min);
    let answer = |seed: u64| {
        let mut manifest = manifest.clone();
        let mut plan = choose_over(&family, &design, Sampling::Balanced, budget, seed).unwrap();
        let looks = looks(&plan, &design, &halves(budget)).unwrap();
        plan.growth = Some(Growth { until: Until::Within(WITHIN, methods.clone()), looks });
        plan.design = design.sha256();
        manifest.identity.points.retain(|p| plan.draws.iter().any(|d| d.point == p.point));
        manifest.identity.sample = plan;
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("design.json"), design.to_json()).unwrap();
        let layout = write_results(dir.path(), &manifest, |task| {
            let mut rows = known[&(task.method.clone(), task.point.clone())].clone();
            if learners.contains(&task.method) {
                let drawn = basics::seed::derive(seed, &["luck", &task.method, &task.point]);
                let factor = luck[drawn as usize % luck.len()];
                rows.iter_mut().for_each(|r| *r.metrics.get_mut("delay_s").unwrap() *= factor);
                let metrics = Metrics::from([("return".to_owned(), -1.0)]);
                rows.insert(0, Row { kind: RowKind::Training, episode: 0, seed: 7, metrics });
            }
            Some(Ok(TaskResult { rows, ..TaskResult::default() }))
        });
        let mut all = Results::load_all(&layout).unwrap();
        for look in 0.. {
            let analysis = domains::analysis(&layout, &all.at_look(look).unwrap()).unwrap();
            let standing = analysis.standing().unwrap();
            if !standing.goes_on() {
                return (look, standing.answer.map(|answer| truth[&answer.0] - best));
            }
            all.dropped.extend(standing.behind);
        }
        unreachable!("the last look goes on with none")
    };
    let ended: Vec<(usize, Option<f64>)> = (0..runs).into_par_iter().map(answer).collect();
    let answers = || ended.iter().filter_map(|(look, loss)| Some((*look, (*loss)?)));
    let wrong = answers().filter(|(_, loss)| *loss > WITHIN).count();
    let at = [0, 1, 2].map(|look| answers().filter(|answer| answer.0 == look).count());
    eprintln!("{runs} runs: answers at looks {at:?}, {wrong} wrong; {truth:?}");
    assert!(20 * wrong <= runs as usize, "{wrong} of {runs}");
}
