//! Networks of several signals and of signals over several nodes.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr, succeed};
use crate::fixture::Scenario;
use crate::folder::rows as rows_of;
use crate::outcomes::record;
use crate::plans_sumo::delay_s;
use crate::report_links::lead_somewhere;
use serde_json::Value;

/// A street that crosses a divided one, whose two nodes are 20 m apart and one signal.
const DIVIDED_NODES: &str = r#"<nodes>
    <node id="w" x="-300" y="0"/> <node id="e" x="320" y="0"/>
    <node id="a" x="0" y="0" type="traffic_light" tl="J"/> <node id="b" x="20" y="0" type="traffic_light" tl="J"/>
    <node id="an" x="0" y="300"/> <node id="as" x="0" y="-300"/>
    <node id="bn" x="20" y="300"/> <node id="bs" x="20" y="-300"/>
</nodes>"#;

const DIVIDED_EDGES: &str = r#"<edges>
    <edge id="wa" from="w" to="a" numLanes="2"/> <edge id="ab" from="a" to="b" numLanes="2"/>
    <edge id="be" from="b" to="e" numLanes="2"/> <edge id="eb" from="e" to="b" numLanes="2"/>
    <edge id="ba" from="b" to="a" numLanes="2"/> <edge id="aw" from="a" to="w" numLanes="2"/>
    <edge id="na" from="an" to="a"/> <edge id="as" from="a" to="as"/>
    <edge id="sb" from="bs" to="b"/> <edge id="bn" from="b" to="bn"/>
</edges>"#;

/// The side streets have green while what is between the nodes has red, and then that has green alone.
const DIVIDED_PROGRAM: &str = r#"<additional><tlLogic id="J" type="static" programID="own" offset="0">
    <phase duration="40" state="rrrGGgGGGGGGrrrGGg"/> <phase duration="3" state="rrryyyyyyyyyrrryyy"/>
    <phase duration="22" state="GGGrrrrrrrrrGGGrrr"/> <phase duration="3" state="yyyrrrrrrrrryyyrrr"/>
    <phase duration="9" state="rrrGGGrrrrrrrrrGGG"/> <phase duration="3" state="rrryyyrrrrrrrrryyy"/>
</tlLogic></additional>"#;

fn flows(flows: &[(&str, &str, u32)], end_s: u32) -> String {
    let flow = |(from, to, vph): &(&str, &str, u32)| {
        format!(
            "<flow id=\"{from}-{to}\" begin=\"0\" end=\"{end_s}\" from=\"{from}\" to=\"{to}\" vehsPerHour=\"{vph}\"/>"
        )
    };
    flows.iter().map(flow).collect()
}

fn with(config: &Path, more: &str, end_s: u32) {
    let text = fs::read_to_string(config).unwrap();
    let end = format!("{more}</input><end value=\"{end_s}\"/>");
    fs::write(config, text.replace("</input>", &end)).unwrap();
}

#[test]
fn max_pressure_knows_what_stands_between_two_nodes_of_a_signal() {
    let files = Scenario::new();
    files.build("divided", DIVIDED_NODES, DIVIDED_EDGES, None);
    fs::write(files.file("own", "add"), DIVIDED_PROGRAM).unwrap();
    let (main, side, turn) = (400, 130, 120);
    let routes = flows(
        &[
            ("wa", "be", main),
            ("eb", "aw", main),
            ("na", "as", side),
            ("sb", "bn", side),
            ("na", "be", turn),
            ("sb", "aw", turn),
            ("wa", "bn", turn),
            ("eb", "as", turn),
        ],
        900,
    );
    let config = files.options("divided", "divided", &routes).config;
    with(&config, "<additional-files value=\"own.add.xml\"/>", 900);
    let folder = config.parent().unwrap();
    // What comes to the lanes of 12 m is seen before.
    let text = succeed(folder, "signals divided.sumocfg");
    assert!(text.contains("ab_0") && !text.contains("seen for"), "{text}");
    let methods = "--methods program,max-pressure --eval-seeds 2 --quiet --out out";
    succeed(folder, &format!("run --sumocfg divided.sumocfg {methods}"));
    let delay_s =
        |task: usize| record(&folder.join("out"), task)[0]["metrics"]["delay_s"].as_f64().unwrap();
    let (program_s, pressure_s) = (delay_s(1), delay_s(2));
    // 67.6 s and 17.0 s with SUMO 1.15; 50.8 s before, with one of the two episodes stuck.
    assert!(pressure_s < 25.0 && pressure_s < program_s, "{pressure_s} s, program {program_s} s");
}

fn street(files: &Scenario, end_s: u32) -> std::path::PathBuf {
    let (mut nodes, mut edges) = (String::new(), String::new());
    let row = ["W", "A", "B", "C", "E"];
    for (i, id) in row.iter().enumerate() {
        let x = 300 * i;
        let kind = if (1..4).contains(&i) { "traffic_light" } else { "priority" };
        nodes += &format!("<node id=\"{id}\" x=\"{x}\" y=\"0\" type=\"{kind}\"/>");
        if (1..4).contains(&i) {
            for (side, y) in [("n", 250), ("s", -250)] {
                nodes += &format!("<node id=\"{side}{id}\" x=\"{x}\" y=\"{y}\"/>");
                edges += &format!(
                    "<edge id=\"{side}{id}in\" from=\"{side}{id}\" to=\"{id}\"/>\
                     <edge id=\"{side}{id}out\" from=\"{id}\" to=\"{side}{id}\"/>"
                );
            }
        }
    }
    for pair in row.windows(2) {
        for (a, b) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            edges += &format!("<edge id=\"{a}{b}\" from=\"{a}\" to=\"{b}\" numLanes=\"2\"/>");
        }
    }
    let (nodes, edges) = (format!("<nodes>{nodes}</nodes>"), format!("<edges>{edges}</edges>"));
    files.build("street", &nodes, &edges, None);
    let mut all = vec![("WA", "CE", 500), ("EC", "AW", 400)];
    for (a, b) in [("nAin", "sAout"), ("sBin", "nBout"), ("nCin", "sCout")] {
        all.push((a, b, 150));
    }
    let config = files.options("street", "street", &flows(&all, end_s)).config;
    with(&config, "", end_s);
    config
}

