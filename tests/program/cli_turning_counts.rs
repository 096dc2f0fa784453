//! `tsc-family build-networks --turning-counts`, `--utdf` and `--existing` end to end.

use std::collections::BTreeMap;

use crate::folder::{Folder, Row, repository};
use crate::report_links::lead_somewhere;

/// A crossing of four arms whose table has no daily counts, with two counted hours: the morning has more traffic.
fn with_counts() -> Folder {
    let mut table = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,right_turn_lanes,\
        speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n".to_owned();
    for (arm, bearing) in [("N", 0), ("E", 90), ("S", 180), ("W", 270)] {
        table += &format!("7,{arm},,,{bearing},2,2,0,0,30,200,,\n");
    }
    let mut counts =
        "Date,Time,INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR,NB HV %\n".to_owned();
    for (hour, through) in [(7, 90), (17, 60)] {
        for minute in [0, 15, 30, 45] {
            counts += &format!(
                "11/5/2026,{hour}:{minute:02},7,10,{through},5,8,70,9,20,30,0,4,35,6,25\n"
            );
        }
    }
    let scenario = "[family]\napproaches = \"a.csv\"\n";
    Folder::with(&[("a.csv", &table), ("a.toml", scenario), ("c.csv", &counts)])
}

fn delays(folder: &Folder, run: &str, method: &str) -> Vec<String> {
    let rows = folder.rows(&format!("{run}/report/scores.csv"));
    let rows = rows.into_iter().filter(|row| row["method"] == method);
    rows.map(|mut row| row.remove("delay_s").unwrap()).collect()
}

fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_default()
}

const SHORT: &str = "--budget all --eval-seeds 1 --set demand.horizon_s=60";

