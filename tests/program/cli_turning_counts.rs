//! `tsc-family build-networks --turning-counts` and `--utdf` end to end.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::{run, stderr, succeed};
use crate::outcomes::refused;
use crate::report_links::lead_somewhere;

/// A crossing whose table has no daily counts.
fn with_table() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let table = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,right_turn_lanes,\
        speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n\
        7,N,,,0,2,2,0,0,30,200,,\n7,E,,,90,2,2,0,0,30,200,,\n7,S,,,180,2,2,0,0,30,200,,\n7,W,,,270,2,2,0,0,30,200,,\n";
    fs::write(folder.path().join("a.csv"), table).unwrap();
    fs::write(folder.path().join("a.toml"), "[family]\napproaches = \"a.csv\"\n").unwrap();
    folder
}

/// Four quarters of two hours; the morning has more on the main street.
fn counts(path: &Path) {
    let mut text =
        "Date,Time,INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR,NB HV %\n".to_owned();
    for (hour, through) in [(7, 90), (17, 60)] {
        for minute in [0, 15, 30, 45] {
            text += &format!(
                "11/5/2026,{hour}:{minute:02},7,10,{through},5,8,70,9,20,30,0,4,35,6,25\n"
            );
        }
    }
    fs::write(path, text).unwrap();
}

#[test]
fn counted_turns_are_what_is_simulated_in_every_period() {
    let folder = with_table();
    counts(&folder.path().join("c.csv"));
    let command = "build-networks a.toml --turning-counts c.csv --period am=07:00-09:00,500 --period pm=16:00-18:00,250 \
                   --out counted";
    let text = succeed(folder.path(), command);
    assert!(text.contains("turning counts: 1 of 1 intersections"), "{text}");
    assert!(text.contains("am: busiest hour 07:00 to 08:00, 1148 vehicles"), "{text}");
    assert!(text.contains("2 networks in counted/networks: 2 built"), "{text}");
    let list = succeed(folder.path(), "list counted");
    assert!(list.contains("i0007-am") && list.contains("0.6667"), "{list}");
    // The vehicles that SUMO gets, over 40 seeds: the deviation of a mean of 360 is 3.
    let mut routes: BTreeMap<String, f64> = BTreeMap::new();
    let (mut heavy, mut northbound) = (0.0, 0.0);
    for seed in 0..40 {
        succeed(
            folder.path(),
            &format!("routes counted --point i0007-am --seed {seed} --out v.rou.xml"),
        );
        let text = fs::read_to_string(folder.path().join("v.rou.xml")).unwrap();
        for line in text.lines().filter(|line| line.contains("<vehicle ")) {
            let route = line.split("route=\"").nth(1).unwrap().split('"').next().unwrap();
            *routes.entry(route.to_owned()).or_default() += 1.0 / 40.0;
            if route.starts_with("in2") {
                northbound += 1.0;
                heavy += f64::from(u8::from(line.contains("type=\"heavy\"")));
            }
        }
    }
    // Arms are numbered clockwise from north: northbound vehicles come from arm 2.
    for (route, expected) in
        [("in2-out0", 360.0), ("in2-out3", 40.0), ("in0-out2", 280.0), ("in3-out1", 120.0)]
    {
        let mean = routes[route];
        assert!((mean - expected).abs() < 4.0 * (expected / 40.0).sqrt(), "{route}: {mean}");
    }
    assert_eq!(routes.get("in3-out2"), None, "nobody turned right from the west");
    assert!((heavy / northbound - 0.25_f64).abs() < 0.02, "{heavy} of {northbound}");
    let output = succeed(
        folder.path(),
        "run counted --budget all --methods baseline --eval-seeds 1 --set demand.horizon_s=60 --out r",
    );
    assert!(output.contains("2/2"), "{output}");
    let page = fs::read_to_string(folder.path().join("r/report/intersections/i0007.html")).unwrap();
    for expected in
        ["am, 500 h a year", "pm, 250 h a year", "Movements, pm", "<th scope=\"row\">am</th>"]
    {
        assert!(page.contains(expected), "{expected}: {page}");
    }
    // A queue beside a storage length says which one it is.
    assert!(page.contains("not longer for 95% of the time") && !page.contains("95% queue"));
    assert!(page.contains("simulated drivers used about 30% less"));
    let table = fs::read_to_string(folder.path().join("r/report/periods.csv")).unwrap();
    let mut rows = table.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>());
    for (period, hours) in [("am", 500.0), ("pm", 250.0)] {
        let row = rows.next().unwrap();
        assert_eq!(row[..4], [period, &format!("{hours}"), "baseline", "1"], "{table}");
        let number = |i: usize| row[i].parse::<f64>().unwrap();
        // Vehicles per hour, times their delay, times the hours of a year.
        let expected = number(4) * number(5) / 3600.0 * hours;
        assert!((number(6) - expected).abs() < 1e-6 * expected, "{table}");
    }
    let page = fs::read_to_string(folder.path().join("r/report/index.html")).unwrap();
    assert!(page.contains("id=\"periods\""));
    // A period may be called anything.
    for (name, old, new) in [
        ("approaches.csv", ",am,", ",AM peak,"),
        ("scenario.toml", "am = 500", "\"AM peak\" = 500"),
    ] {
        let path = folder.path().join("counted").join(name);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(old), "{text}");
        fs::write(path, text.replace(old, new)).unwrap();
    }
    succeed(
        folder.path(),
        "run counted --budget all --methods baseline --eval-seeds 1 --set demand.horizon_s=60 --out named",
    );
    let read =
        |name: &str| fs::read_to_string(folder.path().join("named/report").join(name)).unwrap();
    let renamed = read("periods.csv");
    assert_eq!(renamed.lines().count(), 3, "{renamed}");
    assert!(renamed.contains("AM peak,500,baseline,1,"), "{renamed}");
    assert!(read("intersections/i0007.html").contains("AM peak, 500 h a year"));
    let files = fs::read_dir(folder.path().join("named/report/plans")).unwrap();
    let names: Vec<String> =
        files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    let of_period = |stem: &str| names.iter().filter(|name| name.starts_with(stem)).count();
    assert_eq!(
        (of_period("baseline.AM-peak-"), of_period("baseline.pm.utdf.csv")),
        (1, 1),
        "{names:?}"
    );
}

