//! Tests of reading counts and giving them to arms.

use std::borrow::Cow;

use osm_signals::DrivingSide;
use osm_signals::sources::Source;

use super::join::comparable;
use super::*;
use crate::family::approaches::{Arrivals, Counted, Intersection, read};

const RIGHT: DrivingSide = DrivingSide::Right;

const HEADER: &str = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
    right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n";

/// Intersections of arms with these bearings and movements.
fn table(intersections: &[(&str, &[(f64, &str)])]) -> Vec<Intersection> {
    let mut text = HEADER.to_owned();
    for (id, arms) in intersections {
        for (i, (bearing, movements)) in arms.iter().enumerate() {
            text += &format!("{id},{i},40,-111,{bearing},2,2,0,0,30,200,4000,{movements}\n");
        }
    }
    read(&text, "a.csv").unwrap()
}

fn cross() -> Vec<Intersection> {
    table(&[("7", &[(0.0, "lsr"), (90.0, "lsr"), (180.0, "lsr"), (270.0, "sr")])])
}

fn counts(text: &str) -> TurningCounts {
    let mut counts = TurningCounts::default();
    counts.add(text.as_bytes(), "c.csv").unwrap();
    counts
}

fn refused(text: &str) -> String {
    TurningCounts::default().add(text.as_bytes(), "c.csv").unwrap_err().to_string()
}

/// What was counted on the arms: left, through, right.
fn volumes(joined: &Joined) -> Vec<Option<[f64; 3]>> {
    let of = |c: Counted| [c.left_vph, c.through_vph, c.right_vph];
    joined.approaches.iter().map(|a| a.counted.map(of)).collect()
}

fn doubts(joined: &Joined) -> String {
    joined.doubts.iter().map(Doubt::brief).collect::<Vec<_>>().join("\n")
}

/// Two hours in quarters, of which the second of four is the busiest.
fn quarters(id: &str) -> String {
    let mut text = "Turning Movement Count,\n15 Minute Counts,\nDATE,TIME,INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,\
                    WBT,WBR\n"
        .to_owned();
    for (k, time) in ["0700", "0715", "0730", "0745", "0800"].iter().enumerate() {
        let through = [5, 10, 20, 10, 10][k];
        text += &format!("11/5/2026,=\"{time}\",{id},1,{through},2,0,7,*,1,9,0,0,8,3,\n");
    }
    text + "11/5/2026,Total,7,5,55,10,0,35,*,5,45,0,0,40,15,\n"
}

#[test]
fn the_busiest_hour_reaches_the_arms_that_vehicles_come_from() {
    let joined = counts(&quarters("7")).into_approaches(&cross(), &[], RIGHT).unwrap();
    // North has the southbound vehicles, east the westbound ones.
    let expected = [[0.0, 28.0, 0.0], [0.0, 32.0, 12.0], [4.0, 50.0, 8.0], [4.0, 36.0, 0.0]];
    assert_eq!(volumes(&joined), expected.map(Some));
    let south = joined.approaches[2].counted.unwrap();
    assert_eq!(south.arrivals, Some(Arrivals::QuarterHours([13.0, 23.0, 13.0, 13.0])));
    assert_eq!(joined.found[1], "  busiest hour 07:15 to 08:15, 174 vehicles");
    // The western arm had no left turn, and four left turns were counted.
    assert_eq!(joined.approaches[3].movements, "srl");
    let said = doubts(&joined);
    assert!(said.contains("added to its movements (intersection 7, EB left: 4 veh/h)"), "{said}");
    assert!(
        said.contains(
            "lines without a time or an intersection are passed over (line 9: 11/5/2026 Total)"
        ),
        "{said}"
    );
}

#[test]
fn every_period_has_rows_of_its_own_and_what_was_not_counted_stays() {
    let mut intersections = cross();
    intersections.extend(table(&[("8", &[(0.0, ""), (180.0, "")])]));
    let periods = ["am=07:00-08:15,500", "early=07:00-08:00,100"].map(|p| p.parse().unwrap());
    let joined = counts(&quarters("007")).into_approaches(&intersections, &periods, RIGHT).unwrap();
    assert_eq!(joined.approaches.len(), 12);
    let of = |period: &str| {
        let arms = joined.approaches.iter().filter(|a| a.period == period);
        arms.map(|a| a.counted.map(|c| c.through_vph)).collect::<Vec<_>>()
    };
    assert_eq!(of("am")[2..], [Some(50.0), Some(36.0), None, None]);
    assert_eq!(of("early")[2..4], [Some(45.0), Some(36.0)]);
    assert!(doubts(&joined).contains("in every period (intersection 8)"));
}

