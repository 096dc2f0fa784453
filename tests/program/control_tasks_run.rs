//! `tsc-family run` on every control task, from the family to the page.

use std::fs;
use std::process::Command;

use serde_json::Value;
use tsc_family::control_tasks::mujoco;

#[test]
fn every_control_task_runs_with_every_method_from_the_family_to_the_page() {
    let dir = tempfile::tempdir().unwrap();
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
    for (task, methods, metric) in tasks {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tsc-family"));
        command.args(["run", task, "--budget", "1", "--methods", methods, "-q", "--out", task]);
        for method in methods.split(',') {
            command.args(["--set", &format!("{method}.total_steps=1000")]);
            if ["sac", "td3"].contains(&method) {
                command.args(["--set", &format!("{method}.hidden=8")]);
                command.args(["--set", &format!("{method}.batch_size=8")]);
            }
        }
        let output = command.current_dir(dir.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        for number in 0..methods.split(',').count() {
            let record = dir.path().join(format!("{task}/done/000/{number}.jsonl"));
            let text = fs::read_to_string(record).unwrap();
            let head: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
            assert_eq!(head["outcome"], "ok", "{text}");
            assert!(head["metrics"][metric].is_f64(), "{text}");
        }
        let page = fs::read_to_string(dir.path().join(task).join("report/index.html")).unwrap();
        assert!(methods.split(',').all(|method| page.contains(method)));
    }
}

#[test]
fn without_mujoco_a_run_says_what_to_install_and_a_list_needs_none() {
    let dir = tempfile::tempdir().unwrap();
    let said = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tsc-family"));
        command.args(args).current_dir(dir.path()).env(mujoco::VARIABLE, dir.path());
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, text) = said(&["run", "swimmer", "--methods", "ppo"]);
    assert_eq!(code, Some(4), "{text}");
    assert!(text.contains("MuJoCo is missing, which half-cheetah and swimmer need"), "{text}");
    assert!(text.contains("scripts/setup.sh mujoco"), "{text}");
    let (code, text) = said(&["list", "half-cheetah"]);
    assert_eq!(code, Some(0), "{text}");
}
