//! The join of real signals and counts to the embedded intersections of Salt Lake City.
//!
//! The data is not part of the repository (its licence is unclear); without it the test says so
//! and ends. The arms of the embedded table are schematic: straight, 90 or 120 degrees apart. In
//! a city laid out in squares that is close enough to compare with counted lines.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

use osm_signals::counts::{CountMatch, CountSettings, Counts};
use osm_signals::extract::Place;
use osm_signals::geometry::{LocalMetric, distance_m};
use osm_signals::signals::{SignalColumns, SignalList};
use tsc_family::traffic::family::approaches::Approach;
use tsc_family::traffic::family::features::inflow_vph;
use tsc_family::traffic::family::load::{LoadedScenario, load};

/// Metres on the ground per metre of the table's lengths, which were measured in EPSG:3395.
const LENGTH_SCALE: f64 = 0.757;

/// Distance within which a listed signal is that of an intersection, metres.
const SIGNAL_M: f64 = 40.0;

#[expect(
    clippy::explicit_write,
    reason = "the test harness shows what is printed of failures only"
)]
fn data(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/udot").join(name);
    if !path.exists() {
        writeln!(std::io::stderr(), "skipped: there is no {}", path.display()).unwrap();
    }
    path.exists().then_some(path)
}

/// The street of an arm: straight from the centre in the arm's direction, moved to the right to
/// where no street is if wrong matches are to be counted.
fn street(arm: &Approach, right_m: f64) -> [Place; 2] {
    let metric = LocalMetric::at(arm.latitude);
    let (sin, cos) = arm.bearing_deg.to_radians().sin_cos();
    let place = |along_m: f64| {
        let (east, north) = (along_m * sin + right_m * cos, along_m * cos - right_m * sin);
        let latitude = arm.latitude + north / metric.north_m_per_deg;
        Place::from_degrees(latitude, arm.longitude + east / metric.east_m_per_deg).unwrap()
    };
    [place(0.0), place(arm.length_m * LENGTH_SCALE)]
}

fn lanes(arm: &Approach) -> u32 {
    arm.lanes_in + arm.lanes_out
}

fn matched(counts: &Counts, arm: &Approach) -> Option<CountMatch> {
    counts.along(&street(arm, 0.0), lanes(arm))
}

fn arms(city: &LoadedScenario) -> impl Iterator<Item = &Approach> {
    city.intersections.iter().flat_map(|i| &i.arms)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (mean_a, mean_b) = (mean(a), mean(b));
    let product = |x: &[f64], mean_x: f64, y: &[f64], mean_y: f64| {
        x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>()
    };
    product(a, mean_a, b, mean_b)
        / (product(a, mean_a, a, mean_a) * product(b, mean_b, b, mean_b)).sqrt()
}

/// Quartiles of values.
fn quartiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    [1, 2, 3].map(|q| sorted[(sorted.len() - 1) * q / 4])
}

fn described(values: &[f64]) -> String {
    let mean = mean(values);
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let [first, second, third] = quartiles(values);
    format!(
        "n {}, quartiles {first:.1} / {second:.1} / {third:.1}, mean {mean:.1}, sd {:.1}",
        values.len(),
        variance.sqrt()
    )
}

#[test]
fn nearly_every_embedded_intersection_has_a_listed_signal() {
    let Some(path) = data("signals_slc.csv") else { return };
    let list = SignalList::read(&path, &SignalColumns::default()).unwrap();
    assert_eq!(list.signals.len(), 352);
    let city = load("salt-lake-city").unwrap();
    let nearest: Vec<f64> = city
        .intersections
        .iter()
        .map(|i| {
            let place = Place::from_degrees(i.latitude, i.longitude).unwrap();
            list.signals.iter().map(|s| distance_m(place, s.place)).fold(f64::MAX, f64::min)
        })
        .collect();
    let share =
        |limit: f64| nearest.iter().filter(|d| **d <= limit).count() as f64 / nearest.len() as f64;
    println!("distance to the nearest listed signal, m: {}", described(&nearest));
    for limit in [10.0, 20.0, SIGNAL_M, 80.0] {
        println!("  within {limit} m: {:.3}", share(limit));
    }
    assert!((0.82..0.92).contains(&share(SIGNAL_M)));
    assert!(quartiles(&nearest)[1] < 12.0);
}