#[test]
fn names_above_names_are_read_together_and_a_wrong_sum_is_said() {
    let text = "Location:,Main St,,,,,,\n,Southbound,,,,Northbound,,\n,Main St,,,,Main St,,\nStart Time,Left,Thru,Right,\
                App Total,Left,Thru,Right\n4:00 PM,1,2,3,6,4,5,6\n4:15 PM,1,2,3,6,4,5,6\n4:30 PM,1,2,3,9,4,5,6\n\
                4:45 PM,1,2,3,6,4,5,6\nGrand Total,4,8,12,24,16,20,24\n";
    let joined = counts(text).into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[0], Some([4.0, 8.0, 12.0]));
    assert_eq!(volumes(&joined)[2], Some([16.0, 20.0, 24.0]));
    let said = doubts(&joined);
    assert!(
        said.contains(
            "do not sum up to its column of totals; the turns count (line 7: SB 6 instead of 9)"
        ),
        "{said}"
    );
}

#[test]
fn trucks_beside_cars_and_percentages_give_shares_of_heavy_vehicles() {
    let classes = "INTID,nb_cars_t,nb_truck_t,nb_bus_t,sb_cars_t\n7,90,6,4,50\n";
    let joined = counts(classes).into_approaches(&cross(), &[], RIGHT).unwrap();
    let south = joined.approaches[2].counted.unwrap();
    assert_eq!((south.through_vph, south.heavy_vehicles), (100.0, Some(0.1)));
    assert!(doubts(&joined).contains("read as the vehicles of an hour (intersection 7)"));
    let percent = "INTID,NBL,NBT,NBR,NB HV %\n7,10,80,10,5\n";
    let joined = counts(percent).into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(joined.approaches[2].counted.unwrap().heavy_vehicles, Some(0.05));
}

#[test]
fn turns_fit_the_exits_that_exist() {
    // A fork: from the south the exits lie half left and right, which a count calls left and through.
    let fork = table(&[("7", &[(60.0, "lr"), (180.0, "lr"), (300.0, "lr")])]);
    let joined =
        counts("INTID,NBL,NBT,NBR\n7,30,70,0\n").into_approaches(&fork, &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[1], Some([30.0, 0.0, 70.0]));
    assert!(
        doubts(&joined)
            .contains("30 left, 70 through, 0 right become 30 left, 0 through, 70 right")
    );
    // A T without an arm to the west.
    let tee = table(&[("7", &[(0.0, ""), (90.0, ""), (180.0, "")])]);
    let text = "INTID,NBL,NBT,NBR,NBU,EBT,EBL,EBR\n7,3,60,10,2,4,0,0\n";
    let joined = counts(text).into_approaches(&tee, &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[2], Some([0.0, 60.0, 10.0]));
    let said = doubts(&joined);
    for expected in [
        "have no exit, and their vehicles are not simulated (intersection 7, NB left: 3 veh/h; intersection 7, NB U-turn: 2 veh/h)",
        "have no arm, and their vehicles are not simulated; correct the direction or bearing_deg (intersection 7, EB: 4 veh/h)",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    let joined = counts("INTID,NBL,NBT,NBR,NBU\n7,3,60,10,2\n")
        .into_approaches(&cross(), &[], RIGHT)
        .unwrap();
    assert_eq!(volumes(&joined)[2], Some([5.0, 60.0, 10.0]));
    assert!(doubts(&joined).contains("U-turns count as left turns (intersection 7, NB: 2 veh/h)"));
    // A turn that exists keeps its vehicles, whatever the others are called.
    let joined =
        counts("INTID,NBL,NBT,NBR\n7,2,300,0\n").into_approaches(&tee, &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[2], Some([0.0, 300.0, 2.0]));
}

#[test]
fn what_was_not_counted_or_has_several_exits_is_said() {
    let joined = counts("INTID,NBL,NBT,SBT,SBR,SBL\n7,3,60,*,5,6\n")
        .into_approaches(&cross(), &[], RIGHT)
        .unwrap();
    let said = doubts(&joined);
    assert!(said.contains("were not counted, and have no vehicles (intersection 7, NB right; intersection 7, SB through)"), "{said}");
    let five = table(&[("7", &[(0.0, ""), (45.0, ""), (90.0, ""), (180.0, ""), (270.0, "")])]);
    let joined =
        counts("INTID,SBL,SBT,SBR\n7,60,200,40\n").into_approaches(&five, &[], RIGHT).unwrap();
    assert!(
        doubts(&joined).contains("(intersection 7, SB left: 60 veh/h to 2 exits)"),
        "{}",
        doubts(&joined)
    );
}

#[test]
fn a_street_that_bends_keeps_its_through_traffic() {
    let bent = table(&[("7", &[(50.0, ""), (110.0, ""), (180.0, ""), (270.0, "")])]);
    let text = "INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR\n7,100,400,50,60,300,40,1,2,3,4,5,6\n";
    let joined = counts(text).into_approaches(&bent, &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[2], Some([100.0, 0.0, 450.0]));
    assert_eq!(volumes(&joined)[0], Some([360.0, 40.0, 0.0]));
    let exits = |arm: usize| joined.approaches[arm].counted.unwrap().exits_vph;
    assert_eq!(exits(2), Some([100.0, 400.0, 50.0, 0.0, 0.0]));
    assert_eq!(exits(0), Some([60.0, 300.0, 40.0, 0.0, 0.0]));
    let said = doubts(&joined);
    assert!(said.contains("streets bend") && !said.contains("have no exit"), "{said}");
    // Without the other directions only bearings say where vehicles go.
    let alone = counts("INTID,SBL,SBT,SBR,EBT\n7,60,300,40,2\n");
    let said = doubts(&alone.into_approaches(&bent, &[], RIGHT).unwrap());
    assert!(said.contains("SB: 300 veh/h to where EB comes from"), "{said}");
}

#[test]
fn mornings_and_evenings_may_be_in_files_of_their_own() {
    let mut both = counts("Time,INTID,NBL,NBT,NBR\n07:00,7,1,100,1\n08:00,7,1,90,1\n");
    both.add(b"Time,INTID,NBL,NBT,NBR\n16:00,7,1,200,1\n17:00,7,1,90,1\n", "d.csv").unwrap();
    let periods = ["am=06:00-09:00", "pm=15:00-18:00"].map(|p| p.parse().unwrap());
    let joined = both.into_approaches(&cross(), &periods, RIGHT).unwrap();
    let south: Vec<f64> = joined
        .approaches
        .iter()
        .filter(|a| a.arm == "2")
        .map(|a| a.counted.unwrap().through_vph)
        .collect();
    assert_eq!(south, [100.0, 200.0]);
}

#[test]
fn a_week_is_the_mean_of_its_working_days() {
    let mut text = "Date,Time,INTID,NBL,NBT,NBR\n".to_owned();
    for (day, through) in [("11/6/2026", 100), ("11/7/2026", 900), ("11/9/2026", 300)] {
        text += &format!("{day},17:00,7,0,{through},0\n{day},18:00,7,0,1,0\n");
    }
    let joined = counts(&text).into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[2], Some([0.0, 200.0, 0.0]));
    assert!(doubts(&joined).contains("intersection 7: 2 days, without weekends (1)"));
}

