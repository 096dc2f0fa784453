//! Mistakes of an engineer with counts, UTDF and plans: what the program says of each. docs/engineer.md has the same list.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr};

/// A network of two signals with volumes and plans.
const NETWORK: &str = include_str!("../../crates/signals/tests/utdf/two-signals.csv");

const HEADER: &str = "INTID,Time,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR";

const COUNTS: &str = "1,07:00,9,99,9,9,99,9,9,99,9,9,99,9\n1,08:00,9,80,9,9,80,9,9,80,9,9,80,9\n\
    2,07:00,9,0,9,0,0,0,0,99,9,9,99,0\n2,08:00,9,0,9,0,0,0,0,80,9,9,80,0\n";

const PLAN_HEADER: &str = "intersection,control,cycle_s,reference,phase,ring,barrier,position,movements,yielding,\
    min_green_s,split_s,yellow_s,all_red_s,walk_s,clearance_s,offset_s";

/// Both streets of the first signal, the main street's left turns yielding.
const PLAN: &str = "1,pretimed,70,2,2,1,1,1,EBT EBR WBT WBR,EBL WBL,7,35,4,1,7,14,0\n\
    1,,,,4,1,2,1,NBT NBR SBT SBR,NBL SBL,7,35,4,1,7,14,\n";

/// What a mistake is made with.
enum Given {
    /// `counts.csv` beside the network.
    Counts(String),
    /// `network.csv`.
    Utdf(String),
    /// `plan.csv` beside the network.
    Plan(String),
    /// `--period` beside good counts.
    Period(&'static str),
}

use Given::{Counts, Period, Plan, Utdf};

/// A mistake, whether it is refused or warned of, and what has to be said.
type Mistake = (&'static str, Given, bool, &'static [&'static str]);

fn counts(from: &str, to: &str) -> Given {
    let all = format!("{HEADER}\n{COUNTS}");
    assert!(all.contains(from), "{from}");
    Counts(all.replacen(from, to, 1))
}

fn plan(from: &str, to: &str) -> Given {
    let all = format!("{PLAN_HEADER}\n{PLAN}");
    assert!(all.contains(from), "{from}");
    Plan(all.replacen(from, to, 1))
}

fn utdf(from: &str, to: &str) -> Given {
    assert!(NETWORK.contains(from), "{from}");
    Utdf(NETWORK.replacen(from, to, 1))
}

fn mistakes() -> Vec<Mistake> {
    let lanes = NETWORK.find("[Lanes]").unwrap();
    let volumes = NETWORK.find("Volume,1").unwrap();
    vec![
        (
            "counts of an intersection that the network does not have",
            Counts(format!("{HEADER}\n{COUNTS}").replace("\n2,0", "\n7,0")),
            false,
            &[
                "counts of intersections that the table does not have are not used (7)",
                "intersection 2",
            ],
        ),
        (
            "a table of counts without movements",
            Counts("INTID,Time,Total\n1,07:00,500\n".into()),
            true,
            &["counts.csv, line 1: no line names movements", "INTID, Time, NBL"],
        ),
        (
            "a letter in a count",
            counts("1,07:00,9,99", "1,07:00,9,9o"),
            true,
            &["counts.csv, line 2: \"9o\" in column 4", "write a number"],
        ),
        (
            "a negative count",
            counts("1,07:00,9,99", "1,07:00,9,-99"),
            true,
            &["counts.csv, line 2: -99 in column 4", "expected a number from 0"],
        ),
        (
            "thousands with a comma",
            counts("1,07:00,9,99", "1,07:00,9,\"1,299\""),
            true,
            &["counts.csv, line 2: \"1,299\" in column 4", "without thousands separators"],
        ),
        (
            "counts of a day as those of an hour",
            counts("1,07:00,9,99", "1,07:00,9,99000"),
            true,
            &[
                "counts.csv, line 2: 99000 vehicles of one NB movement",
                "give counts of an hour, not of a day",
            ],
        ),
        (
            "rows that are there twice",
            Counts(format!("{HEADER}\n{COUNTS}{COUNTS}")),
            true,
            &["counts.csv, line 6: 07:00 comes after 08:00", "remove those that are there twice"],
        ),
        (
            "an hour that does not exist",
            counts("1,08:00", "1,25:00"),
            true,
            &["counts.csv, line 3: time \"25:00\" is not understood; write it like 07:15"],
        ),
        (
            "a quotation mark that is not closed",
            counts("1,07:00,9,99", "1,07:00,9,\"99"),
            true,
            &["counts.csv, line 2: a quotation mark is not closed; close or remove it"],
        ),
        (
            "a period that was not counted",
            Period("pm=16:00-18:00,500"),
            true,
            &[
                "counts.csv, line 2: no hour within pm (16:00 to 18:00) is complete",
                "add what is missing",
            ],
        ),
        (
            "counts of a direction from which no street comes",
            counts("2,07:00,9,0,9,0,0,0", "2,07:00,9,0,9,50,120,30"),
            false,
            &[
                "counted directions have no arm",
                "correct the direction or bearing_deg (intersection 2, SB: 200",
            ],
        ),
        (
            "a network as counts",
            Counts(NETWORK.into()),
            true,
            &["counts.csv, line 1: a network in UTDF", "give it with --utdf"],
        ),
        (
            "counts as a network",
            Utdf(format!("{HEADER}\n{COUNTS}")),
            true,
            &["network.csv, line 1: a table of turning counts", "give it with --turning-counts"],
        ),
        (
            "a network without lanes",
            Utdf(NETWORK[..lanes].into()),
            true,
            &["network.csv, line 1: no lanes ([Lanes] or LANES.CSV)", "with all sections"],
        ),
        (
            "a network that was cut off before its volumes",
            Utdf(NETWORK[..volumes].into()),
            true,
            &["network.csv: intersections", "none of them has volumes, turning counts"],
        ),
        (
            "a letter in a volume",
            utdf("Volume,1,", "Volume,1,x"),
            true,
            &["network.csv, line ", "volume = \"x", "expected a number"],
        ),
        (
            "a network that does not say its units",
            utdf("Metric,0\n", ""),
            false,
            &[
                "no Metric in [Network]: lengths are read as feet and speeds as mph; Metric,1",
                "network.csv",
            ],
        ),
        (
            "a link from a node that is not there",
            utdf("Up ID,1,12,11,13,2", "Up ID,1,12,11,99,2"),
            false,
            &[
                "links come from nodes that the network does not have",
                "correct Up ID (node 1, EB: node 99)",
            ],
        ),
        (
            "a growth that is a factor",
            utdf("Growth,1,100,", "Growth,1,1.05,"),
            false,
            &["growth is percent here (100 = none)", "multiply it by 100 (node 1 NBL: 1.05)"],
        ),
        (
            "an empty volume of a movement with lanes",
            utdf("Volume,1,80,310,", "Volume,1,80,,"),
            false,
            &[
                "movements that have lanes were not counted",
                "write 0 where nobody drives (node 1 NBT)",
            ],
        ),
        (
            "a signal without lanes",
            utdf("Lanes,2,1,,1,,,,,2,0,1,2,,,\n", ""),
            false,
            &["signals that cannot be simulated are left out (node 2 has no incoming lane)"],
        ),
        (
            "a walk without its clearance",
            utdf("DontWalk,1,,14,", "DontWalk,1,,,"),
            false,
            &["only one of Walk and DontWalk get no walk; give both, or none (node 1, phase 2)"],
        ),
        (
            "a coordinate that is no number",
            utdf("11,1,0,1200", "11,1,nan,1200"),
            true,
            &["network.csv, line 24: X = \"nan\": expected a number"],
        ),
        (
            "a yellow of the network that is no number",
            utdf("yellowTime,3.5", "yellowTime,\"3,9\""),
            true,
            &[
                "network.csv, line 6: [Network] yellowtime = \"3,9\": expected a number from 1 to 10",
            ],
        ),
        (
            "a cycle that is shorter than its splits",
            utdf("Cycle Length,1,100", "Cycle Length,1,60"),
            false,
            &[
                "node 1: the cycle is 60 s, but the splits",
                "100 s together; correct the cycle or a green",
            ],
        ),
        (
            "a yellow of 35 s",
            plan("35,4,1", "35,35,1"),
            true,
            &["plan.csv, line 2: yellow_s = 35: expected a number from 0 to 10"],
        ),
        (
            "a movement that does not exist",
            plan("EBT EBR WBT", "EBX EBR WBT"),
            true,
            &[
                "plan.csv, line 2: movements = \"EBX EBR WBT WBR\": EBX is no movement",
                "such as NBT NBR",
            ],
        ),
        (
            "movements that cross in one phase",
            plan("EBT EBR WBT", "EBT NBT WBT"),
            true,
            &[
                "plan.csv, line 2: intersection 1: phase 2 has EBT and NBT, which cross",
                "put a turn across opposing traffic under yielding",
            ],
        ),
        (
            "a phase number that stands twice",
            plan("1,,,,4,1,2", "1,,,,2,1,2"),
            true,
            &["plan.csv, line 2: intersection 1: phase 2 stands twice; give each phase one number"],
        ),
        (
            "splits that do not make the cycle",
            plan("1,pretimed,70", "1,pretimed,90"),
            true,
            &[
                "plan.csv, line 2: intersection 1: the cycle is 90 s",
                "are 70 s together; correct the cycle",
            ],
        ),
        (
            "an offset beyond the cycle",
            plan("7,14,0\n", "7,14,95\n"),
            false,
            &[
                "intersection 1: the offset of 95 s is no part of the cycle of 70 s; it counts as 25 s",
            ],
        ),
        (
            "a cycle of an actuated plan",
            plan("1,pretimed", "1,actuated"),
            false,
            &["intersection 1: the cycle of 70 s has no effect, because control is actuated"],
        ),
        (
            "two coordinated phases in one ring",
            plan("1,pretimed,70,2,", "1,coordinated,70,2 4,"),
            true,
            &[
                "plan.csv, line 2: intersection 1: reference phases 2 and 4 are in one ring",
                "give one per ring",
            ],
        ),
        (
            "a walk of 3 s",
            plan("4,1,7,14", "4,1,3,14"),
            false,
            &["intersection 1: phase 2 has a walk of 3 s; the MUTCD asks for 7 s"],
        ),
        (
            "counts as plans",
            Plan(format!("{HEADER}\n{COUNTS}")),
            true,
            &[
                "plan.csv, line 1: a table of turning counts, no plans; give it with --turning-counts",
            ],
        ),
        (
            "a table of plans without its header",
            Plan(PLAN.into()),
            true,
            &[
                "plan.csv, line 1: none of its columns belongs to a table of plans; begin with a header",
            ],
        ),
        (
            "a plan of an intersection that the network does not have",
            Plan(format!("{PLAN_HEADER}\n{PLAN}").replace("\n1,", "\n9,")),
            true,
            &[
                "plan.csv, line 2: no intersection with a plan (9) is in the scenario (1, 2)",
                "call them alike",
            ],
        ),
    ]
}

#[test]
fn pruning_is_refused_where_a_scenario_is_made() {
    let folder = tempfile::tempdir().unwrap();
    for option in ["--utdf n.csv", "--turning-counts c.csv", "--existing p.csv"] {
        let output = run(folder.path(), &format!("build-networks --prune {option} --out x"));
        assert_eq!(output.status.code(), Some(2), "{option}");
        assert!(stderr(&output).contains("cannot be used with"), "{}", stderr(&output));
    }
}

#[test]
fn each_mistake_is_named_with_its_place_and_the_way_out() {
    let mistakes = mistakes();
    assert!(mistakes.len() >= 20);
    let listed = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/engineer.md"));
    let listed = listed.unwrap();
    let mut wrong = Vec::new();
    for (what, given, is_refused, expected) in mistakes {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("network.csv", NETWORK);
        let good = format!("{HEADER}\n{COUNTS}");
        let more = match &given {
            Counts(text) => {
                write("counts.csv", text);
                "--turning-counts counts.csv".to_owned()
            }
            Utdf(text) => {
                write("network.csv", text);
                String::new()
            }
            Plan(text) => {
                write("plan.csv", text);
                "--existing plan.csv".to_owned()
            }
            Period(period) => {
                write("counts.csv", &good);
                format!("--turning-counts counts.csv --period {period}")
            }
        };
        let command = format!("build-networks --utdf network.csv {more} --out built --quiet");
        let output = run(folder.path(), &command);
        let said = stderr(&output);
        let code = if is_refused { 2 } else { 0 };
        if output.status.code() != Some(code) {
            wrong.push(format!("{what}: exit code {:?}, not {code}: {said}", output.status.code()));
        }
        for words in expected.iter().filter(|words| !said.contains(**words)) {
            wrong.push(format!("{what}: not {words:?}, but: {said}"));
        }
        if !listed.contains(what) {
            wrong.push(format!("{what}: docs/engineer.md does not list it"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
