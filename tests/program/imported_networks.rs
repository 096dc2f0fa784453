//! What imported networks have that generated ones have not: level crossings, signals switched by the clock,
//! links that share a letter.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{run, stderr, stdout, succeed};
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
    let config = scenario(&files, "gate", r#"<trip id="t" depart="0" from="wx" to="ce"/>"#);
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

/// Somebody crosses the street between W and C at P; a side street from D joins behind, and yields.
const CROSSING_NODES: &str = r#"<nodes>
    <node id="W" x="-300" y="0"/> <node id="P" x="0" y="0" type="traffic_light"/>
    <node id="C" x="110" y="0" type="priority"/> <node id="D" x="110" y="-200"/> <node id="E" x="400" y="0"/>
</nodes>"#;

const CROSSING_EDGES: &str = r#"<edges>
    <edge id="wp" from="W" to="P" numLanes="2" priority="9"/> <edge id="pc" from="P" to="C" numLanes="2" priority="9"/>
    <edge id="ce" from="C" to="E" numLanes="2" priority="9"/> <edge id="dc" from="D" to="C" priority="1"/>
</edges>"#;

const CROSSING_ROUTES: &str = r#"<route id="main" edges="wp pc ce"/> <route id="side" edges="dc ce"/>
    <flow id="m" route="main" begin="0" end="600" vehsPerHour="1700" departLane="random"/>
    <flow id="s" route="side" begin="0" end="600" vehsPerHour="150"/>"#;

fn with_program(config: &Path, logic: &str) {
    fs::write(folder(config).join("program.add.xml"), format!("<additional>{logic}</additional>"))
        .unwrap();
    let text = fs::read_to_string(config).unwrap();
    let text = text.replace("</input>", "<additional-files value=\"program.add.xml\"/></input>");
    fs::write(config, text).unwrap();
}

#[test]
fn a_signal_for_a_crosswalk_keeps_its_own_program_under_every_method() {
    let files = Scenario::new();
    files.build("walk", CROSSING_NODES, CROSSING_EDGES, None);
    let config = scenario(&files, "walk", CROSSING_ROUTES);
    let logic = r#"<tlLogic id="P" type="static" programID="walk" offset="0"><phase duration="25" state="GG"/>
        <phase duration="3" state="yy"/><phase duration="30" state="rr"/></tlLogic>"#;
    with_program(&config, logic);
    let methods = "program,max-pressure,actuated,nema";
    succeed(
        folder(&config),
        &format!("run --sumocfg walk.sumocfg --methods {methods} --eval-seeds 1 --quiet --out r"),
    );
    let table = fs::read_to_string(folder(&config).join("r/report/episodes.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let place = rows.next().unwrap().iter().position(|c| *c == "delay_s").unwrap();
    let delays: Vec<&str> = rows.map(|row| row[place]).collect();
    assert_eq!(delays.len(), 5, "{table}");
    assert!(delays.iter().all(|d| *d == delays[0]), "{table}");
}

fn four_arms(files: &Scenario) {
    let places = [("n", 0, 300), ("e", 300, 0), ("s", 0, -300), ("w", -300, 0)];
    let mut nodes = r#"<node id="C" x="0" y="0" type="traffic_light"/>"#.to_owned();
    let (mut edges, mut ways) = (String::new(), String::new());
    for (i, (arm, x, y)) in places.iter().enumerate() {
        nodes += &format!(r#"<node id="{arm}" x="{x}" y="{y}"/>"#);
        edges += &format!(r#"<edge id="{arm}i" from="{arm}" to="C" numLanes="2"/>"#);
        edges += &format!(r#"<edge id="{arm}o" from="C" to="{arm}"/>"#);
        for (turn, lane) in [(3, 0), (2, 0), (1, 1)] {
            let to = places[(i + turn) % 4].0;
            ways +=
                &format!(r#"<connection from="{arm}i" to="{to}o" fromLane="{lane}" toLane="0"/>"#);
        }
    }
    let ways = format!("<connections>{ways}</connections>");
    files.build(
        "arms",
        &format!("<nodes>{nodes}</nodes>"),
        &format!("<edges>{edges}</edges>"),
        Some(&ways),
    );
}

#[test]
fn a_dual_ring_program_offers_the_pairs_that_it_may_show() {
    let files = Scenario::new();
    four_arms(&files);
    let routes = r#"<flow id="a" from="ni" to="so" begin="0" end="600" vehsPerHour="300"/>
        <flow id="b" from="ei" to="so" begin="0" end="600" vehsPerHour="200" departLane="1"/>"#;
    let config = scenario(&files, "arms", routes);
    let phase = |name: u32, state: &str| {
        format!(
            r#"<phase name="{name}" duration="30" minDur="5" maxDur="30" vehext="2" yellow="3" red="1" state="{state}"/>"#
        )
    };
    let states = [
        (1, "rrrrrrrrGrrr"),
        (2, "GGrrrrrrrrrr"),
        (3, "rrrrrrrrrrrG"),
        (4, "rrrGGrrrrrrr"),
        (5, "rrGrrrrrrrrr"),
        (6, "rrrrrrGGrrrr"),
        (7, "rrrrrGrrrrrr"),
        (8, "rrrrrrrrrGGr"),
    ];
    let phases: String = states.iter().map(|(name, state)| phase(*name, state)).collect();
    let rings = [
        ("ring1", "1,2,3,4"),
        ("ring2", "5,6,7,8"),
        ("barrierPhases", "4,8"),
        ("barrier2Phases", "2,6"),
        ("minRecall", "2,6"),
    ];
    let rings: String =
        rings.iter().map(|(k, v)| format!(r#"<param key="{k}" value="{v}"/>"#)).collect();
    with_program(
        &config,
        &format!(
            r#"<tlLogic id="C" type="NEMA" programID="rings" offset="0">{rings}{phases}</tlLogic>"#
        ),
    );
    let text = succeed(folder(&config), "signals arms.sumocfg");
    let shown: Vec<&str> =
        (text.lines().map(str::trim).skip_while(|l| !l.starts_with("phase ")).skip(1))
            .take_while(|l| !l.starts_with("warning"))
            .filter_map(|l| l.split_whitespace().nth(1))
            .collect();
    let pairs = [
        "rrGrrrrrGrrr", "GGrrrrGGrrrr", "rrrrrGrrrrrG", "rrrGGrrrrGGr", "rrrrrrGGGrrr",
        "GGGrrrrrrrrr", "rrrrrrrrrGGG", "rrrGGGrrrrrr",
    ];
    assert_eq!(shown, pairs, "{text}");
    succeed(
        folder(&config),
        "run --sumocfg arms.sumocfg --methods program,nema --eval-seeds 1 --quiet --out r",
    );
    let plans = fs::read_to_string(folder(&config).join("r/report/plans.csv")).unwrap();
    let cabinet = fs::read_to_string(folder(&config).join("r/report/cabinet.csv")).unwrap();
    assert_eq!(cabinet.matches(",nema,0,C,phase,").count(), 8, "{cabinet}");
    // What is made of the program serves everything with four of the pairs.
    let baseline = plans.lines().filter(|l| l.contains(",baseline,")).count();
    assert_eq!(baseline, 4, "{plans}");
}

const TWO: &str = r#"<nodes>
    <node id="W" x="-300" y="0"/> <node id="E" x="900" y="0"/>
    <node id="C" x="0" y="0" type="traffic_light"/> <node id="D" x="400" y="0" type="traffic_light"/>
    <node id="A" x="0" y="300"/> <node id="B" x="400" y="300"/>
</nodes>"#;

const STREET: &str = r#"<edges>
    <edge id="wc" from="W" to="C"/> <edge id="cd" from="C" to="D"/> <edge id="de" from="D" to="E"/>
    <edge id="ac" from="A" to="C"/> <edge id="bd" from="B" to="D"/>
</edges>"#;

#[test]
fn a_signal_that_flashes_is_dark_or_closed_keeps_its_program_and_others_are_controlled() {
    let files = Scenario::new();
    files.build("two", TWO, STREET, None);
    let routes = r#"<flow id="f" from="wc" to="de" begin="0" end="300" period="9"/>"#;
    let config = scenario(&files, "two", routes);
    let net = folder(&config).join("two.net.xml");
    let whole = fs::read_to_string(&net).unwrap();
    let start = whole.find("<tlLogic id=\"D\"").unwrap();
    let end = start + whole[start..].find("</tlLogic>").unwrap();
    for letter in ["o", "O"] {
        let logic = &whole[start..end];
        let head = &logic[..=logic.find('>').unwrap()];
        let links = logic.split("state=\"").nth(1).unwrap().find('"').unwrap();
        let phase = format!("<phase duration=\"60\" state=\"{}\"/>", letter.repeat(links));
        fs::write(&net, format!("{}{head}{phase}{}", &whole[..start], &whole[end..])).unwrap();
        let text = succeed(folder(&config), "signals two.sumocfg");
        let heads: Vec<&str> = text.lines().filter(|l| l.starts_with("signal ")).collect();
        assert_eq!(heads, ["signal C"]);
        let expected = "no program of these signals is ever green for cars, since they flash or are dark or closed; they \
                        keep it under every method: D";
        assert!(text.lines().any(|l| l == expected), "{text}");
        let command =
            "run --sumocfg two.sumocfg --methods program,max-pressure --eval-seeds 1 --out";
        let output = run(folder(&config), &format!("{command} {letter}"));
        let said = stderr(&output);
        assert!(output.status.success() && said.contains(expected), "{said}");
    }
}

#[test]
fn a_signal_that_an_additional_file_switches_off_stays_dark_unless_the_clock_may_switch_it_on() {
    let files = Scenario::new();
    files.build("two", TWO, STREET, None);
    let routes = r#"<flow id="f" from="wc" to="de" begin="0" end="300" period="9"/>"#;
    let config = scenario(&files, "two", routes);
    let text = fs::read_to_string(&config).unwrap();
    let end = text.rfind("</").unwrap();
    let more = format!("{}<additional-files value=\"x.add.xml\"/>{}", &text[..end], &text[end..]);
    fs::write(&config, more).unwrap();
    let off = r#"<tlLogic id="D" type="static" programID="off"/>"#;
    let additional = folder(&config).join("x.add.xml");
    fs::write(&additional, format!("<additional>{off}</additional>")).unwrap();
    let told = succeed(folder(&config), "signals two.sumocfg");
    let heads: Vec<&str> = told.lines().filter(|l| l.starts_with("signal ")).collect();
    assert_eq!(heads, ["signal C"]);
    assert!(told.contains("and methods control them where it is removed: D"), "{told}");
    let command =
        "run --sumocfg two.sumocfg --methods program,max-pressure --eval-seeds 1 --out out";
    assert!(run(folder(&config), command).status.success());
    let clock = r#"<WAUT id="w" refTime="0" startProg="off"><wautSwitch time="60" to="0"/></WAUT>
        <wautJunction wautID="w" junctionID="D"/>"#;
    fs::write(&additional, format!("<additional>{off}{clock}</additional>")).unwrap();
    let said = stderr(&run(folder(&config), "signals two.sumocfg"));
    assert!(said.contains("signal D: the program that runs at the start never shows"), "{said}");
    assert!(said.contains("pass --begin with the time of that switch"), "{said}");
}

#[test]
fn quiet_prints_how_many_tasks_failed_and_the_first_reason_in_one_line() {
    let files = Scenario::new();
    // SUMO checks whether a route is connected only when the vehicle is about to depart.
    let gap = r#"<vehicle id="x" depart="10"><route edges="WA BE"/></vehicle>"#;
    let config = scenario(&files, "net", gap);
    let command = "run --sumocfg net.sumocfg --methods program --eval-seeds 1 --quiet --out out";
    let output = run(folder(&config), command);
    let said = stderr(&output);
    assert_eq!((output.status.code(), stdout(&output)), (Some(3), String::new()), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.starts_with("error: 2 of 2 tasks failed; the first, baseline on net: "), "{said}");
    assert!(said.contains("Vehicle 'x' has no valid route"), "{said}");
}

#[test]
fn dead_phases_of_a_program_change_no_choice() {
    let files = Scenario::new();
    let config = scenario(&files, "net", r#"<trip id="t" depart="0" from="WA" to="BE"/>"#);
    let folder = folder(&config);
    let before = succeed(folder, "signals net.sumocfg");
    let path = folder.join("net.net.xml");
    let net = fs::read_to_string(&path).unwrap();
    let end = net.find("</tlLogic>").unwrap();
    let last = net[..end].rfind("<phase ").unwrap();
    let links = net[last..end].split("state=\"").nth(1).unwrap().find('"').unwrap();
    let dead = format!("G{}", "r".repeat(links - 1));
    let phase = format!("<phase duration=\"5\" state=\"{dead}\"/>");
    let (head, rest) = net.split_at(last);
    let rest = rest.replacen("<phase ", "<phase next=\"0\" ", 1);
    let rest = rest.replacen("</tlLogic>", &format!("{phase}</tlLogic>"), 1);
    fs::write(&path, format!("{head}{rest}")).unwrap();
    let after = succeed(folder, "signals net.sumocfg");
    assert_eq!(after, before);
}
