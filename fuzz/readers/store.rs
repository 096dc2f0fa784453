//! Readers of results directories.

use std::path::Path;

use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::record::{Record, Row, TaskResult};
use tsc_family::store::wall::Wall;
use tsc_family::traffic::places::Places;

/// Most tasks that are listed here.
const FEW_TASKS: usize = 10_000;

/// A record, and rows under a summary that fits them, as its checksum would keep the fuzzer out.
pub(crate) fn record(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(record) = Record::parse(text) {
        assert_eq!(Record::parse(&record.to_text()).expect("it was written"), record);
    }
    let rows: Vec<Row> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let finite = |row: &Row| row.metrics.iter().all(|(_, value)| value.abs() < 1e100);
    if !rows.is_empty() && rows.iter().all(finite) {
        let task = Task { task: 0, method: "m".into(), point: "p".into(), replicate: 0, seed: 1 };
        let result = TaskResult { rows, wall: Wall::default(), ..TaskResult::default() };
        let record = Record::finished(&task, "sha256", result);
        assert_eq!(Record::parse(&record.to_text()).expect("it was sealed"), record);
    }
}

/// A manifest, and the tasks that follow from it.
pub(crate) fn manifest(bytes: &[u8]) {
    let path = Path::new("manifest.json");
    let Ok(manifest) = Manifest::parse(bytes, path) else { return };
    let json = serde_json::to_vec(&manifest).expect("a manifest is plain data");
    let read = Manifest::parse(&json, path).expect("it was written");
    assert_eq!((read.sha256(), &read), (manifest.sha256(), &manifest));
    let identity = &manifest.identity;
    let most = identity.points.len() * identity.methods.len() * identity.replicates as usize;
    if most <= FEW_TASKS {
        let tasks = identity.tasks();
        for task in &tasks {
            assert!(!task.point.contains('/') && !task.method.contains('/'), "{task:?}");
        }
    }
}

/// Where the intersections are.
pub(crate) fn places(bytes: &[u8]) {
    let path = Path::new("places.json");
    if let Ok(places) = Places::parse(bytes, path) {
        let read = Places::parse(places.to_json().as_bytes(), path).expect("it was written");
        assert_eq!(read, places);
    }
}
