//! Tests of reading counts and giving them to arms.

use osm_signals::DrivingSide;

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
    read(&text, "a.csv", None).unwrap()
}

fn cross() -> Vec<Intersection> {
    table(&[("7", &[(0.0, "lsr"), (90.0, "lsr"), (180.0, "lsr"), (270.0, "sr")])])
}

fn counts(text: &str) -> TurningCounts {
    let mut counts = TurningCounts::default();
    counts.add(text.as_bytes(), "c.csv").unwrap();
    counts
}

/// Intersections with what was counted in the busiest hour.
fn given(text: &str, intersections: &[Intersection]) -> Joined {
    counts(text).into_approaches(intersections, &[], RIGHT).unwrap()
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

#[track_caller]
fn says(joined: &Joined, expected: &str) {
    let said = doubts(joined);
    assert!(said.contains(expected), "{expected}: {said}");
}

/// Two hours in quarters, of which the second of four is the busiest.
fn quarters(id: &str) -> String {
    let mut text = "DATE,TIME,INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,\
                    WBT,WBR\n"
        .to_owned();
    for (k, time) in ["0700", "0715", "0730", "0745", "0800"].iter().enumerate() {
        let through = [5, 10, 20, 10, 10][k];
        text += &format!("11/5/2026,{time},{id},1,{through},2,0,7,*,1,9,0,0,8,3\n");
    }
    text
}

#[test]
fn the_busiest_hour_reaches_the_arms_that_vehicles_come_from() {
    let joined = given(&quarters("7"), &cross());
    // North has the southbound vehicles, east the westbound ones.
    let expected = [[0.0, 28.0, 0.0], [0.0, 32.0, 12.0], [4.0, 50.0, 8.0], [4.0, 36.0, 0.0]];
    assert_eq!(volumes(&joined), expected.map(Some));
    let south = joined.approaches[2].counted.unwrap();
    assert_eq!(south.arrivals, Some(Arrivals::QuarterHours([13.0, 23.0, 13.0, 13.0])));
    assert_eq!(joined.found[1], "  busiest hour 07:15 to 08:15, 174 vehicles");
    // The western arm had no left turn, and four left turns were counted.
    assert_eq!(joined.approaches[3].movements, "srl");
    says(&joined, "added to its movements (intersection 7, EB left: 4 veh/h)");
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
    says(&joined, "in every period (intersection 8)");
}

#[test]
fn turns_fit_the_exits_that_exist() {
    // A fork: from the south the exits lie half left and right, which a count calls left and through.
    let fork = table(&[("7", &[(60.0, "lr"), (180.0, "lr"), (300.0, "lr")])]);
    let joined = given("INTID,NBL,NBT,NBR\n7,30,70,0\n", &fork);
    assert_eq!(volumes(&joined)[1], Some([30.0, 0.0, 70.0]));
    says(&joined, "30 left, 70 through, 0 right become 30 left, 0 through, 70 right");
    // A T without an arm to the west.
    let tee = table(&[("7", &[(0.0, ""), (90.0, ""), (180.0, "")])]);
    let text = "INTID,NBL,NBT,NBR,NBU,EBT,EBL,EBR\n7,3,60,10,2,4,0,0\n";
    let joined = given(text, &tee);
    assert_eq!(volumes(&joined)[2], Some([0.0, 60.0, 10.0]));
    for expected in [
        "have no exit, and their vehicles are not simulated (intersection 7, NB left: 3 veh/h; intersection 7, NB U-turn: 2 veh/h)",
        "have no arm, and their vehicles are not simulated; correct the direction or bearing_deg (intersection 7, EB: 4 veh/h)",
    ] {
        says(&joined, expected);
    }
    let joined = given("INTID,NBL,NBT,NBR,NBU\n7,3,60,10,2\n", &cross());
    assert_eq!(volumes(&joined)[2], Some([5.0, 60.0, 10.0]));
    says(&joined, "U-turns count as left turns (intersection 7, NB: 2 veh/h)");
    let left_hand = counts("INTID,NBL,NBT,NBR,NBU\n7,3,60,10,2\n");
    let left_hand = left_hand.into_approaches(&cross(), &[], DrivingSide::Left).unwrap();
    assert_eq!(volumes(&left_hand)[2], Some([3.0, 60.0, 12.0]));
    // A turn that exists keeps its vehicles, whatever the others are called.
    let joined = given("INTID,NBL,NBT,NBR\n7,2,300,0\n", &tee);
    assert_eq!(volumes(&joined)[2], Some([0.0, 300.0, 2.0]));
}

#[test]
fn what_was_not_counted_is_said() {
    let joined = given("INTID,NBL,NBT,SBT,SBR,SBL\n7,3,60,*,5,6\n", &cross());
    says(&joined, "have no vehicles (c.csv, intersection 7, NB right; c.csv, intersection 7, SB");
}

#[test]
fn a_street_that_bends_keeps_its_through_traffic() {
    let bent = table(&[("7", &[(50.0, ""), (110.0, ""), (180.0, ""), (270.0, "")])]);
    let text = "INTID,NBL,NBT,NBR,SBL,SBT,SBR,EBL,EBT,EBR,WBL,WBT,WBR\n7,100,400,50,60,300,40,1,2,3,4,5,6\n";
    let joined = given(text, &bent);
    assert_eq!(volumes(&joined)[2], Some([100.0, 0.0, 450.0]));
    assert_eq!(volumes(&joined)[0], Some([360.0, 40.0, 0.0]));
    let exits = |arm: usize| joined.approaches[arm].counted.unwrap().exits_vph;
    assert_eq!(exits(2), Some([100.0, 400.0, 50.0, 0.0, 0.0]));
    assert_eq!(exits(0), Some([60.0, 300.0, 40.0, 0.0, 0.0]));
    let said = doubts(&joined);
    assert!(said.contains("streets bend") && !said.contains("have no exit"), "{said}");
}

#[test]
fn names_are_compared_without_case_leading_zeros_and_what_separates_words() {
    let same = |a: &str, b: &str| meant(a, [b].into_iter()).unwrap() == Some(b);
    assert!(same("Main St / 5th Ave", "main-st_5TH  ave"));
    assert!(same("007", "7") && same("Site 007", "site-7") && same("0", "000"));
    assert!(same("Stra\u{df}e 3", "STRA\u{df}E-03"));
    for (a, b) in [("0", "7"), ("70", "7"), ("1-2", "12"), ("a07", "a7"), ("/", "-")] {
        assert!(!same(a, b), "{a} {b}");
    }
}

#[test]
fn arms_that_are_called_by_directions_keep_them() {
    // The street bends: its northbound end lies in the east.
    let mut arms = cross();
    for (arm, name) in arms[0].arms.iter_mut().zip(["EB", "NB Main St", "WB", "SB Main St"]) {
        arm.arm = name.to_owned();
    }
    let text = "INTID,NBL,NBT,SBT,EBT,NB Peds\n7,1,100,50,7,30\n";
    let joined = given(text, &arms);
    let through = joined.approaches.iter().map(|a| a.counted.unwrap().through_vph);
    assert_eq!(through.collect::<Vec<_>>(), [7.0, 100.0, 0.0, 50.0]);
    assert_eq!(joined.approaches[1].counted.unwrap().pedestrians_per_h, Some(30.0));
}

#[test]
fn pedestrians_cross_the_arm_that_the_vehicles_of_their_direction_have() {
    let skew = table(&[("7", &[(220.0, ""), (135.0, ""), (0.0, "")])]);
    let text = "INTID,NBL,NBR,SBL,SBR,EBL,EBR,NB Peds\n7,11,12,21,22,31,32,25\n";
    let joined = given(text, &skew);
    let counted: Vec<Counted> = joined.approaches.iter().map(|a| a.counted.unwrap()).collect();
    assert_eq!([0, 1, 2].map(|arm: usize| counted[arm].total_vph()), [63.0, 23.0, 43.0]);
    let people = [0, 1, 2].map(|arm: usize| counted[arm].pedestrians_per_h);
    assert_eq!(people, [None, Some(25.0), None], "nobody counted the others");
    says(&joined, "pedestrians were counted on other arms only");
    let joined = given("INTID,NBL,NBT,NBR,NB Peds\n7,1,2,3,9000\n", &cross());
    assert_eq!(joined.approaches[2].counted.unwrap().pedestrians_per_h, Some(3600.0));
    says(&joined, "cross an arm, and so many are simulated (intersection 7, arm 2: 9000)");
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
        let joined = given(text, &arms);
        let south = joined.approaches[2].counted.unwrap();
        (south.heavy_vehicles, south.arrivals)
    };
    assert_eq!(south("INTID,NBL,NBT,NBR\n7,1,80,1\n"), (Some(0.15), before.arrivals));
    let counted = south("INTID,NBL,NBT,NBR,NB HV %\n7,1,80,1,5\n").0.unwrap();
    assert!((counted - 0.05).abs() < 1e-9, "{counted}");
}

const SHEETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/count-sheets");

/// Sheets of `tests/count-sheets`, given to the first of so many corners.
fn joined(names: &[&str], corners: usize) -> Result<Joined, FamilyError> {
    let approaches = std::fs::read_to_string(format!("{SHEETS}/approaches.csv")).unwrap();
    let mut all = read(&approaches, "approaches.csv", Some(f64::NAN)).unwrap();
    all.truncate(corners);
    let files: Vec<PathBuf> = names.iter().map(|name| Path::new(SHEETS).join(name)).collect();
    TurningCounts::read(&files, None)?.into_approaches(&all, &[], RIGHT)
}

/// What was counted on the arms of the first corner, which are north, east, south, west.
fn corner<T>(joined: &Joined, of: fn(Counted) -> T) -> Vec<T> {
    joined.approaches[..4].iter().map(|arm| of(arm.counted.unwrap())).collect()
}

#[test]
fn sheets_of_vendors_and_cities_have_the_volumes_of_all_classes() {
    let all = [[35.0, 286.0, 56.0], [31.0, 164.0, 48.0], [60.0, 392.0, 31.0], [89.0, 204.0, 27.0]];
    let lights =
        [[33.0, 266.0, 52.0], [21.0, 108.0, 31.0], [40.0, 258.0, 21.0], [58.0, 135.0, 18.0]];
    for (name, expected) in [
        ("time-in-upper-heading.csv", all),
        ("vendor.xlsx", all),
        ("vendor-with-peak-sheet.xlsx", all),
        ("vendor-with-classes.xlsx", all),
        ("heavy-of-intersection.csv", all),
        ("heavy-count-and-percent.csv", all),
        ("peds-by-leg.csv", all),
        ("peds-by-walking-direction.csv", all),
        ("peds-with-sum.csv", all),
        // One truck per turn and quarter beside the cars.
        ("classes-as-columns.csv", all.map(|arm| arm.map(|n| n + 4.0))),
        ("approach-class-turn.csv", all),
        ("long-rows.csv", lights),
    ] {
        let corners = if name.starts_with("time-in") { 1 } else { 2 };
        let joined = joined(&[name], corners).unwrap_or_else(|e| panic!("{name}: {e}"));
        let found = corner(&joined, |c| [c.left_vph, c.through_vph, c.right_vph]);
        assert_eq!(found, expected, "{name}: {}", doubts(&joined));
    }
}

