//! The plans of a report are what a method did: plain `sumo` with them shows their phases, and repeats
//! the recorded delays to the last digit.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{stderr, succeed};
use crate::fixture::Scenario;
use crate::folder::{Row, rows};
use crate::nightly::is_nightly;
use serde_json::Value;
use tsc_family::traffic::sim::tripinfo;

/// What both simulations have beside network, vehicles and programs.
const OPTIONS: &str = "--time-to-teleport -1 --xml-validation never --no-step-log \
    --tripinfo-output trips.xml --tripinfo-output.write-unfinished \
    --tripinfo-output.write-undeparted";

fn watch(folder: &Path, signal: &str) {
    let event =
        format!("<timedEvent type=\"SaveTLSStates\" source=\"{signal}\" dest=\"shown.xml\"/>");
    fs::write(folder.join("watch.add.xml"), format!("<additional>{event}</additional>")).unwrap();
}

fn shown(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("shown.xml")).unwrap();
    let state = |line: &str| Some(line.split_once(" state=\"")?.1.split_once('"')?.0.to_owned());
    text.lines().filter(|line| line.contains("<tlsState ")).filter_map(state).collect()
}

pub(crate) fn delay_s(folder: &Path, args: &str) -> f64 {
    let mut sumo = Command::new("sumo");
    let words = args.split_whitespace().chain(OPTIONS.split_whitespace());
    let output = sumo.args(words).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{args}: {}", stderr(&output));
    let (trips, _) = tripinfo::read(&folder.join("trips.xml")).unwrap();
    assert!(trips.vehicles > 0);
    trips.delay_s / f64::from(trips.vehicles)
}

fn records(folder: &Path) -> Vec<(Value, Vec<Value>)> {
    let tasks = fs::read_dir(folder.join("out/done/000")).unwrap().count();
    let record = |task: usize| {
        let text = fs::read_to_string(folder.join(format!("out/done/000/{task}.jsonl"))).unwrap();
        let mut lines: Vec<Value> =
            text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        let summary = lines.remove(0);
        lines.retain(|row| row["kind"] == "evaluation");
        (summary, lines)
    };
    (0..tasks).map(record).collect()
}

fn plan(folder: &Path, point: &str, method: &str) -> Vec<Row> {
    let mut rows = rows(&folder.join("out/report/plans.csv"));
    rows.retain(|row| row["point"] == point && row["method"] == method);
    rows
}

fn cell<'a>(row: &'a Row, name: &str) -> &'a str {
    &row[name]
}

/// What a fixed cycle of `plans.csv` shows from time 0 on, second by second, by greens only.
fn greens(plan: &[Row], seconds: usize) -> Vec<Option<String>> {
    let mut cycle = Vec::new();
    for row in plan {
        let seconds = |name| cell(row, name).parse::<usize>().unwrap();
        cycle.extend(vec![Some(cell(row, "state").to_owned()); seconds("green_s")]);
        cycle.extend(vec![None; seconds("yellow_s") + seconds("all_red_s")]);
    }
    assert_eq!(cycle.len(), cell(&plan[0], "cycle_s").parse::<usize>().unwrap());
    cycle.into_iter().cycle().take(seconds).collect()
}

#[test]
fn plain_sumo_shows_the_plans_of_generated_networks_and_repeats_their_delays() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let settings = "--preset field --set demand.horizon_s=300";
    let search = "--set fixed_time.simulations=8";
    let methods = "--methods fixed-time,actuated,max-pressure --eval-seeds 2";
    succeed(folder, &format!("run smoke {methods} {settings} {search} --quiet --out out"));
    watch(folder, "c");
    let plans = Path::new("out/report/plans");
    let mut programs = 0;
    for (summary, rows) in records(folder) {
        let text = |name: &str| summary[name].as_str().unwrap().to_owned();
        let (method, point) = (text("method"), text("point"));
        let name = match method.as_str() {
            "fixed-time" => format!("{point}.add.xml"),
            method => format!("{point}.{method}.add.xml"),
        };
        if !folder.join(plans).join(&name).exists() {
            assert!(["baseline", "max-pressure"].contains(&&*method), "{name}");
            continue;
        }
        programs += 1;
        let networks = provenance(folder);
        for row in &rows {
            let seed = &row["seed"];
            let routes = format!("routes --point {point} smoke --seed {seed} --out r.xml");
            succeed(folder, &format!("{routes} {settings}"));
            let vehicles = format!("--route-files r.xml --seed {seed}");
            let add = format!("-a {}/{name},watch.add.xml", plans.display());
            let config = format!("-c {networks}/{point}/{point}.sumocfg");
            let delay_s = delay_s(folder, &format!("{config} {vehicles} {add}"));
            assert_eq!(row["metrics"]["delay_s"], delay_s, "{method} on {point}");
        }
        if method == "fixed-time" {
            let shown = shown(folder);
            let planned = greens(&plan(folder, &point, &method), shown.len());
            assert!(shown.len() >= 300);
            for (second, (shown, planned)) in shown.iter().zip(planned).enumerate() {
                match planned {
                    Some(green) => assert_eq!(*shown, green, "{point} at {second} s"),
                    None => assert!(!shown.contains('g') || shown.contains('y'), "{second} s"),
                }
            }
        }
    }
    assert_eq!(programs, 4);
}

