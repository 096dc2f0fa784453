//! Tests of loading scenarios.

use super::*;

#[test]
fn salt_lake_city_has_164_point_mdps_of_282_intersections() {
    let loaded = load("salt-lake-city").unwrap();
    assert_eq!((loaded.intersections.len(), loaded.family.points.len()), (282, 164));
    assert_eq!((loaded.family.points[0].instances, loaded.scenario.version), (19, 2));
    let instances = |is: &dyn Fn(&PointMdp) -> bool| -> u32 {
        loaded.family.points.iter().filter(|p| is(p)).map(|p| p.instances).sum()
    };
    assert_eq!(instances(&|p| p.instances == 1), 117);
    assert_eq!(instances(&|p| p.features[3] == 60.0), 4, "raised to the minimal inflow");
    let imputed: Vec<u32> =
        loaded.intersections.iter().map(|i| i.imputed).filter(|n| *n > 0).collect();
    assert_eq!((imputed.len(), imputed.iter().sum::<u32>()), (30, 36));
    assert_eq!(load("smoke").unwrap().scenario.version, 1, "without a version it is the first");
}

#[test]
fn the_design_hour_has_other_point_mdps_of_the_same_table() {
    let (mean, peak) = (load("salt-lake-city").unwrap(), load("salt-lake-city-peak").unwrap());
    assert_eq!((peak.intersections, peak.table), (mean.intersections, mean.table));
    assert_eq!(peak.family.points.len(), 187);
    let mut settings = peak.scenario;
    (settings.name, settings.title) = (mean.scenario.name.clone(), mean.scenario.title.clone());
    settings.version = mean.scenario.version;
    settings.family.hourly_share = mean.scenario.family.hourly_share;
    assert_eq!(settings, mean.scenario);
}

/// The ids of a family of intersections with these ids, each with one arm.
fn per_approach(ids: &[&str]) -> Result<Vec<String>, String> {
    let mut table = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,\
        left_turn_lanes,right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,\
        movements\n"
        .to_owned();
    for id in ids {
        table += &format!("{id},A,40,-111,0,2,1,1,0,30,200,9000,\n");
        table += &format!("{id},B,40,-111,90,2,1,1,0,30,200,9000,\n");
    }
    let text = "name = \"x\"\n[family]\napproaches = \"a.csv\"\ndetail = \"per-approach\"\n";
    let loaded = from_text(text, "t.toml", &[], &|_| Ok(table.clone()));
    let loaded = loaded.map_err(|e| e.to_string())?;
    Ok(loaded.family.points.into_iter().map(|p| p.id).collect())
}

#[test]
fn only_plain_numbers_are_renamed_and_two_intersections_of_one_point_id_are_refused() {
    let ids = per_approach(&["7", "007", "12345", "99999999999", "n7"]).unwrap();
    assert_eq!(ids, ["007", "99999999999", "i0007", "i12345", "n7"]);
    assert_eq!(
        per_approach(&["7", "i0007"]).unwrap_err(),
        "a.csv: intersection = i0007: the point MDP would be called i0007, as that of \
         intersection 7; rename one of the two"
    );
}

/// A family of two intersections, of which one was counted in two periods.
fn with_periods(periods: &str) -> Result<LoadedScenario, String> {
    let header = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
        right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements,period,left_vph,through_vph,right_vph\n";
    let mut table = header.to_owned();
    for (id, period, volume) in [("7", "am", 100), ("7", "pm", 300), ("Main", "pm", 200)] {
        for (arm, bearing_deg) in [("A", 0), ("B", 180)] {
            let place = if id == "7" { "," } else { "40,-111" };
            table += &format!(
                "{id},{arm},{place},{bearing_deg},2,2,0,0,30,200,,lsr,{period},0,{volume},0\n"
            );
        }
    }
    let text = format!("[family]\napproaches = \"a.csv\"\n{periods}");
    from_text(&text, "t.toml", &[], &|_| Ok(table.clone())).map_err(|e| e.to_string())
}