#[test]
fn what_is_no_count_is_refused_with_the_line_and_the_way_out() {
    assert!(
        refused("a,b\n1,2\n")
            .starts_with("c.csv, line 1: no line names movements; expected columns such as INTID")
    );
    assert_eq!(
        refused("INTID,NBL,NBTR,NBT,NBR\n7,1,2,3,4\n"),
        "c.csv, line 1: column NBTR counts several turns together; give each turn a column of its own"
    );
    assert_eq!(
        refused("INTID,NBL,NBT,NBR\n7,1,many,3\n"),
        "c.csv, line 2: \"many\" in column 3: write a number such as 40.78"
    );
    assert!(
        refused("INTID,NBL,NBT,NBR\n7,1,-5,3\n")
            .contains("-5 in column 3: expected a number from 0")
    );
    assert!(refused("INTID,NBL,NBT,NBR\n").contains("no row with counts"));
    let network = refused(include_str!("../../tests/utdf/two-signals.csv"));
    assert!(
        network.contains("line 1: a network in UTDF, not a table of counts; give it with --utdf"),
        "{network}"
    );
    let e = refused("Time,INTID,NBL,NBT,NBR\n7h15,7,1,2,3\n");
    assert_eq!(e, "c.csv, line 2: time \"7h15\" is not understood; write it like 07:15");
    for (columns, time) in
        [("Time", "2026-11-05T13:15:00Z"), ("Date,Time", "2026-11-05,13:15+00:00")]
    {
        let e = refused(&northbound(columns, &[(time, 100)]));
        assert!(
            e.contains("c.csv, line 2: time ") && e.contains("is universal time; write local"),
            "{e}"
        );
    }
    for (columns, row) in [("Time,Time Zone", "13:15,UTC"), ("Time,UTC Offset", "13:15,0")] {
        let e = refused(&northbound(columns, &[(row, 100)]));
        assert!(e.contains("line 2: time in the zone") && e.contains("is universal time"), "{e}");
    }
    let e = refused(&format!("Time zone: UTC,,\n{}", northbound("Time", &[("13:15", 100)])));
    assert!(e.contains("line 1: time in the zone \"UTC\" is universal time"), "{e}");
    let e = refused(&northbound("Date,Time (UTC)", &[("2026-11-05,13:15", 100)]));
    assert!(e.contains("line 1: column Time (UTC) has universal time; write local time"), "{e}");
    let local = ["2026-11-05T00:00:00Z,07:15", "2026-11-05,07:15-06:00"].map(|row| (row, 100));
    counts(&northbound("Date,Time", &local[..1]));
    counts(&northbound("Date,Time", &local[1..]));
    let e = refused("INTID,NBL,NBT,NBR,NBL\n7,1,2,3,4\n");
    assert!(e.contains("columns NBL and NBL count the same"), "{e}");
    let e = refused("INTID,NBL,NBT,NBR,NB Trucks\n7,1,2,3,4\n");
    assert!(e.contains("column NB Trucks may count vehicles, and is not understood"), "{e}");
    let e = refused("INTID,NBL,NBT,NBR RTOR,SBT\n7,1,2,3,4\n");
    assert!(e.contains("column NBR RTOR may count vehicles, and is not"), "{e}");
    let e = counts("INTID,Time,NBL,NBT,NBR\n7,07:00,1,2,3\n7,07:25,1,2,3\n")
        .into_approaches(&cross(), &[], RIGHT)
        .unwrap_err()
        .to_string();
    assert!(e.contains("line 3: 25 minutes after the row"), "{e}");
    let e = refused("Period End,INTID,NBL,NBT,NBR\n07:15,7,1,2,3\n");
    assert!(e.contains("ends of intervals only"), "{e}");
    let twelve = "Time,INTID,NBL,NBT,NBR\n8:00,7,1,5,3\n9:00,7,1,5,3\n4:00,7,1,5,3\n5:00,7,1,5,3\n";
    let e = counts(twelve).into_approaches(&cross(), &[], RIGHT).unwrap_err().to_string();
    assert!(
        e.contains(
            "line 4: 04:00 comes after 09:00 on the same day; write 16:00 if it is the afternoon"
        ),
        "{e}"
    );
    let elsewhere = counts("INTID,NBL,NBT,NBR\n99,1,5,3\n")
        .into_approaches(&cross(), &[], RIGHT)
        .unwrap_err()
        .to_string();
    assert!(
        elsewhere.contains("none of the counted intersections (99) is one of the table (7)"),
        "{elsewhere}"
    );
    let mut two = cross();
    two.extend(table(&[("8", &[(0.0, ""), (180.0, "")])]));
    two.extend(table(&[("007", &[(0.0, ""), (180.0, "")])]));
    let either = counts("INTID,NBL,NBT,NBR\n7,1,5,3\n07,1,5,3\n").into_approaches(&two, &[], RIGHT);
    assert_eq!(
        either.unwrap_err().to_string(),
        "c.csv, line 3: 07 may be intersection 007 or 7; call it exactly like one of them"
    );
    let nameless =
        counts("NBL,NBT,NBR\n1,5,3\n").into_approaches(&two, &[], RIGHT).unwrap_err().to_string();
    assert!(nameless.contains("add a column INTID"), "{nameless}");
    let twice = counts("INTID,NBL,NBT,NBR\n7,1,5,3\n7,1,5,3\n")
        .into_approaches(&cross(), &[], RIGHT)
        .unwrap_err();
    assert!(twice.to_string().contains("line 3: a second row of the same intersection"), "{twice}");
    let quarter = "15 Minute Counts\nTIME,INTID,NBL,NBT,NBR\n1700,7,1,5,3\n";
    let short = counts(quarter).into_approaches(&cross(), &[], RIGHT).unwrap_err().to_string();
    assert!(short.contains("no hour is complete: rows of 15 minutes were counted"), "{short}");
}