#[test]
fn counts_are_joined_to_the_arms_whose_street_they_are_of() {
    let Some(path) = data("slc_segments_aadt2019.geojson") else { return };
    let city = load("salt-lake-city").unwrap();
    let total = arms(&city).count() as f64;
    let read = |settings: CountSettings| Counts::read(&path, &settings).unwrap();
    let share = |settings: CountSettings, right_m: f64| {
        let counts = read(settings);
        let found = |a: &&Approach| counts.along(&street(a, right_m), lanes(a)).is_some();
        arms(&city).filter(found).count() as f64 / total
    };
    for match_m in [5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 80.0] {
        let settings = CountSettings { match_m, ..CountSettings::default() };
        let [own, moved, far] = [0.0, 60.0, 100.0].map(|m| share(settings.clone(), m));
        println!(
            "match_m {match_m}: {own:.3} of arms; {moved:.3} if moved by 60 m, {far:.3} by 100 m"
        );
    }
    for match_deg in [10.0, 20.0, 30.0, 45.0, 60.0] {
        let settings = CountSettings { match_deg, ..CountSettings::default() };
        println!("match_deg {match_deg}: {:.3} of arms", share(settings, 0.0));
    }
    let limit = CountSettings::default().max_veh_per_day_per_lane;
    let unlimited = CountSettings { max_veh_per_day_per_lane: 1e6, ..CountSettings::default() };
    let unlimited = read(unlimited);
    let of_arms: Vec<_> = arms(&city).filter_map(|a| Some((a, matched(&unlimited, a)?))).collect();
    let above =
        |(arm, m): &&(&Approach, CountMatch)| m.aadt_veh_per_day > limit * f64::from(lanes(arm));
    let above: Vec<_> = of_arms.iter().filter(above).map(|(_, m)| &m.id).collect();
    println!("{} arms without a limit per lane, above {limit}: {above:?}", of_arms.len());
    assert!((4..=10).contains(&above.len()));
    let counts = read(CountSettings::default());
    println!("{} lines, field {}, {:?}", counts.len(), counts.field(), counts.bounds());
    assert_eq!((counts.len(), counts.field()), (764, "AADT2021"));
    let found: Vec<_> = arms(&city).filter_map(|a| matched(&counts, a)).collect();
    println!("share of arms with a count: {:.3}", found.len() as f64 / total);
    let of = |f: fn(&CountMatch) -> f64| described(&found.iter().map(f).collect::<Vec<_>>());
    println!("distance, m: {}", of(|m| m.distance_m));
    println!("angle, degrees: {}", of(|m| m.angle_deg));
    assert!((0.64..0.74).contains(&(found.len() as f64 / total)));
    assert!(share(CountSettings::default(), 60.0) < 0.03);
    let distances: Vec<_> = found.iter().map(|m| m.distance_m).collect();
    assert!(quartiles(&distances)[1] < 2.0 && quartiles(&distances)[2] < 5.0);
}

/// A joined arm: its count, its inflow from the count and the embedded one.
struct Joined<'a> {
    arm: &'a Approach,
    aadt: f64,
    ours: f64,
    theirs: f64,
}