#[test]
fn an_intersection_is_a_point_mdp_in_every_period_and_counts_by_its_hours() {
    let loaded = with_periods("periods = { am = 500, pm = 250 }\n").unwrap();
    let points: Vec<(&str, f64, f64)> =
        loaded.family.points.iter().map(|p| (&*p.id, p.importance, p.features[3])).collect();
    assert_eq!(
        points,
        [("i0007-am", 0.5, 100.0), ("Main-pm", 0.25, 200.0), ("i0007-pm", 0.25, 300.0)]
    );
    let inflows = loaded.scenario.family.inflows.unwrap();
    assert_eq!((inflows.by_turn, inflows.counted), (1.0, 1.0));
    let equal = with_periods("").unwrap();
    assert!(equal.family.points.iter().all(|p| (p.importance - 1.0 / 3.0).abs() < 1e-12));
    let doubts: Vec<String> = equal.doubts.iter().map(Doubt::brief).collect();
    assert!(doubts.iter().any(|d| d.starts_with("the periods am, pm count equally")), "{doubts:?}");
}

#[test]
fn periods_and_their_hours_must_fit_together() {
    for (periods, why) in [
        ("am = 500", "no hours for its period \"pm\""),
        ("am = 1, pm = 1, night = 1", "night = 1: expected hours per year above 0, of a period"),
        ("am = 0, pm = 1", "hours per year above 0"),
    ] {
        let e = with_periods(&format!("periods = {{ {periods} }}\n")).unwrap_err();
        assert!(e.contains(why), "{periods}: {e}");
    }
}

#[test]
fn a_point_mdp_is_called_by_the_streets_in_the_names_of_its_arms() {
    let table = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,right_turn_lanes,\
        speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n7,NB Oak Ave,,,180,2,2,0,0,30,200,5000,\n\
        7,SB Oak Ave,,,0,2,2,0,0,30,200,5000,\n7,EB Main St,,,270,2,2,0,0,30,200,5000,\n";
    let text = "[family]\napproaches = \"a.csv\"\n";
    let title = |table: &str| {
        let loaded = from_text(text, "t.toml", &[], &|_| Ok(table.to_owned())).unwrap();
        (loaded.family.points[0].id.clone(), loaded.family.points[0].title.clone())
    };
    assert_eq!(title(table), ("i0007".into(), "Oak Ave / Main St".into()));
    assert_eq!(title(&table.replace("EB Main St", "west")).1, "i0007");
}

#[test]
fn a_table_is_a_scenario_whatever_the_case_of_its_columns_and_counts_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let load = |name: &str| load(folder.path().join(name).to_str().unwrap()).unwrap();
    let (header, rows) = EMBEDDED_TABLES[0].1.split_once('\n').unwrap();
    let points = "point,importance,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes\n\
                  a,1,4,30,300,500,0,0\n";
    for (name, text) in [
        ("streets.csv", format!("{}\n{rows}", header.to_uppercase())),
        ("points.csv", points.to_owned()),
        ("streets.toml", "[family]\napproaches = \"streets.csv\"\n".to_owned()),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let streets = load("streets.csv");
    assert_eq!((streets.family.points.len(), streets.scenario.name.as_str()), (282, "streets"));
    assert_eq!(streets.scenario.family.detail, Detail::PerApproach);
    assert_eq!(streets, load("streets.toml"), "the scenario whose file names it");
    assert_eq!(load("points.csv").family.points[0].id, "a");
    let path = folder.path().join("counts.csv");
    std::fs::write(&path, "INTID,Date,Time,NBL,NBT\n1,1/1/2026,07:00,1,2\n").unwrap();
    let e = super::load(path.to_str().unwrap()).unwrap_err().to_string();
    assert!(e.contains("counts.csv, line 1: a table without the columns of a scenario"), "{e}");
    assert!(e.contains("--turning-counts"), "{e}");
}