#[test]
fn names_are_compared_without_case_leading_zeros_and_what_separates_words() {
    let same = |a: &str, b: &str| comparable(a) == comparable(b);
    assert!(same("Main St / 5th Ave", "main-st_5TH  ave"));
    assert!(same("007", "7") && same("Site 007", "site-7") && same("0", "000"));
    assert!(same("Stra\u{df}e 3", "STRA\u{df}E-03"));
    for (a, b) in [("0", "7"), ("70", "7"), ("1-2", "12"), ("a07", "a7"), ("/", "-")] {
        assert!(!same(a, b), "{a} {b}");
    }
}

#[test]
fn pedestrians_cross_the_arm_that_their_column_names_or_any() {
    let walk = |text: &str| -> (Vec<Option<f64>>, String) {
        let joined = counts(text).into_approaches(&cross(), &[], RIGHT).unwrap();
        let walk = joined.approaches.iter().map(|a| a.counted.unwrap().pedestrians_per_h);
        (walk.collect(), doubts(&joined))
    };
    let text = "INTID,Time,NBL,NBT,NBR,SBT,NB Peds,SB Peds CW,SB Peds CCW\n\
                7,07:00,1,2,3,4,30,7,8\n7,08:00,0,0,1,0,1,1,1\n";
    // North, east, south, west.
    assert_eq!(walk(text).0, [Some(15.0), None, Some(30.0), None]);
    let (of_any, said) = walk("INTID,NBL,NBT,NBR,PED\n7,1,2,3,20\n");
    assert_eq!(of_any, [Some(5.0); 4]);
    assert!(said.contains("divided equally among the crosswalks (intersection 7: 20)"), "{said}");
    let without =
        counts("INTID,NBL,NBT,SBT\n7,1,2,3\n").into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(without.approaches[0].counted.unwrap().pedestrians_per_h, None);
}

