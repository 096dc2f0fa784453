//! Numbers that are too large: on the command line, in scenarios, tables, plans and results of strangers.

use std::fs;

use crate::outcomes::refused;
use crate::quick::quick_results;

#[test]
fn numbers_on_the_command_line_are_refused_at_once_with_the_largest_that_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    for (args, expected) in [
        ("run smoke --eval-seeds 100000000", "expected a whole number from 1 to 100000\n"),
        ("run smoke --replicates 4000000000", "expected a whole number from 1 to 100000\n"),
        ("run smoke --jobs 1000000000000", "expected a whole number from 1 to 1024\n"),
        ("build-networks --jobs 100000", "expected a whole number from 1 to 1024\n"),
        ("run smoke --methods idqn --episodes 4000000000", "expected a number from 1 to 1000000\n"),
        ("run smoke --budget 1000000000000", "give a budget from 1 to 2, or `all`\n"),
        ("run smoke --budget 2 --until-decided --looks 1,99999999", "to the budget, 2\n"),
        ("estimate x --repeats 4000000000", "expected a whole number from 1 to 100000\n"),
        ("sensitivity x --cases --repeats 100001", "expected a whole number from 1 to 100000\n"),
        ("evaluate --model x --point y --eval-seeds 100001", "from 1 to 100000\n"),
        (
            "run --methods all --replicates 100000",
            "are taken; give fewer point MDPs, methods or replicates: at most 30487 tasks per point MDP\n",
        ),
        (
            "run cartpole --methods ppo,dqn --replicates 4000 --eval-seeds 100000",
            "4608000 tasks are 460800000000; give at most 217 evaluation seeds\n",
        ),
    ] {
        let said = refused(folder.path(), args);
        assert!(said.contains(expected), "{args}: {said}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}

#[test]
fn numbers_of_scenarios_and_tables_have_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let head = "importance,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes";
    let table = |columns: &str, row: &str| {
        fs::write(folder.join("p.csv"), format!("{head}{columns}\n{row}\n")).unwrap();
    };
    let scenario = |text: &str| {
        fs::write(folder.join("s.toml"), format!("family.points = \"p.csv\"\n{text}\n")).unwrap();
    };
    scenario("");
    for (columns, row, expected) in [
        (
            "",
            "1e308,4,30,200,500,0,0",
            "importance = 1e308: expected a number from 0 to 1000000000000",
        ),
        (",x", "1,4,30,200,500,0,0,1e300", "x = 1e300: expected a number from 0 to 1000000000000"),
        ("", "1,4,30,200,1e308,0,0", "expected a number from 1 to 50000"),
        ("", "1,4,30,200,1e309,0,0", "write a number such as 40.78"),
        (
            ",intersections",
            "1,4,30,200,500,0,0,1e30",
            "expected a whole number that is not negative",
        ),
    ] {
        table(columns, row);
        let said = refused(folder, "list s.toml");
        assert!(said.contains(expected), "{row}: {said}");
    }
    table("", "1,4,30,200,500,0,0");
    for (setting, expected) in [
        (
            "demand.turn_shares = {left = 1e308, through = 1e308, right = 0.0}",
            "expected numbers from 0 to 1000000",
        ),
        (
            "demand.turn_shares = {left = 1e-320, through = 0.0, right = 0.0}",
            "0.000001 or more together",
        ),
        ("demand.horizon_s = 1e308", "expected a number from 10 to 86400"),
        ("signal.min_green_s = inf", "expected a whole number from 0"),
        (
            "family.bins = {lanes = 1e-308, speed_mph = 5.0, length_m = 1.0, inflow_vph = 1.0, left_turn_lanes = 1.0, right_turn_lanes = 1.0}",
            "expected a number from 0.001 to 1000000",
        ),
        (
            "family.inflows = {counted = 1e308, spread = 0.0, imputed = 0.0, default = 0.0}",
            "shares from 0 to 1",
        ),
        ("version = 4000000000", "expected a number from 1 to 1000000"),
        ("training.episodes = 100000000000000000000", "i64"),
    ] {
        scenario(setting);
        let said = refused(folder, "list s.toml");
        assert!(said.contains(expected) || expected == "i64", "{setting}: {said}");
    }
    scenario("");
    let said = refused(folder, "list s.toml --set demand.horizon_s=1e308");
    assert!(said.contains("from 10 to 86400"), "{said}");
}

#[test]
fn numbers_of_a_stranger_s_results_and_plans_have_limits() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    quick_results(folder);
    let path = folder.join("results/manifest.json");
    let text = fs::read_to_string(&path).unwrap();
    let altered = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
        change(&mut manifest["identity"]);
        fs::write(&path, manifest.to_string()).unwrap();
        refused(folder, "report results")
    };
    for (change, expected) in [
        (
            &|m: &mut serde_json::Value| m["replicates"] = 4_000_000_000_u32.into(),
            "replicates = 4000000000: expected 1 to 100000",
        ),
        (
            &|m: &mut serde_json::Value| m["points"][0]["features"][0] = 1e308.into(),
            "/identity/points/0/features/0 = 1e308: expected a number from -1e100 to 1e100",
        ),
        (
            &|m: &mut serde_json::Value| {
                m["sample"]["draws"][1]["count"] = 4_000_000_000_u32.into()
            },
            "4000000002 draws from a family of 576",
        ),
        (
            &|m: &mut serde_json::Value| m["sample"]["family_size"] = u64::MAX.into(),
            "draws from a family of 18446744073709551615",
        ),
        (
            &|m: &mut serde_json::Value| {
                m["replicated"] = serde_json::json!(["ppo"]);
                m["replicates"] = 100_000.into();
                m["evaluation_seeds"] = vec![1; 90_000].into();
            },
            "give at most 3333 evaluation seeds",
        ),
        (
            &|m: &mut serde_json::Value| m["points"][0]["title"] = "a\nerror: b".into(),
            "\"a\\nerror: b\" has control characters; restore it",
        ),
    ] as [(&dyn Fn(&mut serde_json::Value), &str); 6]
    {
        let said = altered(change);
        assert!(said.contains("manifest.json") && said.contains(expected), "{said}");
    }
    fs::write(&path, &text).unwrap();
}