fn provenance(folder: &Path) -> String {
    let manifest = fs::read_to_string(folder.join("out/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    manifest["provenance"]["networks"].as_str().unwrap().to_owned()
}

/// A SUMO scenario of three signals from 100 s to 700 s, in steps of half a second.
fn three_signals(scenario: &Scenario) -> PathBuf {
    let flows = [("WA", "BE", 7), ("NA", "SX", 9), ("MB", "BE", 11), ("PS", "SQ", 8)];
    let routes: String = flows
        .iter()
        .map(|(from, to, period)| {
            format!(
                "<flow id=\"{from}\" from=\"{from}\" to=\"{to}\" begin=\"100\" end=\"700\" \
                 period=\"{period}\"/>"
            )
        })
        .collect();
    let config = scenario.options("net", "a", &routes).config;
    let text = fs::read_to_string(&config).unwrap();
    let time =
        "<begin value=\"100\"/><end value=\"700\"/><step-length value=\"0.5\"/></configuration>";
    fs::write(&config, text.replace("</configuration>", time)).unwrap();
    config
}

#[test]
fn plans_of_several_signals_in_an_imported_scenario_repeat_delays_too() {
    let scenario = Scenario::new();
    let config = three_signals(&scenario);
    let folder = config.parent().unwrap();
    let methods = "--methods fixed-time,actuated,program --set fixed_time.simulations=8";
    succeed(folder, &format!("run --sumocfg a.sumocfg {methods} --eval-seeds 2 --quiet --out out"));
    for (summary, rows) in records(folder) {
        let method = summary["method"].as_str().unwrap();
        let file = match method {
            "fixed-time" => "-a out/report/plans/a.add.xml".to_owned(),
            "program" => String::new(),
            method => format!("-a out/report/plans/a.{method}.add.xml"),
        };
        for row in &rows {
            let args = format!("-c a.sumocfg --seed {} {file}", row["seed"]);
            assert_eq!(row["metrics"]["delay_s"], delay_s(folder, &args), "{method}");
        }
        let plan = plan(folder, "a", method);
        let mut signals: Vec<&str> = plan.iter().map(|row| cell(row, "signal")).collect();
        signals.dedup();
        assert_eq!(signals, ["A", "B", "S"], "{method}");
    }
    // Records do not have the offsets of the network's own programs.
    let rows = rows(&folder.join("out/report/cabinet.csv"));
    let offsets = |method: &str| -> BTreeSet<&str> {
        let own = rows.iter().filter(|row| row["method"] == method);
        own.map(|row| row["offset_s"].as_str()).collect()
    };
    assert_eq!(offsets("program"), BTreeSet::from([""]));
    assert!(!offsets("fixed-time").is_empty() && !offsets("fixed-time").contains(""));
}

/// Every method's first evaluation episode, as `routes` writes it for plain `sumo`, has the recorded delay.
fn episodes_are_repeated(folder: &Path) -> usize {
    let mut repeated = 0;
    for (summary, rows) in records(folder) {
        let text = |name: &str| summary[name].as_str().unwrap().to_owned();
        let (method, point) = (text("method"), text("point"));
        let _ = fs::remove_dir_all(folder.join("played"));
        succeed(
            folder,
            &format!("routes --run out --point {point} --method {method} --out played"),
        );
        let delay_s = delay_s(folder, "-c played/episode.sumocfg");
        assert_eq!(rows[0]["metrics"]["delay_s"], delay_s, "{method} on {point}");
        repeated += 1;
    }
    repeated
}

#[test]
fn plain_sumo_repeats_an_episode_of_any_method_on_generated_networks() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let presets = if is_nightly() { &["field", "resco"][..] } else { &["field"] };
    for preset in presets {
        let methods =
            "--methods fixed-time,actuated,max-pressure,nema,idqn --eval-seeds 1 --episodes 1";
        let settings =
            format!("--preset {preset} --set demand.horizon_s=300 --set fixed_time.simulations=8");
        let _ = fs::remove_dir_all(folder.join("out"));
        succeed(folder, &format!("run smoke {methods} {settings} --quiet --out out"));
        // The baseline and five methods on two point MDPs.
        assert_eq!(episodes_are_repeated(folder), 12);
    }
}

#[test]
fn plain_sumo_repeats_an_episode_of_any_method_of_a_part_of_a_scenario() {
    let scenario = Scenario::new();
    let config = three_signals(&scenario);
    let folder = config.parent().unwrap();
    let methods = "--methods program,baseline,actuated,max-pressure,nema --eval-seeds 1";
    succeed(
        folder,
        &format!("run --sumocfg a.sumocfg --begin 150 --end 450 {methods} --quiet --out out"),
    );
    assert_eq!(episodes_are_repeated(folder), 5);
}

#[test]
fn plain_sumo_repeats_a_scenario_whose_options_a_run_replaces() {
    let scenario = Scenario::new();
    let config = three_signals(&scenario);
    let folder = config.parent().unwrap();
    let options = "<mesosim value='true'/><tls.all-off value='1'/><max-depart-delay value='30'/>\
        <time-to-teleport.highways value='20'/><collision.action value='remove'/><remote-port value='8899'/>\
        <tripinfo value='mine.xml'/><netstate-dump value='dump.xml'/></configuration>";
    let text = fs::read_to_string(&config).unwrap();
    fs::write(&config, text.replace("</configuration>", options)).unwrap();
    // At 130 s a fixed cycle of the shortest greens of `actuated`, which is 20 s long, is not in its first phase.
    let given = "--begin 130 --end 500 --step-length 1 --accept microscopic,signals-on";
    let methods = "--methods actuated --eval-seeds 1";
    succeed(folder, &format!("run --sumocfg a.sumocfg {given} {methods} --quiet --out out"));
    let plans = folder.join("out/report/plans");
    assert_eq!(episodes_are_repeated(folder), 2);
    for written in ["mine.xml", "dump.xml"] {
        assert!(!plans.join(written).exists() && !folder.join("played").join(written).exists());
    }
}

#[test]
fn plain_sumo_repeats_episodes_of_a_scenario_whose_programs_change_by_the_clock() {
    let scenario = Scenario::new();
    let config = three_signals(&scenario);
    let folder = config.parent().unwrap();
    let network = fs::read_to_string(folder.join("net.net.xml")).unwrap();
    let program = network.split("<tlLogic id=\"A\"").nth(1).unwrap();
    let program = program.split("</tlLogic>").next().unwrap();
    let night = program
        .replace("programID=\"0\"", "programID=\"night\"")
        .replace("offset=\"0\"", "offset=\"20\"");
    assert_ne!(night, program);
    let add = format!(
        "<additional><tlLogic id=\"A\"{night}</tlLogic><WAUT refTime='0' id='w' startProg='0'>\
         <wautSwitch time='300' to='night'/></WAUT><wautJunction wautID='w' junctionID='A'/>\
         <e1Detector id='d' lane='WA_0' pos='1' freq='10' file='mine.txt'/></additional>"
    );
    fs::write(folder.join("add.xml"), add).unwrap();
    let text = fs::read_to_string(&config).unwrap();
    let add = "<additional-files value='add.xml'/></configuration>";
    fs::write(&config, text.replace("</configuration>", add)).unwrap();
    let methods = "--methods program,actuated,max-pressure --eval-seeds 1";
    succeed(folder, &format!("run --sumocfg a.sumocfg {methods} --quiet --out out"));
    assert_eq!(episodes_are_repeated(folder), 4);
    assert!(!folder.join("mine.txt").exists());
    assert!(folder.join("out/report/plans/a.actuated.add.xml").exists());
}

/// Flows over a signal of four nodes, of which the vehicles of one are left out of SUMO's `tripinfo`.
const OVER_FOUR: &str = r#"<routes>
    <vType id="q"><param key="has.tripinfo.device" value="false"/></vType>
    <flow id="a" type="q" from="left0A0" to="B0right0" begin="0" end="300" period="7"/>
    <flow id="b" from="bottom0A0" to="A1top0" begin="0" end="300" period="9"/>
    <flow id="c" from="right1B1" to="A1left1" begin="0" end="300" period="8"/>
    <flow id="d" from="top1B1" to="B0bottom1" begin="0" end="300" period="11"/>
</routes>"#;

#[test]
fn what_is_handed_out_of_a_signal_over_several_nodes_runs_in_plain_sumo_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let options = "--grid --grid.number 2 --grid.length 30 --grid.attach-length 150 \
        --default-junction-type traffic_light --tls.join --tls.join-dist 40 -o n.net.xml";
    let words = options.split_whitespace();
    let made = Command::new("netgenerate").args(words).current_dir(folder).output().unwrap();
    assert!(made.status.success(), "{}", stderr(&made));
    let detector = "<e1Detector id='e' lane='left0A0_0' pos='-20' period='60' file='mine.xml'/>";
    for (name, text) in [
        ("r.xml", OVER_FOUR.to_owned()),
        ("x.xml", format!("<additional>{detector}</additional>")),
        ("a.sumocfg", "<c><n v='n.net.xml'/><r v='r.xml'/><a v='x.xml'/><e v='300'/></c>".into()),
    ] {
        fs::write(folder.join(name), text).unwrap();
    }
    let methods = "--methods fixed-time --set fixed_time.simulations=8 --eval-seeds 1";
    succeed(folder, &format!("run --sumocfg a.sumocfg {methods} --quiet --out out"));
    assert_eq!(episodes_are_repeated(folder), 2);
    assert!(!folder.join("mine.xml").exists() && !folder.join("played/mine.xml").exists());
}
