//! Tests of the decision on made-up streets.

use super::*;
use crate::mirror::mirrored_extract;

/// A place without anything: the streets decide alone.
const SEA: (f64, f64) = (30.0, -40.0);
const LONDON: (f64, f64) = (51.5, -0.12);
const SALT_LAKE_CITY: (f64, f64) = (40.76, -111.89);

/// One-way streets 60 m long with the opposite carriageway 20 m to the left: right-hand traffic.
fn streets(at: (f64, f64), pairs: usize, tag: &str) -> Extract {
    let (mut nodes, mut ways) = (String::new(), String::new());
    let mut number = 0;
    let mut node = |north_m: f64, east_m: f64| {
        number += 1;
        let latitude = at.0 + north_m / 111_195.0;
        let longitude = at.1 + east_m / (111_195.0 * at.0.to_radians().cos());
        nodes += &format!("<node id=\"{number}\" lat=\"{latitude:.7}\" lon=\"{longitude:.7}\"/>");
        number
    };
    for pair in 0..pairs {
        let east_m = 200.0 * pair as f64;
        let (up, down) = (
            [node(0.0, east_m), node(60.0, east_m)],
            [node(60.0, east_m - 20.0), node(0.0, east_m - 20.0)],
        );
        for (i, ends) in [up, down].into_iter().enumerate() {
            ways += &format!(
                "<way id=\"{}\"><nd ref=\"{}\"/><nd ref=\"{}\"/><tag k=\"highway\" v=\"primary\"/>\
                 <tag k=\"oneway\" v=\"yes\"/><tag k=\"name\" v=\"street {pair}\"/>{tag}</way>",
                2 * pair + i + 1,
                ends[0],
                ends[1]
            );
        }
    }
    let file = tempfile::Builder::new().suffix(".osm").tempfile().unwrap();
    std::fs::write(file.path(), format!("<osm version=\"0.6\">{nodes}{ways}</osm>")).unwrap();
    read(file.path())
}

fn read(path: &std::path::Path) -> Extract {
    crate::read::read(path, &|_, _| {}).unwrap()
}

fn auto(extract: &Extract) -> SideDecision {
    decide(extract, SideSetting::Auto, None).unwrap()
}

#[test]
fn the_opposite_carriageway_is_to_the_left_of_right_hand_traffic() {
    let extract = streets(SEA, 3, "");
    let votes = |extract| evidence::carriageways(extract, &|_| true);
    assert_eq!(votes(&extract), Votes { right: 6, left: 0 });
    assert_eq!(votes(&mirrored_extract(&extract)), Votes { right: 0, left: 6 });
    assert_eq!(evidence::carriageways(&extract, &|_| false), Votes::default());
}

#[test]
fn roundabouts_say_it_by_their_sense_in_pieces_and_as_a_whole() {
    for case in ["roundabout", "roundabout_with_signals"] {
        let extract = read(&std::path::Path::new("tests/networks").join(case).join("input.osm"));
        let right = evidence::roundabouts(&extract, &|_| true);
        assert!(right.right > 0 && right.left == 0, "{case}: {right:?}");
        let left = evidence::roundabouts(&mirrored_extract(&extract), &|_| true);
        assert_eq!(left, Votes { right: 0, left: right.right }, "{case}");
    }
}

#[test]
fn a_few_streets_do_not_outweigh_the_country_and_many_do() {
    let one = auto(&streets(LONDON, 1, ""));
    assert_eq!((one.driving_side, one.doubt), (DrivingSide::Left, None));
    let few = auto(&streets(LONDON, 3, ""));
    assert_eq!((few.driving_side, few.decided_by), (DrivingSide::Left, DecidedBy::Country));
    assert_eq!(few.doubt, Some(Doubt::CountryNotStreets));
    let many = auto(&streets(LONDON, 8, ""));
    assert_eq!((many.driving_side, many.decided_by), (DrivingSide::Right, DecidedBy::Streets));
    assert_eq!(many.doubt, Some(Doubt::StreetsNotCountry));
    let usual = auto(&mirrored_extract(&streets((LONDON.0, -LONDON.1), 8, "")));
    assert_eq!((usual.driving_side, usual.decided_by), (DrivingSide::Left, DecidedBy::Country));
    assert_eq!((usual.countries[0].code.as_str(), usual.doubt), ("GB", None));
    assert_eq!(usual.carriageways, Votes { right: 0, left: 16 });
}

#[test]
fn tags_count_where_they_are_the_rule() {
    let tag = "<tag k=\"driving_side\" v=\"left\"/>";
    let all = auto(&streets(SALT_LAKE_CITY, 1, tag));
    assert_eq!((all.driving_side, all.decided_by), (DrivingSide::Left, DecidedBy::Streets));
    // One diverging diamond in a city.
    let mut city = streets(SALT_LAKE_CITY, 20, "");
    city.ways[0].street.driving_side = Some(DrivingSide::Left);
    let city = auto(&city);
    assert_eq!((city.driving_side, city.tags.left), (DrivingSide::Right, 1));
}

#[test]
fn where_nothing_speaks_right_is_assumed_and_told() {
    let nothing = auto(&streets(SEA, 1, ""));
    assert_eq!(
        (nothing.driving_side, nothing.decided_by),
        (DrivingSide::Right, DecidedBy::Nothing)
    );
    assert_eq!(nothing.doubt, Some(Doubt::Nothing));
    let streets = auto(&mirrored_extract(&streets((SEA.0, -SEA.1), 8, "")));
    assert_eq!((streets.driving_side, streets.decided_by), (DrivingSide::Left, DecidedBy::Streets));
    assert_eq!(streets.doubt, None);
}

#[test]
fn a_setting_wins_and_a_contradiction_is_told() {
    let extract = streets(SALT_LAKE_CITY, 8, "");
    let left = decide(&extract, SideSetting::Left, None).unwrap();
    assert_eq!((left.driving_side, left.decided_by), (DrivingSide::Left, DecidedBy::Setting));
    assert_eq!(left.doubt, Some(Doubt::SettingNotStreets));
    assert_eq!(decide(&extract, SideSetting::Right, None).unwrap().doubt, None);
    let few = decide(&streets(SALT_LAKE_CITY, 1, ""), SideSetting::Left, None).unwrap();
    assert_eq!(few.doubt, Some(Doubt::SettingNotCountry));
}

#[test]
fn an_extract_on_both_sides_of_a_border_is_refused_without_a_boundary() {
    // Shenzhen and Hong Kong.
    let mut extract = streets((22.543, 114.058), 8, "");
    extract.nodes.set(1, Place::from_degrees(22.319, 114.169).unwrap());
    extract.nodes.set(5, Place::from_degrees(22.319, 114.17).unwrap());
    let refused = decide(&extract, SideSetting::Auto, None).unwrap_err();
    assert_eq!(
        (&refused.right.countries[..], &refused.left.countries[..]),
        (&["CN".to_owned()][..], &["HK".to_owned()][..])
    );
    assert!(refused.to_string().contains("where traffic keeps to the right (CN)"), "{refused}");
    assert!(decide(&extract, SideSetting::Right, None).is_ok());
    let boundary = Boundary::parse("114.0,22.5,114.2,22.6").unwrap();
    let inside = decide(&extract, SideSetting::Auto, Some(&boundary)).unwrap();
    assert_eq!((inside.driving_side, inside.countries.len()), (DrivingSide::Right, 1));
}