#[test]
fn a_map_takes_counts_and_says_that_its_inflows_were_counted() {
    let folder = tempfile::tempdir().unwrap();
    let map = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("osm-signals/tests/networks/four_arms/input.osm");
    fs::copy(map, folder.path().join("m.osm")).unwrap();
    let mut text = "INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR\n".to_owned();
    text += "n101,10,300,20,15,280,30,40,90,10,20,80,12\n";
    fs::write(folder.path().join("c.csv"), text).unwrap();
    succeed(folder.path(), "build-networks --osm m.osm --turning-counts c.csv --out city");
    let read = |name: &str| fs::read_to_string(folder.path().join("city").join(name)).unwrap();
    assert!(read("scenario.toml").contains("counted = 1.0"), "{}", read("scenario.toml"));
    assert!(read("approaches.csv").contains(",10,300,20,"), "{}", read("approaches.csv"));
    assert!(read("quality.json").contains("turning-counts"));
    // The same command again builds nothing, and a table that was edited is not overwritten.
    let again =
        succeed(folder.path(), "build-networks --osm m.osm --turning-counts c.csv --out city");
    assert!(again.contains("0 built, 1 up to date"), "{again}");
}

#[test]
fn mistakes_with_counts_are_refused_with_the_way_out() {
    let folder = with_table();
    counts(&folder.path().join("c.csv"));
    let refused = |arguments: &str| {
        let output = run(folder.path(), &format!("build-networks {arguments}"));
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        assert!(!folder.path().join("x").exists(), "{arguments}: nothing is written");
        stderr(&output)
    };
    let e = refused("a.toml --turning-counts c.csv");
    assert!(e.contains("say with --out in which folder"), "{e}");
    let e = refused("a.toml --turning-counts none.csv --out x");
    assert!(e.contains("none.csv") && e.contains("No such file"), "{e}");
    let e = refused(
        "a.toml --turning-counts c.csv --period am=07:00-09:00 --period am=10:00-12:00 --out x",
    );
    assert!(e.contains("--period am is given twice"), "{e}");
    let e = refused(
        "a.toml --turning-counts c.csv --period am=07:00-09:00,500 --period pm=16:00-18:00 --out x",
    );
    assert!(e.contains("give hours per year for every period, or for none"), "{e}");
    let e = refused("a.toml --turning-counts c.csv --period noon=11:00-13:00 --out x");
    assert!(e.contains("c.csv, line 2: no hour within noon (11:00 to 13:00) is complete"), "{e}");
    let e = refused("smoke --turning-counts c.csv --out x");
    assert!(e.contains("turning counts need the arms of intersections"), "{e}");
    let table = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let with_periods =
        table.replace("movements\n", "movements,period\n").replace(",,\n", ",,,am\n");
    fs::write(folder.path().join("p.csv"), with_periods).unwrap();
    let e = refused("p.csv --turning-counts c.csv --out x");
    assert!(e.contains("p.csv: period = am: the table of approaches has periods already"), "{e}");
    let e = refused("a.toml --period am=07:00-09:00 --out x");
    assert!(e.contains("--turning-counts"), "{e}");
    let e = refused("a.toml --out x");
    assert!(e.contains("aadt_veh_per_day_per_lane is empty"), "{e}");
}

