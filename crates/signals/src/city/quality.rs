//! How good a derived family is: what was found, what was not and why, and how much of it rests on
//! the map rather than on assumptions.

use std::collections::BTreeMap;

use osm_signals::listing::{ListMatch, RowNote};
use osm_signals::oddities::{Oddities, Oddity};
use osm_signals::streets::Source;
use osm_signals::traffic::InflowSource;
use osm_signals::{Arm, Counts, DrivingSide, Extract};
use serde::Serialize;

use super::config::DesignHour;
use super::reason::Reason;
use super::sites::City;
use super::spots::{Spot, spots};

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
    pub reason: Reason,
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
    /// Share that is a count elsewhere on the same street; inflow only.
    pub spread: f64,
    /// Share that is the mode or mean of the highway class in the extract.
    pub imputed: f64,
    /// Share that is a default.
    pub default: f64,
}

/// What became of one row of a signal list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListedRow {
    /// Id in the list.
    pub id: String,
    /// Line in the list, the first line being 1.
    pub line: u64,
    /// Latitude in the list, degrees.
    pub latitude: f64,
    /// Longitude in the list, degrees.
    pub longitude: f64,
    /// Id of its intersection, if it has one.
    pub intersection: Option<String>,
    /// Distance to it, or to that of the row that it repeats, metres.
    pub distance_m: Option<f64>,
    /// Whether the map has a signal there as well.
    pub on_map: bool,
    /// Why it has none, or why its intersection is not called like it.
    pub reason: Option<&'static str>,
    /// Line of the row that has the intersection that this row would have.
    pub duplicate_of: Option<u64>,
}

impl ListedRow {
    fn of((row, left_out): (&ListMatch, Option<Reason>)) -> Self {
        let duplicate_of = match row.note {
            Some(RowNote::Duplicate(line)) => Some(line),
            _ => None,
        };
        Self {
            id: row.id.clone(),
            line: row.line,
            latitude: row.latitude,
            longitude: row.longitude,
            intersection: row.intersection.clone().filter(|_| left_out.is_none()),
            distance_m: row.distance_m,
            on_map: row.on_map,
            reason: left_out.map(Reason::words).or(row.note.map(RowNote::words)),
            duplicate_of,
        }
    }

    /// Returns the reason in words; for a duplicate with the row that it repeats.
    pub fn why(&self) -> Option<String> {
        match self.duplicate_of {
            Some(line) => Some(format!("duplicate of row {line}")),
            None => self.reason.map(str::to_owned),
        }
    }
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
    /// Approaches that have the count of another block of their street.
    pub spread: usize,
    /// How far along a street counts were spread, metres.
    pub spread_m: f64,
    /// What was skipped of the file.
    pub skipped: Vec<(String, Oddity)>,
}

/// What the family adds to what is known of a city.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyFacts {
    /// Its name.
    pub name: String,
    /// Which hour is simulated.
    pub demand: DesignHour,
    /// The six features.
    pub features: Vec<Distribution>,
    /// Distinct point MDPs.
    pub point_mdps: usize,
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
    /// Side of the street that traffic keeps to.
    pub driving_side: DrivingSide,
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
    /// Which hour is simulated.
    pub demand: DesignHour,
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
    /// Turn restrictions at certain times that hold in the simulated hour, and all of them.
    pub timed_restrictions: (usize, usize),
    /// What became of the rows of the signal list.
    pub listed: Vec<ListedRow>,
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
/// * `time_of_day` — when the simulated hour begins, hours after midnight.
/// * `counts` — the counts and how far they were spread, metres.
pub fn quality(
    family: FamilyFacts,
    (inputs, written): (Vec<InputFile>, BTreeMap<String, String>),
    (extract, time_of_day): (&Extract, f64),
    city: &City,
    counts: Option<(&Counts, f64)>,
) -> Quality {
    let arms = || {
        city.sites()
            .flat_map(|site| site.found.arms.iter().zip(site.traffic).zip(&site.found.turns))
            .filter(|((arm, _), _)| arm.lanes_in > 0)
    };
    let approaches = arms().count();
    let share = |feature, source: &dyn Fn(&Arm) -> Source| {
        let mut of = BTreeMap::new();
        for ((arm, _), _) in arms() {
            *of.entry(source(arm)).or_insert(0_u32) += 1;
        }
        let share = |s| f64::from(of.get(&s).copied().unwrap_or(0)) / approaches.max(1) as f64;
        Provenance {
            feature,
            tagged: share(Source::Tagged),
            spread: 0.0,
            imputed: share(Source::Imputed),
            default: share(Source::Default),
        }
    };
    let sources = city.inflow_sources();
    let inflow = Provenance {
        feature: "inflow",
        tagged: sources.counted,
        spread: sources.spread,
        imputed: sources.imputed,
        default: sources.default,
    };
    let resting = |source| arms().filter(|((_, t), _)| t.source == source).count();
    let marked = |yes| if yes { Source::Tagged } else { Source::Default };
    let counts = counts.map(|(counts, spread_m)| CountsSummary {
        field: counts.field.clone(),
        counts: counts.count,
        approaches,
        matched: resting(InflowSource::Counted),
        spread: resting(InflowSource::Spread),
        spread_m,
        skipped: counts.oddities.iter().map(|(r, o)| (r.to_owned(), o.clone())).collect(),
    });
    Quality {
        name: family.name,
        version: env!("CARGO_PKG_VERSION"),
        inputs,
        written,
        driving_side: city.side,
        ways: extract.ways.len(),
        signals: extract.signals.len(),
        signals_used: city.sites().map(|site| site.found.signals.len()).sum(),
        intersections: city.sites().count(),
        approaches,
        point_mdps: family.point_mdps,
        demand: family.demand,
        skipped: skip_counts(city),
        provenance: vec![
            share("lanes", &|arm| arm.lanes_source),
            share("turn_lanes", &|arm| marked(arm.marked)),
            share("speed", &|arm| arm.speed_source),
            share("length", &|arm| marked(!arm.cut && !arm.clamped)),
            inflow,
        ],
        cut_approaches: arms().filter(|((arm, _), _)| arm.cut).count(),
        no_way_across: arms().filter(|(_, turns)| turns.is_none()).count(),
        counts,
        left_out: city.left_out.clone(),
        timed_restrictions: extract.timed_restrictions(time_of_day),
        listed: city.listed().map(ListedRow::of).collect(),
        ignored: extract.oddities.clone(),
        features: family.features,
        spots: spots(city),
    }
}

fn skip_counts(city: &City) -> Vec<SkipCount> {
    let count = |(reason, signals): (Reason, usize)| {
        let of_reason = city.skipped().filter(|s| s.reason == reason);
        let examples = of_reason.filter_map(|s| s.signals.first().copied()).take(EXAMPLES);
        SkipCount { reason, text: reason.words(), signals, examples: examples.collect() }
    };
    city.skips().into_iter().map(count).collect()
}
