//! A learner end to end, with SUMO: trained, killed, continued, and its model elsewhere.

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{program, stderr, stdout};
use crate::folder::Folder;
use serde_json::Value;

const POINTS: &str = "\
point,intersections,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes
narrow,1,2,30,200,250,0,0
";

/// A point MDP with more lanes.
const WIDE: &str = "wide,1,6,30,200,250,1,1\n";

/// A folder with a scenario whose learners train for some short episodes.
fn city(points: &str, episodes: u32) -> Folder {
    let scenario = format!(
        "name = \"city\"\nfamily.points = \"points.csv\"\ndemand.horizon_s = 200.0\ntraining.episodes = {episodes}\n"
    );
    Folder::with(&[("city.toml", &scenario), ("points.csv", points)])
}

fn json_lines(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn models_drive_elsewhere_as_they_did_where_they_were_trained() {
    let folder = city(&format!("{POINTS}{WIDE}"), 2);
    folder.run("run city.toml --methods mplight,idqn --eval-seeds 2 --quiet --out out");
    // Tasks 1 and 4 are of mplight, 2 and 5 of idqn.
    let record = folder.record("out", 2);
    let summary = &record[0]["metrics"];
    let training = record.iter().filter(|r| r["kind"] == "training");
    let delays: Vec<f64> = training.map(|r| r["metrics"]["delay_s"].as_f64().unwrap()).collect();
    assert_eq!(delays.len(), 2);
    assert_eq!(summary["resco_best_delay_s"].as_f64().unwrap(), delays[0].min(delays[1]));
    assert!(!folder.has("out/ckpt/000/2.safetensors"));
    assert_eq!(folder.rows("out/report/models.csv").len(), 4);

    // As methods of a run they are what they are alone; another timing of signals is warned of.
    let beside = "run city.toml --methods baseline --model m=out/models/000/1.safetensors --eval-seeds 2 --out";
    assert!(!folder.says(0, &format!("{beside} beside")).contains("another timing"));
    let delay = |out: &str, task| folder.record(out, task)[0]["metrics"]["delay_s"].clone();
    assert_eq!(delay("beside", 1), delay("out", 1));
    let config = "networks/city/narrow/narrow.sumocfg";
    let elsewhere = "--methods program --model m=out/models/000/2.safetensors --eval-seeds 1";
    folder.run(&format!("run --sumocfg {config} {elsewhere} --quiet --out imported"));
    assert_eq!(folder.record("imported", 2)[0]["outcome"], "ok");
    folder.run("run city.toml --methods idqn --eval-seeds 2 -q --out guarded --set signal.longest_wait_s=20");
    assert_ne!(delay("guarded", 1), delay("out", 2), "who has waited for 20 s is served");
    let said = folder.says(0, &format!("{beside} other --set signal.delta_time_s=5"));
    assert!(said.contains("m was trained with another timing of signals"), "{said}");

    // A run of the models of another one simulates models alone and names what does not carry over.
    let output = folder.output("evaluate --from out --out moved --json");
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let mut named = json_lines(&stdout(&output));
    let unfit = named
        .iter()
        .find(|l| (&l["method"], &l["point"]) == (&"idqn-of-narrow".into(), &"wide".into()));
    let reason = unfit.unwrap()["reason"].as_str().unwrap();
    assert!(reason.starts_with("the model does not fit"), "{reason}");
    named.retain(|line| line["event"] == "method");
    assert_eq!(named.len(), 7, "baseline, two methods and their four models: {named:?}");
    assert!(named.iter().any(|line| line["method"] == "idqn-of-wide"));
    assert_eq!(folder.rows("moved/transfer/transfer.csv").len(), 8);
    assert_eq!(delay("moved", 3), delay("out", 1), "at home a model is what its training was");
    folder.refuses(&[(
        "evaluate --from out --out ./out",
        "whose models are taken; give another folder",
    )]);
}

fn planned(folder: &Folder, from: &str, to: &str) {
    folder.write(&format!("{to}/manifest.json"), &folder.read(&format!("{from}/manifest.json")));
}

const WORKER: &str = "worker killed --task 1 --checkpoint-every-s 0";
const CHECKPOINT: &str = "killed/ckpt/000/1.safetensors";

/// Begins a task and kills it after its first checkpoint.
fn killed(folder: &Folder) {
    let mut child = program(folder.path())
        .args(WORKER.split_whitespace())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !folder.has(CHECKPOINT) {
        assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint in a minute");
        sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(folder.has(CHECKPOINT) && !folder.has("killed/done/000/1.jsonl"));
}

#[test]
fn a_killed_training_continues_to_the_same_record_and_model() {
    let folder = city(POINTS, 16);
    folder.run("run city.toml --methods idqn --eval-seeds 2 --quiet --out whole");
    planned(&folder, "whole", "killed");
    killed(&folder);
    assert!(folder.says(0, WORKER).contains("training continues after episode "));
    assert_eq!(folder.record("killed", 1), folder.record("whole", 1));
    let model = |out: &str| fs::read(folder.join(out).join("models/000/1.safetensors")).unwrap();
    assert!(model("killed") == model("whole"), "the models differ");
    assert!(!folder.has(CHECKPOINT));
    // A model is no checkpoint: it is named, and costs only time.
    planned(&folder, "whole", "other");
    fs::create_dir_all(folder.join("other/ckpt/000")).unwrap();
    fs::write(folder.join("other/ckpt/000/1.safetensors"), model("whole")).unwrap();
    let said = folder.says(0, "worker other --task 1");
    assert!(said.contains("1.safetensors is not used: it is not a checkpoint"), "{said}");
    assert_eq!(folder.record("other", 1), folder.record("whole", 1));
}

#[test]
fn one_training_on_several_point_mdps_is_a_run_that_goes_on_where_it_was_killed() {
    let folder = city(&format!("{POINTS}{WIDE}third,1,4,30,200,300,0,0\n"), 9);
    let settings = "--set training.validation_start=4 --set training.validation_interval=4";
    let train =
        format!("train city.toml --on 2 --others 1 --trainings 2 --eval-seeds 1 {settings}");
    let said = folder.says(0, &format!("{train} --out whole"));
    assert!(said.contains("best training of mplight: replicate "), "{said}");
    let rows = folder.record("whole", 1);
    let number = |row: &Value| row["metrics"]["member"].as_f64();
    let members: Vec<f64> = rows.iter().filter_map(number).collect();
    assert!(members.len() == 9 && members.contains(&1.0) && members.contains(&2.0), "{members:?}");
    planned(&folder, "whole", "killed");
    killed(&folder);
    assert!(folder.says(0, WORKER).contains("training continues after episode "));
    assert_eq!(folder.record("killed", 1), rows);
    let model = |path: &str| fs::read(folder.join(path)).unwrap();
    assert!(model("killed/models/000/1.safetensors") == model("whole/models/000/1.safetensors"));
    let said = folder.says(
        0,
        "run city.toml --methods baseline --model shared=whole/mplight.safetensors --eval-seeds 1 --out on-all",
    );
    for words in ["on 2 point MDPs of its training, and ", " on 1 point MDP that it had not seen"] {
        assert!(said.contains(words), "{said}");
    }
    assert_eq!(folder.records("on-all").len(), 6, "it serves signals of every layout");
    folder.refuses(&[
        (&format!("{train} --methods idqn"), "only mplight and mplight-star learn on several"),
        (&format!("{train} --episodes 1"), "1 training episodes visit 1 of 2 point MDPs"),
        (&format!("{train} --budget 2"), "--budget has no effect: --on and --others say"),
    ]);
}
