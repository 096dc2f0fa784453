//! Readers of scenarios: the TOML, what replaces its settings, the tables that it names.

use osm_signals::DrivingSide;
use tsc_family::family::MdpFamily;
use tsc_family::family::error::FamilyError;
use tsc_family::traffic::existing::{NamedPlan, schedule, table};
use tsc_family::traffic::family::approaches::{Approach, read, to_csv};
use tsc_family::traffic::family::load::{LoadedScenario, from_text};
use tsc_family::traffic::network::demand::DemandSpec;
use tsc_family::traffic::network::intersection::intersections;
use tsc_family::traffic::settings::{DemandSettings, Scenario};
use tsc_family::traffic::turning::TurningCounts;
use tsc_family::traffic::utdf::Utdf;

/// Scenarios of each kind of table.
const POINTS: &str = "name = \"fuzz\"\n[family]\npoints = \"table.csv\"\n";
const APPROACHES: &str = "name = \"fuzz\"\n[family]\napproaches = \"table.csv\"\n";
const PER_APPROACH: &str = "detail = \"per-approach\"\n";

/// A crossing and a fork without counts.
const JUNCTIONS: &str = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
    right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n\
    7,N,,,0,2,2,0,0,30,200,,lsr\n7,E,,,90,2,2,1,0,30,200,,\n7,S,,,180,2,2,0,0,30,200,,\n7,W,,,270,0,2,0,0,30,200,,\n\
    8,A,,,60,1,1,0,0,30,200,,lr\n8,B,,,180,1,1,0,0,30,200,,lr\n8,C,,,300,1,1,0,0,30,200,,lr\n";

/// Tables that are in order.
const POINT_TABLE: &str = include_str!("../seeds/points/smoke");
const APPROACH_TABLE: &str = include_str!("../seeds/approaches/two");

fn loaded(text: &str, table: &str) -> Result<LoadedScenario, FamilyError> {
    from_text(text, "fuzz.toml", &[], &|_| Ok(table.to_owned()))
}

/// What every family is.
fn sound(family: &MdpFamily) {
    assert!(!family.points.is_empty(), "a family without point MDPs is an error");
    let sum: f64 = family.points.iter().map(|p| p.importance).sum();
    assert!((sum - 1.0).abs() < 1e-3, "importance sums to {sum}");
    for point in &family.points {
        assert!(point.importance >= 0.0 && point.features.iter().all(|x| x.is_finite()));
        assert!(!point.id.contains(['/', '\0']) && point.id != "..", "{} is no name", point.id);
        assert_eq!(point.features.len(), family.features.len());
    }
}

/// A table of point MDPs, in any encoding that is read.
pub(crate) fn points(bytes: &[u8]) {
    let Ok(text) = sheet::decode(bytes) else { return };
    if let Ok(loaded) = loaded(POINTS, &text) {
        sound(&loaded.family);
    }
}

/// A table of approaches, for both kinds of families.
pub(crate) fn approaches(bytes: &[u8]) {
    let Ok(text) = sheet::decode(bytes) else { return };
    for scenario in [APPROACHES.to_owned(), format!("{APPROACHES}{PER_APPROACH}")] {
        if let Ok(loaded) = loaded(&scenario, &text) {
            sound(&loaded.family);
            let members: usize = loaded.members.iter().map(Vec::len).sum();
            assert_eq!(members, loaded.intersections.len(), "every intersection counts once");
        }
    }
}

/// Turning counts, given to a crossing and to a fork.
pub(crate) fn turning_counts(bytes: &[u8]) {
    let mut counts = TurningCounts::default();
    if counts.add(bytes, "counts.csv").is_err() {
        return;
    }
    let table = read(JUNCTIONS, "table.csv", Some(f64::NAN)).expect("the table is in order");
    let period = "am=06:00-10:00,500".parse().expect("a period");
    for periods in [vec![], vec![period]] {
        if let Ok(joined) = counts.into_approaches(&table, &periods, DrivingSide::Right) {
            simulated(joined.approaches);
        }
    }
}

/// A network in UTDF.
pub(crate) fn utdf(bytes: &[u8]) {
    let mut utdf = Utdf::default();
    if utdf.add(bytes, "network.csv").is_err() {
        return;
    }
    if let Ok(converted) = utdf.intersections() {
        simulated(converted.intersections.into_iter().flat_map(|i| i.arms).collect());
        let numbered = converted.plans.all.into_iter().enumerate();
        let numbered = numbered.map(|(i, plan)| NamedPlan { intersection: i.to_string(), ..plan });
        shown(&numbered.collect::<Vec<_>>());
    }
}

/// A table of existing plans.
pub(crate) fn existing(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(plans) = table::read(text, "plans.csv") {
        shown(&plans.all);
    }
}

/// Checks that plans read back as they are written, and have a cycle that can be shown.
fn shown(plans: &[NamedPlan]) {
    if plans.is_empty() {
        return;
    }
    let text = table::to_csv(plans);
    let again = table::read(&text, "plans.csv").expect("what is written is read");
    assert_eq!(table::to_csv(&again.all), text);
    for named in plans {
        let (timed, cycle_s) = schedule(&named.plan);
        assert!(timed.iter().all(|t| t.begin_s <= cycle_s), "{named:?}");
    }
}

/// Checks that approaches are a table that reads back, and that each of its intersections has vehicles to draw.
fn simulated(approaches: Vec<Approach>) {
    let Ok(loaded) = loaded(&format!("{APPROACHES}{PER_APPROACH}"), &to_csv(&approaches)) else {
        // Arms without counts and without daily ones.
        assert!(approaches.iter().any(|a| a.counted.is_none()), "{}", to_csv(&approaches));
        return;
    };
    sound(&loaded.family);
    for spec in intersections(&loaded).expect("features are in order") {
        let demand = DemandSpec::from_intersection(&spec, &DemandSettings::default());
        let demand = demand.expect("every counted turn exists");
        assert!(demand.streams.iter().all(|s| s.inflow_vph.is_finite() && s.inflow_vph >= 0.0));
    }
}

/// A scenario.
pub(crate) fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for table in [POINT_TABLE, APPROACH_TABLE] {
        if let Ok(loaded) = loaded(text, table) {
            reads_back(&loaded.scenario);
            sound(&loaded.family);
        }
    }
}

/// Checks that settings are the same once they were written, as they are in manifests.
fn reads_back(scenario: &Scenario) {
    let json = serde_json::to_string(scenario).expect("settings are plain data");
    let read: Scenario = serde_json::from_str(&json).expect("they were written");
    assert_eq!(&read, scenario);
}
