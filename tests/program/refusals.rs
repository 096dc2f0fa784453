//! What commands refuse, with the reason and before anything is written.

use std::fs;

use crate::common::{stderr, stdout};
use crate::folder::Folder;

/// What each command says, which must end with code 2 and write nothing.
fn refused(folder: &Folder, commands: &[&str]) -> String {
    let before = folder.names("");
    let says = |args: &&str| {
        let output = folder.output(args);
        assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
        assert!(stdout(&output).is_empty(), "{args}");
        let said = stderr(&output);
        let error = said.lines().find(|line| line.starts_with("error")).unwrap_or(&said);
        format!("{args}\n  {error}\n")
    };
    let said = commands.iter().map(says).collect();
    assert_eq!(folder.names(""), before, "nothing is written");
    said
}

/// Compares with a snapshot, in which learners and methods are not listed.
fn snapshot(name: &str, said: String) {
    let filters = [
        ("no method learns; .* do;", "no method learns; ... do;"),
        ("known are .*", "known are ..."),
        (r"embedded scenario \(.*\)", "embedded scenario (...)"),
    ];
    insta::with_settings!({ filters => filters.to_vec() }, { insta::assert_snapshot!(name, said) });
}

#[test]
fn commands_with_wrong_values_say_what_to_give() {
    let folder = Folder::with(&[("no.sumocfg", "<configuration/>"), ("thesis/chapter.tex", "")]);
    snapshot(
        "wrong_values",
        refused(
            &folder,
            &[
                "run smoke --methods maxpressure",
                "run smok",
                "rum smoke",
                "list atlantis",
                "run --bugdet 3",
                "run smoke --episodes 0",
                "run smoke --jobs two",
                "run smoke --seed -1.5",
                "run smoke --seed=-1",
                "run smoke --eval-seeds 100000000",
                "run smoke --methods idqn --episodes 2000000",
                "run smoke --budget 0",
                "run smoke --budget 3",
                "run smoke --budget some",
                "run --methods all --replicates 100000",
                "run --sumocfg nowhere.sumocfg",
                "run --sumocfg no.sumocfg",
                "run smoke --methods coordinated,baseline --set idqn.learning_rat=1",
                "run pendulum --methods dqn",
                "run cartpole --methods idqn",
                "run quad --set environment.tilt_chek=false",
                "report .",
                "signals nowhere smoke",
                "signals nowhere.sumocfg",
                "routes --point nowhere smoke --seed 1 --out r.xml",
                "run smoke --model m=nowhere.safetensors",
                "list salt-lake-city --set demand.horizon_s",
                "list salt-lake-city --set =600",
                "list salt-lake-city --set demand.horizon=600",
                "list salt-lake-city --set baseline.program=netconver",
                "list salt-lake-city --set dqn.learning_rate=5e-4",
                "list salt-lake-city --set demand.horizon_s=soon",
                "list salt-lake-city --set demand.horizon_s=5",
                "list salt-lake-city --set title=x --set fixed_time.max_cycle_s=15",
                "list salt-lake-city --set family.approaches=nowhere.csv",
                "run smoke --methods baseline --eval-seeds 1 --out thesis",
                "run smoke --methods baseline --eval-seeds 1 --networks thesis",
                "build-networks smoke --quiet --out thesis",
                "routes smoke --point busy --seed 1 --out no.sumocfg",
            ],
        ),
    );
    let forced = "run smoke --methods baseline --eval-seeds 1 --quiet --out thesis";
    folder.run(&format!("{forced} --force"));
    folder.run(forced);
}

