//! What was published stays readable, whatever becomes of the formats: every run below `results/`, and a model of the
//! first version.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{run, stderr, stdout, succeed};
use crate::nightly::is_nightly;

/// The folders with packed records.
fn published() -> Vec<PathBuf> {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let folders = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect()
    };
    let mut runs: Vec<PathBuf> = folders(&results).iter().flat_map(|f| folders(f)).collect();
    runs.retain(|run| run.join("records.tar.xz").exists());
    runs.sort();
    runs
}

/// Unpacks a published run as its README says.
fn unpacked(run: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(run).unwrap().map(Result::unwrap) {
        let is_packed = !["plan.jsonl", "lock.json"].iter().any(|name| entry.file_name() == *name);
        if entry.path().is_file() && is_packed {
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
    let unpack = "tar -xJf records.tar.xz && gunzip -k plan.jsonl.gz";
    assert!(Command::new("sh").args(["-c", unpack]).current_dir(to).status().unwrap().success());
}

/// Checks that the published report of a run is the one that the program writes; files that only one of them has are left out.
fn published_report_is_the_programs(run_at: &Path, to: &Path) {
    let mut compared = 0;
    for entry in fs::read_dir(run_at.join("report")).unwrap().map(Result::unwrap) {
        let name = entry.file_name();
        let is_page = ["csv", "html", "svg", "tex"]
            .iter()
            .any(|e| entry.path().extension().is_some_and(|x| x == *e));
        let Some(now) = fs::read(to.join("report").join(&name)).ok().filter(|_| is_page) else {
            continue;
        };
        let same = fs::read(entry.path()).unwrap() == now;
        assert!(same, "{} is of another build; make the report again", entry.path().display());
        compared += 1;
    }
    assert!(compared >= 5, "{}", run_at.display());
}

/// Checks that the records of a run give the same page where they are still packed, and that nothing is added to them.
fn packed_reads_the_same(folder: &Path, run_at: &Path, html: &[u8]) {
    let to = folder.join("packed");
    fs::create_dir(&to).unwrap();
    for name in ["manifest.json", "records.tar.xz", "design.json", "places.json"] {
        if run_at.join(name).exists() {
            fs::copy(run_at.join(name), to.join(name)).unwrap();
        }
    }
    succeed(folder, "report packed");
    assert!(fs::read(to.join("report/index.html")).unwrap() == html, "{}", run_at.display());
    let whole = stdout(&run(folder, "check packed --json"));
    assert!(whole.contains("\"damaged\":0"), "{whole}");
    let status = stdout(&run(folder, "status packed"));
    assert!(!status.contains(" 0 of "), "{status}");
    let resumed = run(folder, "resume packed");
    let said = stderr(&resumed);
    assert!(!resumed.status.success(), "{said}");
    assert!(said.contains("its records are packed") || said.contains("use that version"), "{said}");
    fs::remove_dir_all(&to).unwrap();
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
        unpacked(path, &to);
        let output = run(folder.path(), &format!("check {number} --json"));
        let said = stdout(&output);
        let whole: serde_json::Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
        assert_eq!(whole["damaged"], 0, "{}: {said}", path.display());
        // Some are still being computed.
        let expected = if whole["missing"] == 0 { 0 } else { 6 };
        assert_eq!(output.status.code(), Some(expected), "{}: {said}", path.display());
        succeed(folder.path(), &format!("report {number}"));
        published_report_is_the_programs(path, &to);
        let html = fs::read(to.join("report/index.html")).unwrap();
        packed_reads_the_same(folder.path(), path, &html);
        if whole["missing"] == 0 && whole["failed"] == 0 {
            let estimate =
                format!("estimate {number} --budgets 10 --repeats 2 --out {number}/estimate");
            let output = run(folder.path(), &estimate);
            // What a sample misses cannot be known from the sample.
            let manifest = fs::read_to_string(to.join("manifest.json")).unwrap();
            let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
            let is_sample = manifest["identity"]["sample"]["sampling"] != "all";
            assert_eq!(output.status.code(), Some(if is_sample { 2 } else { 0 }), "{output:?}");
            assert!(!is_sample || stderr(&output).contains("--budget all"), "{output:?}");
        }
        fs::remove_dir_all(&to).unwrap();
    }
}