#[test]
fn rings_keep_to_a_common_cycle_and_the_cabinet_is_told_cycle_offset_and_splits() {
    let files = Scenario::new();
    let config = street(&files, 450);
    let folder = config.parent().unwrap();
    let methods = "--methods nema,coordinated,fixed-time --eval-seeds 2 --set coordinated.simulations=8 \
                   --set fixed_time.simulations=8";
    succeed(
        folder,
        &format!("run --sumocfg street.sumocfg --preset field {methods} --quiet --out out"),
    );
    let records: Vec<Vec<Value>> = (0..4).map(|task| record(&folder.join("out"), task)).collect();
    let of = |method: &str| records.iter().find(|rows| rows[0]["method"] == method).unwrap();
    let programs = of("coordinated")[0]["programs"].as_array().unwrap();
    assert_eq!(programs.len(), 3);
    for program in programs {
        assert_eq!(program["cycle_s"], programs[0]["cycle_s"]);
        let phases = program["rings"].as_array().unwrap();
        for ring in [1, 2] {
            let own = phases.iter().filter(|phase| phase["ring"] == ring);
            let splits_s: u64 = own.map(|phase| phase["split_s"].as_u64().unwrap()).sum();
            assert_eq!(splits_s, program["cycle_s"].as_u64().unwrap(), "{phases:?}");
        }
        let held: Vec<&Value> = phases.iter().filter(|p| p["coordinated"] == true).collect();
        assert_eq!(held.len(), 2, "{phases:?}");
        // They are those of the street, which has two lanes per direction.
        assert!(held.iter().all(|phase| phase["movements"][0].to_string().contains("BT")));
        assert!(held.iter().any(|phase| phase["movements"][0] == "EBT"), "{held:?}");
    }
    // The episode once more, from the stages in the record; a seed that goes another way is an error.
    succeed(folder, "routes --run out --point street --method coordinated --out ev");
    let rows = of("coordinated");
    let row = rows.iter().find(|row| row["kind"] == "evaluation").unwrap();
    assert_eq!(row["metrics"]["delay_s"], delay_s(folder, "-c ev/episode.sumocfg"));
    // Free rings have no cycle.
    assert!(of("nema")[0]["programs"][0].get("cycle_s").is_none());
    let mut told = rows_of(&folder.join("out/report/cabinet.csv"));
    told.retain(|row| row["method"] == "coordinated");
    assert!(!told.is_empty());
    for row in told {
        assert_eq!(row["control"], "coordinated");
        assert_eq!(row["cycle_s"], programs[0]["cycle_s"].to_string());
        assert!(row["offset_s"].parse::<f64>().is_ok() && !row["reference"].is_empty());
    }
    let page = fs::read_to_string(folder.join("out/report/index.html")).unwrap();
    assert!(page.contains("All plans, to print"), "the page names no sheets to print");
    assert!(page.contains("Time-space diagram of coordinated"), "the page has no diagram");
    let sheets = fs::read_to_string(folder.join("out/report/plans/street.html")).unwrap();
    let cycle = format!("coordinated, cycle {} s, offset", programs[0]["cycle_s"]);
    assert!(sheets.contains(&cycle), "the sheet says nothing of the cycle");
    for signal in ["A", "B", "C"] {
        assert!(sheets.contains(&format!("<h2>Signal {signal}, ")), "no sheet of {signal}");
    }
    // Tables and UTDF are for point MDPs of one signal.
    assert!(!folder.join("out/report/plans/coordinated.csv").exists());
    assert_eq!(lead_somewhere(&folder.join("out/report")), 2);
    // The street has travel times per direction.
    let mut both = rows_of(&folder.join("out/report/corridors.csv"));
    both.retain(|row| row["method"] == "fixed-time");
    let told: Vec<_> = both.iter().map(|row| (&*row["direction"], &*row["signals"])).collect();
    assert_eq!(told, [("EB", "A B C"), ("WB", "C B A")]);
    for row in both {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        // 600 m between the stop lines at 50 km/h, and some 290 m before.
        let (travel_s, delay_s) = (number("travel_s"), number("delay_s"));
        assert!((travel_s - delay_s - 64.0).abs() < 3.0, "{row:?}");
        assert!(delay_s > 0.0 && number("vehicles_per_episode") > 30.0, "{row:?}");
        assert!(number("travel_s_low") <= travel_s && travel_s <= number("travel_s_high"));
    }
}

#[test]
fn a_signal_alone_cannot_be_coordinated_and_the_message_says_what_to_run() {
    let folder = tempfile::tempdir().unwrap();
    let args = "run smoke --methods coordinated --eval-seeds 1 --set demand.horizon_s=60 --out out";
    let output = run(folder.path(), args);
    assert_eq!(output.status.code(), Some(3));
    let text = stderr(&output);
    assert!(text.contains("nothing to coordinate; run nema"), "{text}");
}
