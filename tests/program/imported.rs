//! Scenarios of one's own: what SUMO reads is in the manifest, what it would write is not written, all that is in the way is
//! said at once, and what runs then is what plain `sumo` runs.

use std::collections::BTreeSet;

use crate::common::{stderr, stdout};
use crate::folder::Folder;
use crate::plans_sumo::delay_s;
use serde_json::Value;

/// A folder with a network and its vehicles as `n.xml` and `r.xml`, and some lane of the network.
fn city() -> (Folder, String) {
    let folder = Folder::after("build-networks smoke --quiet");
    let net = folder.read("networks/smoke/busy/busy.net.xml");
    folder.write("n.xml", &net);
    folder.write("r.xml", &folder.read("networks/smoke/busy/busy.rou.xml"));
    let lanes = net.split("<lane id=\"").skip(1).map(|l| l.split('"').next().unwrap());
    let lane = lanes.into_iter().find(|l| !l.starts_with(':')).unwrap().to_owned();
    (folder, lane)
}

fn configure(folder: &Folder, options: &str) {
    let text = format!("<c>{options}<begin value='0'/><end value='120'/></c>");
    folder.write("a.sumocfg", &text);
}

const PLAIN: &str = "<net-file value='n.xml'/><route-files value='r.xml'/>";

const RUN: &str =
    "run --sumocfg a.sumocfg --methods program,max-pressure --eval-seeds 1 --quiet --out";

fn rows(folder: &Folder, results: &str) -> [Vec<Value>; 2] {
    [1, 2].map(|task| folder.record(results, task).split_off(1))
}

fn hashed(folder: &Folder, results: &str) -> BTreeSet<String> {
    let manifest = folder.json(&format!("{results}/manifest.json"));
    let hashes = manifest["identity"]["points"][0]["sha256"].as_object().unwrap();
    hashes.keys().cloned().collect()
}

#[test]
fn an_included_file_that_changes_after_planning_is_noticed() {
    let (folder, _) = city();
    folder.write("sub/r.xml", &folder.read("r.xml"));
    folder.write("all.xml", "<routes><include href='sub/r.xml'/></routes>");
    configure(&folder, "<net-file value='n.xml'/><additional value='all.xml'/>");
    folder.run(&format!("{RUN} out"));
    let expected = ["a.sumocfg", "all.xml", "n.xml", "sub/r.xml"].map(str::to_owned);
    assert_eq!(hashed(&folder, "out"), expected.into());
    std::fs::remove_file(folder.join("out/done/000/1.jsonl")).unwrap();
    folder.edit("sub/r.xml", "</routes>", "</routes>\n");
    let said = folder.says(5, &format!("{RUN} out"));
    assert!(said.contains("the point MDP a.sha256.sub/r.xml is"), "{said}");
}

#[test]
fn outputs_of_a_configuration_are_not_written_and_change_no_record() {
    let (folder, lane) = city();
    configure(&folder, PLAIN);
    folder.run(&format!("{RUN} plain"));
    // Outputs of files, and of files that these draw in, beside those of options.
    let detectors = format!(
        "<additional><e1Detector id='d' lane='{lane}' pos='1' freq='10' file='mine.txt'/>\
         <edgeData id='e' file='mine.txt'/><include href='more.xml'/></additional>"
    );
    folder.write("writes.xml", &detectors);
    let more = "<additional><laneData id='l' file='mine.txt' edgesFile='mine.txt'/></additional>";
    folder.write("more.xml", more);
    folder.write("mine.txt", "mine");
    let writes = "<fcd-output value='mine.txt'/><tripinfo value='mine.txt'/><log value='mine.txt'/>\
        <save-state.times value='9'/><save-state.files value='mine.txt'/><output-prefix value='x-'/>\
        <save-configuration value='mine.txt'/><device.ssm.probability value='1'/>\
        <human-readable-time value='true'/><gui_only><start value='true'/></gui_only>";
    let additional = "<additional-files value='writes.xml'/>";
    for (out, options) in [("out", writes), ("other", additional)] {
        configure(&folder, &format!("{PLAIN}{options}"));
        let mut expected = folder.names("");
        folder.run(&format!("{RUN} {out}"));
        expected.push(out.to_owned());
        expected.sort();
        assert_eq!((folder.names(""), folder.read("mine.txt")), (expected, "mine".to_owned()));
    }
    assert_eq!(rows(&folder, "out"), rows(&folder, "plain"));
    let hashed = hashed(&folder, "other");
    assert!(hashed.contains("more.xml") && hashed.contains("writes.xml"), "{hashed:?}");
}

