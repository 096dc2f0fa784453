//! `tsc-family run cartpole`: from the plan to the records, without SUMO.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::outcomes::record;

const SHORT: [&str; 4] = ["--set", "ppo.total_steps=4096", "--set", "dqn.total_steps=4000"];

fn command(args: &[&str], dir: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tsc-family")).args(args).current_dir(dir).output().unwrap()
}

fn run(args: &[&str], dir: &Path) -> Output {
    let output = command(&[&["run", "cartpole"], args, &SHORT].concat(), dir);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

#[test]
fn a_run_has_records_and_models_and_is_the_same_with_two_workers() {
    let dir = tempfile::tempdir().unwrap();
    let (one, two) = (dir.path().join("one"), dir.path().join("two"));
    run(&["--budget", "2", "--out", "one", "--jobs", "1", "-q"], dir.path());
    run(
        &["--budget", "2", "--out", "two", "--jobs", "2", "-q", "--methods", "ppo,dqn"],
        dir.path(),
    );
    for task in 0..4 {
        let rows = record(&one, task);
        assert_eq!(rows, record(&two, task));
        assert_eq!((&rows[0]["outcome"], &rows[0]["reason"]), (&"ok".into(), &Value::Null));
        let score = rows[0]["metrics"]["normalised_return"].as_f64().unwrap();
        assert!(score > 0.0 && score <= 1.0, "{score}");
        let kinds = |kind: &str| rows.iter().filter(|r| r["kind"] == kind).count();
        // An update of ppo is 2,048 steps; a row of dqn is a fiftieth of its steps.
        let rows_of = if rows[0]["method"] == "dqn" { 50 } else { 2 };
        assert_eq!((kinds("training"), kinds("evaluation")), (rows_of, 5));
        let model = format!("models/000/{task}.safetensors");
        assert_eq!(fs::read(one.join(&model)).unwrap(), fs::read(two.join(&model)).unwrap());
    }
    let manifest: Value =
        serde_json::from_str(&fs::read_to_string(one.join("manifest.json")).unwrap()).unwrap();
    let of = |name: &str| manifest["identity"].get(name).unwrap_or(&manifest[name]).clone();
    assert_eq!((of("domain"), of("objective")), ("cartpole".into(), "normalised_return".into()));
    assert_eq!(of("methods"), serde_json::json!(["ppo", "dqn"]));
}

#[test]
fn a_table_of_own_points_is_evaluated() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("p.csv"), "point,instances,masspole_kg\na,3,0.2\n").unwrap();
    let scenario = "domain = \"cartpole\"\nname = \"own\"\nfamily.points = \"p.csv\"\n\
                    ppo.total_steps = 2048";
    fs::write(dir.path().join("own.toml"), scenario).unwrap();
    let output = command(&["run", "own.toml", "--methods", "ppo", "-q"], dir.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(record(&dir.path().join("results/own"), 0)[0]["point"], "a");
}

#[test]
fn the_family_is_listed() {
    let dir = tempfile::tempdir().unwrap();
    let said = |args: &[&str]| {
        String::from_utf8(command(&[&["list", "cartpole"], args].concat(), dir.path()).stdout)
            .unwrap()
    };
    assert!(said(&[]).ends_with("576 point MDPs in scenario cartpole\n"));
    assert!(said(&["--features"]).contains("gravity_mps2      m/s²"));
    let first: Value = serde_json::from_str(said(&["--json"]).lines().next().unwrap()).unwrap();
    assert_eq!(
        (&first["point"], &first["force_n"]),
        (&"l0.05-c0.1-p0.01-f1-g0.1".into(), &1.0.into())
    );
}
