//! What was published stays readable, whatever becomes of the formats: every run below `results/`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{run, stderr, stdout, succeed};
use crate::nightly::is_nightly;

/// What a browser opens at once.
const MOST_BYTES: usize = 2_000_000;

fn published() -> Vec<PathBuf> {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let folders = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect()
    };
    let mut runs: Vec<PathBuf> = folders(&results).iter().flat_map(|f| folders(f)).collect();
    runs.retain(|run| run.join("run.jsonl.xz").exists());
    runs.sort();
    runs
}

#[test]
fn every_published_run_is_sound_and_reported() {
    let runs = published();
    assert!(runs.len() >= 9, "{runs:?}");
    // A family, a sample of learners and a control task; the others do not change from one commit to the next.
    let short = [
        "salt-lake-city/nema-resco",
        "salt-lake-city/learners-validated-field-20",
        "cartpole/carl",
    ];
    let runs: Vec<_> =
        runs.iter().filter(|r| is_nightly() || short.iter().any(|s| r.ends_with(s))).collect();
    assert!(runs.len() >= short.len(), "{runs:?}");
    let folder = tempfile::tempdir().unwrap();
    for (number, path) in runs.iter().enumerate() {
        let to = folder.path().join(number.to_string());
        fs::create_dir(&to).unwrap();
        fs::copy(path.join("run.jsonl.xz"), to.join("run.jsonl.xz")).unwrap();
        let output = run(folder.path(), &format!("check {number} --json"));
        let said = stdout(&output);
        let whole: serde_json::Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
        assert_eq!(whole["damaged"], 0, "{}: {said}", path.display());
        let expected = if whole["missing"] == 0 { 0 } else { 6 };
        assert_eq!(output.status.code(), Some(expected), "{}: {said}", path.display());
        succeed(folder.path(), &format!("report {number}"));
        succeed(folder.path(), &format!("export {number} --out again.xz"));
        let packed = |path: &Path| fs::read(path).unwrap();
        let (again, before) = (folder.path().join("again.xz"), to.join("run.jsonl.xz"));
        assert!(packed(&again) == packed(&before), "{} is packed otherwise", path.display());
        let page = fs::read_to_string(to.join("report/index.html")).unwrap();
        assert!(page.len() < MOST_BYTES, "{}: {} bytes", path.display(), page.len());
        let numbers = |before: &str| -> BTreeSet<String> {
            let rest = page.split(before).skip(1);
            rest.filter_map(|r| r.split('"').next()).map(str::to_owned).collect()
        };
        let (rows, dots) = (numbers("<tr id=\"row-"), numbers("<g class=\"tt\" id=\"dot-"));
        let has_map = path.iter().any(|part| part == "salt-lake-city");
        let linked = if has_map { rows } else { BTreeSet::new() };
        assert_eq!([&dots, &numbers("href=\"#dot-"), &numbers("data-row=\"row-")], [&linked; 3]);
        if whole["missing"] == 0 && whole["failed"] == 0 {
            let estimate =
                format!("estimate {number} --budgets 10 --repeats 2 --out {number}/estimate");
            let output = run(folder.path(), &estimate);
            // What a sample misses cannot be known from the sample.
            let said = stderr(&output);
            let is_sample = output.status.code() == Some(2) && said.contains("--budget all");
            assert!(is_sample || output.status.success(), "{output:?}");
        }
    }
}
