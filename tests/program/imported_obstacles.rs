//! All that is in the way of a scenario is said at once, in the same words by every command, with the options that pass it;
//! what can be replaced is, with a warning; and what runs then is what plain `sumo` runs.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::{run, stderr, stdout, succeed};
use crate::imported_files::{RUN, city, configure, files, rows};
use tsc_family::traffic::sim::tripinfo;

/// What a command says of its failure, without what SUMO says.
fn error(folder: &Path, command: &str, code: i32) -> String {
    let output = run(folder, command);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{command}: {said}");
    let start = said.find("error: ").unwrap_or_else(|| panic!("{command}: {said}"));
    assert_eq!(stdout(&output), "", "{command}");
    said[start..].to_owned()
}

/// What all commands say, which has to be the same, before anything is written.
fn refused(folder: &Path) -> String {
    let before = files(folder);
    let said = error(folder, &format!("{RUN} out"), 2);
    for command in
        [&*format!("{RUN} out --dry-run"), "run --sumocfg a.sumocfg --dry-run", "signals a.sumocfg"]
    {
        assert_eq!(error(folder, command, 2), said, "{command}");
    }
    assert_eq!(files(folder), before, "nothing is written");
    said
}

#[test]
fn all_that_is_in_the_way_is_said_at_once_and_its_options_pass_it() {
    let (folder, lane) = city();
    let folder = folder.path();
    let add = format!(
        "<additional>\n<calibrator id='k' lane='{lane}' pos='0' output='k.txt'/>\
         <e1Detector id='d' lane='{lane}' pos='1' freq='10' file='mine.txt'/></additional>"
    );
    fs::write(folder.join("add.xml"), add).unwrap();
    let options = "<net-file value='n.xml'/><routes value='r.xml'/><a v='add.xml'/>\
        <step-length v='0.3'/><max-depart-delay value='20'/><remote-port value='8813'/>\
        <new-thing value='1'/><e1-output value='x'/>";
    fs::write(folder.join("a.sumocfg"), format!("<configuration>{options}</configuration>"))
        .unwrap();
    let said = refused(folder);
    assert!(said.starts_with("error: 4 things are in the way:\n"), "{said}");
    for expected in [
        "a.sumocfg: option <new-thing>: it is none that is known to be safe",
        "add.xml: line 2: <calibrator> adds or removes vehicles, and these differ between methods",
        "a.sumocfg: no end; the last vehicle or flow that is known departs at",
        "a.sumocfg: a step-length of 0.3 s does not divide a second",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    let last = said.trim_end().lines().last().unwrap();
    assert!(last.contains("--accept calibrators,unknown-options for all of it"), "{last}");
    let pass = "--end 120 --step-length 1 --accept calibrators,unknown-options";
    let output = run(folder, &format!("{} out {pass}", RUN.replace("--quiet", "")));
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    for warning in [
        "warning: a.sumocfg: max-depart-delay = 20 is taken as -1",
        "warning: a.sumocfg: remote-port = 8813 is left out: nothing connects",
        "warning: a.sumocfg: accepted: add.xml: line 2: <calibrator>",
        "warning: a.sumocfg: --end 120 in place of no end",
    ] {
        assert_eq!(said.matches(warning).count(), 1, "{warning}: {said}");
    }
    let text = fs::read_to_string(folder.join("out/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&text).unwrap();
    let given = &manifest["identity"]["points"][0]["given"];
    assert_eq!((&given["end_s"], &given["step_length_s"]), (&120.0.into(), &1.0.into()));
    let warnings = manifest["provenance"]["warnings"].as_array().unwrap();
    let has = |text: &str| warnings.iter().any(|w| w.as_str().unwrap().contains(text));
    assert!(has("max-depart-delay = 20 is taken as -1"), "{warnings:?}");
    let page = fs::read_to_string(folder.join("out/report/index.html")).unwrap();
    assert!(page.contains("max-depart-delay = 20 is taken as -1"), "the page has the warnings");
    // Another end is another run.
    let other = format!("{RUN} out {}", pass.replace("120", "60"));
    let said = error(folder, &other, 5);
    assert!(said.contains("the command line says other things of the scenario a"), "{said}");
}

#[test]
fn what_only_a_change_of_the_files_passes_is_named_with_the_rest() {
    let (folder, _) = city();
    let folder = folder.path();
    configure(folder, "<net-file value='n.xml'/><routes value='r.xml,gone.xml'/><mesosim v='1'/>");
    let said = refused(folder);
    assert!(
        said.contains("gone.xml: the scenario names it, but it cannot be read; add it"),
        "{said}"
    );
    assert!(said.contains("the mesoscopic model has no lanes"), "{said}");
    let last = said.trim_end().lines().last().unwrap();
    assert_eq!(last, "pass --accept microscopic for the rest, once the files are changed");
}

#[test]
fn what_sumo_itself_refuses_is_said_with_the_rest() {
    let (folder, _) = city();
    let folder = folder.path();
    let net = fs::read_to_string(folder.join("n.xml")).unwrap();
    let newer = net.replacen("<net ", "<!-- Eclipse SUMO netconvert Version 9.87.0 -->\n<net ", 1);
    fs::write(folder.join("n.xml"), newer).unwrap();
    let unknown = "<routes><route id='r' edges='nowhere'/><vehicle id='v' depart='triggered' \
                   route='r'/></routes>";
    fs::write(folder.join("wrong.xml"), unknown).unwrap();
    let options = "<net-file value='n.xml'/><routes value='wrong.xml'/>";
    fs::write(folder.join("a.sumocfg"), format!("<c>{options}</c>")).unwrap();
    let said = refused(folder);
    assert!(said.starts_with("error: 2 things are in the way:\n"), "{said}");
    assert!(said.contains("a.sumocfg: no end; pass --end 3600"), "{said}");
    assert!(said.contains("a.sumocfg: SUMO cannot load it: The edge 'nowhere'"), "{said}");
    assert!(said.contains("n.xml was written by SUMO 9.87, and SUMO"), "{said}");
    assert!(said.contains("docs/install.md says how to use another SUMO"), "{said}");
}

/// Two edges before a delay-based signal whose lengths differ by less than SUMO tells apart: on its detector over both a
/// build of SUMO with assertions crashes.
const NEARLY_AS_LONG: [(&str, &str); 2] = [
    (
        "n.nod.xml",
        "<nodes><node id='a' x='-200' y='0'/><node id='b' x='-100' y='0'/><node id='s' x='0' y='-100'/>\
         <node id='c' x='0' y='0' type='traffic_light' tlType='delay_based'/><node id='d' x='100' y='0'/></nodes>",
    ),
    (
        "n.edg.xml",
        "<edges><edge id='ab' from='a' to='b' length='50.43'/><edge id='bc' from='b' to='c' length='50.38'/>\
         <edge id='cd' from='c' to='d'/><edge id='sc' from='s' to='c'/></edges>",
    ),
];

#[test]
fn a_scenario_that_sumo_crashes_on_is_named_with_the_rest() {
    let (folder, _) = city();
    let folder = folder.path();
    for (name, text) in NEARLY_AS_LONG {
        fs::write(folder.join(name), text).unwrap();
    }
    let made = Command::new("netconvert")
        .args(["-n", "n.nod.xml", "-e", "n.edg.xml", "-o", "n.xml", "-X", "never"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", stderr(&made));
    fs::write(folder.join("r.xml"), "<routes><trip id='t' depart='0' from='ab' to='cd'/></routes>")
        .unwrap();
    configure(folder, "<net-file value='n.xml'/><routes value='r.xml'/>");
    if run(folder, "signals a.sumocfg").status.success() {
        // A build without assertions loads it.
        return;
    }
    let said = refused(folder);
    assert!(said.contains("a.sumocfg: SUMO crashes on it ("), "{said}");
    assert!(said.contains("another length (n.xml: signal c)"), "{said}");
    fs::write(folder.join("a.sumocfg"), "<c><net-file value='n.xml'/><r v='r.xml'/></c>").unwrap();
    let said = refused(folder);
    assert!(said.contains("no end;") && said.contains("SUMO crashes on it ("), "{said}");
}

#[test]
fn a_scenario_of_people_alone_is_refused_by_a_run_and_shows_its_signals() {
    let (folder, lane) = city();
    let folder = folder.path();
    let edge = lane.split('_').next().unwrap();
    let walks = format!("<person id='p' depart='0'><walk edges='{edge}'/></person>");
    fs::write(folder.join("r.xml"), format!("<routes>{walks}</routes>")).unwrap();
    configure(folder, "<net-file value='n.xml'/><routes value='r.xml'/>");
    let before = files(folder);
    let said = error(folder, &format!("{RUN} out"), 2);
    let expected = "a.sumocfg: none of its files has a vehicle, only people or containers (r.xml)";
    assert!(said.contains(expected), "{said}");
    assert_eq!(files(folder), before, "nothing is written");
    succeed(folder, "signals a.sumocfg");
}

#[test]
fn options_on_scenarios_have_no_effect_without_one() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["run smoke --end 60 --dry-run", "signals busy smoke --accept calibrators"] {
        let said = error(folder.path(), command, 2);
        assert!(said.contains("has no effect: no SUMO configuration is given"), "{said}");
    }
}

/// The delay that plain `sumo` gives with the seed of a task's only episode.
fn plain_delay_s(folder: &Path, results: &str, task: usize, options: &str) -> (Value, f64) {
    let text = fs::read_to_string(folder.join(format!("{results}/done/000/{task}.jsonl"))).unwrap();
    let row: Value = serde_json::from_str(text.lines().nth(1).unwrap()).unwrap();
    let command = format!(
        "-c a.sumocfg --seed {} --time-to-teleport -1 --xml-validation never {options} \
         --tripinfo-output trips.xml --tripinfo-output.write-unfinished \
         --tripinfo-output.write-undeparted",
        row["seed"]
    );
    let output =
        Command::new("sumo").args(command.split_whitespace()).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let trips = tripinfo::read(&folder.join("trips.xml")).unwrap();
    (row["metrics"]["delay_s"].clone(), trips.delay_s / f64::from(trips.vehicles))
}

#[test]
fn a_scenario_with_outputs_and_an_end_of_the_command_line_is_what_plain_sumo_runs() {
    let (folder, lane) = city();
    let folder = folder.path();
    let add = format!(
        "<additional><e1Detector id='d' lane='{lane}' pos='1' freq='10' file='d.txt'/>\
         <timedEvent type='SaveTLSStates' source='{}' dest='t.txt'/></additional>",
        signal(folder)
    );
    fs::write(folder.join("add.xml"), add).unwrap();
    let options = "<net-file value='n.xml'/><routes value='r.xml'/><a v='add.xml'/>\
        <max-depart-delay v='20'/>";
    fs::write(folder.join("a.sumocfg"), format!("<c>{options}</c>")).unwrap();
    succeed(folder, &format!("{RUN} out --end 200 --begin 10"));
    let (recorded, plain) =
        plain_delay_s(folder, "out", 1, "--begin 10 --end 200 --max-depart-delay -1");
    assert_eq!(recorded, plain);
}

/// The id of the network's only signal.
fn signal(folder: &Path) -> String {
    let net = fs::read_to_string(folder.join("n.xml")).unwrap();
    net.split("<tlLogic id=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
}

/// Writes a scenario whose signal changes from a program of short greens at the start to the network's own after so many
/// seconds.
fn switching(folder: &Path, after_s: u32) {
    let net = fs::read_to_string(folder.join("n.xml")).unwrap();
    let logic = net.split("<tlLogic ").nth(1).unwrap().split("</tlLogic>").next().unwrap();
    let field =
        |name: &str| logic.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap();
    let own = field("programID");
    let states = logic.split("state=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    let phase = |state: &str| {
        let duration = if state.contains('y') { 3 } else { 8 };
        format!("<phase duration='{duration}' state='{state}'/>")
    };
    let phases: String =
        states.filter(|state| state.contains(['G', 'g', 'y'])).map(phase).collect();
    let id = signal(folder);
    let text = format!(
        "<additional><tlLogic id='{id}' type='static' programID='night' offset='0'>{phases}</tlLogic>\
         <WAUT id='w' refTime='0' startProg='night'><wautSwitch time='{after_s}' to='{own}'/></WAUT>\
         <wautJunction wautID='w' junctionID='{id}'/></additional>"
    );
    fs::write(folder.join("plan.xml"), text).unwrap();
    let options = "<net-file value='n.xml'/><routes value='r.xml'/><a v='plan.xml'/>";
    fs::write(folder.join("a.sumocfg"), format!("<c>{options}<e v='400'/></c>")).unwrap();
}

#[test]
fn a_day_plan_runs_under_program_and_leaves_the_signals_to_the_other_methods() {
    let (folder, _) = city();
    let folder = folder.path();
    let delays = |after_s: u32, out: &str| {
        switching(folder, after_s);
        // Seeds follow from the bytes of the files, and are to be the same.
        let folder_of = folder.join(format!("{out}-scenario"));
        fs::create_dir(&folder_of).unwrap();
        let run = RUN.replace("program,max-pressure", "program,max-pressure,actuated");
        succeed(folder, &format!("{run} {out}"));
        let (recorded, plain) = plain_delay_s(folder, out, 1, "");
        assert_eq!(recorded, plain, "{out}");
        rows(&folder.join(out))
    };
    let (early, late) = (delays(100, "early"), delays(900, "late"));
    assert_ne!(early, late, "the seeds differ, and the program switches");
    // The greens of the others are those of the program that is active at the beginning, which stays.
    let said = succeed(folder, "signals a.sumocfg --json");
    let json: Value = serde_json::from_str(said.lines().next().unwrap()).unwrap();
    assert!(!json["phases"].as_array().unwrap().is_empty());
    let shown = stderr(&run(folder, "signals a.sumocfg"));
    assert!(shown.contains("signals change their programs by the clock (<WAUT>)"), "{shown}");
}

#[test]
fn signals_that_an_option_switches_off_run_their_programs_when_that_is_accepted() {
    let (folder, _) = city();
    let folder = folder.path();
    configure(
        folder,
        "<net-file value='n.xml'/><routes value='r.xml'/><tls.all-off value='true'/>",
    );
    let said = refused(folder);
    assert!(
        said.contains("tls.all-off = true is taken as false: it switches all signals off"),
        "{said}"
    );
    assert!(said.trim_end().ends_with("pass --accept signals-on"), "{said}");
    succeed(folder, &format!("{RUN} on --accept signals-on"));
    configure(folder, "<net-file value='n.xml'/><routes value='r.xml'/>");
    succeed(folder, &format!("{RUN} plain"));
    assert_eq!(rows(&folder.join("on")), rows(&folder.join("plain")));
}
