//! Mistakes of an engineer with counts, UTDF and plans: what the program says of each.

use crate::common::stderr;
use crate::folder::{Folder, repository};

const NETWORK: &str = "network.csv";
const COUNTS: &str = "counts.csv";
const PLAN: &str = "plan.csv";

const COUNTED: &str = "INTID,Time,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR\n\
    1,07:00,9,99,9,9,99,9,9,99,9,9,99,9\n1,08:00,9,80,9,9,80,9,9,80,9,9,80,9\n\
    2,07:00,9,0,9,0,0,0,0,99,9,9,99,0\n2,08:00,9,0,9,0,0,0,0,80,9,9,80,0\n";

const COLUMNS: &str = "intersection,control,cycle_s,reference,phase,ring,barrier,position,movements,yielding,\
    min_green_s,split_s,yellow_s,all_red_s,walk_s,clearance_s,offset_s\n";

/// Both streets of the first signal, the main street's left turns yielding.
const PHASES: &str = "1,pretimed,70,2,2,1,1,1,EBT EBR WBT WBR,EBL WBL,7,35,4,1,7,14,0\n\
    1,,,,4,1,2,1,NBT NBR SBT SBR,NBL SBL,7,35,4,1,7,14,\n";

const MISTAKES: [(&str, &str, &str, &str); 33] = [
    ("counts of an intersection that the network does not have", COUNTS, "\n2,0", "\n7,0"),
    ("a letter in a count", COUNTS, "1,07:00,9,99", "1,07:00,9,9o"),
    ("a count that is not available", COUNTS, "1,07:00,9,99", "1,07:00,9,n/a"),
    ("a negative count", COUNTS, "1,07:00,9,99", "1,07:00,9,-99"),
    ("thousands with a comma", COUNTS, "1,07:00,9,99", "1,07:00,9,\"1,299\""),
    ("counts of a day as those of an hour", COUNTS, "1,07:00,9,99", "1,07:00,9,99000"),
    ("an hour that does not exist", COUNTS, "1,08:00", "1,25:00"),
    ("a quotation mark that is not closed", COUNTS, "1,07:00,9,99", "1,07:00,9,\"99"),
    (
        "counts of a direction from which no street comes",
        COUNTS,
        "2,07:00,9,0,9,0,0,0",
        "2,07:00,9,0,9,50,120,30",
    ),
    ("a letter in a volume", NETWORK, "Volume,1,", "Volume,1,x"),
    ("a network that does not say its units", NETWORK, "Metric,0\n", ""),
    ("a link from a node that is not there", NETWORK, "Up ID,1,12,11,13,2", "Up ID,1,12,11,99,2"),
    ("a growth that is a factor", NETWORK, "Growth,1,100,", "Growth,1,1.05,"),
    ("an empty volume of a movement with lanes", NETWORK, "Volume,1,80,310,", "Volume,1,80,,"),
    ("a signal without lanes", NETWORK, "Lanes,2,1,,1,,,,,2,0,1,2,,,\n", ""),
    ("a walk without its clearance", NETWORK, "DontWalk,1,,14,", "DontWalk,1,,,"),
    ("a coordinate that is no number", NETWORK, "11,1,0,1200", "11,1,nan,1200"),
    ("a yellow of the network that is no number", NETWORK, "yellowTime,3.5", "yellowTime,\"3,9\""),
    ("a cycle that is shorter than its splits", NETWORK, "Cycle Length,1,100", "Cycle Length,1,60"),
    ("a yellow of 35 s", PLAN, "35,4,1", "35,35,1"),
    ("a movement that does not exist", PLAN, "EBT EBR WBT", "EBX EBR WBT"),
    ("movements that cross in one phase", PLAN, "EBT EBR WBT", "EBT NBT WBT"),
    ("a phase number that stands twice", PLAN, "1,,,,4,1,2", "1,,,,2,1,2"),
    ("splits that do not make the cycle", PLAN, "1,pretimed,70", "1,pretimed,90"),
    ("an offset beyond the cycle", PLAN, "7,14,0\n", "7,14,95\n"),
    ("a cycle of an actuated plan", PLAN, "1,pretimed", "1,actuated"),
    ("two coordinated phases in one ring", PLAN, "1,pretimed,70,2,", "1,coordinated,70,2 4,"),
    ("a walk of 3 s", PLAN, "4,1,7,14", "4,1,3,14"),
    ("a network without lanes", NETWORK, "[Lanes]", ""),
    ("a network without phases", NETWORK, "[Phases]", "[Other]"),
    ("a plan without the column of yellow", PLAN, "yellow_s,", ""),
    ("a table of plans without its header", PLAN, COLUMNS, ""),
    ("a plan of an intersection that the network does not have", PLAN, "\n1,", "\n9,"),
];

fn written() -> Folder {
    let network = repository("crates/signals/tests/utdf/two-signals.csv");
    let plan = format!("{COLUMNS}{PHASES}");
    Folder::with(&[(NETWORK, &network), (COUNTS, COUNTED), (PLAN, &plan)])
}

fn said(folder: &Folder, file: &str, more: &str) -> (Option<i32>, String) {
    let with = match file {
        COUNTS => "--turning-counts counts.csv",
        PLAN => "--existing plan.csv",
        _ => "",
    };
    let command = format!("build-networks --utdf network.csv {with} {more} --out built --quiet");
    let output = folder.output(&command);
    (output.status.code(), stderr(&output))
}

#[test]
fn each_mistake_is_named_with_its_place_and_the_way_out() {
    let usual = [NETWORK, COUNTS, PLAN].map(|file| said(&written(), file, "").1).concat();
    let mut all = String::new();
    let mut tell = |what: &str, (code, said): (Option<i32>, String)| {
        all += &format!("{what}: {code:?}\n");
        for line in said.lines().filter(|line| !usual.contains(line)) {
            all += &format!("  {line}\n");
        }
    };
    for (what, file, from, to) in MISTAKES {
        let folder = written();
        folder.edit(file, from, to);
        tell(what, said(&folder, file, ""));
    }
    let network = written().read(NETWORK);
    let volumes = network.split("Volume,1").next().unwrap();
    for (what, file, text) in [
        ("a table of counts without movements", COUNTS, "INTID,Time,Total\n1,07:00,500\n"),
        ("rows that are there twice", COUNTS, &COUNTED.replace("08:00", "07:00")),
        ("counts without the intersection", COUNTS, &COUNTED.replace("INTID", "Number")),
        ("a movement that was not counted", COUNTS, &COUNTED.replace("WBT", "Other")),
        ("a network that was cut off before its volumes", NETWORK, volumes),
        ("a network as counts", COUNTS, &network),
        ("counts as a network", NETWORK, COUNTED),
        ("counts as plans", PLAN, COUNTED),
    ] {
        let folder = written();
        folder.write(file, text);
        tell(what, said(&folder, file, ""));
    }
    let plans =
        format!("{COLUMNS}{PHASES}{}", PHASES.replace("1,pre", "9,pre").replace("\n1,", "\n9,"));
    let folder = written();
    folder.write(PLAN, &plans);
    tell("a plan of another network", said(&folder, PLAN, ""));
    tell("a file that is not there", said(&written(), NETWORK, "--existing nowhere.csv"));
    let period = "--period pm=16:00-18:00,500";
    tell("a period that was not counted", said(&written(), COUNTS, period));
    insta::assert_snapshot!("mistakes", all);
}
