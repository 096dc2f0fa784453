//! An episode of a run, played again by `tsc-family routes`.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr, succeed};

const RUN: &str = "run smoke --budget all --preset field --methods nema,fixed-time,max-pressure-tuned,idqn --eval-seeds 2 \
    --set demand.horizon_s=300 --set fixed_time.simulations=8 --set training.episodes=2 --out results --quiet";

fn refused(folder: &Path, args: &str) -> String {
    let output = run(folder, &format!("routes --run {args}"));
    assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
    stderr(&output)
}

#[test]
fn an_episode_of_every_kind_of_method_is_the_one_that_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeed(folder, RUN);
    for method in ["baseline", "nema", "fixed-time", "max-pressure-tuned", "idqn"] {
        let command =
            format!("routes --run results --point busy --method {method} --out ep/{method}");
        let output = run(folder, &command);
        assert_eq!(output.status.code(), Some(0), "{method}: {}", stderr(&output));
        // It would warn of another delay.
        assert!(!stderr(&output).contains("warning"), "{method}: {}", stderr(&output));
        let files = ["episode.sumocfg", "states.add.xml", "vehicles.rou.xml"];
        assert!(files.iter().all(|f| folder.join("ep").join(method).join(f).is_file()), "{method}");
    }
    // Two seeds are two episodes.
    let text = fs::read_to_string(folder.join("results/report/episodes.csv")).unwrap();
    let is = |line: &&str| line.starts_with("nema,busy,0,evaluation,");
    let seeds: Vec<&str> = text.lines().filter(is).map(|l| l.split(',').nth(5).unwrap()).collect();
    let again = |seed: &str, out: &str| {
        let args = format!("--point busy --method nema --seed {seed}");
        succeed(folder, &format!("routes --run results {args} --out {out}"));
        fs::read(folder.join(out).join("states.add.xml")).unwrap()
    };
    assert_eq!(again(seeds[0], "again"), fs::read(folder.join("ep/nema/states.add.xml")).unwrap());
    assert_ne!(again(seeds[0], "again"), again(seeds[1], "other"));

    let nema = "--point busy --method nema";
    let e = refused(folder, "results --point bussy --method nema --out x");
    assert!(e.contains("has no point MDP \"bussy\"") && e.contains("busy"), "{e}");
    let e = refused(folder, "results --point busy --method actuated --out x");
    assert!(e.contains("has no method \"actuated\"") && e.contains("it has baseline, "), "{e}");
    let e = refused(folder, &format!("results {nema} --seed 1 --out x"));
    assert!(e.contains("--seed 1 is of no evaluation episode") && e.contains(seeds[0]), "{e}");
    let e = refused(folder, &format!("results {nema} --replicate 3 --out x"));
    assert!(e.contains("has no training 3 of nema on busy; they count from 0"), "{e}");
    let e = refused(folder, &format!("results {nema} --out results"));
    assert!(e.contains("is not empty and no folder that routes wrote"), "{e}");
    assert!(!folder.join("x").exists());
}
