//! How good a derived family is: what was found, what was not and why, and how much of it rests on
//! the map rather than on assumptions.

use std::collections::BTreeMap;

use serde::Serialize;

use super::city::City;
use super::counts::Counts;
use super::extract::Extract;
use super::intersections::{Intersection, Skip};
use super::listing::ListMatch;
use super::oddities::{Oddities, Oddity};
use super::streets::Source;
use super::traffic::ArmTraffic;

/// Examples of signals that are named per reason.
const EXAMPLES: usize = 5;

/// A file that went in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// What it is: `extract`, `signals`, `aadt`, `boundary`, `config`.
    pub role: &'static str,
    /// Its name, without its folder.
    pub name: String,
    /// Hash of its bytes.
    pub sha256: String,
}

/// Signals that are no intersection for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SkipCount {
    /// The reason.
    pub reason: Skip,
    /// The reason in words.
    pub text: &'static str,
    /// How many signals.
    pub signals: usize,
    /// Some of their nodes.
    pub examples: Vec<i64>,
}

/// What the values of one feature rest on, over approaches; the shares sum to 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Provenance {
    /// The feature: `lanes`, `turn_lanes`, `speed`, `length`, `inflow`.
    pub feature: &'static str,
    /// Share that is tagged, measured or counted.
    pub tagged: f64,
    /// Share that is the mode or mean of the highway class in the extract.
    pub imputed: f64,
    /// Share that is a default.
    pub default: f64,
}

/// The values of one feature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distribution {
    /// Name with the unit as a suffix.
    pub name: String,
    /// Unit in words.
    pub unit: String,
    /// Mean over intersections.
    pub mean: f64,
    /// Standard deviation over intersections.
    pub sd: f64,
    /// Width of the bins that make intersections one point MDP.
    pub bin: f64,
    /// One value per intersection, before quantising.
    pub values: Vec<f64>,
}

/// One intersection on the map and in `intersections.geojson`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spot {
    /// Id of the intersection.
    pub id: String,
    /// Names of its streets.
    pub streets: Vec<String>,
    /// Latitude, degrees.
    pub latitude: f64,
    /// Longitude, degrees.
    pub longitude: f64,
    /// Number of arms.
    pub arms: usize,
    /// Number of signal nodes.
    pub signals: usize,
    /// Share of its lanes, speeds and inflows that are tagged or counted.
    pub known: f64,
    /// Distance to its place in the signal list, metres.
    pub list_distance_m: Option<f64>,
    /// Mean distance of the matched counts, metres.
    pub count_distance_m: Option<f64>,
}

/// The join of traffic counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CountsSummary {
    /// The field that was read.
    pub field: String,
    /// Counts in the file.
    pub counts: usize,
    /// Approaches in all.
    pub approaches: usize,
    /// Approaches with a count.
    pub matched: usize,
    /// What was skipped of the file.
    pub skipped: Vec<(String, Oddity)>,
}

/// What there is to say of a family that was derived from a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quality {
    /// Name of the family.
    pub name: String,
    /// Version of this program.
    pub version: &'static str,
    /// Files that went in.
    pub inputs: Vec<InputFile>,
    /// Hashes of the tables that were written with it, so that edited ones are noticed.
    pub written: BTreeMap<String, String>,
    /// Drivable ways.
    pub ways: usize,
    /// Signal nodes in the extract.
    pub signals: usize,
    /// Signal nodes that belong to an intersection.
    pub signals_used: usize,
    /// Intersections.
    pub intersections: usize,
    /// Approaches: arms with incoming lanes.
    pub approaches: usize,
    /// Distinct point MDPs.
    pub point_mdps: usize,
    /// Why the other signals are no intersection.
    pub skipped: Vec<SkipCount>,
    /// What values rest on.
    pub provenance: Vec<Provenance>,
    /// Approaches whose street the extract cuts before the next junction.
    pub cut_approaches: usize,
    /// Approaches for which the map leaves no way across the junction.
    pub no_way_across: usize,
    /// The join of traffic counts, if there are any.
    pub counts: Option<CountsSummary>,
    /// Intersections without a sound network, and why.
    pub left_out: BTreeMap<String, String>,
    /// What became of the rows of the signal list.
    pub listed: Vec<ListMatch>,
    /// Values of the map that were ignored.
    pub ignored: Oddities,
    /// The six features.
    pub features: Vec<Distribution>,
    /// The intersections.
    pub spots: Vec<Spot>,
}