/// What all commands say of a scenario, which has to be the same and is said before anything is written.
fn refused(folder: &Folder) -> String {
    let before = folder.names("");
    let said = |command: &str| {
        let said = folder.says(2, command);
        said[said.find("error: ").unwrap()..].to_owned()
    };
    let first = said(&format!("{RUN} out"));
    for command in ["run --sumocfg a.sumocfg --dry-run", "signals a.sumocfg"] {
        assert_eq!(said(command), first, "{command}");
    }
    assert_eq!(folder.names(""), before, "nothing is written");
    first
}

#[test]
fn all_that_is_in_the_way_is_said_at_once_and_its_options_pass_it() {
    let (folder, lane) = city();
    let add = format!(
        "<additional>\n<calibrator id='k' lane='{lane}' pos='0' output='k.txt'/>\
         <e1Detector id='d' lane='{lane}' pos='1' freq='10' file='mine.txt'/></additional>"
    );
    folder.write("add.xml", &add);
    let options = "<a v='add.xml'/><step-length v='0.3'/><max-depart-delay value='20'/>\
        <remote-port value='8813'/><new-thing value='1'/><e1-output value='x'/>";
    folder.write("a.sumocfg", &format!("<c>{PLAIN}{options}</c>"));
    insta::assert_snapshot!("in_the_way", refused(&folder));
    let pass = "--end 120 --step-length 1 --accept calibrators,unknown-options";
    let output = folder.output(&format!("{} out {pass}", RUN.replace("--quiet", "")));
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    let given = &folder.json("out/manifest.json")["identity"]["points"][0]["given"];
    assert_eq!((&given["end_s"], &given["step_length_s"]), (&120.0.into(), &1.0.into()));
    let warning = "max-depart-delay = 20 is taken as -1";
    assert_eq!(said.matches(warning).count(), 1, "{said}");
    folder.shows("out/manifest.json", &[warning]);
    folder.shows("out/report/index.html", &[warning]);
    // Another end is another run.
    folder.says(5, &format!("{RUN} out {}", pass.replace("120", "60")));
}

#[test]
fn what_only_a_change_of_the_files_or_sumo_itself_refuses_is_named_with_the_rest() {
    let (folder, lane) = city();
    configure(&folder, "<net-file value='n.xml'/><routes value='r.xml,gone.xml'/><mesosim v='1'/>");
    let said = refused(&folder);
    assert!(said.contains("gone.xml: the scenario names it, but it cannot be read"), "{said}");
    assert!(said.contains("pass --accept microscopic for the rest"), "{said}");
    // People alone have no delay of vehicles, but their signals are shown.
    let edge = lane.split('_').next().unwrap();
    let walks = format!("<person id='p' depart='0'><walk edges='{edge}'/></person>");
    folder.write("r.xml", &format!("<routes>{walks}</routes>"));
    configure(&folder, PLAIN);
    folder.refuses(&[(&format!("{RUN} out"), "a.sumocfg: none of its files has a vehicle")]);
    folder.run("signals a.sumocfg");
    let unknown = "<routes><route id='r' edges='nowhere'/><vehicle id='v' depart='triggered' route='r'/></routes>";
    folder.write("r.xml", unknown);
    folder.write("a.sumocfg", &format!("<c>{PLAIN}</c>"));
    let said = refused(&folder);
    assert!(said.contains("a.sumocfg: no end; pass --end 3600"), "{said}");
    assert!(said.contains("a.sumocfg: SUMO cannot load it: "), "{said}");
    assert!(!said.contains("newer-classes"), "{said}");
    let net = folder.read("n.xml");
    let class = net.replacen("<lane id=\"", "<lane disallow=\"drone\" id=\"", 1);
    folder.write("n.xml", &class);
    let said = refused(&folder);
    assert!(said.contains("pass --accept newer-classes --end 3600"), "{said}");
}