/// Rows of northbound through traffic below the names of their columns.
fn northbound(first: &str, rows: &[(&str, u32)]) -> String {
    let rows = rows.iter().map(|(row, through)| format!("{row},7,1,{through},1\n"));
    format!("{first},INTID,NBL,NBT,NBR\n{}", rows.collect::<String>())
}

/// The northbound through vehicles of the crossing, in the first period.
fn through(joined: &Joined) -> f64 {
    joined.approaches[2].counted.unwrap().through_vph
}

/// A sheet of a workbook, with empty rows above.
fn sheet(name: &str, text: &str, above: i64) -> Source<'static> {
    Source {
        bytes: Cow::Owned(text.as_bytes().to_vec()),
        rows: ("row", above),
        sheet: name.to_owned(),
    }
}

#[test]
fn every_sheet_that_names_movements_is_read() {
    let mut counts = TurningCounts::default();
    let sheets = [
        sheet("Notes", "counted by hand\n", 0),
        sheet("AM", &northbound("Time", &[("07:00", 100)]), 0),
        sheet("PM", &northbound("Time", &[("16:00", 200)]), 0),
    ];
    counts.add_sheets(&sheets, "c.xlsx").unwrap();
    let periods = ["am=06:00-09:00", "pm=15:00-18:00"].map(|p| p.parse().unwrap());
    let joined = counts.into_approaches(&cross(), &periods, RIGHT).unwrap();
    assert_eq!(through(&joined), 100.0);
    assert_eq!(joined.approaches[6].counted.unwrap().through_vph, 200.0);
    let said = doubts(&joined);
    assert!(
        said.contains("c.xlsx: sheets that name no movements are passed over (Notes)"),
        "{said}"
    );
}

#[test]
fn sheets_are_named_in_messages_with_the_rows_of_the_workbook() {
    let refused = |sheets: &[Source<'_>]| {
        let mut counts = TurningCounts::default();
        let read = counts.add_sheets(sheets, "c.xlsx");
        let joined = read.and_then(|()| counts.into_approaches(&cross(), &[], RIGHT));
        joined.unwrap_err().to_string()
    };
    let good = northbound("Time", &[("07:00", 100)]);
    let e = refused(&[sheet("AM", &good, 0), sheet("PM", &northbound("Time", &[("4h", 1)]), 9)]);
    assert!(e.starts_with("c.xlsx, sheet PM, line 11: time \"4h\" is not understood"), "{e}");
    let e = refused(&[sheet("Cars", &good, 0), sheet("Trucks", &good, 0)]);
    assert!(
        e.contains("the same time as line 2; remove one of the two, or the sheet that has a part of the vehicles"),
        "{e}"
    );
}

#[test]
fn a_date_may_have_a_time_beside_the_column_of_times() {
    let minutes = ["7:00", "7:15", "7:30", "7:45"];
    for day in ["11/5/2026 TIME", "11/5/2026 0:00", "46331.3", "7-Nov-2026"] {
        let rows = minutes.map(|time| (format!("{},{time}", day.replace("TIME", time)), 25));
        let rows: Vec<(&str, u32)> = rows.iter().map(|(row, n)| (row.as_str(), *n)).collect();
        let joined = counts(&northbound("Date,Time", &rows));
        let joined = joined.into_approaches(&cross(), &[], RIGHT).unwrap();
        assert_eq!(through(&joined), 100.0, "{day}");
    }
    let german = counts(&northbound("Date", &[("5.11.2026", 100), ("6.11.2026", 300)]));
    let e = german.into_approaches(&cross(), &[], RIGHT).unwrap_err().to_string();
    assert!(e.contains("line 3: a second row of the same intersection"), "{e}");
}

#[test]
fn times_after_midnight_may_have_points() {
    let rows = [("0.00", 10), ("0.15", 20), ("0.30", 30), ("0.45", 40)];
    let joined = counts(&northbound("Time", &rows)).into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(through(&joined), 100.0);
}

