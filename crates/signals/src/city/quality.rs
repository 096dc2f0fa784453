//! How good a derived family is: what was found, what was not and why, and how much of it rests on the map rather than
//! on assumptions.

use std::collections::BTreeMap;

use osm_signals::oddities::Oddities;
use osm_signals::streets::Source;
use osm_signals::traffic::InflowSource;
use osm_signals::{Arm, Counts, DrivingSide, Extract};
use serde::Serialize;

use super::InputFile;
use super::sites::{City, Reason, Site};
use crate::family::load::LoadedScenario;

/// Examples of signals that are named per reason.
const EXAMPLES: usize = 5;

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

/// One intersection on the map, in the table of the page and in `intersections.geojson`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spot {
    /// Id of the intersection.
    pub id: String,
    /// Names of its streets.
    pub streets: String,
    /// Latitude, degrees.
    pub latitude: f64,
    /// Longitude, degrees.
    pub longitude: f64,
    /// Number of its arms.
    pub arms: usize,
    /// What the inflow of each approach rests on, clockwise from north.
    pub inflow_sources: Vec<InflowSource>,
    /// Number of signal nodes.
    pub signals: usize,
    /// Share of its lanes, speeds and inflows that are tagged or counted.
    pub known: f64,
    /// What is worth a look, in words.
    pub flags: Vec<&'static str>,
}

impl Spot {
    fn of(site: &Site<'_>) -> Self {
        let (i, traffic) = (site.found, site.traffic);
        let approaches = || i.arms.iter().zip(traffic).filter(|(arm, _)| arm.lanes_in > 0);
        let known: usize = approaches()
            .map(|(arm, traffic)| {
                let tagged = [arm.lanes_source, arm.speed_source].map(|s| s == Source::Tagged);
                let counted = traffic.source == InflowSource::Counted;
                tagged.into_iter().chain([counted]).filter(|known| *known).count()
            })
            .sum();
        Self {
            id: i.id.clone(),
            streets: i.streets().into_iter().collect::<Vec<_>>().join(" / "),
            latitude: i.centre.latitude(),
            longitude: i.centre.longitude(),
            arms: i.arms.len(),
            inflow_sources: approaches().map(|(_, traffic)| traffic.source).collect(),
            signals: i.signals.len(),
            known: known as f64 / (3 * approaches().count().max(1)) as f64,
            flags: site.flags(),
        }
    }
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
    /// Share of the day's traffic in the hour that is simulated.
    pub hourly_share: f64,
    /// Share of that in the peak direction.
    pub directional_split: f64,
    /// The peak direction, degrees clockwise from north.
    pub peak_heading_deg: f64,
    /// Why the other signals are no intersection.
    pub skipped: Vec<SkipCount>,
    /// What values rest on.
    pub provenance: Vec<Provenance>,
    /// Approaches whose street the extract cuts before the next junction.
    pub cut_approaches: usize,
    /// Approaches for which the map leaves no way across the junction.
    pub no_way_across: usize,
    /// Intersections without a sound network, and why.
    pub left_out: BTreeMap<String, String>,
    /// Turn restrictions at certain times that hold in the simulated hour, and all of them.
    pub timed_restrictions: (usize, usize),
    /// Rows of the signal list, by what became of them.
    pub listed: BTreeMap<&'static str, usize>,
    /// Values of the map and of the counts that were ignored.
    pub ignored: Oddities,
    /// The intersections.
    pub spots: Vec<Spot>,
}

/// Outcome of a row of a signal list that has an intersection, with and without a signal on the map.
pub const MATCHED: [&str; 2] =
    ["matched, and a signal on the map", "matched, at a junction without a signal on the map"];

/// Returns the quality of a city.
pub(super) fn quality(
    loaded: &LoadedScenario,
    (inputs, written): (Vec<InputFile>, BTreeMap<String, String>),
    (extract, time_of_day): (&Extract, f64),
    city: &City,
    counts: Option<&Counts>,
) -> Quality {
    let arms = || {
        city.sites()
            .flat_map(|site| site.found.arms.iter().zip(&site.found.turns))
            .filter(|(arm, _)| arm.lanes_in > 0)
    };
    let approaches = arms().count();
    let share = |feature, source: &dyn Fn(&Arm) -> Source| {
        let share = |s| {
            let n = arms().filter(|(arm, _)| source(arm) == s).count();
            n as f64 / approaches.max(1) as f64
        };
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
    let marked = |yes| if yes { Source::Tagged } else { Source::Default };
    let skipped = city.skips().into_iter().map(|(reason, signals)| {
        let of_reason = city.skipped().filter(|(_, _, other)| *other == reason);
        let examples = of_reason.filter_map(|(nodes, ..)| nodes.first().copied()).take(EXAMPLES);
        SkipCount { reason, text: reason.words(), signals, examples: examples.collect() }
    });
    let mut listed = BTreeMap::new();
    for (row, left_out) in city.listed() {
        let is_matched = row.intersection.is_some() && left_out.is_none();
        let why = || left_out.map(Reason::words).or(row.note.map(|note| note.words()));
        let outcome =
            if is_matched { MATCHED[usize::from(!row.on_map)] } else { why().unwrap_or("unknown") };
        *listed.entry(outcome).or_default() += 1;
    }
    let mut ignored = extract.oddities.clone();
    ignored.merge(counts.map(|counts| counts.oddities.clone()).unwrap_or_default());
    let family = &loaded.scenario.family;
    Quality {
        name: loaded.scenario.name.clone(),
        version: env!("CARGO_PKG_VERSION"),
        inputs,
        written,
        driving_side: city.side,
        ways: extract.ways.len(),
        signals: extract.signals.len(),
        signals_used: city.sites().map(|site| site.found.signals.len()).sum(),
        intersections: city.sites().count(),
        approaches,
        point_mdps: loaded.family.points.len(),
        hourly_share: family.hourly_share,
        directional_split: family.directional_split,
        peak_heading_deg: family.peak_heading_deg,
        skipped: skipped.collect(),
        provenance: vec![
            share("lanes", &|arm| arm.lanes_source),
            share("turn_lanes", &|arm| marked(arm.marked)),
            share("speed", &|arm| arm.speed_source),
            share("length", &|arm| marked(!arm.cut && !arm.clamped)),
            inflow,
        ],
        cut_approaches: arms().filter(|(arm, _)| arm.cut).count(),
        no_way_across: arms().filter(|(_, turns)| turns.is_none()).count(),
        left_out: city.left_out.clone(),
        timed_restrictions: extract.timed_restrictions(time_of_day),
        listed,
        ignored,
        spots: city.sites().map(|site| Spot::of(&site)).collect(),
    }
}
