//! A large family: how big its page is, and that every row has its dot.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::made_up::{equal_points, evaluations, manifest, reported, well_linked};
use tsc_family::report;
use tsc_family::store::Layout;
use tsc_family::store::manifest::Manifest;
use tsc_family::store::record::{Record, TaskResult};

/// Point MDPs of the family; each stands for three intersections.
const POINTS: usize = 300;

const LIMIT: usize = 2_000_000;

const METHODS: [&str; 6] = ["baseline", "fixed-time", "actuated", "max-pressure", "a", "b"];

fn large() -> Manifest {
    let mut manifest = manifest(&METHODS);
    equal_points(&mut manifest, POINTS, |i| {
        (format!("L4-S30-D300-Q{i}-l0-r0"), vec![(i % 6) as f64, (i % 40) as f64 * 25.0])
    });
    for (i, row) in manifest.identity.points.iter_mut().enumerate() {
        let at = |k: usize| {
            let spread = (i * 3 + k) as f64;
            [40.7 + 0.1 * (spread * 0.618).fract(), -111.9 + 0.1 * (spread * 0.377).fract()]
        };
        row.places = (0..3).map(at).collect();
    }
    manifest
}

fn results(root: &Path, manifest: &Manifest) -> Layout {
    let points = manifest.identity.points.iter().enumerate();
    let position: BTreeMap<&str, usize> = points.map(|(i, p)| (p.point.as_str(), i)).collect();
    let sha256 = manifest.sha256();
    let layout = crate::made_up::write_results(root, manifest, |_| None);
    for task in manifest.identity.tasks() {
        let method = METHODS.iter().position(|m| *m == task.method).unwrap();
        let point = position[task.point.as_str()];
        let delay = 10.0 + ((point * 7 + method * 13) % 90) as f64;
        let result =
            TaskResult { rows: evaluations(&[delay, delay * 1.1]), ..TaskResult::default() };
        let record = Record::finished(&task, &sha256, result);
        // Not committed: that would wait for the disk 1,800 times.
        let mut text = serde_json::to_string(&record.summary).unwrap() + "\n";
        for row in &record.rows {
            text += &(serde_json::to_string(row).unwrap() + "\n");
        }
        let path = layout.record(task.task);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    layout
}

#[test]
fn many_point_mdps_fit_a_page_with_a_row_for_every_dot() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path(), &large());
    report::write(&layout, &reported(&layout)).unwrap();
    let page = fs::read_to_string(layout.report().join("index.html")).unwrap();
    assert!(page.len() < LIMIT, "{} bytes", page.len());
    well_linked(&page);
    let numbers = |before: &str| -> BTreeSet<String> {
        let rest = page.split(before).skip(1);
        rest.filter_map(|r| r.split('"').next()).map(str::to_owned).collect()
    };
    let (rows, dots) = (numbers("<tr id=\"row-"), numbers("<g class=\"tt\" id=\"dot-"));
    assert_eq!((rows.len(), &rows), (3 * POINTS, &dots));
    assert_eq!(numbers("href=\"#dot-"), dots);
    assert_eq!(numbers("data-row=\"row-"), rows);
}
