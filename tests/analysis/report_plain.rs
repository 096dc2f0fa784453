//! Reports on a task that this program does not know: no baseline, more is better, nothing of traffic.

use std::fs;
use std::path::Path;

use crate::made_up::{
    evaluations, manifest, reported, well_formed, well_linked, words, write_results,
};
use tsc_family::report::{self, text};
use tsc_family::stats::Direction;
use tsc_family::store::Layout;
use tsc_family::store::manifest::Manifest;
use tsc_family::store::record::{Metrics, TaskResult};
use tsc_family::store::results::Results;

/// Distances on `quiet` and `busy` per method, metres; the second seed's are half a metre more.
const DISTANCES: [(&str, [f64; 2]); 3] =
    [("drift", [0.0, 0.25]), ("stroke", [8.0, 2.0]), ("dive", [5.0, 20.0])];

fn swimmers() -> Manifest {
    let mut manifest = manifest(&DISTANCES.map(|(name, _)| name));
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
    manifest
}

fn results(root: &Path) -> Layout {
    let manifest = swimmers();
    write_results(root, &manifest, |task| {
        let (_, distances) = DISTANCES.iter().find(|(name, _)| *name == task.method)?;
        let distance = distances[usize::from(task.point == "busy")];
        let mut rows = evaluations(&[distance, distance + 0.5]);
        for row in &mut rows {
            let distance = ("distance_m".to_owned(), row.metrics["delay_s"]);
            row.metrics = Metrics::from([distance, ("strokes".to_owned(), 30.0)]);
        }
        Some(Ok(TaskResult { rows, ..TaskResult::default() }))
    })
}

#[test]
fn the_largest_value_leads_and_the_smallest_is_the_worst() {
    let dir = tempfile::tempdir().unwrap();
    let data = reported(&results(dir.path()));
    let overall: Vec<_> =
        data.methods.iter().map(|m| (m.method.as_str(), m.overall.unwrap())).collect();
    // Weights are 3 to 1.
    assert_eq!(overall, [("dive", 9.0), ("stroke", 6.75), ("drift", 0.3125)]);
    let worst: Vec<_> = data.methods.iter().map(|m| m.worst.clone().unwrap()).collect();
    let expected = [("quiet", 5.25), ("busy", 2.25), ("quiet", 0.25)];
    assert_eq!(worst, expected.map(|(point, score)| (point.to_owned(), score)));
    insta::assert_snapshot!(text::table(&data));
}

#[test]
fn the_page_knows_neither_baseline_nor_traffic() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    let paths = report::write(&layout, &reported(&layout)).unwrap();
    let page = fs::read_to_string(&paths.html).unwrap();
    well_formed(&page[page.find("<body>").unwrap()..page.find("</html>").unwrap()]);
    well_linked(&page);
    for strange in ["delay", "vehicle", "intersection", "signal", "traffic", "SUMO", "NaN"] {
        assert!(!page.contains(strange), "{strange}");
    }
    insta::assert_snapshot!(words(&page));
    let names: Vec<_> =
        paths.figures.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["overall.svg", "profiles.svg", "distribution.svg"]);
    for figure in &paths.figures {
        let drawing = fs::read_to_string(figure).unwrap();
        well_formed(&drawing);
        assert!(drawing.contains("higher is better"), "{drawing}");
    }
    insta::assert_snapshot!(fs::read_to_string(layout.report().join("summary.csv")).unwrap());
}

#[test]
fn an_edited_manifest_is_refused() {
    let said = |edit: &dyn Fn(&mut Manifest)| {
        let dir = tempfile::tempdir().unwrap();
        let mut manifest = swimmers();
        edit(&mut manifest);
        let e = Results::load(&write_results(dir.path(), &manifest, |_| None)).unwrap_err();
        e.to_string()
    };
    let e = said(&|m| m.identity.points[0].features.clear());
    assert!(e.contains("manifest.json") && e.contains("quiet has 0 features of 2"), "{e}");
    let e = said(&|m| m.identity.methods[1] = "../../esc".into());
    assert!(e.contains("a method cannot be called \"../../esc\""), "{e}");
}
