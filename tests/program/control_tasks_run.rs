//! `tsc-family run` on control tasks, from the family to the page, without SUMO.

use std::fs;

use serde_json::Value;
use tsc_family::control_tasks::mujoco;

use crate::common::{program, stderr};
use crate::folder::Folder;

#[test]
fn a_run_has_records_and_models_and_is_the_same_with_two_workers() {
    let folder = Folder::new();
    let run = "run cartpole --budget 2 --methods ppo,dqn --set ppo.total_steps=4096 --set dqn.total_steps=2000 -q";
    folder.run(&format!("{run} --out one --jobs 1"));
    folder.run(&format!("{run} --out two --jobs 2"));
    assert_eq!(folder.records("one"), folder.records("two"));
    for task in 0..4 {
        let rows = folder.record("one", task);
        let score = rows[0]["metrics"]["normalised_return"].as_f64().unwrap();
        assert!(score > 0.0 && score <= 1.0, "{score}");
        let kinds = |kind: &str| rows.iter().filter(|r| r["kind"] == kind).count();
        // An update of ppo is 2,048 steps; a row of dqn is a fiftieth of its steps.
        let training = if rows[0]["method"] == "dqn" { 50 } else { 2 };
        assert_eq!((kinds("training"), kinds("evaluation")), (training, 5));
        let model = |out: &str| {
            fs::read(folder.join(&format!("{out}/models/000/{task}.safetensors"))).unwrap()
        };
        assert!(model("one") == model("two"), "{task}");
    }
    let identity = folder.json("one/manifest.json")["identity"].clone();
    assert_eq!(
        (&identity["domain"], &identity["objective"]),
        (&"cartpole".into(), &"normalised_return".into())
    );
}

#[test]
fn a_family_is_listed_and_a_table_of_own_points_is_evaluated() {
    let scenario =
        "domain = \"cartpole\"\nname = \"own\"\nfamily.points = \"p.csv\"\nppo.total_steps = 2048";
    let table = "point,instances,masspole_kg\na,3,0.2\n";
    let folder = Folder::with(&[("own.toml", scenario), ("p.csv", table)]);
    folder.run("run own.toml --methods ppo -q");
    assert_eq!(folder.record("results/own", 0)[0]["point"], "a");
    assert!(folder.run("list cartpole").ends_with("576 point MDPs in scenario cartpole\n"));
    let listed = folder.run("list cartpole --json");
    let first: Value = serde_json::from_str(listed.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&first["point"], &first["force_n"]),
        (&"l0.05-c0.1-p0.01-f1-g0.1".into(), &1.0.into())
    );
}

#[test]
fn every_control_task_runs_with_every_method_from_the_family_to_the_page() {
    let mut tasks = vec![
        ("acrobot", "ppo,dqn,trpo,ars", "return"),
        ("cartpole", "trpo,ars", "normalised_return"),
        ("pendulum", "ppo,sac,td3,trpo,ars", "normalised_return"),
        ("mountain-car", "ppo,sac,td3,trpo,ars", "return"),
        ("pendulum-swing-up", "ppo,td3,trpo", "steps_to_upright"),
        ("quad", "ppo,td3,trpo", "course_share"),
    ];
    match mujoco::version() {
        Ok(_) => tasks.extend([
            ("half-cheetah", "ppo,sac,td3,trpo,ars", "return"),
            ("swimmer", "ppo,td3,trpo", "steps_to_goal"),
        ]),
        Err(e) => eprintln!("half-cheetah and swimmer are skipped: {e}"),
    }
    let folder = Folder::new();
    for (task, methods, metric) in tasks {
        let mut command =
            format!("run {task} --budget 1 --eval-seeds 1 --methods {methods} -q --out {task}");
        for method in methods.split(',') {
            command += &format!(" --set {method}.total_steps=500");
            if ["sac", "td3"].contains(&method) {
                command += &format!(" --set {method}.hidden=8 --set {method}.batch_size=8");
            }
        }
        folder.run(&command);
        for (number, method) in methods.split(',').enumerate() {
            let head = folder.record(task, number).remove(0);
            assert_eq!(head["outcome"], "ok", "{head}");
            assert!(head["metrics"][metric].is_f64(), "{head}");
            folder.shows(&format!("{task}/report/index.html"), &[method]);
        }
    }
}

#[test]
fn without_mujoco_a_run_says_what_to_install_and_a_list_needs_none() {
    let folder = Folder::new();
    let run = |args: &str| {
        let mut program = program(folder.path());
        program.args(args.split(' ')).env(mujoco::VARIABLE, folder.path()).output().unwrap()
    };
    let output = run("run swimmer --methods ppo");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("scripts/setup.sh mujoco"), "{}", stderr(&output));
    assert!(run("list half-cheetah").status.success());
}