#[test]
fn heavy_vehicles_come_from_classes_numbers_or_percentages() {
    let shares = |name: &str| {
        let heavy = corner(&joined(&[name], 2).unwrap(), |c| c.heavy_vehicles.unwrap());
        heavy.into_iter().map(|share| (share * 1e4).round() / 1e4).collect::<Vec<_>>()
    };
    // Trucks and buses of an hour, 80 of 1423, numbers beside percentages, and the classes below the rows.
    assert_eq!(
        shares("approach-class-turn.csv"),
        [16.0 / 377.0, 16.0 / 243.0, 16.0 / 483.0, 16.0 / 320.0]
            .map(|x: f64| (x * 1e4).round() / 1e4)
    );
    assert_eq!(shares("heavy-of-intersection.csv"), [0.0562; 4]);
    assert_eq!(shares("heavy-count-and-percent.csv"), [0.0265, 0.0329, 0.0414, 0.0281]);
    for name in ["vendor.xlsx", "vendor-with-classes.xlsx"] {
        assert_eq!(shares(name), [0.0507, 0.0497, 0.0498, 0.0497], "{name}");
    }
    let joined = joined(&["heavy-count-and-percent.csv"], 2).unwrap();
    says(&joined, "columns that are not used (NB HV %)");
}

#[test]
fn people_cross_the_leg_or_the_approach_that_their_column_names() {
    for (name, expected) in [
        ("peds-by-leg.csv", [Some(1.0), Some(3.0), Some(2.0), Some(4.0)]),
        ("peds-with-sum.csv", [Some(2.0), Some(4.0), Some(1.0), Some(3.0)]),
        // Seven each way in a quarter, without the sum.
        ("peds-by-walking-direction.csv", [Some(28.0), None, Some(44.0), None]),
        ("vendor.xlsx", [Some(20.0); 4]),
    ] {
        let joined = joined(&[name], 2).unwrap();
        assert_eq!(corner(&joined, |c| c.pedestrians_per_h), expected, "{name}");
    }
    let any = given("INTID,NBL,NBT,NBR,PED\n7,1,2,3,20\n", &cross()).approaches.into_iter();
    let any = any.map(|a| a.counted.unwrap().pedestrians_per_h);
    assert_eq!(any.collect::<Vec<_>>(), [Some(5.0); 4]);
}

