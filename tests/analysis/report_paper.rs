//! What a report has for papers: tables in LaTeX, learning curves as numbers, what to cite.

use std::fs;
use std::path::Path;

use crate::made_up::{SEEDS, evaluations, manifest, reported, write_results};
use tsc_family::report::{self, CITATIONS};
use tsc_family::store::Layout;
use tsc_family::store::record::{Metrics, Row, RowKind, TaskResult};

/// Delays of a training, relative to those of the baseline.
const COURSE: [f64; 3] = [2.0, 1.5, 1.0];

/// A baseline, a tuned method and a learner that ends as good as the baseline was.
fn written(root: &Path) -> Layout {
    let mut manifest = manifest(&["baseline", "fixed-time", "idqn"]);
    manifest.identity.evaluation_seeds = SEEDS.to_vec();
    let layout = write_results(root, &manifest, |task| {
        let unit = if task.point == "busy" { 50.0 } else { 20.0 };
        let score = if task.method == "baseline" { 1.0 } else { 0.5 };
        let training = |(episode, relative): (usize, &f64)| Row {
            kind: RowKind::Training,
            episode: episode as u32,
            seed: episode as u64,
            metrics: Metrics::from([
                ("delay_s".to_owned(), relative * unit),
                ("return".to_owned(), -3.0),
            ]),
        };
        let learns = task.method == "idqn";
        let mut rows: Vec<Row> =
            COURSE.iter().enumerate().filter(|_| learns).map(training).collect();
        rows.extend(evaluations(&[score * unit; SEEDS.len()]));
        Some(Ok(TaskResult { rows, ..TaskResult::default() }))
    });
    report::write(&layout, &reported(&layout)).unwrap();
    layout
}

fn text(layout: &Layout, file: &str) -> String {
    fs::read_to_string(layout.report().join(file)).unwrap()
}

#[test]
fn tables_are_there_in_latex() {
    let dir = tempfile::tempdir().unwrap();
    let layout = written(dir.path());
    let tables = ["ranking.tex", "summaries.tex", "pairs.tex", "training.tex"];
    insta::assert_snapshot!(tables.map(|name| text(&layout, name)).join("\n"));
}

#[test]
fn learning_curves_are_there_as_numbers() {
    let dir = tempfile::tempdir().unwrap();
    let csv = text(&written(dir.path()), "learning.csv");
    // Trailing means of 2, 1.5 and 1; returns are all the same, and no loss was recorded.
    assert_eq!(
        csv,
        "method,row,trainings,score,score_low,score_high,return,return_low,return_high,loss,loss_low,loss_high\n\
         idqn,1,2,2,2,2,-3,-3,-3,,,\n\
         idqn,2,2,1.75,1.75,1.75,-3,-3,-3,,,\n\
         idqn,3,2,1.5,1.5,1.5,-3,-3,-3,,,\n"
    );
}

#[test]
fn the_page_says_what_to_cite() {
    let dir = tempfile::tempdir().unwrap();
    let page = text(&written(dir.path()), "index.html");
    assert!(page.contains("<h2 id=\"cite-h\">How to cite</h2>"));
    assert!(page.contains(&format!("version = {{{}}}", env!("CARGO_PKG_VERSION"))));
    let cff =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CITATION.cff")).unwrap();
    let version = format!("version: {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(cff.matches(&version).count(), 2, "of the software and of what to cite");
    let year = cff.lines().find_map(|line| line.strip_prefix("  year: ")).unwrap();
    assert!(CITATIONS.contains(&format!("year = {{{year}}},\n  version")), "{CITATIONS}");
    assert!(
        cff.contains("The Impact of Task Underspecification")
            && CITATIONS.contains("The Impact of Task Underspecification")
    );
}

#[test]
fn a_page_is_for_everybody_for_researchers_or_for_practice() {
    let dir = tempfile::tempdir().unwrap();
    let page = text(&written(dir.path()), "index.html");
    assert!(page.contains("id=\"reader-all\" checked=\"checked\""));
    // What is hidden for a reader follows the switch, in an element beside it.
    let switch = page.find("id=\"reader-practice\"").unwrap();
    assert!(
        page.find("class=\"practice\"").unwrap() > switch
            && page.find("class=\"researcher\"").unwrap() > switch
    );
    assert!(page.contains("#reader-practice:checked ~ * .researcher { display: none; }"));
    assert!(page.contains("#reader-researcher:checked ~ * .practice,"));
}