#[test]
fn a_table_that_was_edited_is_not_overwritten() {
    let folder = with_table();
    counts(&folder.path().join("c.csv"));
    let command = "build-networks a.toml --turning-counts c.csv --out counted";
    succeed(folder.path(), command);
    let table = folder.path().join("counted/approaches.csv");
    let edited = fs::read_to_string(&table).unwrap().replace(",360,", ",361,");
    fs::write(&table, &edited).unwrap();
    let output = run(folder.path(), command);
    assert!(stderr(&output).contains("not as this command wrote it"), "{}", stderr(&output));
    assert_eq!(fs::read_to_string(&table).unwrap(), edited);
    succeed(folder.path(), &format!("{command} --force"));
}

#[test]
fn a_network_in_utdf_is_simulated_with_its_volumes_or_with_counts() {
    let folder = tempfile::tempdir().unwrap();
    let network =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/signals/tests/utdf/two-signals.csv");
    fs::copy(network, folder.path().join("n.csv")).unwrap();
    let output = run(folder.path(), "build-networks --utdf n.csv");
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(text.contains("UTDF: 2 of 2 signals, 2 with volumes"), "{text}");
    assert!(text.contains("2 networks in networks/n/networks: 2 built"), "{text}");
    assert!(stderr(&output).contains("records that are not used"), "{}", stderr(&output));
    let run_it = "run networks/n --budget all --methods nema,fixed-time,existing --eval-seeds 1 --set demand.horizon_s=120 --out r";
    let result = succeed(folder.path(), run_it);
    assert!(result.contains("2/2"), "{result}");
    movements_make_up_the_delay(&folder.path().join("r/report"));
    // The phases of the dual ring and the stages of fixed time have the movements of the street.
    let sheet = fs::read_to_string(folder.path().join("r/report/cabinet.csv")).unwrap();
    for row in [
        // Numbers are those of the existing plans, in which 2 is eastbound.
        "i0001,nema,0,c,phase,actuated,,0,,0,1,1,1,1,WBL,,",
        "i0002,nema,0,c,phase,actuated,,0,,0,2,1,1,2,EBT EBR,,",
        ",fixed-time,0,c,stage,pretimed,",
        "i0001,existing,0,c,phase,coordinated,100,0,2 6,0,2,1,1,2,EBT,EBL EBR,15,34,39.5,3,4.3,1.2,7,14,max,",
        "i0002,existing,0,c,phase,coordinated,100,32,2 6,0,8,2,2,2,NBL,NBR,8,27.6,32,3,3.3,1.1,7,18,none,",
    ] {
        assert!(sheet.contains(row), "{row}: {sheet}");
    }
    let page = fs::read_to_string(folder.path().join("r/report/index.html")).unwrap();
    assert!(page.contains("id=\"movements\"") && page.contains("id=\"cabinet\""));
    let page = fs::read_to_string(folder.path().join("r/report/intersections/i0001.html")).unwrap();
    assert!(
        page.contains("existing plan is coordinated, and this intersection was simulated alone")
    );
    plans_go_back(folder.path());
    plans_are_given_back(folder.path());
    fs::write(folder.path().join("c.csv"), "INTID,NBL,NBR,EBT,EBR,WBL,WBT\n2,5,6,7,8,9,10\n")
        .unwrap();
    succeed(folder.path(), "build-networks --utdf n.csv --turning-counts c.csv --out both");
    let table = fs::read_to_string(folder.path().join("both/approaches.csv")).unwrap();
    assert!(
        table.contains(",lr,,30.5,5,0,6,") && table.contains(",lsr,45.7,,80,310,45,0.9,"),
        "{table}"
    );
    // The file in a wrong place is called what it is.
    let bad = "[family]\napproaches = \"n.csv\"\n";
    fs::write(folder.path().join("bad.toml"), bad).unwrap();
    for wrong in [
        "build-networks salt-lake-city --turning-counts n.csv --out x",
        "build-networks --osm n.csv --out x",
        "list bad.toml",
        "run n.csv --budget 1 --out x",
    ] {
        let output = run(folder.path(), wrong);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("--utdf"), "{wrong}: {}", stderr(&output));
    }
    let output = run(folder.path(), "build-networks --utdf c.csv --out x");
    assert!(stderr(&output).contains("--turning-counts"), "{}", stderr(&output));
}