#[test]
fn sheets_that_repeat_others_are_named_and_an_intersection_may_be_called_by_its_file() {
    let peak = joined(&["vendor-with-peak-sheet.xlsx"], 2).unwrap();
    says(&peak, "sheets that are not used (Summary; AM Peak (7.30 AM - 8.30 AM))");
    let said = doubts(&joined(&["vendor-with-classes.xlsx"], 2).unwrap());
    assert!(said.contains("Lights") && said.contains("Mediums"), "{said}");
    let folder = tempfile::tempdir().unwrap();
    for (name, through) in [("7", 100), ("main st - 8", 200), ("~$7", 1)] {
        let text = format!("Time,NBL,NBT,NBR\n07:00,1,{through},1\n");
        std::fs::write(folder.path().join(format!("{name}.csv")), text).unwrap();
    }
    let mut two = cross();
    two.extend(table(&[("Main St 8", &[(0.0, ""), (180.0, "")])]));
    let counts = TurningCounts::read(&files(&[folder.path().into()]).unwrap(), None).unwrap();
    let joined = counts.into_approaches(&two, &[], RIGHT).unwrap();
    let through = |arm: usize| joined.approaches[arm].counted.unwrap().through_vph;
    assert_eq!((through(2), through(5)), (100.0, 200.0));
}

