//! Small made-up results directories, and what to check in the reports on them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tempfile::TempDir;
use tsc_family::analysis::MethodSummary;
use tsc_family::domains;
use tsc_family::family::Feature;
use tsc_family::report::{self, Report, ReportPaths, findings};
use tsc_family::sample::{Draw, SamplePlan, Sampling};
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Identity, Manifest, PointRow, Provenance, Task};
use tsc_family::store::record::{Metrics, Record, Row, RowKind, TaskResult};
use tsc_family::store::results::Results;
use tsc_family::store::wall::Wall;

/// Evaluation seeds; a manifest has the first two, unless a test gives it all.
pub(crate) const SEEDS: [u64; 3] = [1_073_741_825, 1_073_741_826, 1_073_741_827];

pub(crate) type Ending = Result<TaskResult, &'static str>;

fn point(id: &str, importance: f64, inflow_vph: f64) -> PointRow {
    PointRow {
        point: id.to_owned(),
        title: String::new(),
        importance,
        instances: 3,
        features: vec![2.0, inflow_vph],
        places: vec![[40.76, -111.89]],
        content: String::new(),
        environment: format!("networks/{id}"),
        sha256: BTreeMap::from([("net.xml.gz".to_owned(), "ab".repeat(32))]),
        given: BTreeMap::new(),
    }
}

/// The manifest of two point MDPs, `quiet` and `busy`; the first method is the baseline.
pub(crate) fn manifest(methods: &[&str]) -> Manifest {
    let draw =
        |point: &str, weight| Draw { point: point.to_owned(), weight, count: 1, inclusion: None };
    let feature = |name: &str, unit: &str| Feature { name: name.into(), unit: unit.into() };
    Manifest {
        identity: Identity {
            domain: "traffic".into(),
            direction: tsc_family::stats::Direction::Lower,
            schema_version: 1,
            tsc_family: "0.1.0".into(),
            simulator: "SUMO 1.15.0".into(),
            scenario: "smoke".into(),
            settings: serde_json::json!({
                "preset": "field",
                "signal": {"actions": "own-greens"},
                "demand": {"horizon_s": 3600.0}
            }),
            features: vec![feature("lanes", ""), feature("inflow_vph", "veh/h")],
            sample: SamplePlan {
                sampling: Sampling::All,
                budget: 2,
                family_size: 2,
                seed: 0,
                draws: vec![draw("quiet", 0.75), draw("busy", 0.25)],
                design: String::new(),
                growth: None,
            },
            points: vec![point("quiet", 0.75, 250.0), point("busy", 0.25, 900.0)],
            methods: methods.iter().map(|m| (*m).to_owned()).collect(),
            controllers: vec![],
            baseline: methods[0].to_owned(),
            objective: "delay_s".into(),
            replicates: 1,
            replicated: vec![],
            base_seed: 0,
            evaluation_seeds: SEEDS[..2].to_vec(),
        },
        provenance: Provenance {
            command: "tsc-family run smoke".into(),
            git: "abc1234".into(),
            rustc: "rustc 1.95.0".into(),
            host: "Linux x86_64".into(),
            started: "2026-01-01T00:00:00Z".into(),
            networks: "networks/smoke".into(),
            warnings: vec![],
            memory_per_worker_mb: None,
            assisting: None,
        },
    }
}

/// A point MDP and its draw, of which others are made.
pub(crate) fn pattern(manifest: &Manifest) -> (PointRow, Draw) {
    (manifest.identity.points[0].clone(), manifest.identity.sample.draws[0].clone())
}

/// Gives a run so many point MDPs of equal weight, with these names and features.
pub(crate) fn equal_points(
    manifest: &mut Manifest,
    n: usize,
    of: impl Fn(usize) -> (String, Vec<f64>),
) {
    let (point, draw) = pattern(manifest);
    let (importance, identity) = (1.0 / n as f64, &mut manifest.identity);
    let row = |(name, features)| PointRow { point: name, features, importance, ..point.clone() };
    identity.points = (0..n).map(of).map(row).collect();
    let drawn = |p: &PointRow| Draw { point: p.point.clone(), weight: importance, ..draw.clone() };
    identity.sample.draws = identity.points.iter().map(drawn).collect();
    (identity.sample.budget, identity.sample.family_size) = (n, n);
}

pub(crate) fn write_results(
    root: &Path,
    manifest: &Manifest,
    ending: impl Fn(&Task) -> Option<Ending>,
) -> Layout {
    let layout = Layout::new(root);
    fs::write(layout.manifest(), serde_json::to_string(&manifest).unwrap()).unwrap();
    let sha256 = manifest.sha256();
    for task in manifest.identity.tasks() {
        match ending(&task) {
            None => {}
            Some(Ok(result)) => {
                Record::finished(&task, &sha256, result).commit(&layout).unwrap();
            }
            Some(Err(reason)) => {
                let reason = reason.to_owned();
                Record::failed(&task, &sha256, reason, Wall::default()).commit(&layout).unwrap();
            }
        }
    }
    layout
}