#[test]
fn inflows_from_counts_are_plausible_where_embedded_ones_are_not() {
    let Some(path) = data("slc_segments_aadt2019.geojson") else { return };
    let city = load("salt-lake-city").unwrap();
    let settings = CountSettings { field: Some("AADT2019".into()), ..CountSettings::default() };
    let counts = Counts::read(&path, &settings).unwrap();
    let inflow = |arm: &Approach| inflow_vph(arm, &city.scenario.family);
    let join = |arm| {
        let aadt = matched(&counts, arm)?.aadt_veh_per_day;
        // A one-way street's count is of its only direction.
        let directions = if arm.lanes_out > 0 { 2.0 } else { 1.0 };
        let aadt_veh_per_day_per_lane = aadt / directions / f64::from(arm.lanes_in);
        let ours = inflow(&Approach { aadt_veh_per_day_per_lane, ..arm.clone() });
        Some(Joined { arm, aadt, ours, theirs: inflow(arm) })
    };
    let joined: Vec<_> = arms(&city).filter(|a| a.lanes_in > 0).filter_map(join).collect();
    let (ours, theirs): (Vec<_>, Vec<_>) = joined.iter().map(|j| (j.ours, j.theirs)).unzip();
    println!("inflow from counts, veh/h: {}", described(&ours));
    println!("inflow embedded, veh/h:    {}", described(&theirs));
    let of_arms = correlation(&ours, &theirs);
    let mut groups: BTreeMap<&str, Vec<&Joined>> = BTreeMap::new();
    for j in &joined {
        groups.entry(&j.arm.intersection).or_default().push(j);
    }
    let of_group = |group: &Vec<&Joined>, f: fn(&Joined) -> f64| {
        group.iter().map(|j| f(j)).sum::<f64>() / group.len() as f64
    };
    let (a, b): (Vec<_>, Vec<_>) =
        groups.values().map(|g| (of_group(g, |j| j.ours), of_group(g, |j| j.theirs))).unzip();
    let of_intersections = correlation(&a, &b);
    println!("correlation: arms {of_arms:.3}, {} intersections {of_intersections:.3}", a.len());

    let embedded = |a: &Approach| a.aadt_veh_per_day_per_lane;
    let ratios = |divisor: fn(&Approach) -> u32| {
        let known = joined.iter().filter(|j| embedded(j.arm) > 0.0);
        let ratio = |j: &Joined| j.aadt / (embedded(j.arm) * f64::from(divisor(j.arm)));
        quartiles(&known.map(ratio).collect::<Vec<_>>())
    };
    println!("count / (embedded per lane * lanes in): {:.2?}", ratios(|a| a.lanes_in));
    println!("count / (embedded per lane * all lanes): {:.2?}", ratios(lanes));

    // Both arms of a street that goes through an intersection have much the same traffic.
    let apart = |a: f64, b: f64| a.max(b) / a.min(b).max(1.0);
    let total = |a: &Approach| embedded(a) * f64::from(lanes(a));
    let opposite =
        |a: &Joined, b: &Joined| (b.arm.bearing_deg - a.arm.bearing_deg - 180.0).abs() < 1.0;
    let (our_pairs, their_pairs): (Vec<_>, Vec<_>) = groups
        .values()
        .flat_map(|g| g.iter().flat_map(|a| g.iter().map(|b| (*a, *b))))
        .filter(|(a, b)| opposite(a, b))
        .map(|(a, b)| (apart(a.aadt, b.aadt), apart(total(a.arm), total(b.arm))))
        .unzip();
    println!(
        "ratio of {} opposite arms: from counts {:.2?}",
        our_pairs.len(),
        quartiles(&our_pairs)
    );
    println!("  embedded {:.2?}", quartiles(&their_pairs));

    let per_lane = |aadt: f64, arm: &Approach| aadt / f64::from(lanes(arm));
    let limit = settings.max_veh_per_day_per_lane;
    for arm in arms(&city).filter(|a| embedded(a) > limit) {
        let found = matched(&counts, arm);
        let found = found.map(|m| format!("{:.0} ({})", per_lane(m.aadt_veh_per_day, arm), m.id));
        println!(
            "intersection {} arm {}, lanes {}+{}: embedded {} per lane, from counts {}",
            arm.intersection,
            arm.arm,
            arm.lanes_in,
            arm.lanes_out,
            embedded(arm),
            found.unwrap_or_else(|| "none".to_owned())
        );
    }
    assert!(joined.iter().all(|j| per_lane(j.aadt, j.arm) <= limit));
    let [_, median, _] = quartiles(&ours);
    assert!((290.0..380.0).contains(&median), "{median}");
    assert!((0.3..0.6).contains(&of_arms) && (0.5..0.75).contains(&of_intersections));
    assert!(quartiles(&our_pairs)[1] < 1.1 && quartiles(&their_pairs)[1] > 1.3);
}