#[test]
fn a_table_that_fits_no_layout_is_answered_with_its_rows_and_a_layout_to_fill_in() {
    let text = "Kreuzung;Zeit;N links;N gerade;S links;S gerade\n7;07:00;1;2;3;4\n";
    let e = refused(text);
    for expected in ["c.csv, line 1: no layout", "Kreuzung,Zeit", "vehicles = [", "--counts-layout"]
    {
        assert!(e.contains(expected), "{expected}: {e}");
    }
    let folder = tempfile::tempdir().unwrap();
    let [file, layout] = ["c.csv", "l.toml"].map(|name| folder.path().join(name));
    std::fs::write(&file, text.replace("links", "L").replace("gerade", "T")).unwrap();
    std::fs::write(
        &layout,
        "[columns]\nintersection = [\"Kreuzung\"]\ntime = [\"Zeit\"]\nvehicles = [\"{leg} {turn}\"]\n",
    )
    .unwrap();
    let counts = TurningCounts::read(std::slice::from_ref(&file), Some(&layout)).unwrap();
    let joined = counts.into_approaches(&cross(), &[], RIGHT).unwrap();
    assert_eq!(volumes(&joined)[0], Some([1.0, 2.0, 0.0]), "vehicles from the north go south");
    std::fs::write(&layout, "[columns]\nvehicle = []\n").unwrap();
    let e = TurningCounts::read(&[file], Some(&layout)).unwrap_err().to_string();
    assert!(e.contains("l.toml, line 1: not a layout of counts: unknown variant `vehicle`"), "{e}");
}

#[test]
fn columns_that_may_count_vehicles_are_refused() {
    for (columns, why) in [
        ("NBL,NBT,NBR,NBRTOR", "column NBRTOR may count vehicles"),
        ("NBL,NBT,NBR,NB Trucks Thru", "column NB Trucks Thru may count vehicles"),
        ("NBL,NBT,NBR,Net", "column Net may count vehicles"),
        ("NBL,NBT,NBR,UTC Time", "column UTC Time may count vehicles"),
        ("NBL,NBT,NBR,NB Left", "columns NBL and NB Left count the same"),
    ] {
        let cells = columns.split(',').map(|_| "1").collect::<Vec<_>>().join(",");
        let e = refused(&format!("INTID,{columns}\n7,{cells}\n"));
        assert!(e.contains(why), "{columns}: {e}");
    }
    let diagonal = table(&[("7", &[(45.0, ""), (135.0, ""), (225.0, "")])]);
    let net = given("INTID,NEL,NET,NER\n7,0,100,0\n", &diagonal);
    assert_eq!(volumes(&net)[2], Some([0.0, 100.0, 0.0]));
}

#[test]
fn times_and_dates_are_local_and_have_forms_of_the_layout() {
    for (columns, rows) in [
        ("Date,Time", ["11/5/2026,7:00 AM", "11/5/2026,8:00 a.m."]),
        ("Date,Time", ["2026-11-05 00:00:00,0700", "2026-11-05 00:00:00,0800"]),
        ("Time", ["2026-11-05T07:00:00", "2026-11-05T08:00:00"]),
        ("Date,Time", ["5-Nov-2026,\"=\"\"07:00\"\"\"", "5-Nov-2026,7:60 PM"]),
    ] {
        let text = |rows: &[&str]| {
            let row = |(row, n): (&&str, u32)| format!("{row},7,1,{n},1\n");
            let rows: String = rows.iter().zip([100, 50]).map(row).collect();
            format!("{columns},INTID,NBL,NBT,NBR\n{rows}")
        };
        if rows[1].contains("7:60") {
            assert!(refused(&text(&rows)).contains("line 3: time \"7:60 PM\" is not understood"));
            continue;
        }
        let joined = given(&text(&rows), &cross());
        assert_eq!(joined.found[1], "  busiest hour 07:00 to 08:00, 102 vehicles", "{rows:?}");
        assert_eq!(joined.approaches[2].counted.unwrap().arrivals, None);
    }
    for time in ["2026-11-05T13:15:00Z", "07:15-06:00", "7h15"] {
        let e = refused(&format!("Time,INTID,NBL,NBT,NBR\n{time},7,1,2,3\n"));
        assert!(e.contains("is not understood; write it like 07:15, in local time"), "{e}");
    }
}