pub(crate) fn done(rows: Vec<Row>) -> Ending {
    Ok(TaskResult { rows, ..TaskResult::default() })
}

pub(crate) fn ended(delays_s: &[f64]) -> Option<Ending> {
    Some(done(evaluations(delays_s)))
}

/// The same with another value of a metric, or without it.
pub(crate) fn measured(delays_s: &[f64], metric: &str, value: Option<f64>) -> Ending {
    let mut rows = evaluations(delays_s);
    for row in &mut rows {
        let others = row.metrics.iter().filter(|(name, _)| *name != metric);
        row.metrics = others.map(|(name, value)| (name.clone(), *value)).collect();
        row.metrics.extend(value.map(|value| (metric.to_owned(), value)));
    }
    done(rows)
}

/// A report as it was written, whose page and drawings are well-formed.
pub(crate) struct Written {
    _folder: Option<TempDir>,
    pub(crate) layout: Layout,
    pub(crate) data: Report,
    pub(crate) paths: ReportPaths,
    pub(crate) html: String,
}

pub(crate) fn written(manifest: &Manifest, ending: impl Fn(&Task) -> Option<Ending>) -> Written {
    Written::new(manifest, &[], ending)
}

impl Written {
    pub(crate) fn new(
        manifest: &Manifest,
        files: &[(&str, String)],
        ending: impl Fn(&Task) -> Option<Ending>,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let layout = write_results(folder.path(), manifest, ending);
        files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
        let data = reported(&layout);
        Self { _folder: Some(folder), ..Self::of(layout, data) }
    }

    fn of(layout: Layout, data: Report) -> Self {
        let paths = report::write(&layout, &data).unwrap();
        let html = fs::read_to_string(&paths.html).unwrap();
        // The two elements that HTML leaves open.
        let page = html.replace("utf-8\">", "utf-8\"/>").replace("scale=1\">", "scale=1\"/>");
        well_formed(&page.replace("<!DOCTYPE html>", ""));
        well_linked(&html);
        assert!(!html.contains("NaN"), "a number is none");
        paths.figures.iter().for_each(|path| well_formed(&fs::read_to_string(path).unwrap()));
        Self { _folder: None, layout, data, paths, html }
    }

    /// Writes another report on the same records, which lasts as long as this one.
    pub(crate) fn rewritten(&self, data: Report) -> Self {
        Self::of(Layout::new(self.layout.root()), data)
    }

    pub(crate) fn write_again(&self) {
        report::write(&self.layout, &reported(&self.layout)).unwrap();
    }

    pub(crate) fn file(&self, name: &str) -> String {
        let path = self.paths.html.with_file_name(name);
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn rows(&self, name: &str) -> Vec<BTreeMap<String, String>> {
        let text = self.file(name);
        csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
    }

    pub(crate) fn words(&self) -> String {
        words(&self.html)
    }

    /// The words before the ranking.
    pub(crate) fn first(&self) -> String {
        self.words().split_once("\nRanking\n").unwrap().0.to_owned()
    }

    /// The words from one heading to another; the links above the page have the same words.
    pub(crate) fn section(&self, from: &str, until: &str) -> String {
        let words = self.words();
        let (_, rest) = words.rsplit_once(&format!("\n{from}\n")).unwrap();
        rest.split_once(&format!("\n{until}\n")).unwrap().0.to_owned()
    }

    pub(crate) fn notes(&self) -> String {
        findings::notes(&self.data).join("\n")
    }

    pub(crate) fn title(&self) -> String {
        self.html.split_once("<h1>").unwrap().1.split_once("</h1>").unwrap().0.to_owned()
    }

    pub(crate) fn method(&self, name: &str) -> &MethodSummary {
        self.data.methods.iter().find(|m| m.method == name).unwrap()
    }
}

pub(crate) fn reported(layout: &Layout) -> Report {
    domains::report(layout, &Results::load(layout).unwrap()).unwrap()
}

pub(crate) fn evaluations(delays_s: &[f64]) -> Vec<Row> {
    delays_s.iter().enumerate().map(row).collect()
}

fn row((k, delay_s): (usize, &f64)) -> Row {
    let metrics: Metrics = [
        ("delay_s", *delay_s),
        ("waiting_s", delay_s / 2.0),
        ("queue_veh", 4.0),
        ("throughput_veh", 900.0),
        ("unfinished_veh", 20.0),
        ("undeparted_veh", 5.0),
        ("vehicles_veh", 1000.0),
        ("teleports", 0.0),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect();
    Row { kind: RowKind::Evaluation, episode: k as u32, seed: SEEDS[k], metrics }
}

pub(crate) fn well_formed(xml: &str) {
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
pub(crate) fn words(page: &str) -> String {
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

/// Checks that a page loads nothing from elsewhere, that its ids are unique and its links lead to them.
pub(crate) fn well_linked(page: &str) {
    for forbidden in ["src=", "<link", "<script ", "@import", "url(", "fetch(", "import("] {
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
