//! What imported networks have that generated ones have not: level crossings, signals switched by the clock,
//! links that share a letter.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{run, stderr, succeed};
use crate::fixture::Scenario;

/// A street that crosses a railway at X and comes to a signal at C.
const NODES: &str = r#"<nodes>
    <node id="X" x="0" y="0" type="rail_crossing"/> <node id="N" x="0" y="400"/>
    <node id="S" x="0" y="-400"/> <node id="W" x="-300" y="0"/>
    <node id="C" x="300" y="0" type="traffic_light"/> <node id="E" x="600" y="0"/>
    <node id="A" x="300" y="300"/> <node id="B" x="300" y="-300"/>
</nodes>"#;

const EDGES: &str = r#"<edges>
    <edge id="nx" from="N" to="X" allow="rail" speed="30"/>
    <edge id="xs" from="X" to="S" allow="rail" speed="30"/>
    <edge id="wx" from="W" to="X" disallow="rail"/> <edge id="xc" from="X" to="C" disallow="rail"/>
    <edge id="ce" from="C" to="E" disallow="rail"/> <edge id="ac" from="A" to="C" disallow="rail"/>
    <edge id="cb" from="C" to="B" disallow="rail"/>
</edges>"#;

/// Writes a configuration that ends after ten minutes.
fn scenario(scenario: &Scenario, network: &str, routes: &str) -> PathBuf {
    let config = scenario.options(network, network, routes).config;
    let text = fs::read_to_string(&config).unwrap();
    fs::write(&config, text.replace("</input>", "</input><end value=\"600\"/>")).unwrap();
    config
}

fn folder(config: &Path) -> &Path {
    config.parent().unwrap()
}

#[test]
fn a_level_crossing_is_no_signal_to_control() {
    let files = Scenario::new();
    files.build("gate", NODES, EDGES, None);
    let config = scenario(&files, "gate", "");
    let text = succeed(folder(&config), "signals gate.sumocfg");
    let heads: Vec<&str> = text.lines().filter(|l| l.starts_with("signal ")).collect();
    assert_eq!(heads, ["signal C"]);
    // Nobody sees through the gate.
    assert!(text.lines().any(|l| l.trim().starts_with("xc_0") && l.ends_with(" -")), "{text}");
    let expected = "trains steer these level crossings, and no method controls them: X";
    assert!(text.lines().any(|l| l == expected), "{text}");
    let lines = succeed(folder(&config), "signals gate.sumocfg --json");
    assert_eq!(lines.lines().count(), 1, "{lines}");
    let output = run(folder(&config), "run --sumocfg gate.sumocfg --methods actuated --dry-run");
    let notes = stderr(&output);
    assert!(notes.contains(&format!("gate.sumocfg: {expected}")), "{notes}");
}

#[test]
fn the_forecast_counts_the_simulations_of_every_signal() {
    let files = Scenario::new();
    let config = scenario(&files, "net", "");
    let methods = "--methods fixed-time,max-pressure --eval-seeds 1 --dry-run";
    let output = run(folder(&config), &format!("run --sumocfg net.sumocfg {methods}"));
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
    // Three signals with 24 each, and an evaluation each of these two and the baseline.
    assert!(text.contains("75 episodes at most"), "{text}");
}
