//! `tsc-family signals`: what is derived of networks made by hand, in words.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{run, stderr, succeed};
use crate::fixture::Scenario;

/// A street in three edges, of which the last has 0.9 m, to a signal, and one in two edges from there
/// to the next:
///
/// ```text
///   W -- w1 -- V -- w2 -- U -- w3 -- A -- e1 -- F -- e2 -- B -- be -- E
/// ```
const STREET_NODES: &str = r#"<nodes>
    <node id="W" x="-260" y="0"/> <node id="V" x="-120" y="0"/> <node id="U" x="-12" y="0"/>
    <node id="A" x="0" y="0" type="traffic_light"/> <node id="S" x="0" y="-90"/>
    <node id="N" x="0" y="90"/> <node id="F" x="100" y="0"/>
    <node id="B" x="200" y="0" type="traffic_light"/> <node id="M" x="200" y="90"/>
    <node id="E" x="300" y="0"/>
</nodes>"#;

const STREET_EDGES: &str = r#"<edges>
    <edge id="w1" from="W" to="V" numLanes="2"/> <edge id="w2" from="V" to="U" numLanes="2"/>
    <edge id="w3" from="U" to="A" numLanes="2" length="0.9"/>
    <edge id="as" from="A" to="S"/> <edge id="na" from="N" to="A"/>
    <edge id="e1" from="A" to="F"/> <edge id="e2" from="F" to="B"/>
    <edge id="mb" from="M" to="B"/> <edge id="be" from="B" to="E"/>
</edges>"#;

const STREET_CONNECTIONS: &str = r#"<connections>
    <connection from="w3" to="as" fromLane="0" toLane="0"/>
    <connection from="w3" to="e1" fromLane="1" toLane="0"/>
</connections>"#;

const WHOLE_NODES: &str = r#"<nodes>
    <node id="W" x="-260" y="0"/> <node id="A" x="0" y="0" type="traffic_light"/>
    <node id="S" x="0" y="-90"/> <node id="N" x="0" y="90"/>
    <node id="B" x="200" y="0" type="traffic_light"/> <node id="M" x="200" y="90"/>
    <node id="E" x="300" y="0"/>
</nodes>"#;

const WHOLE_EDGES: &str = r#"<edges>
    <edge id="w" from="W" to="A" numLanes="2"/>
    <edge id="as" from="A" to="S"/> <edge id="na" from="N" to="A"/> <edge id="e" from="A" to="B"/>
    <edge id="mb" from="M" to="B"/> <edge id="be" from="B" to="E"/>
</edges>"#;

const WHOLE_CONNECTIONS: &str = r#"<connections>
    <connection from="w" to="as" fromLane="0" toLane="0"/>
    <connection from="w" to="e" fromLane="1" toLane="0"/>
</connections>"#;

/// A crossing with lanes for left turns from north and south and a crosswalk in the west.
const CROSSING_NODES: &str = r#"<nodes>
    <node id="C" x="0" y="0" type="traffic_light"/> <node id="N" x="0" y="200"/>
    <node id="E" x="200" y="0"/> <node id="S" x="0" y="-200"/> <node id="W" x="-200" y="0"/>
</nodes>"#;

const CROSSING_EDGES: &str = r#"<edges>
    <edge id="nc" from="N" to="C" numLanes="2"/> <edge id="cn" from="C" to="N"/>
    <edge id="sc" from="S" to="C" numLanes="2"/> <edge id="cs" from="C" to="S"/>
    <edge id="ec" from="E" to="C"/> <edge id="ce" from="C" to="E"/>
    <edge id="wc" from="W" to="C" sidewalkWidth="2"/>
    <edge id="cw" from="C" to="W" sidewalkWidth="2"/>
</edges>"#;

const CROSSING_CONNECTIONS: &str = r#"<connections>
    <connection from="nc" to="cs" fromLane="0" toLane="0"/>
    <connection from="nc" to="ce" fromLane="1" toLane="0"/>
    <connection from="sc" to="cn" fromLane="0" toLane="0"/>
    <connection from="sc" to="cw" fromLane="1" toLane="1"/>
    <connection from="ec" to="cw" fromLane="0" toLane="1"/>
    <connection from="wc" to="ce" fromLane="1" toLane="0"/>
    <crossing node="C" edges="wc cw"/>
</connections>"#;

/// Straight on with lefts that yield, straight on alone, east and west, pedestrians alone.
const CROSSING_PROGRAM: &str = r#"<additional>
    <tlLogic id="C" type="static" programID="own" offset="0">
        <phase duration="30" state="GgrGgrr"/> <phase duration="20" state="GrrGrrr"/>
        <phase duration="30" state="rrGrrGr"/> <phase duration="10" state="rrrrrrG"/>
    </tlLogic>
</additional>"#;