#[test]
fn counted_turns_are_what_is_simulated_in_every_period() {
    let folder = with_counts();
    let text = folder.run(
        "build-networks a.toml --turning-counts c.csv --period am=07:00-09:00,500 --period pm=16:00-18:00,250 --out counted",
    );
    for expected in
        ["1 of 1 intersections", "am: busiest hour 07:00 to 08:00, 1148 vehicles", "2 built"]
    {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // The vehicles that SUMO gets, over 40 seeds: the deviation of a mean of 360 is 3.
    let mut routes: BTreeMap<String, f64> = BTreeMap::new();
    let (mut heavy, mut northbound) = (0.0, 0.0);
    for seed in 0..40 {
        folder.run(&format!("routes counted --point i0007-am --seed {seed} --out v.rou.xml"));
        for line in folder.read("v.rou.xml").lines().filter(|line| line.contains("<vehicle ")) {
            let route = line.split("route=\"").nth(1).unwrap().split('"').next().unwrap();
            *routes.entry(route.to_owned()).or_default() += 1.0 / 40.0;
            // Arms are numbered clockwise from north: northbound vehicles come from arm 2.
            if route.starts_with("in2") {
                northbound += 1.0;
                heavy += f64::from(u8::from(line.contains("type=\"heavy\"")));
            }
        }
    }
    for (route, expected) in
        [("in2-out0", 360.0), ("in2-out3", 40.0), ("in0-out2", 280.0), ("in3-out1", 120.0)]
    {
        let mean = routes[route];
        assert!((mean - expected).abs() < 4.0 * (expected / 40.0_f64).sqrt(), "{route}: {mean}");
    }
    assert_eq!(routes.get("in3-out2"), None, "nobody turned right from the west");
    assert!((heavy / northbound - 0.25_f64).abs() < 0.02, "{heavy} of {northbound}");
    // The report has a row per period; a period may be called anything.
    folder.edit("counted/approaches.csv", ",am,", ",AM peak,");
    folder.edit("counted/scenario.toml", "am = 500", "\"AM peak\" = 500");
    folder.run(&format!("run counted --methods baseline {SHORT} --out r"));
    let rows = folder.rows("r/report/periods.csv");
    for (row, (period, hours)) in rows.iter().zip([("AM peak", 500.0), ("pm", 250.0)]) {
        assert_eq!((&*row["period"], &*row["method"]), (period, "baseline"));
        let values: Vec<f64> = row.values().filter_map(|v| v.parse().ok()).collect();
        assert!(values.contains(&hours), "{row:?}");
    }
    assert_eq!(rows.len(), 2);
    folder.shows(
        "r/report/intersections/i0007.html",
        &["AM peak, 500 h a year", "pm, 250 h a year", "Movements, pm"],
    );
    folder.shows("r/report/index.html", &["id=\"periods\""]);
    assert!(folder.path().join("r/report/plans/baseline.pm.utdf.csv").exists());
    // What was edited is not overwritten.
    let again = "build-networks a.toml --turning-counts c.csv --out counted";
    folder.refuses(&[(again, "not as this command wrote it")]);
}

#[test]
fn a_map_takes_counts_and_says_that_its_inflows_were_counted() {
    let folder =
        Folder::with(&[("m.osm", &repository("osm-signals/tests/networks/four_arms/input.osm"))]);
    folder.write(
        "c.csv",
        "INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR\nn101,10,300,20,15,280,30,40,90,10,20,80,12\n",
    );
    let command = "build-networks --osm m.osm --turning-counts c.csv --out city";
    folder.run(command);
    folder.shows("city/scenario.toml", &["counted = 1.0"]);
    folder.shows("city/approaches.csv", &[",10,300,20,"]);
    folder.shows("city/quality.json", &["turning-counts"]);
    let again = folder.run(command);
    assert!(again.contains("0 built, 1 up to date"), "{again}");
}

#[test]
fn mistakes_with_counts_are_refused_with_the_way_out() {
    let folder = with_counts();
    let table = folder.read("a.csv");
    folder.write(
        "p.csv",
        &table.replace("movements\n", "movements,period\n").replace(",,\n", ",,,am\n"),
    );
    let counts = "build-networks a.toml --turning-counts c.csv";
    folder.refuses(&[
        (counts, "say with --out in which folder"),
        ("build-networks a.toml --turning-counts none.csv --out x", "No such file"),
        (
            &format!("{counts} --period am=07:00-09:00 --period am=10:00-12:00 --out x"),
            "--period am is given twice",
        ),
        (
            &format!("{counts} --period am=07:00-09:00,500 --period pm=16:00-18:00 --out x"),
            "give hours per year for every period, or for none",
        ),
        (
            &format!("{counts} --period noon=11:00-13:00 --out x"),
            "line 2: no hour within noon (11:00 to 13:00) is complete",
        ),
        (
            "build-networks smoke --turning-counts c.csv --out x",
            "turning counts need the arms of intersections",
        ),
        (
            "build-networks p.csv --turning-counts c.csv --out x",
            "the table of approaches has periods already",
        ),
        ("build-networks a.toml --period am=07:00-09:00 --out x", "--turning-counts"),
        ("build-networks a.toml --out x", "aadt_veh_per_day_per_lane is empty"),
    ]);
}

const UTDF: &str = "crates/signals/tests/utdf/two-signals.csv";

#[test]
fn a_network_in_utdf_is_simulated_and_its_plans_go_out_and_come_back() {
    let folder = Folder::with(&[("n.csv", &repository(UTDF))]);
    let text = folder.run("build-networks --utdf n.csv");
    assert!(
        text.contains("UTDF: 2 of 2 signals, 2 with volumes") && text.contains("2 built"),
        "{text}"
    );
    folder.run(&format!("run networks/n --methods nema,fixed-time,existing {SHORT} --out r"));
    // The delays of movements, weighted by their vehicles, are the delay of every point MDP and method.
    let mut sums: BTreeMap<(String, String), [f64; 2]> = BTreeMap::new();
    for row in folder.rows("r/report/movements.csv") {
        let sum = sums.entry((row["point"].clone(), row["method"].clone())).or_default();
        sum[0] += number(&row, "volume_vph") * number(&row, "delay_s");
        sum[1] += number(&row, "volume_vph");
    }
    assert_eq!(sums.len(), 8);
    for row in folder.rows("r/report/scores.csv") {
        let [delay, vehicles] = sums[&(row["point"].clone(), row["method"].clone())];
        let expected = number(&row, "delay_s");
        assert!(
            (delay / vehicles - expected).abs() < 1e-6 * expected,
            "{row:?}: {}",
            delay / vehicles
        );
    }
    // Phases have the movements of the street; numbers are those of the existing plans.
    folder.shows(
        "r/report/cabinet.csv",
        &[
            "i0001,nema,0,c,phase,actuated,,0,,0,5,2,1,1,EBL,,",
            "i0001,baseline,0,c,stage,pretimed,90,0,2,0,2+6,1,1,1,EBT EBR WBT WBR,EBL WBL,",
            "i0001,existing,0,c,phase,coordinated,100,0,2 6,0,2,1,1,2,EBT,EBL EBR,15,34,39.5,3,4.3,1.2,7,14,max,",
            "i0002,existing,0,c,phase,coordinated,100,32,2 6,0,8,2,2,2,NBL,NBR,8,27.6,32,3,3.3,1.1,7,18,none,",
        ],
    );
    folder.shows("r/report/intersections/i0001.html", &["existing plan is coordinated"]);
    // The network without its phases takes back the plans that the report wrote.
    let network = folder.read("n.csv");
    let is_phase = |line: &&str| line.starts_with("Phase") || line.starts_with("PermPhase");
    let streets: Vec<_> = network
        .split("[Timeplans]")
        .next()
        .unwrap()
        .lines()
        .filter(|line| !is_phase(line))
        .collect();
    for method in ["existing", "nema", "fixed-time"] {
        let plans = folder.read(&format!("r/report/plans/{method}.utdf.csv"));
        let plans = plans.split_once("[Lanes]").unwrap().1;
        folder.write("back.csv", &format!("{}\n\n[Lanes]{plans}", streets.join("\n")));
        folder.run(&format!("build-networks --utdf back.csv --force --out back-{method}"));
    }
    // Right turns that go with the through movement have its phase now; all else is the same.
    let plan = |name: &str| -> Vec<Row> {
        let mut rows = folder.rows(name);
        for movements in rows.iter_mut().filter_map(|row| row.get_mut("movements")) {
            *movements = movements
                .split(' ')
                .filter(|name| !name.ends_with('R'))
                .collect::<Vec<_>>()
                .join(" ");
        }
        rows
    };
    assert_eq!(plan("back-existing/existing.csv"), plan("networks/n/existing.csv"));
    // Given as plans, they give the same delays to the last digit.
    folder.run(&format!(
        "run networks/n --methods existing {SHORT} --existing r/report/plans/fixed-time.csv \
         --plan-file new=r/report/plans/nema.csv --out given"
    ));
    assert_eq!(folder.read("given/report/plans/new.csv"), folder.read("r/report/plans/nema.csv"));
    assert_eq!(delays(&folder, "given", "existing"), delays(&folder, "r", "fixed-time"));
    folder.write("c.csv", "INTID,NBL,NBR,EBT,EBR,WBL,WBT\n2,5,6,7,8,9,10\n");
    folder.run("build-networks --utdf n.csv --turning-counts c.csv --out both");
    folder.shows("both/approaches.csv", &[",lr,,30.5,5,0,6,", ",lsr,45.7,,80,310,45,0.9,"]);
    let text = folder.run("build-networks --utdf n.csv --only 1,2 --skip 1 --out one");
    assert!(
        text.contains("1 built") && !folder.read("one/approaches.csv").contains("\n1,"),
        "{text}"
    );
    // A file in a wrong place is called what it is.
    folder.write("bad.toml", "[family]\napproaches = \"n.csv\"\n");
    let scenario =
        "run --sumocfg networks/n/networks/i0001/i0001.sumocfg --plan-file a=n.csv --out x";
    folder.refuses(&[
        ("build-networks salt-lake-city --turning-counts n.csv --out x", "--utdf"),
        ("list bad.toml", "UTDF"),
        ("run n.csv --budget 1 --out x", "UTDF"),
        ("build-networks --utdf c.csv --out x", "--turning-counts"),
        ("build-networks --utdf n.csv --only 9 --out x", "9: no intersection is called so"),
        (
            "run networks/n --existing r/report/cabinet.csv --out x",
            "control differs from that of a row above",
        ),
        ("run networks/n --plan-file a --out x", "\"a\": write NAME=FILE"),
        ("run networks/n --plan-file nema=n.csv --out x", "there is a method nema already"),
        ("run networks/n --plan-file a=none.csv --out x", "none.csv"),
        ("run cartpole --plan-file a=n.csv --out x", "only signals have methods of your own"),
        (scenario, "cannot be used with"),
    ]);
}

#[test]
fn printed_plans_hold_walks_and_clearances_and_what_is_not_legal_is_said() {
    let folder =
        Folder::with(&[("n.csv", &repository("crates/signals/tests/utdf/double-left.csv"))]);
    folder.run("build-networks --utdf n.csv");
    let run = format!("run networks/n --preset field {SHORT}");
    let methods = "existing,retime,nema,fixed-time,actuated";
    let searches = "--set fixed_time.simulations=8 --set retime.simulations=20";
    folder.run(&format!("{run} --methods {methods} {searches} --out r"));
    let sheet = folder.read("r/report/plans/i0001.html");
    let checks = |sheet: &str| -> Vec<String> {
        let plans = sheet.split("<h2>").skip(1).filter(|plan| plan.contains("Check:"));
        plans.map(|plan| plan.split(':').next().unwrap().to_owned()).collect()
    };
    assert_eq!(checks(&sheet), ["existing", "retime"], "the others keep to the limits");
    let page = folder.read("r/report/intersections/i0001.html");
    assert!(page.contains("phase 1, 5: yellow at 45 mph"), "{page}");
    assert!(page.contains("NB not served"), "{page}");
    for row in folder.rows("r/report/signals.csv") {
        assert_eq!(number(&row, "plan_findings") > 0.0, checks(&sheet).contains(&row["method"]));
    }
    // Splits are whole, greens have tenths that hold what the limits want, and the plan passes as an existing one.
    for row in folder.rows("r/report/cabinet.csv").iter().filter(|row| row["kind"] == "stage") {
        let of = |name: &str| row[name].parse().unwrap_or(0.0_f64);
        assert!(of("min_green_s") >= (of("walk_s") + of("clearance_s")).max(5.0), "{row:?}");
        let is_whole = (of("split_s") - of("split_s").round()).abs() < 1e-9;
        assert!(is_whole || row["control"] == "actuated", "{row:?}");
    }
    for method in ["baseline", "fixed-time", "actuated", "nema"] {
        folder.run(&format!(
            "{run} --existing r/report/plans/{method}.csv --methods existing --out {method}"
        ));
        let audit = folder.read(&format!("{method}/report/audit.csv"));
        assert!(!audit.contains("phase "), "{audit}");
    }
}

const PLAN: &str = "intersection,control,cycle_s,phase,ring,barrier,position,movements,yielding,split_s,yellow_s,all_red_s,\
    walk_s,clearance_s,recall\n\
    7,pretimed,70,2,1,1,1,NBT NBR,NBL,40,4,1,7,12,max\n7,,,6,2,1,1,SBT,SBL,40,4,1,,,max\n\
    7,,,4,1,2,1,EBT,EBL,30,3.5,1.5,,,max\n7,,,8,2,2,1,WBT,WBL,30,3.5,1.5,,,max\n";

#[test]
fn an_existing_plan_is_simulated_and_compared_with() {
    let folder = with_counts();
    folder.write("p.csv", PLAN);
    folder.run("build-networks a.toml --turning-counts c.csv --existing p.csv --out city");
    let options = "--budget all --eval-seeds 2 --set demand.horizon_s=300";
    folder.run(&format!(
        "run city {options} --set fixed_time.simulations=8 --against existing --out r"
    ));
    folder.shows(
        "r/report/index.html",
        &["which is what is done today", "intersections&#x2f;i0007.html"],
    );
    folder.shows("r/report/plans/i0007.html", &["pretimed, cycle 70 s"]);
    let page = "r/report/intersections/i0007.html";
    folder.shows(
        page,
        &["<td>today</td>", "\u{b1}", "2: 40, 4: 30, 6: 40, 8: 30", ">NBL ", "../plans/i0007.html"],
    );
    assert!(lead_somewhere(&folder.path().join("r/report")) > 3);
    // A table of approaches takes another plan without being written again; a longer cycle delays more.
    folder
        .write("q.csv", &PLAN.replace(",30,3.5", ",60,3.5").replace("pretimed,70", "pretimed,100"));
    folder.run(&format!("run city {options} --existing q.csv --methods existing --out q"));
    let delay = |run: &str| delays(&folder, run, "existing")[0].parse::<f64>().unwrap();
    assert!(delay("q") > delay("r"), "a cycle of 100 s is longer");
    // Its splits can be better, and add up in both rings; the record says what ran.
    let retime = "--methods existing,retime --set retime.simulations=20";
    folder.run(&format!("run city {options} --existing q.csv {retime} --out t"));
    let better: f64 = delays(&folder, "t", "retime")[0].parse().unwrap();
    assert!(better < delay("q"), "{better} of {}", delay("q"));
    let table = folder.read("t/report/plans/retime.csv");
    let numbers = table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let splits: Vec<[f64; 2]> =
        numbers.map(|cells| [3, 15].map(|column| cells[column].parse().unwrap())).collect();
    let [cycle_s, _] = splits[0];
    assert!(cycle_s < 100.0 && splits[0][1] + splits[2][1] == cycle_s, "{table}");
    assert!(splits[1][1] + splits[3][1] == cycle_s, "{table}");
    folder.run("routes --run t --point i0007 --method retime --out t-episode");
}

#[test]
fn mistakes_with_existing_plans_are_refused_with_the_way_out() {
    let folder = with_counts();
    folder.run("build-networks a.toml --turning-counts c.csv --out city");
    folder.write("p.csv", PLAN);
    let network = repository(UTDF);
    folder.write("n.csv", &network);
    folder.write("no.csv", network.split("[Phases]").next().unwrap());
    folder.refuses(&[
        (
            "run city --methods existing --out x",
            "no plan was given, or none that can be shown, for 1 of 1 point MDPs",
        ),
        ("run city --existing c.csv --out x", "c.csv, line 1: no column intersection; add it"),
        ("run city --existing none.csv --out x", "none.csv"),
        (
            "run smoke --existing p.csv --methods existing --out x",
            "existing plans belong to real intersections",
        ),
        ("run cartpole --existing p.csv --out x", "--existing has no effect"),
        (
            "build-networks city --existing p.csv",
            "--existing makes a scenario of its own; say with --out",
        ),
        (
            "run city --existing no.csv --out x",
            "no plan that can be shown; export the network with its phases",
        ),
        (
            "run city --existing n.csv --out x",
            "no intersection with a plan (1, 2) is in the scenario (7)",
        ),
        (
            "run --sumocfg city/networks/i0007/i0007.sumocfg --methods existing --out x",
            "no plan was given, or none that can be shown",
        ),
    ]);
    for (from, to, expected) in [
        ("NBT NBR,NBL", "NBR,NBL", "p.csv, line 2: intersection 7: NBT has no phase"),
        ("EBT,EBL", "EBT NBT,EBL", "which cross, or lead into one lane; correct ring and barrier"),
        ("SBT,SBL", "NET,SBL", "it has movements of NE traffic, but no approach goes that way"),
        ("pretimed,70", "pretimed,80", "the cycle is 80 s, but the splits"),
        (",40,4,1,7,12,max", ",forty,4,1,7,12,max", "p.csv, line 2: split_s = \"forty\""),
    ] {
        folder.write("p.csv", &PLAN.replace(from, to));
        folder.refuses(&[("run city --existing p.csv --methods existing --out x", expected)]);
    }
}