#[test]
fn the_end_of_summer_time_is_told_by_the_zone_of_the_times() {
    let offsets = [
        "2026-11-01T00:00:00-06:00", "2026-11-01T01:00:00-06:00", "2026-11-01T01:00:00-07:00",
        "2026-11-01T02:00:00-07:00",
    ];
    let names = ["00:00,BST", "01:00,BST", "01:00,GMT", "02:00,GMT"];
    for (columns, times, day) in
        [("Time", offsets, "2026-11-01, 2 rows"), ("Time,Time Zone", names, "2 rows")]
    {
        let rows: Vec<(&str, u32)> = times.into_iter().zip([10, 900, 800, 20]).collect();
        let joined = counts(&northbound(columns, &rows));
        let joined = joined.into_approaches(&cross(), &[], RIGHT).unwrap();
        assert_eq!(through(&joined), 20.0, "{columns}");
        let said = doubts(&joined);
        let twice = format!("do not count on that day (intersection 7: {day})");
        assert!(said.contains(&twice), "{said}");
    }
}

#[test]
fn of_several_columns_of_times_the_local_one_counts() {
    for columns in ["Time (UTC),Local Time", "Timestamp,Local Time", "UTC Time,Time"] {
        let joined = counts(&northbound(columns, &[("13:15:00Z,07:15", 100)]));
        let joined = joined.into_approaches(&cross(), &[], RIGHT).unwrap();
        assert_eq!(joined.found[1], "  busiest hour 07:15 to 08:15, 102 vehicles", "{columns}");
        let unused = columns.split(',').next().unwrap();
        let said = doubts(&joined);
        assert!(said.contains(&format!("columns that are not used: {unused}")), "{said}");
    }
}

#[test]
fn dates_that_are_not_understood_leave_weekends_in_and_are_said() {
    let rows = [("11/7/2026,07:00", 100), ("day 2,07:00", 300)];
    let joined = counts(&northbound("Date,Time", &rows));
    let joined = joined.into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(through(&joined), 200.0);
    let said = doubts(&joined);
    assert!(
        said.contains("write all of them like 2026-11-05 (intersection 7: \"day 2\")"),
        "{said}"
    );
}

#[test]
fn one_intersection_shows_for_all_whether_the_day_comes_first() {
    let mut intersections = cross();
    intersections.extend(table(&[("8", &[(0.0, ""), (180.0, "")])]));
    // Day first, the 8th of November is a Sunday; month first, the 11th of August is none.
    let text = "Date,Time,INTID,NBL,NBT,NBR\n6/11/2026,07:00,7,1,100,1\n8/11/2026,07:00,7,1,900,1\n\
                13/11/2026,07:00,8,1,100,1\n";
    let joined = counts(text).into_approaches(&intersections, &[], RIGHT).unwrap();
    assert_eq!(through(&joined), 100.0);
}

#[test]
fn a_weekend_counts_in_a_period_without_working_days() {
    let rows = [("11/6/2026,07:00", 100), ("11/7/2026,16:00", 200)];
    let periods = ["pm=15:00-18:00", "am=06:00-09:00"].map(|p| p.parse().unwrap());
    let joined = counts(&northbound("Date,Time", &rows));
    let joined = joined.into_approaches(&cross(), &periods, RIGHT).unwrap();
    assert_eq!(through(&joined), 200.0);
    let said = doubts(&joined);
    assert!(
        said.contains(
            "one of a weekend, because no working day was counted then (intersection 7, pm)"
        ),
        "{said}"
    );
}

#[test]
fn arms_that_are_called_by_directions_keep_them() {
    // The street bends: its northbound end lies in the east.
    let mut arms = cross();
    for (arm, name) in arms[0].arms.iter_mut().zip(["EB", "NB Main St", "WB", "SB Main St"]) {
        arm.arm = name.to_owned();
    }
    let text = "INTID,NBL,NBT,SBT,EBT,NB Peds\n7,1,100,50,7,30\n";
    let joined = counts(text).into_approaches(&arms, &[], RIGHT).unwrap();
    let through = joined.approaches.iter().map(|a| a.counted.unwrap().through_vph);
    assert_eq!(through.collect::<Vec<_>>(), [7.0, 100.0, 0.0, 50.0]);
    assert_eq!(joined.approaches[1].counted.unwrap().pedestrians_per_h, Some(30.0));
}

#[test]
fn u_turns_belong_to_the_turn_across_opposing_traffic() {
    let text = "INTID,NBL,NBT,NBR,NBU\n7,3,60,10,2\n";
    let joined = counts(text).into_approaches(&cross(), &[], DrivingSide::Left).unwrap();
    assert_eq!(volumes(&joined)[2], Some([3.0, 60.0, 12.0]));
    let said = doubts(&joined);
    assert!(said.contains("U-turns count as right turns (intersection 7, NB: 2 veh/h)"), "{said}");
}

