//! A small scenario in a temporary folder, built with netconvert.
//!
//! ```text
//!            N                M
//!            |                |      all edges lead away from W, N and P
//!  W ======= A -------------- B ---- E
//!            |
//!        P - S - Q                   A, B and S have signals
//!            |
//!            X
//! ```
//!
//! The right turn from W at A is not controlled, although its lane also leads straight on.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use tempfile::TempDir;
use tsc_family::traffic::sim::StartOptions;

pub(crate) const NODES: &str = r#"<nodes>
    <node id="W" x="-300" y="0"/> <node id="E" x="600" y="0"/> <node id="N" x="0" y="300"/>
    <node id="M" x="300" y="200"/> <node id="P" x="-200" y="-200"/>
    <node id="Q" x="200" y="-200"/> <node id="X" x="0" y="-400"/>
    <node id="A" x="0" y="0" type="traffic_light"/>
    <node id="B" x="300" y="0" type="traffic_light"/>
    <node id="S" x="0" y="-200" type="traffic_light"/>
</nodes>"#;

pub(crate) const EDGES: &str = r#"<edges>
    <edge id="WA" from="W" to="A" numLanes="2"/> <edge id="NA" from="N" to="A"/>
    <edge id="AB" from="A" to="B"/> <edge id="AS" from="A" to="S"/>
    <edge id="MB" from="M" to="B"/> <edge id="BE" from="B" to="E"/>
    <edge id="PS" from="P" to="S"/> <edge id="SQ" from="S" to="Q"/>
    <edge id="SX" from="S" to="X"/>
</edges>"#;

const CONNECTIONS: &str = r#"<connections>
    <connection from="WA" to="AS" fromLane="0" toLane="0" uncontrolled="true"/>
    <connection from="WA" to="AB" fromLane="0" toLane="0"/>
    <connection from="WA" to="AB" fromLane="1" toLane="0"/>
</connections>"#;

/// A scenario on disk; the folder goes when it is dropped.
pub(crate) struct Scenario {
    folder: TempDir,
}

impl Scenario {
    pub(crate) fn new() -> Self {
        let scenario = Self { folder: TempDir::new().expect("a temporary folder") };
        scenario.build("net", NODES, EDGES, Some(CONNECTIONS));
        scenario
    }

    pub(crate) fn build(&self, name: &str, nodes: &str, edges: &str, connections: Option<&str>) {
        self.build_with(name, nodes, edges, connections, &[]);
    }

    pub(crate) fn build_with(
        &self,
        name: &str,
        nodes: &str,
        edges: &str,
        connections: Option<&str>,
        options: &[&str],
    ) {
        let mut netconvert = Command::new(netconvert());
        netconvert.args(["-X", "never", "--no-turnarounds"]).args(options);
        netconvert.arg("-o").arg(self.file(name, "net"));
        let inputs =
            [("nod", "-n", Some(nodes)), ("edg", "-e", Some(edges)), ("con", "-x", connections)];
        for (ending, option, text) in inputs {
            if let Some(text) = text {
                fs::write(self.file(name, ending), text).expect("a writable folder");
                netconvert.arg(option).arg(self.file(name, ending));
            }
        }
        let output = netconvert.output().expect("netconvert is installed with SUMO");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    pub(crate) fn options(&self, network: &str, name: &str, routes: &str) -> StartOptions {
        fs::write(self.file(name, "rou"), format!("<routes>{routes}</routes>")).expect("writable");
        let config = self.folder.path().join(format!("{name}.sumocfg"));
        let text = format!(
            r#"<configuration><input>
            <net-file value="{network}.net.xml"/><route-files value="{name}.rou.xml"/>
            </input></configuration>"#
        );
        fs::write(&config, text).expect("writable");
        StartOptions { config, ..StartOptions::default() }
    }

    pub(crate) fn file(&self, name: &str, ending: &str) -> PathBuf {
        self.folder.path().join(format!("{name}.{ending}.xml"))
    }
}

/// Returns the netconvert beside libsumo, if SUMO_HOME has one, else the one in the path.
fn netconvert() -> PathBuf {
    env::var_os("SUMO_HOME")
        .map(|home| PathBuf::from(home).join("bin/netconvert"))
        .filter(|program| program.exists())
        .unwrap_or_else(|| "netconvert".into())
}