/// Returns the quality of a city; what its family adds is given.
///
/// # Arguments
///
/// * `(inputs, written)` — files that went in, and hashes of those that come out.
/// * `features` — the six features of the family.
pub fn quality(
    name: &str,
    (inputs, written): (Vec<InputFile>, BTreeMap<String, String>),
    extract: &Extract,
    city: &City,
    counts: Option<&Counts>,
    features: Vec<Distribution>,
    point_mdps: usize,
) -> Quality {
    let arms = || {
        let intersections = city.found.intersections.iter().zip(&city.traffic);
        intersections
            .flat_map(|(i, traffic)| i.arms.iter().zip(traffic).zip(&i.turns))
            .filter(|((arm, _), _)| arm.lanes_in > 0)
    };
    let approaches = arms().count();
    let share = |feature, source: &dyn Fn(&super::arms::Arm, &ArmTraffic) -> Source| {
        let mut of = BTreeMap::new();
        for ((arm, traffic), _) in arms() {
            *of.entry(source(arm, traffic)).or_insert(0_u32) += 1;
        }
        let share = |s| f64::from(of.get(&s).copied().unwrap_or(0)) / approaches.max(1) as f64;
        Provenance {
            feature,
            tagged: share(Source::Tagged),
            imputed: share(Source::Imputed),
            default: share(Source::Default),
        }
    };
    let marked = |yes| if yes { Source::Tagged } else { Source::Default };
    let counts = counts.map(|counts| CountsSummary {
        field: counts.field().to_owned(),
        counts: counts.len(),
        approaches,
        matched: arms().filter(|((_, t), _)| t.source == Source::Tagged).count(),
        skipped: counts.oddities().iter().map(|(r, o)| (r.to_owned(), o.clone())).collect(),
    });
    Quality {
        name: name.to_owned(),
        version: env!("CARGO_PKG_VERSION"),
        inputs,
        written,
        ways: extract.ways.len(),
        signals: extract.signals.len(),
        signals_used: city.found.intersections.iter().map(|i| i.signals.len()).sum(),
        intersections: city.found.intersections.len(),
        approaches,
        point_mdps,
        skipped: skip_counts(city),
        provenance: vec![
            share("lanes", &|arm, _| arm.lanes_source),
            share("turn_lanes", &|arm, _| marked(arm.marked)),
            share("speed", &|arm, _| arm.speed_source),
            share("length", &|arm, _| marked(!arm.cut && !arm.clamped)),
            share("inflow", &|_, traffic| traffic.source),
        ],
        cut_approaches: arms().filter(|((arm, _), _)| arm.cut).count(),
        no_way_across: arms().filter(|(_, turns)| turns.is_none()).count(),
        counts,
        left_out: city.left_out.clone(),
        listed: city.listed.clone(),
        ignored: extract.oddities.clone(),
        features,
        spots: city.found.intersections.iter().zip(&city.traffic).map(spot).collect(),
    }
}

fn skip_counts(city: &City) -> Vec<SkipCount> {
    let count = |(reason, signals): (Skip, usize)| {
        let of_reason = city.found.skipped.iter().filter(|s| s.reason == reason);
        let examples = of_reason.filter_map(|s| s.signals.first().copied()).take(EXAMPLES);
        SkipCount { reason, text: reason.reason(), signals, examples: examples.collect() }
    };
    city.skips().into_iter().map(count).collect()
}

fn spot((i, traffic): (&Intersection, &Vec<ArmTraffic>)) -> Spot {
    let approaches = || i.arms.iter().zip(traffic).filter(|(arm, _)| arm.lanes_in > 0);
    let known: usize = approaches()
        .map(|(arm, traffic)| {
            let sources = [arm.lanes_source, arm.speed_source, traffic.source];
            sources.iter().filter(|s| **s == Source::Tagged).count()
        })
        .sum();
    let distances: Vec<f64> =
        traffic.iter().filter_map(|t| t.count.as_ref().map(|(_, metres)| *metres)).collect();
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    Spot {
        id: i.id.clone(),
        streets: i.streets().into_iter().map(str::to_owned).collect(),
        latitude: i.centre.latitude(),
        longitude: i.centre.longitude(),
        arms: i.arms.len(),
        signals: i.signals.len(),
        known: known as f64 / (3 * approaches().count().max(1)) as f64,
        list_distance_m: i.list_distance_m,
        count_distance_m: (!distances.is_empty()).then_some(mean),
    }
}