#[test]
fn of_two_exits_ahead_that_are_as_close_the_network_s_goes_through() {
    let fork = table(&[("7", &[(20.0, ""), (180.0, ""), (340.0, "")])]);
    let counted = |row: &str, side| {
        let counts = counts(&format!("INTID,NBL,NBT,NBR\n7,{row}\n"));
        volumes(&counts.into_approaches(&fork, &[], side).unwrap())[1]
    };
    assert_eq!(counted("10,60,0", RIGHT), Some([10.0, 60.0, 0.0]));
    assert_eq!(counted("0,60,10", DrivingSide::Left), Some([0.0, 60.0, 10.0]));
}

#[test]
fn pedestrians_cross_the_arm_that_the_vehicles_of_their_direction_have() {
    let skew = table(&[("7", &[(220.0, ""), (135.0, ""), (0.0, "")])]);
    let text = "INTID,NBL,NBR,SBL,SBR,EBL,EBR,NB Peds\n7,11,12,21,22,31,32,25\n";
    let joined = counts(text).into_approaches(&skew, &[], RIGHT).unwrap();
    let counted: Vec<Counted> = joined.approaches.iter().map(|a| a.counted.unwrap()).collect();
    assert_eq!([0, 1, 2].map(|arm: usize| counted[arm].total_vph()), [63.0, 23.0, 43.0]);
    let people = [0, 1, 2].map(|arm: usize| counted[arm].pedestrians_per_h);
    assert_eq!(people, [None, Some(25.0), None], "nobody counted the others");
    let said = doubts(&joined);
    assert!(said.contains("pedestrians were counted on other arms only"), "{said}");
}

#[test]
fn pedestrians_beyond_what_is_simulated_are_said() {
    let joined = counts("INTID,NBL,NBT,NBR,NB Peds\n7,1,2,3,9000\n");
    let joined = joined.into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(joined.approaches[2].counted.unwrap().pedestrians_per_h, Some(3600.0));
    let said = doubts(&joined);
    assert!(said.contains("more than 3600 pedestrians per hour cross an arm"), "{said}");
    assert!(said.contains("(intersection 7, arm 2: 9000)"), "{said}");
}

#[test]
fn words_that_look_like_counts_are_none() {
    for title in ["15 Minute Counts", "Minneapolis, 15 min", "15-mins", "15 minutes each"] {
        assert_eq!(minutes_of_title(title), Some(15), "{title}");
    }
    for title in ["Hwy 5 Minneapolis", "Hwy 5 minster", "Counts"] {
        assert_eq!(minutes_of_title(title), None, "{title}");
    }
    // A title between two tables.
    let tables = [("07:00", 100), ("08:00", 50)].map(|row| northbound("Time", &[row]));
    let text = tables.join("5th Avenue counts\n");
    let joined = counts(&text).into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(through(&joined), 100.0);
    assert!(doubts(&joined).contains("(line 3: 5th Avenue counts)"), "{}", doubts(&joined));
    // Net is a sum beside other streets, and traffic beside the rest of its street.
    let net = counts("INTID,NBL,NBT,NBR,Net\n7,1,100,1,102\n");
    let net = net.into_approaches(&cross(), &[], RIGHT).unwrap();
    assert!(doubts(&net).contains("columns that are not used: Net"), "{}", doubts(&net));
    let diagonal = table(&[("7", &[(45.0, ""), (135.0, ""), (225.0, "")])]);
    let net = counts("INTID,NEL,NET,NER\n7,0,100,0\n");
    let net = net.into_approaches(&diagonal, &[], RIGHT).unwrap();
    assert_eq!(volumes(&net)[2], Some([0.0, 100.0, 0.0]));
}

#[test]
fn heavy_vehicles_and_the_peak_hour_factor_stay_where_the_counts_have_none() {
    let mut arms = cross();
    let before = Counted {
        heavy_vehicles: Some(0.15),
        arrivals: Some(Arrivals::PeakHourFactor(0.9)),
        ..Counted::default()
    };
    arms[0].arms[2].counted = Some(before);
    let south = |text: &str| {
        let joined = counts(text).into_approaches(&arms, &[], RIGHT).unwrap();
        let south = joined.approaches[2].counted.unwrap();
        (south.heavy_vehicles, south.arrivals)
    };
    assert_eq!(south("INTID,NBL,NBT,NBR\n7,1,80,1\n"), (Some(0.15), before.arrivals));
    let counted = south("INTID,NBL,NBT,NBR,NB HV %\n7,1,80,1,5\n").0.unwrap();
    assert!((counted - 0.05).abs() < 1e-9, "{counted}");
}