#[test]
fn weekends_count_only_where_no_working_day_was_counted() {
    let rows = [
        ("11/6/2026,07:00", 100),
        ("11/7/2026,07:00", 900),
        ("11/9/2026,07:00", 300),
        ("11/7/2026,16:00", 200),
    ];
    let rows: String = rows.iter().map(|(row, n)| format!("{row},7,0,{n},0\n")).collect();
    let counts = counts(&format!("Date,Time,INTID,NBL,NBT,NBR\n{rows}"));
    let periods = ["am=06:00-09:00", "pm=15:00-18:00"].map(|p| p.parse().unwrap());
    let joined = counts.into_approaches(&cross(), &periods, RIGHT).unwrap();
    let through: Vec<f64> =
        [2, 6].map(|arm: usize| joined.approaches[arm].counted.unwrap().through_vph).into();
    assert_eq!(through, [200.0, 200.0]);
    says(&joined, "intersection 7, am: 2 days, without weekends (1)");
    says(&joined, "because no working day was counted then (intersection 7, pm)");
}

#[test]
fn what_is_no_count_is_refused_with_the_line_and_the_way_out() {
    for (text, why) in [
        (
            "INTID,NBL,NBT,NBR\n7,1,many,3\n",
            "c.csv, line 2: \"many\" in column 3: write a number such as 40.78",
        ),
        (
            "INTID,NBL,NBT,NBR\n7,1,5,3\n7,1,5,3\n",
            "line 3: the same time as line 2 for NB; remove one of the two",
        ),
        (
            "INTID,NBL,NBT,NBR,NB HV count\n7,1,2,3,33\n",
            "line 2: 33 heavy vehicles NB, but 6 vehicles there",
        ),
        (
            include_str!("../../tests/utdf/two-signals.csv"),
            "a network in UTDF, not a table of counts; give it with --utdf",
        ),
        (
            "study_name,entry_dir_name,movement,classification,volume\n7,N,left,Trams,3\n",
            "the class \"Trams\" is in no list of the layout",
        ),
    ] {
        let e = refused(text);
        assert!(e.contains(why), "{why}: {e}");
    }
    let wrong = |text: &str, table: &[Intersection]| {
        counts(text).into_approaches(table, &[], RIGHT).unwrap_err().to_string()
    };
    let mut named = cross();
    for (arm, name) in named[0].arms.iter_mut().zip(["NE Oak", "SW Oak", "SE Main", "NW Main"]) {
        arm.arm = name.to_owned();
    }
    let e = wrong("INTID,NBL,NBT,SBT\n7,1,100,50\n", &named);
    let expected = "intersection 7: its counted directions NB SB belong to none of its arms NE Oak, SW Oak, SE Main, NW Main";
    assert!(e.contains(expected), "{e}");
    let e = wrong("INTID,NBL,NBT,NBR\n99,1,5,3\n", &cross());
    assert!(e.contains("none of the counted intersections (99) is one of the table (7)"), "{e}");
    let mut two = cross();
    two.extend(table(&[("007", &[(0.0, ""), (180.0, "")])]));
    let e = wrong("INTID,NBL,NBT,NBR\n07,1,5,3\n", &two);
    assert_eq!(
        e,
        "c.csv, line 2: 07 may be intersection 007 or 7; call it exactly like one of them"
    );
}

#[test]
fn totals_and_titles_are_passed_over() {
    let text = "Location:,Main St,,,,,,\n,Southbound,,,,Northbound,,\n,Main St,,,,Main St,,\nStart Time,Left,Thru,Right,\
                App Total,Left,Thru,Right\n4:00 PM,1,2,3,6,4,5,6\n4:15 PM,1,2,3,6,4,5,6\n4:30 PM,1,2,3,9,4,5,6\n\
                4:45 PM,1,2,3,6,4,5,6\nGrand Total,4,8,12,24,16,20,24\n";
    let joined = given(text, &cross());
    assert_eq!(volumes(&joined)[0], Some([4.0, 8.0, 12.0]));
    assert_eq!(volumes(&joined)[2], Some([16.0, 20.0, 24.0]));
    says(&joined, "passed over (line 9: Grand Total 4)");
}