fn is_plain(folder: &Folder, results: &str, options: &str) {
    let row = folder.record(results, 1).remove(1);
    let delay_s = delay_s(folder.path(), &format!("-c a.sumocfg --seed {} {options}", row["seed"]));
    assert_eq!(row["metrics"]["delay_s"], delay_s, "{results}");
}

#[test]
fn a_scenario_with_outputs_and_an_end_of_the_command_line_is_what_plain_sumo_runs() {
    let (folder, lane) = city();
    let signal = "<timedEvent type='SaveTLSStates' source='c' dest='t.txt'/>";
    let detector = format!("<e1Detector id='d' lane='{lane}' pos='1' freq='10' file='d.txt'/>");
    folder.write("add.xml", &format!("<additional>{detector}{signal}</additional>"));
    let options = "<a v='add.xml'/><max-depart-delay v='20'/><step-length value='0.5'/>";
    folder.write("a.sumocfg", &format!("<c>{PLAIN}{options}</c>"));
    folder.run(&format!("{RUN} out --end 200 --begin 10"));
    is_plain(&folder, "out", "--begin 10 --end 200 --max-depart-delay -1");
    // Vehicles do not depend on what a file is called.
    folder.write("b.sumocfg", &folder.read("a.sumocfg"));
    let renamed = RUN.replace("a.sumocfg", "b.sumocfg");
    folder.run(&format!("{renamed} renamed --end 200 --begin 10"));
    assert_eq!(rows(&folder, "out"), rows(&folder, "renamed"));
}

#[test]
fn a_day_plan_runs_under_program_and_leaves_the_signals_to_the_other_methods() {
    let (folder, _) = city();
    let net = folder.read("n.xml");
    let logic = net.split("<tlLogic ").nth(1).unwrap().split("</tlLogic>").next().unwrap();
    let own = logic.split("programID=\"").nth(1).unwrap().split('"').next().unwrap();
    let states = logic.split("state=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    let phases: String = states
        .filter(|state| state.contains(['G', 'g', 'y']))
        .map(|state| {
            let duration = if state.contains('y') { 3 } else { 8 };
            format!("<phase duration='{duration}' state='{state}'/>")
        })
        .collect();
    // The signal changes from a program of short greens to the network's own one.
    let plan = format!(
        "<additional><tlLogic id='c' type='static' programID='night' offset='0'>{phases}</tlLogic>\
         <WAUT id='w' refTime='0' startProg='night'><wautSwitch time='100' to='{own}'/></WAUT>\
         <wautJunction wautID='w' junctionID='c'/></additional>"
    );
    folder.write("plan.xml", &plan);
    folder.write("a.sumocfg", &format!("<c>{PLAIN}<a v='plan.xml'/><e v='400'/></c>"));
    folder.run(&format!("{} out", RUN.replace("max-pressure", "max-pressure,actuated")));
    is_plain(&folder, "out", "");
    // The greens of the others are those of the program that is active at the beginning.
    let output = folder.output("signals a.sumocfg --json");
    let json: Value = serde_json::from_str(stdout(&output).lines().next().unwrap()).unwrap();
    assert!(!json["phases"].as_array().unwrap().is_empty());
    assert!(stderr(&output).contains("signals change their programs by the clock (<WAUT>)"));
}

#[test]
fn signals_that_an_option_switches_off_run_their_programs_when_that_is_accepted() {
    let (folder, _) = city();
    configure(&folder, &format!("{PLAIN}<tls.all-off value='true'/>"));
    let said = refused(&folder);
    assert!(said.trim_end().ends_with("pass --accept signals-on"), "{said}");
    folder.run(&format!("{RUN} on --accept signals-on"));
    configure(&folder, PLAIN);
    folder.run(&format!("{RUN} plain"));
    assert_eq!(rows(&folder, "on"), rows(&folder, "plain"));
}