/// Checks the page of an intersection: on it stands what changes from today, and it follows the assumptions of its reader.
fn page_of_an_intersection(folder: &Path) {
    let page = || fs::read_to_string(folder.join("r/report/intersections/i0007.html")).unwrap();
    let first = page();
    for expected in [
        "<td>today</td>",
        "<svg xmlns=",
        "\u{b1}",
        "existing, pretimed, cycle 70 s, offset 0 s",
        "2: 40, 4: 30, 6: 40, 8: 30",
        "value_of_time_usd_per_h",
        ">NBL ",
        "../plans/i0007.html",
    ] {
        assert!(first.contains(expected), "{expected}: {first}");
    }
    let index = fs::read_to_string(folder.join("r/report/index.html")).unwrap();
    assert!(index.contains("href=\"intersections&#x2f;i0007.html\""), "no link");
    fs::write(folder.join("r/assumptions.toml"), "value_of_time_usd_per_h = 0\n").unwrap();
    succeed(folder, "report r");
    assert!(page().contains("<td>yours</td>") && page() != first, "{}", page());
    fs::write(folder.join("r/assumptions.toml"), "value_of_time = 5\n").unwrap();
    let e = refused(folder, "report r");
    assert!(
        e.contains("r/assumptions.toml: value_of_time is no assumption; expected one of")
            && e.contains("correct it, or delete it for the defaults"),
        "{e}"
    );
    fs::remove_file(folder.join("r/assumptions.toml")).unwrap();
}

/// Checks that the delays of movements, weighted by their vehicles, are the delay of every point MDP and method.
fn movements_make_up_the_delay(report: &Path) {
    let rows = |name: &str| -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(report.join(name)).unwrap();
        reader.deserialize().map(Result::unwrap).collect()
    };
    let number =
        |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap_or_default();
    let mut sums: BTreeMap<(String, String), [f64; 2]> = BTreeMap::new();
    for row in rows("movements.csv") {
        let sum = sums.entry((row["point"].clone(), row["method"].clone())).or_default();
        sum[0] += number(&row, "volume_vph") * number(&row, "delay_s");
        sum[1] += number(&row, "volume_vph");
    }
    assert_eq!(sums.len(), 8);
    for row in rows("scores.csv") {
        let [delay, vehicles] = sums[&(row["point"].clone(), row["method"].clone())];
        let expected = number(&row, "delay_s");
        assert!(
            (delay / vehicles - expected).abs() < 1e-6 * expected,
            "{row:?}: {}",
            delay / vehicles
        );
    }
}