#[test]
fn what_has_no_effect_is_refused() {
    let folder = Folder::new();
    folder.run("build-networks smoke --quiet");
    fs::rename(folder.join("networks/smoke/busy/busy.sumocfg"), folder.join("a.sumocfg")).unwrap();
    snapshot(
        "without_effect",
        refused(
            &folder,
            &[
                "run smoke --dry-run --sampling k-means",
                "run smoke --dry-run --methods max-pressure --replicates 2",
                "run smoke --dry-run --episodes 5",
                "run smoke --dry-run --end 60",
                "run --dry-run --sumocfg a.sumocfg --networks elsewhere",
                "run --dry-run --sumocfg a.sumocfg --budget 1 --sampling k-means",
                "run cartpole --sumocfg a.sumocfg",
                "run cartpole --episodes 3",
                "run cartpole --networks n",
                "run smoke --out out --executor script --sbatch lines",
                "run smoke --out out --job-minutes 3",
                "run smoke --out out --answer-timeout 5",
            ],
        ),
    );
    folder.run("run smoke --dry-run --sampling k-means --budget 1");
    // Where published scores do not fit any more, they are to be written again.
    assert!(folder.run("run --dry-run --budget 20").contains("(bayesian-quadrature, seed 0)"));
    let plan = folder.run("run smoke -n --methods all --json");
    for left_out in ["coordinated", "program", "existing"] {
        assert!(plan.contains("\"nema\"") && !plan.contains(&format!("\"{left_out}\"")), "{plan}");
    }
}

#[test]
fn bad_families_are_refused_with_file_and_place() {
    let header =
        "point,importance,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes\n";
    let row = |start: &str| format!("{header}{start},200,500,0,0\n");
    let scenario = "name = \"city\"\n[family]\npoints = \"points.csv\"\n";
    let without = "point,importance,lanes,speed,length_m\na,1,4,30,200\n".to_owned();
    let cases = [
        (scenario, String::new()),
        (scenario, header.to_owned()),
        (scenario, without),
        (scenario, row("a,1,NaN,30")),
        (scenario, row("a,1,4,-30")),
        (scenario, format!("{header}a,0.5,4,30,200,500,0,0\n")),
        (scenario, format!("{header}a,1e308,4,30,200,500,0,0\n")),
        (scenario, format!("# by hand\n\n{header}a,1\n")),
        (scenario, row("a,1,4,30").replace(',', ";").replace("200", "1,200")),
        ("name = \"city\"\n[family\n", String::new()),
        ("", String::new()),
        ("name = \"city\"\nhorizon = 3\n[family]\npoints = \"p\"\n", String::new()),
        ("demand.turn_shares = {left = 1e308, through = 1.0, right = 0.0}\n", row("a,1,4,30")),
        ("signal.min_green_s = inf\n", row("a,1,4,30")),
        (
            "domain = \"quad\"\n[family]\npoints = \"points.csv\"\n",
            "point,upper_wall_m\na,1".into(),
        ),
    ];
    let said = cases.map(|(scenario, table)| {
        let folder = Folder::with(&[("city.toml", scenario), ("points.csv", &table)]);
        refused(&folder, &["list city.toml"])
    });
    snapshot("families", said.concat());
}

#[test]
fn a_run_with_another_network_table_or_setting_says_which() {
    let header = "point,intersections,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes\n";
    let scenario = "name = \"town\"\n[family]\npoints = \"p.csv\"\n";
    let folder = Folder::with(&[("town.toml", scenario)]);
    let table = |row: &str| folder.write("p.csv", &format!("{header}{row},30,150,250,0,0\n"));
    let short = "run town.toml --eval-seeds 1 --methods baseline --quiet --set demand.horizon_s=120 --out out";
    table("M\u{fc}hlstra\u{df}e / B 27,1,2");
    folder.run(short);
    let listed = folder.run("list town.toml --json");
    assert!(listed.contains("\"name\":\"M\u{fc}hlstra\u{df}e / B 27\""), "{listed}");
    let mut said = String::new();
    for row in ["M\u{fc}hlstra\u{df}e / B 27,1,4", "M\u{fc}hlstra\u{df}e,1,2"] {
        table(row);
        said += &folder.says(5, short);
    }
    table("M\u{fc}hlstra\u{df}e / B 27,1,2");
    said += &folder.says(5, &short.replace("=120", "=180"));
    snapshot("another_run", said);
}