fn build(scenario: &Scenario, name: &str, network: [&str; 3], routes: &str) -> PathBuf {
    let [nodes, edges, connections] = network;
    scenario.build(name, nodes, edges, Some(connections));
    let config = scenario.options(name, name, routes).config;
    change(&config, "</input>", "</input><time><end value=\"1800\"/></time>");
    config
}

fn change(file: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(file).unwrap();
    fs::write(file, text.replace(from, to)).unwrap();
}

fn street(scenario: &Scenario, routes: &str) -> PathBuf {
    build(scenario, "street", [STREET_NODES, STREET_EDGES, STREET_CONNECTIONS], routes)
}

fn crossing(scenario: &Scenario) -> PathBuf {
    let network = [CROSSING_NODES, CROSSING_EDGES, CROSSING_CONNECTIONS];
    let config =
        build(scenario, "crossing", network, r#"<trip id="t" depart="0" from="nc" to="cs"/>"#);
    fs::write(config.with_file_name("crossing.add.xml"), CROSSING_PROGRAM).unwrap();
    change(&config, "</input>", "<additional-files value=\"crossing.add.xml\"/></input>");
    config
}

fn signals(config: &Path, options: &str) -> String {
    let folder = config.parent().unwrap();
    succeed(folder, &format!("signals {} {options}", config.display()))
}

#[test]
fn a_street_in_several_edges_is_traced_to_its_start_and_to_the_next_signal() {
    let scenario = Scenario::new();
    insta::assert_snapshot!(signals(&street(&scenario, ""), ""));
}

#[test]
fn greens_that_differ_in_lefts_count_all_movements_and_one_for_pedestrians_is_left_out() {
    let scenario = Scenario::new();
    let config = crossing(&scenario);
    insta::assert_snapshot!(signals(&config, ""));

    let line: serde_json::Value = serde_json::from_str(&signals(&config, "--json")).unwrap();
    assert_eq!(line["greens_without_vehicles"], serde_json::json!(["rrrrrrG"]));
    assert_eq!(line["phases"].as_array().unwrap().len(), 3);
    assert_eq!(line["warnings"][0]["about"], "rrrrrrG");

    let folder = config.parent().unwrap();
    let args = format!("run --sumocfg {} --methods max-pressure --dry-run", config.display());
    let output = run(folder, &args);
    assert!(output.status.success());
    let notes = stderr(&output);
    assert!(
        notes.contains("signal C: no lane for cars is served by the greens rrrrrrG"),
        "{notes}"
    );
}

fn delay_s(config: &Path) -> f64 {
    let folder = config.parent().unwrap();
    let args = format!(
        "run --sumocfg {} --methods max-pressure --eval-seeds 5 --json --out {}",
        config.display(),
        config.with_extension("results").display()
    );
    let lines = succeed(folder, &args);
    let line = lines.lines().find(|l| l.contains("\"method\":\"max-pressure\"")).unwrap();
    serde_json::from_str::<serde_json::Value>(line).unwrap()["delay_s"].as_f64().unwrap()
}

#[test]
fn max_pressure_is_as_good_on_a_split_network_as_on_the_same_in_one_piece() {
    let flow = |id: &str, edges: &str, vph: u32| {
        format!(
            r#"<flow id="{id}" begin="0" end="1800" vehsPerHour="{vph}" departLane="best"
            departSpeed="max"><route edges="{edges}"/></flow>"#
        )
    };
    let demand = |west: &str, east: &str| {
        [
            flow("through", &format!("{west} {east} be"), 500),
            flow("right", &format!("{west} as"), 200),
            flow("north", "na as", 450),
            flow("side", "mb be", 450),
        ]
        .concat()
    };
    let scenario = Scenario::new();
    let network = [WHOLE_NODES, WHOLE_EDGES, WHOLE_CONNECTIONS];
    let whole = delay_s(&build(&scenario, "whole", network, &demand("w", "e")));
    let split = delay_s(&street(&scenario, &demand("w1 w2 w3", "e1 e2")));
    assert!((split / whole - 1.0).abs() < 0.1, "{split} s split and {whole} s in one piece");
}

#[test]
fn turns_on_red_are_no_phases() {
    let folder = tempfile::tempdir().unwrap();
    let phases = |preset: &str| {
        let said = succeed(
            folder.path(),
            &format!("signals busy smoke --preset {preset} --set signal.left_turns=network --json"),
        );
        let signal: serde_json::Value = serde_json::from_str(said.lines().next().unwrap()).unwrap();
        let phases = signal["phases"].as_array().unwrap().clone();
        phases.into_iter().map(|phase| phase["state"].clone()).collect::<Vec<_>>()
    };
    let field = phases("field");
    assert!(
        field.len() > 1 && !field.iter().any(|s| s.as_str().unwrap().contains('s')),
        "{field:?}"
    );
    assert_eq!(field, phases("resco"));
}
