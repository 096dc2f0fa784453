//! What SUMO reads with somebody's own scenario is in the manifest, or the scenario is refused; what it
//! would write over the user's files is not written.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::common::{run, stderr, succeed};
use serde_json::Value;

/// A folder with a network and its vehicles as `n.xml` and `r.xml`, and some lane of the network.
pub(crate) fn city() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    let busy = folder.path().join("networks/smoke/busy");
    fs::copy(busy.join("busy.net.xml"), folder.path().join("n.xml")).unwrap();
    fs::copy(busy.join("busy.rou.xml"), folder.path().join("r.xml")).unwrap();
    let net = fs::read_to_string(folder.path().join("n.xml")).unwrap();
    let lane = net.split("<lane id=\"").map(|l| l.split('"').next().unwrap());
    let lane = lane.skip(1).find(|l| !l.starts_with(':')).unwrap().to_owned();
    (folder, lane)
}

/// Writes a configuration of two minutes.
pub(crate) fn configure(folder: &Path, options: &str) {
    let text =
        format!("<configuration>{options}<begin value='0'/><end value='120'/></configuration>");
    fs::write(folder.join("a.sumocfg"), text).unwrap();
}

pub(crate) const RUN: &str =
    "run --sumocfg a.sumocfg --methods program,max-pressure --eval-seeds 1 --quiet --out";

pub(crate) fn rows(results: &Path) -> String {
    let rows = |task: usize| {
        let text = fs::read_to_string(results.join(format!("done/000/{task}.jsonl"))).unwrap();
        text.lines().skip(1).collect::<Vec<_>>().join("\n")
    };
    format!("{}\n{}", rows(0), rows(1))
}

fn hashed(results: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(results.join("manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&text).unwrap();
    let points = manifest["identity"]["points"].as_array().unwrap();
    points[0]["sha256"].as_object().unwrap().keys().cloned().collect()
}

pub(crate) fn files(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn every_way_to_name_routes_is_in_the_manifest_and_gives_the_same_records() {
    let (folder, _) = city();
    let folder = folder.path();
    let ways = [
        "<net-file value='n.xml'/><route-files value='r.xml'/>",
        "<n v='n.xml'/><routes value='r.xml'/>",
        "<net>n.xml</net><r value='%72.xml'/>",
        "<net-file v='n.xml'/><route-files v=' r.xml , '/>",
        "<x><net-file>n.xml</net-file><routes>\n r.xml\n</routes></x>",
    ];
    for (i, way) in ways.iter().enumerate() {
        configure(folder, way);
        succeed(folder, &format!("{RUN} {i}"));
        let expected = ["a.sumocfg", "n.xml", "r.xml"].map(str::to_owned);
        assert_eq!(hashed(&folder.join(i.to_string())), expected.into(), "{way}");
        assert_eq!(rows(&folder.join(i.to_string())), rows(&folder.join("0")), "{way}");
    }
}

#[test]
fn an_included_file_that_changes_after_planning_is_noticed() {
    let (folder, _) = city();
    let folder = folder.path();
    fs::create_dir(folder.join("sub")).unwrap();
    fs::rename(folder.join("r.xml"), folder.join("sub/r.xml")).unwrap();
    fs::write(folder.join("all.xml"), "<routes><include href='sub/r.xml'/></routes>").unwrap();
    configure(folder, "<net-file value='n.xml'/><additional value='all.xml'/>");
    succeed(folder, &format!("{RUN} out"));
    let expected = ["a.sumocfg", "all.xml", "n.xml", "sub/r.xml"].map(str::to_owned);
    assert_eq!(hashed(&folder.join("out")), expected.into());
    fs::remove_file(folder.join("out/done/000/1.jsonl")).unwrap();
    let routes = fs::read_to_string(folder.join("sub/r.xml")).unwrap();
    fs::write(folder.join("sub/r.xml"), routes.replacen("<vehicle", " <vehicle", 1) + "\n")
        .unwrap();
    let output = run(folder, &format!("{RUN} out"));
    assert_eq!(output.status.code(), Some(5));
    let expected = "the file sub/r.xml of the point MDP a was changed";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
}

#[test]
fn outputs_of_a_configuration_are_not_written_and_change_no_record() {
    let (folder, lane) = city();
    let folder = folder.path();
    let plain = "<net-file value='n.xml'/><route-files value='r.xml'/>";
    configure(folder, plain);
    succeed(folder, &format!("{RUN} plain"));
    // Outputs of files, and of files that these draw in, beside those of options.
    let detectors = format!(
        "<additional><e1Detector id='d' lane='{lane}' pos='1' freq='10' file='mine.txt'/>\
         <edgeData id='e' file='mine.txt'/><include href='more.xml'/></additional>"
    );
    fs::write(folder.join("writes.xml"), detectors).unwrap();
    let more = "<additional><laneData id='l' file='mine.txt' edgesFile='mine.txt'/></additional>";
    fs::write(folder.join("more.xml"), more).unwrap();
    fs::write(folder.join("mine.txt"), "mine").unwrap();
    let writes = "<fcd-output value='mine.txt'/><tripinfo value='mine.txt'/><log value='mine.txt'/>\
        <save-state.times value='9'/><save-state.files value='mine.txt'/><output-prefix value='x-'/>\
        <save-configuration value='mine.txt'/><device.ssm.probability value='1'/>\
        <human-readable-time value='true'/><gui_only><start value='true'/></gui_only>";
    configure(folder, &format!("{plain}{writes}"));
    let before = files(folder);
    succeed(folder, &format!("{RUN} out"));
    assert_eq!(fs::read_to_string(folder.join("mine.txt")).unwrap(), "mine");
    assert_eq!(files(folder).difference(&before).collect::<Vec<_>>(), ["out"]);
    assert_eq!(rows(&folder.join("out")), rows(&folder.join("plain")));
    configure(folder, &format!("{plain}<additional-files value='writes.xml'/>"));
    let before = files(folder);
    let output = run(folder, &format!("{} nowhere", RUN.replace("--quiet ", "")));
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("outputs are not written: 4, the first in writes.xml: line 1"), "{said}");
    assert_eq!(fs::read_to_string(folder.join("mine.txt")).unwrap(), "mine");
    assert_eq!(files(folder).difference(&before).collect::<Vec<_>>(), ["nowhere"]);
    let hashed = hashed(&folder.join("nowhere"));
    assert!(hashed.contains("more.xml") && hashed.contains("writes.xml"), "{hashed:?}");
}
