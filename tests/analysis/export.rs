//! One table of all records: what is in it, read back by the crate's reader.

use std::fs;
use std::path::Path;

use crate::dropped::written;
use crate::made_up::{done, evaluations, manifest, reported, write_results};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row as Line};
use tsc_family::export::{Format, export};
use tsc_family::sample::Until;
use tsc_family::store::Layout;
use tsc_family::store::record::{Record, Row, RowKind};
use tsc_family::store::results::Results;

const REASON: &str = "training diverged: \"loss\", 1e300\nin episode 3";

/// A baseline, a learner with two episodes of training, and a method that failed on one point MDP.
fn results(root: &Path) -> Layout {
    let mut manifest = manifest(&["baseline", "learner", "fails", "waits"]);
    manifest.identity.features[0].name = "queue_veh".into();
    manifest.identity.features[1].name = "seed".into();
    manifest.identity.points[1].title = "Main St / 5th, \"corner\"".into();
    write_results(root, &manifest, |task| {
        let delay_s = 10.0 + task.task as f64 / 3.0;
        let mut rows = evaluations(&[delay_s, delay_s * 2.0]);
        let training = |episode: u32| {
            let metrics = [("delay_s", 50.0), ("return", -1.5), ("loss", f64::from(episode))];
            let some = 2 + usize::from(episode > 0);
            let metrics = metrics[..some].iter().map(|(n, v)| ((*n).to_owned(), *v)).collect();
            Row { kind: RowKind::Training, episode, seed: 7 + u64::from(episode), metrics }
        };
        match (task.method.as_str(), task.point.as_str()) {
            ("learner", _) => rows.splice(..0, [training(0), training(1)]).for_each(drop),
            ("fails", "busy") => return Some(Err(REASON)),
            ("waits", "busy") => return None,
            _ => {}
        }
        Some(done(rows))
    })
}

fn lines(path: &Path) -> Vec<Line> {
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    reader.get_row_iter(None).unwrap().map(Result::unwrap).collect()
}

fn cell<'a>(line: &'a Line, name: &str) -> &'a Field {
    line.get_column_iter().find(|(column, _)| *column == name).unwrap().1
}

#[test]
fn every_episode_of_every_record_is_a_row_with_what_the_record_says() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    let path = dir.path().join("records.parquet");
    let exported = export(&layout, &path, Format::Parquet).unwrap();
    let results = Results::load(&layout).unwrap();
    let sha256 = &results.sha256;
    let lines = lines(&path);
    assert_eq!(exported, (lines.len(), 7, 8));
    let mut left = lines.iter();
    for task in results.plan() {
        let Some(record) = Record::read(&layout, task, sha256).unwrap() else { continue };
        let point =
            results.manifest.identity.points.iter().find(|p| p.point == task.point).unwrap();
        for row in &record.rows {
            let line = left.next().unwrap();
            let text = |name: &str| match cell(line, name) {
                Field::Str(text) => text.clone(),
                other => panic!("{name} is {other:?}"),
            };
            let whole = |name: &str| match cell(line, name) {
                Field::ULong(value) => *value,
                other => panic!("{name} is {other:?}"),
            };
            assert_eq!(
                (whole("task"), text("method")),
                (task.task as u64, task.method.to_string())
            );
            assert_eq!(
                (text("point"), text("title")),
                (point.point.clone(), point.name().to_owned())
            );
            assert_eq!((whole("episode"), whole("seed")), (row.episode.into(), row.seed));
            assert_eq!(text("kind") == "training", row.kind == RowKind::Training);
            assert_eq!((text("outcome").as_str(), cell(line, "reason")), ("ok", &Field::Null));
            assert_eq!(cell(line, "importance"), &Field::Double(point.importance));
            assert_eq!(cell(line, "queue_veh"), &Field::Double(point.features[0]));
            assert_eq!(cell(line, "feature_seed"), &Field::Double(point.features[1]));
            for (name, of) in
                [("delay_s", "delay_s"), ("metric_queue_veh", "queue_veh"), ("loss", "loss")]
            {
                let expected = row.metrics.get(of).map_or(Field::Null, |v| Field::Double(*v));
                assert_eq!(cell(line, name), &expected, "{name}");
            }
        }
        if record.rows.is_empty() {
            let line = left.next().unwrap();
            assert_eq!(cell(line, "reason"), &Field::Str(REASON.into()));
            assert_eq!(cell(line, "outcome"), &Field::Str("failed".into()));
            for empty in ["episode", "seed", "kind", "delay_s"] {
                assert_eq!(cell(line, empty), &Field::Null, "{empty}");
            }
        }
    }
    assert!(left.next().is_none());
}

#[test]
fn of_a_run_that_stopped_early_weights_are_those_of_the_report() {
    let dir = tempfile::tempdir().unwrap();
    let layout = written(
        dir.path(),
        Until::FirstPlace(["fixed-time", "ippo"].map(str::to_owned).to_vec()),
        &["baseline"],
    );
    let path = dir.path().join("records.parquet");
    export(&layout, &path, Format::Parquet).unwrap();
    let report = reported(&layout);
    assert_eq!(report.points.len(), 4);
    let lines = lines(&path);
    assert!(lines.iter().any(|line| cell(line, "point") == &Field::Str("p7".into())));
    for line in &lines {
        let Field::Str(point) = cell(line, "point") else { panic!("{line:?}") };
        let weight = report.points.iter().find(|p| p.row.point == *point).map(|p| p.weight);
        assert_eq!(cell(line, "weight"), &weight.map_or(Field::Null, Field::Double), "{point}");
    }
}

#[test]
fn a_damaged_record_leaves_the_file_as_it_was() {
    let dir = tempfile::tempdir().unwrap();
    let layout = results(dir.path());
    let path = dir.path().join("records.parquet");
    fs::write(&path, "before").unwrap();
    let record = fs::read_to_string(layout.record(1)).unwrap();
    fs::write(layout.record(1), record.replace("50.0", "51.0")).unwrap();
    let e = export(&layout, &path, Format::Parquet).unwrap_err().to_string();
    assert!(e.contains("1.jsonl: altered"), "{e}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "before");
    let drafts = fs::read_dir(dir.path()).unwrap().flatten();
    assert!(drafts.into_iter().all(|f| !f.file_name().to_string_lossy().contains("draft")));
}