/// One phase per street, four arms.
const PLAN: &str = "intersection,control,cycle_s,phase,ring,barrier,position,movements,yielding,split_s,yellow_s,all_red_s,\
    walk_s,clearance_s,recall\n\
    7,pretimed,70,2,1,1,1,NBT NBR,NBL,40,4,1,7,12,max\n7,,,6,2,1,1,SBT,SBL,40,4,1,,,max\n\
    7,,,4,1,2,1,EBT,EBL,30,3.5,1.5,,,max\n7,,,8,2,2,1,WBT,WBL,30,3.5,1.5,,,max\n";

#[test]
fn an_existing_plan_is_simulated_and_compared_with() {
    let folder = with_table();
    counts(&folder.path().join("c.csv"));
    fs::write(folder.path().join("p.csv"), PLAN).unwrap();
    succeed(
        folder.path(),
        "build-networks a.toml --turning-counts c.csv --existing p.csv --out city",
    );
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("city/scenario.toml").contains("existing = \"existing.csv\""));
    // It runs by default, and the page begins with it.
    let command = "run city --budget all --eval-seeds 2 --set demand.horizon_s=600 --set fixed_time.simulations=8 \
                   --against existing --out r";
    succeed(folder.path(), command);
    let manifest: serde_json::Value = serde_json::from_str(&read("r/manifest.json")).unwrap();
    let plan = &manifest["identity"]["points"][0]["given"]["existing"];
    assert_eq!(plan["ways"]["NBL"][0], serde_json::json!(["in2", "out3"]), "{plan}");
    let page = read("r/report/index.html");
    assert!(page.contains("which is what is done today"), "no headline");
    assert!(page.contains("pretimed, cycle 70 s, offset 0 s"), "no caption");
    assert!(folder.path().join("r/report/against-existing/index.html").is_file());
    page_of_an_intersection(folder.path());
    // The page, that against the existing plan, and those of the intersection.
    assert!(lead_somewhere(&folder.path().join("r/report")) > 3);
    // Greens of 35 and 25 s, yellow of 4 s and all-red of 1 s; SUMO can run it.
    let plans = read("r/report/plans.csv");
    let row = plans.lines().find(|row| row.contains(",existing,")).unwrap();
    assert!(row.contains("70"), "{row}");
    // Another plan is another run, and a table of approaches takes plans without being written again.
    let other = read("p.csv").replace(",30,3.5", ",60,3.5").replace("pretimed,70", "pretimed,100");
    fs::write(folder.path().join("q.csv"), other).unwrap();
    succeed(
        folder.path(),
        "run city --existing q.csv --budget all --methods existing --eval-seeds 1 --set demand.horizon_s=600 --out q",
    );
    let delay = |path: &str| -> f64 {
        let mut reader = csv::Reader::from_path(folder.path().join(path)).unwrap();
        let mut rows = reader.deserialize::<BTreeMap<String, String>>().map(Result::unwrap);
        rows.find(|row| row["method"] == "existing").unwrap()["delay_s"].parse().unwrap()
    };
    assert!(
        delay("q/report/scores.csv") > delay("r/report/scores.csv"),
        "a cycle of 100 s is longer"
    );
}

