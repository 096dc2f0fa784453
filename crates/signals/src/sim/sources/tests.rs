//! Tests of how the files of a scenario are read.

use std::fs;
use std::io::Write;

use super::*;

/// The files of a scenario with additional files of these names and texts, the first of which is named.
fn with_option(files: &[(&str, &[u8])], outside: bool) -> Sources {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("city");
    fs::create_dir_all(folder.join("sub")).unwrap();
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).unwrap();
    }
    let config = folder.join("a.sumocfg");
    fs::write(&config, format!("<c><n v='n.xml'/><a v='{}'/></c>", files[0].0)).unwrap();
    fs::write(folder.join("n.xml"), "<net/>").unwrap();
    let accept = if outside { BTreeSet::from([Accept::OutsideFiles]) } else { BTreeSet::new() };
    let mut found = Sources::of(&SumoConfig::read(&config).unwrap(), &accept);
    let shown = folder.display().to_string();
    for obstacle in &mut found.obstacles {
        obstacle.place = obstacle.place.replace(&shown, ".");
        obstacle.reason = obstacle.reason.replace(&shown, ".");
    }
    found
}

fn with(files: &[(&str, &[u8])]) -> Sources {
    with_option(files, false)
}

fn names(sources: &Sources) -> Vec<&str> {
    sources.named().map(|(name, _)| name).collect()
}

#[test]
fn files_that_files_name_are_followed_from_where_they_lie() {
    let mut zipped = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    zipped.write_all(b"<a><include href='c.xml'/><include href='a.xml'/></a>").unwrap();
    let found = with(&[
        ("a.xml", b"<a><include href='sub/b.xml'/><rerouter id='r' file='d.xml'/></a>"),
        ("sub/b.xml", &zipped.finish().unwrap()),
        ("sub/c.xml", b"<a/>"),
        ("sub/a.xml", b"<a/>"),
        ("d.xml", b"<rerouter/>"),
    ]);
    let expected = ["n.xml", "a.xml", "sub/b.xml", "d.xml", "sub/c.xml", "sub/a.xml"];
    assert_eq!((names(&found), found.obstacles.len()), (expected.to_vec(), 0));
    assert_eq!(found.files[1].names, [Some(2), Some(3)]);
}

#[test]
fn a_file_outside_the_folders_of_the_scenario_is_drawn_in_only_when_that_is_accepted() {
    let text: &[u8] = b"<a><include href='/etc/hostname'/></a>";
    let found = with(&[("a.xml", text)]);
    assert_eq!((names(&found), found.obstacles.len()), (vec!["n.xml", "a.xml"], 1));
    assert!(found.obstacles[0].goes_with(&[Accept::OutsideFiles]));
    let accepted = with_option(&[("a.xml", text)], true);
    assert_eq!(names(&accepted).len(), 3);
    // Whatever lies beneath a folder from which the configuration takes a file is the scenario's.
    let files: &[(&str, &[u8])] = &[("sub/a.xml", b"<a><include href='../n.xml'/></a>")];
    assert!(with(files).obstacles.is_empty());
    assert_eq!(with(&[("a.xml", b"<a><include href='../x.xml'/></a>")]).obstacles.len(), 1);
}

#[test]
fn outputs_and_day_plans_are_counted_with_the_place_of_the_first() {
    let text = b"<a>\r\n\r\n<e1Detector file='o.xml'/><location output='o.xml'/>\n<timedEvent dest='o'/>\
        <engine xmlFile='e.xml'/><edgeData edgesFile='e.txt'/><param key='device.ssm.file' value='s'/>\
        <WAUT id='w' refTime='0' startProg='0'/></a>";
    let found = with(&[("a.xml", text)]);
    assert_eq!(found.obstacles, []);
    let notes = found.notes();
    assert!(notes[0].starts_with("outputs are not written: 6, the first in "), "{notes:?}");
    assert!(notes[0].ends_with("a.xml: line 3, <e1Detector file=\"o.xml\">"), "{notes:?}");
    assert!(
        notes[1].starts_with("signals change their programs by the clock (<WAUT>)"),
        "{notes:?}"
    );
    assert!(found.has_day_plan());
}