#[test]
fn sums_of_pedestrians_are_not_added_to_their_parts() {
    let people = |columns: &str, row: &str| {
        let counts = counts(&format!("INTID,NBL,NBT,NBR,{columns}\n7,1,2,3,{row}\n"));
        let joined = counts.into_approaches(&cross(), &[], RIGHT).unwrap();
        (joined.approaches[2].counted.unwrap().pedestrians_per_h, doubts(&joined))
    };
    let (both_ways, said) = people("NB Peds CW,NB Peds CCW,NB Peds Total", "10,15,25");
    assert_eq!(both_ways, Some(25.0));
    assert!(said.contains("columns that are not used: NB Peds Total"), "{said}");
    assert_eq!(people("NB Peds CW,NB Peds Total", "10,25").0, Some(25.0));
    let (all, said) = people("NB Peds,PEDS", "10,10");
    assert!(all == Some(10.0) && said.contains("not used: PEDS"), "{said}");
    let e = refused("INTID,NBL,NBT,NBR,SBT,NB Peds,PEDS\n7,1,2,3,4,5,9\n");
    assert!(e.contains("column PEDS may be the sum of NB Peds and others; remove it"), "{e}");
    let e = refused("INTID,NBL,NBT,NBR,NB Peds,Northbound Peds\n7,1,2,3,4,5\n");
    assert!(e.contains("columns NB Peds and Northbound Peds count the same"), "{e}");
}

#[test]
fn heavy_vehicles_that_may_be_something_else_are_refused() {
    let e = refused("INTID,NBL,NBT,NBR,NB HV\n7,100,400,50,33\n");
    assert!(e.contains("column NB HV may have percentages or numbers of heavy vehicles"), "{e}");
    assert!(e.contains("call it NB HV % or NB HV count"), "{e}");
    let e = refused("INTID,NBL,NBT,NBR,NB HV count,NB HV percent\n7,100,400,50,20,5\n");
    assert!(e.contains("columns NB HV count and NB HV percent count the same"), "{e}");
    let count = counts("INTID,NBL,NBT,NBR,NB HV count\n7,100,400,50,33\n");
    let joined = count.into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(joined.approaches[2].counted.unwrap().heavy_vehicles, Some(0.06));
    let e = refused("INTID,NBL,NBT,NBR,NB HV count\n7,1,2,3,33\n");
    assert!(e.contains("line 2: 33 heavy vehicles NB, but 6 vehicles there"), "{e}");
    let e = refused("INTID,NBL,NBT,NBR,NB Trucks Thru\n7,100,400,50,40\n");
    assert!(e.contains("column NBT may contain the vehicles of NB Trucks Thru; if it does not, call it NBT Cars"), "{e}");
    let classes = counts("INTID,NBL,NBT Cars,NBR,NB Trucks Thru\n7,100,360,50,40\n");
    let joined = classes.into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(through(&joined), 400.0);
}

#[test]
fn directions_that_no_arm_has_are_named_with_the_arms() {
    let mut arms = cross();
    for (arm, name) in arms[0].arms.iter_mut().zip(["NE Oak", "SW Oak", "SE Main", "NW Main"]) {
        arm.arm = name.to_owned();
    }
    let e = counts("INTID,NBL,NBT,SBT\n7,1,100,50\n").into_approaches(&arms, &[], RIGHT);
    let e = e.unwrap_err().to_string();
    let expected = "intersection 7: its counted directions NB SB belong to none of its arms NE Oak, SW Oak, SE Main, NW Main";
    assert!(e.contains(expected), "{e}");
}

#[test]
fn an_int_that_is_no_intersection_is_named_and_hours_that_overlap_are_refused() {
    let int = counts("NBL,NBT,NBR,Int\n10,80,6,96\n").into_approaches(&cross(), &[], RIGHT);
    let e = int.unwrap_err().to_string();
    assert!(
        e.contains("(96) is one of the table (7)") && e.contains("column Int was read as"),
        "{e}"
    );
    let rolling = northbound("Time", &[("7:00-8:00", 100), ("7:15-8:15", 110)]);
    let e = counts(&rolling).into_approaches(&cross(), &[], RIGHT).unwrap_err().to_string();
    assert!(e.contains("line 3: begins at 07:15, before the row of line 2 ends at 08:00"), "{e}");
    let e = refused("INTID,NBL,NBT,NBR,NBRTOR\n7,1,2,3,4\n");
    assert!(e.contains("column NBRTOR may count vehicles, and is not understood"), "{e}");
}

#[test]
fn columns_of_totals_may_be_called_app_and_int() {
    let text = ",Northbound,,,,Southbound,,,,\nTime,R,T,L,App,R,T,L,App,Int\n7:00,1,80,3,84,4,50,6,60,144\n";
    let joined = counts(text).into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(
        (volumes(&joined)[2], volumes(&joined)[0]),
        (Some([3.0, 80.0, 1.0]), Some([6.0, 50.0, 4.0]))
    );
}