#[test]
fn mistakes_with_existing_plans_are_refused_with_the_way_out() {
    let folder = with_table();
    counts(&folder.path().join("c.csv"));
    succeed(folder.path(), "build-networks a.toml --turning-counts c.csv --out city");
    fs::write(folder.path().join("p.csv"), PLAN).unwrap();
    let refused = |arguments: &str| {
        let output = run(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", stderr(&output));
        assert!(!folder.path().join("x").exists(), "{arguments}: nothing is written");
        stderr(&output)
    };
    let e = refused("run city --methods existing --out x");
    assert!(
        e.contains(
            "no plan was given for the method existing (1 point MDPs); give one with --existing"
        ),
        "{e}"
    );
    let e = refused("run city --existing c.csv --out x");
    assert!(e.contains("c.csv, line 1: a table of turning counts, no plans"), "{e}");
    let e = refused("run city --existing none.csv --out x");
    assert!(e.contains("none.csv"), "{e}");
    let e = refused("run smoke --existing p.csv --methods existing --out x");
    assert!(e.contains("existing plans belong to real intersections"), "{e}");
    let e = refused("run cartpole --existing p.csv --out x");
    assert!(e.contains("--existing has no effect"), "{e}");
    let e = refused("build-networks city --existing p.csv");
    assert!(e.contains("--existing makes a scenario of its own; say with --out"), "{e}");
    let network =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/signals/tests/utdf/two-signals.csv");
    let text = fs::read_to_string(network).unwrap();
    fs::write(folder.path().join("n.csv"), text.split("[Phases]").next().unwrap()).unwrap();
    let e = refused("run city --existing n.csv --out x");
    assert!(
        e.contains("n.csv, line 1: no plan that can be shown: it has no section [Phases]"),
        "{e}"
    );
    fs::write(folder.path().join("n.csv"), text).unwrap();
    let e = refused("run city --existing n.csv --out x");
    assert!(e.contains("no intersection with a plan (1, 2) is in the scenario (7)"), "{e}");
    fs::write(folder.path().join("t.xml"), "<additional/>").unwrap();
    let e = refused("run city --existing t.xml --out x");
    assert!(e.contains("t.xml, line 1: XML without a tlLogic, no existing plan"), "{e}");
    let logic =
        "<additional><tlLogic id='7'><phase duration='9' state='GGrr'/></tlLogic></additional>";
    fs::write(folder.path().join("t.xml"), logic).unwrap();
    let e = refused("run city --existing t.xml --out x");
    assert!(
        e.contains("signal 7: states have 4 letters, but the intersection has 16 links"),
        "{e}"
    );
    for (from, to, expected) in [
        ("NBT NBR,NBL", "NBR,NBL", "p.csv, line 2: intersection 7: NBT has no phase"),
        ("EBT,EBL", "EBT NBT,EBL", "which cross; correct ring and barrier, or put a turn across"),
        ("SBT,SBL", "NET,SBL", "it has movements of NE traffic, but no approach goes that way"),
        ("pretimed,70", "pretimed,80", "the cycle is 80 s, but the splits"),
        (",40,4,1,7,12,max", ",forty,4,1,7,12,max", "p.csv, line 2: split_s = \"forty\""),
    ] {
        let changed = PLAN.replace(from, to);
        assert_ne!(changed, PLAN, "{from}");
        fs::write(folder.path().join("p.csv"), changed).unwrap();
        let e = refused("run city --existing p.csv --methods existing --out x");
        assert!(e.contains(expected), "{expected}: {e}");
    }
    // A SUMO scenario has its own program.
    let config = "city/networks/i0007/i0007.sumocfg";
    let e = refused(&format!("run --sumocfg {config} --methods existing --out x"));
    assert!(e.contains("what SUMO scenarios have today is the method program"), "{e}");
}

/// Checks that tables of plans that the report wrote are taken back with the same values, that a fixed cycle then gives the
/// same delays to the last digit, also as a program of SUMO, and that the sheet of all methods has to be told apart.
fn plans_are_given_back(folder: &Path) {
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let text = read("r/report/plans/i0001.add.xml").replace("id=\"c\"", "id=\"1\"");
    let other = read("r/report/plans/i0002.add.xml").replace("id=\"c\"", "id=\"i0002\"");
    let logic = |text: &str| {
        let from = text.find("<tlLogic").unwrap();
        text[from..text.find("</additional>").unwrap()].to_owned()
    };
    let both = format!("<additional>{}{}</additional>", logic(&text), logic(&other));
    fs::write(folder.join("both.add.xml"), both).unwrap();
    let plans = "--plan-file old=both.add.xml --plan-file new=r/report/plans/nema.csv";
    let run_it = "run networks/n --budget all --methods existing --eval-seeds 1 --set demand.horizon_s=120 \
                  --existing r/report/plans/fixed-time.csv --out given";
    succeed(folder, &format!("{run_it} {plans}"));
    assert_eq!(read("given/report/plans/existing.csv"), read("r/report/plans/fixed-time.csv"));
    assert_eq!(read("given/report/plans/new.csv"), read("r/report/plans/nema.csv"));
    let delays = |name: &str, method: &str| -> Vec<String> {
        let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
        let rows = reader.deserialize::<BTreeMap<String, String>>().map(Result::unwrap);
        rows.filter(|row| row["method"] == method).map(|row| row["delay_s"].clone()).collect()
    };
    let fixed_time = delays("r/report/scores.csv", "fixed-time");
    assert_eq!(delays("given/report/scores.csv", "existing"), fixed_time);
    assert_eq!(delays("given/report/scores.csv", "old"), fixed_time);
    // A further plan adds to the run.
    let third = "--plan-file third=r/report/plans/existing.csv";
    let grown = run(folder, &format!("{run_it} {plans} {third}"));
    assert!(stderr(&grown).contains("8 records stay"), "{}", stderr(&grown));
    assert_eq!(delays("given/report/scores.csv", "third").len(), 2);
    for (arguments, expected) in [
        (
            "run networks/n --existing r/report/cabinet.csv --out x",
            ": rows are of several methods (baseline, nema); keep those of one, or give plans/METHOD.csv",
        ),
        ("run networks/n --plan-file a --out x", "\"a\": write NAME=FILE, with a table of phases"),
        ("run networks/n --plan-file nema=n.csv --out x", "there is a method nema already"),
        ("run networks/n --plan-file a=none.csv --out x", "none.csv"),
        ("run cartpole --plan-file a=n.csv --out x", "has no effect on cartpole"),
        (
            "run --sumocfg networks/n/networks/i0001/i0001.sumocfg --plan-file a=n.csv --out x",
            "--plan-file a has no effect: plans are of generated networks",
        ),
    ] {
        let output = run(folder, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{arguments}: {}", stderr(&output));
    }
}

/// Checks that the network without its phases takes back the plans that the report wrote, with the same values, and that
/// they run as another method's plan.
fn plans_go_back(folder: &Path) {
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let network = read("n.csv");
    let streets = network.split("[Timeplans]").next().unwrap();
    let is_phase = |line: &&str| line.starts_with("Phase") || line.starts_with("PermPhase");
    let streets: Vec<&str> = streets.lines().filter(|line| !is_phase(line)).collect();
    for method in ["existing", "nema", "fixed-time"] {
        let plans = read(&format!("r/report/plans/{method}.utdf.csv"));
        let plans = plans.split_once("[Lanes]").unwrap().1;
        fs::write(folder.join("back.csv"), format!("{}\n\n[Lanes]{plans}", streets.join("\n")))
            .unwrap();
        succeed(folder, &format!("build-networks --utdf back.csv --force --out back-{method}"));
        let table = read(&format!("back-{method}/existing.csv"));
        assert!(table.lines().count() > 4, "{method}: {table}");
    }
    // Right turns that go with the through movement have its phase now; all else is the same.
    let rows = |name: &str| -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
        let rows = reader.deserialize::<BTreeMap<String, String>>().map(Result::unwrap);
        rows.map(|mut row| {
            let names = row["movements"].split(' ').filter(|name| !name.ends_with('R'));
            let names = names.collect::<Vec<_>>().join(" ");
            row.insert("movements".to_owned(), names);
            row
        })
        .collect()
    };
    assert_eq!(rows("back-existing/existing.csv"), rows("networks/n/existing.csv"));
    assert!(read("back-existing/existing.csv").contains(",SBT SBR,SBL,"));
    succeed(
        folder,
        "run back-nema --budget all --methods existing --eval-seeds 1 --set demand.horizon_s=60 --out back",
    );
    // A report's file is a plan too, without the network that Synchro merges it into.
    succeed(
        folder,
        "run networks/n --budget all --methods existing --plan-file again=r/report/plans/existing.utdf.csv --eval-seeds 1 \
         --set demand.horizon_s=60 --out again",
    );
    let mut reader = csv::Reader::from_path(folder.join("again/report/scores.csv")).unwrap();
    let scores: Vec<BTreeMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    let delays = |method: &str| -> Vec<&String> {
        scores.iter().filter(|row| row["method"] == method).map(|row| &row["delay_s"]).collect()
    };
    assert_eq!(delays("again").len(), 2);
    assert_eq!(delays("again"), delays("existing"));
    let page = read("r/report/plans/i0001.html");
    assert!(page.contains("@media print") && page.contains("coordinated, cycle 100 s"), "{page}");
}