#[test]
fn all_that_is_in_the_way_is_found_with_its_place() {
    for (text, expected) in [
        ("<a>\n<calibrator output='x'/></a>", "./a.xml: line 2: <calibrator> adds or removes"),
        ("<a><location href='e.txt'/></a>", "none that is followed"),
        ("<a><include href='&#36;{HOME}/b.xml'/></a>", "give the name of a file in ASCII"),
        (
            "<a><include href='b.xml'/></a>",
            "b.xml: the scenario names it, but it cannot be read; add it, or correct its name",
        ),
        ("<a><include href='sub\\b.xml'/></a>", "or correct its name, with slashes"),
        ("<!DOCTYPE a [<!ENTITY x SYSTEM 'b'>]><a>&x;</a>", "a <!DOCTYPE> can draw other files in"),
        ("<?xml version='1.0' encoding='UTF-7'?><a/>", "encoding \"utf-7\"; save it as UTF-8"),
        ("<\0a\0/\0>\0", "it has null bytes; save it as UTF-8"),
    ] {
        let found = with(&[("a.xml", text.as_bytes())]);
        let said: Vec<String> = found.obstacles.iter().map(ToString::to_string).collect();
        assert!(said.len() == 1 && said[0].contains(expected), "{said:?}");
    }
    let many = format!("<a>{}</a>", "<calibrator/>".repeat(25));
    let found = with(&[("a.xml", many.as_bytes()), ("b.xml", b"<a/>")]);
    assert_eq!(found.obstacles.len(), 1);
    assert!(found.obstacles[0].to_string().contains("vehicles (25 of the kind); pass --accept"));
    // Classes of a newer SUMO are left out where that is accepted.
    let text = b"<net><lane allow='drone'/><lane disallow='tram drone bus'/></net>";
    let Scanned { newer_classes, edits, .. } = with(&[("a.xml", text)]).files.remove(1).scanned;
    let left: Vec<&str> = newer_classes.iter().map(|edit| edit.with.as_str()).collect();
    assert_eq!((left, edits), (vec!["ignoring", "tram bus"], Vec::new()));
}

/// The same, with its configuration.
fn scenario(folder: &Path, files: &[(&str, &str)]) -> (SumoConfig, Sources) {
    for (name, text) in files.iter().chain(&[("n.xml", "<net/>")]) {
        fs::write(folder.join(name), text).unwrap();
    }
    let text = format!("<c><n v='n.xml'/><a v='{}'/></c>", files[0].0);
    fs::write(folder.join("a.sumocfg"), text).unwrap();
    let config = SumoConfig::read(&folder.join("a.sumocfg")).unwrap();
    let sources = Sources::of(&config, &BTreeSet::new());
    assert_eq!(sources.obstacles, []);
    (config, sources)
}

#[test]
fn outputs_of_any_kind_go_nowhere_and_everything_else_stays_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<a>\r\n<!-- Stra\u{df}e file='x' --><e1Detector id=\"d\" file=\"\u{fc} o.xml\"\n/>\
        <edgeData edgesFile='e' file=  'x&amp;.xml'/><timedEvent dest='t.xml' source=\"c\"/>\
        <vType emissionClass='PHEMlight/PC'><param key='device.ssm.file' value='s.xml'/>\
        <param value='false' key='has.tripinfo.device'/><param key='x-output' value=''/></vType>\
        <routeProbe file='NUL'/><vType imgFile='b.png'/></a> ";
    let (config, sources) = scenario(folder.path(), &[("a.xml", text)]);
    let options = copy(&config, &sources, &folder.path().join("copies"), true).unwrap();
    let copied = fs::read_to_string(folder.path().join("copies/1.xml")).unwrap();
    let expected = text
        .replace("\u{fc} o.xml", "NUL")
        .replace("edgesFile='e'", "             ")
        .replace("x&amp;.xml", "NUL")
        .replace("t.xml", "NUL")
        .replace("PHEMlight/PC", "HBEFA3/PC_G_EU4")
        .replace("s.xml", "NUL")
        .replace("value='false'", "value='true'");
    assert_eq!(copied, expected);
    let shown = |name: &str| folder.path().join(name).display().to_string();
    let expected = [
        ("net-file".to_owned(), shown("n.xml")),
        ("additional-files".to_owned(), shown("copies/1.xml")),
    ];
    assert_eq!(options, expected);
    assert_eq!(sources.files[1].scanned.outputs.as_ref().unwrap().0, 5);
    assert!(!folder.path().join("copies/0.xml").exists(), "the network has nothing otherwise");
}

#[test]
fn a_day_plan_is_left_out_where_it_is_asked_for_with_what_draws_it_in() {
    let folder = tempfile::tempdir().unwrap();
    let plan = "<a><x/><WAUT id='w' startProg='p'><wautSwitch time='9' to='q'/></WAUT>\
        <wautJunction wautID='w' junctionID='c'/><include href='c.xml'/></a>";
    let files = [
        ("a.xml", "<a><include href='b.xml'/></a>"),
        ("b.xml", plan),
        ("c.xml", "<c><include href='a.xml'/></c>"),
    ];
    let (config, sources) = scenario(folder.path(), &files);
    let with = |day_plan: bool| {
        let copies = folder.path().join(format!("copies-{day_plan}"));
        copy(&config, &sources, &copies, day_plan).unwrap().len()
    };
    assert_eq!((with(true), with(false)), (0, 2));
    let read = |n: usize| fs::read_to_string(folder.path().join(format!("copies-false/{n}.xml")));
    assert_eq!(read(1).unwrap(), "<a><include href='2.xml'/></a>");
    assert_eq!(read(2).unwrap(), "<a><x/><include href='3.xml'/></a>");
    assert_eq!(read(3).unwrap(), "<c><include href='1.xml'/></c>");
}
