//! What the page on the quality of a family says in words: the summary, what to do, warnings.

use osm_signals::intersections::Skip;

use super::explain::sentence;
use crate::demand;
use evaluation::report::format::{self, count};
use signals::city::quality::{Provenance, Quality};
use signals::city::reason::Reason;

/// Share of the inflows that are defaults above which results say little about real traffic.
const MANY_DEFAULTS: f64 = 0.5;

/// Share of the approaches above which cut ones are worth a warning.
const MANY_CUT: f64 = 0.1;

/// Share of the listed signals above which unmatched ones are worth a warning.
const MANY_UNMATCHED: f64 = 0.2;

/// Share of the signals above which those that are no intersection are worth a warning.
const MANY_SKIPPED: f64 = 0.2;

/// Share of approaches from which on a feature counts as known.
const KNOWN: f64 = 0.95;

/// Returns a share as per cent; less than all is never "100%".
pub(super) fn percent(share: f64) -> String {
    if (0.995..1.0 - 1e-9).contains(&share) { ">99%".to_owned() } else { format::percent(share) }
}

/// Returns a part of a whole as a share; nothing of nothing is nothing.
pub(super) fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// Returns how many rows of the signal list have an intersection.
pub(super) fn matched(q: &Quality) -> usize {
    q.listed.iter().filter(|row| row.intersection.is_some()).count()
}

/// Returns the title: what came from how many signals.
pub(super) fn headline(q: &Quality) -> String {
    let from = match q.listed.len() {
        0 => count(q.signals, "signal"),
        rows => count(rows, "listed signal"),
    };
    let (intersections, points) =
        (count(q.intersections, "intersection"), count(q.point_mdps, "point MDP"));
    format!("{intersections} and {points} from {from}")
}

/// Returns the summary: how many signals are used, how much is known, what is weakest.
pub(super) fn sentences(q: &Quality) -> Vec<String> {
    let mut sentences = vec![used(q)];
    let features = q.provenance.len().max(1) as f64;
    let mean =
        |of: fn(&Provenance) -> f64| percent(q.provenance.iter().map(of).sum::<f64>() / features);
    let d = q.demand;
    sentences.push(format!(
        "Demand: {}; inflows: {}.",
        demand::hour(d.hourly_share, d.directional_split, d.peak_heading_deg),
        demand::sources(inflow_sources(q))
    ));
    let spread = match q.provenance.iter().map(|p| p.spread).sum::<f64>() {
        0.0 => String::new(),
        sum => format!("{} are counts from elsewhere on the street, ", percent(sum / features)),
    };
    sentences.push(format!(
        "Of the lanes, turn lanes, speeds, lengths and inflows of {}, {} come from the data, \
         {spread}{} are taken from other streets of the same class and {} are defaults.",
        approaches(q.approaches),
        mean(|p| p.tagged),
        mean(|p| p.imputed),
        mean(|p| p.default),
    ));
    // Of equally weak features the last, inflow, is the one that a user can mend at once.
    let weakest =
        q.provenance.iter().rev().min_by(|a, b| {
            a.tagged.total_cmp(&b.tagged).then_with(|| b.default.total_cmp(&a.default))
        });
    sentences.extend(weakest.map(|p| match p.tagged >= KNOWN {
        true => {
            format!("Every feature is known for at least {} of the approaches.", percent(KNOWN))
        }
        false => advice(q, p),
    }));
    sentences.push(sentence(&q.side.text()));
    sentences
}

/// Returns what inflows rest on: counted, spread, from the class, default.
fn inflow_sources(q: &Quality) -> [f64; 4] {
    let inflow = q.provenance.iter().find(|p| p.feature == "inflow");
    inflow.map_or([0.0; 4], |p| [p.tagged, p.spread, p.imputed, p.default])
}

fn approaches(n: usize) -> String {
    if n == 1 { "1 approach".to_owned() } else { format!("{n} approaches") }
}

fn used(q: &Quality) -> String {
    if q.listed.is_empty() {
        return format!(
            "{} of {} in the extract ({}) belong to an intersection of the family.",
            q.signals_used,
            count(q.signals, "signal"),
            percent(share(q.signals_used, q.signals)),
        );
    }
    let matched = matched(q);
    let unmapped = q.listed.iter().filter(|r| r.intersection.is_some() && !r.on_map).count();
    let mut text = format!(
        "{matched} of {} ({}) have an intersection in the extract",
        count(q.listed.len(), "listed signal"),
        percent(share(matched, q.listed.len())),
    );
    if unmapped > 0 {
        text.push_str(&format!("; at {unmapped} of them the map has no signal"));
    }
    text + "."
}

/// Says what the values of the weakest feature rest on, and what improves them.
fn advice(q: &Quality, p: &Provenance) -> String {
    let (unknown, imputed) = (percent(1.0 - p.tagged), percent(p.imputed));
    let default = percent(p.default);
    match (p.feature, &q.counts) {
        ("inflow", None) => "The weakest feature is inflow: no counts were given, so all inflows \
                             are defaults by class of street; give traffic counts with --aadt."
            .to_owned(),
        ("inflow", Some(c)) if c.matched == 0 => format!(
            "The weakest feature is inflow: none of the {} lies along an approach, so all inflows \
             are defaults by class of street; give counts of this area with --aadt.",
            count(c.counts, "count"),
        ),
        ("inflow", Some(_)) => format!(
            "The weakest feature is inflow: {unknown} of the approaches have no count of their own, \
             so {} get one of another block of their street, {imputed} the mean of their class and \
             {default} a default; give counts of more streets with --aadt.",
            percent(p.spread)
        ),
        ("speed", _) => format!(
            "The weakest feature is speed: {unknown} of the approaches have no speed limit in the \
             map, so {imputed} get the usual one of their class and {default} a default; add \
             maxspeed to OpenStreetMap where it differs, or set streets.default_speed_mph with \
             --config for classes without any."
        ),
        ("lanes", _) => format!(
            "The weakest feature is lanes: {unknown} of the approaches have none in the map, so \
             {imputed} get the usual number of their class and {default} a default; add lanes to \
             OpenStreetMap, or set streets.default_lanes with --config."
        ),
        ("turn_lanes", _) => format!(
            "The weakest feature is turn lanes: {unknown} of the approaches have no turn:lanes in \
             the map and are taken to have no lane for turns only; add turn:lanes to OpenStreetMap \
             where arrows are marked."
        ),
        ("length", _) => format!(
            "The weakest feature is length: the extract cuts {} of {} approaches before the next \
             junction, so they are too short; give a larger extract.",
            q.cut_approaches, q.approaches,
        ),
        (feature, _) => format!(
            "The weakest feature is {}: it is not known for {unknown} of the approaches.",
            feature.replace('_', " ")
        ),
    }
}

/// Returns what a reader must know before using the family.
pub(super) fn warnings(q: &Quality) -> Vec<String> {
    let mut warnings = Vec::new();
    warnings.extend(q.side.warning.as_deref().map(sentence));
    let inflow = q.provenance.iter().find(|p| p.feature == "inflow");
    if let Some(p) = inflow.filter(|p| p.default > MANY_DEFAULTS) {
        warnings.push(format!(
            "Inflows are defaults on {} of the approaches: what is measured on this family holds \
             for these streets, not for their real traffic.",
            percent(p.default)
        ));
    }
    if let Some(c) = q.counts.as_ref().filter(|c| c.matched + c.spread == 0) {
        warnings.push(format!(
            "None of the {} matches an approach: the file is of another area, or its coordinates \
             are not WGS 84.",
            count(c.counts, "count")
        ));
    }
    let cut = share(q.cut_approaches, q.approaches);
    if cut > MANY_CUT {
        warnings.push(format!(
            "The extract cuts {} of {} approaches ({}) before the next junction: their lengths \
             are too small. Give an extract that is some hundred metres larger.",
            q.cut_approaches,
            q.approaches,
            percent(cut)
        ));
    }
    let unmatched = q.listed.len() - matched(q);
    if share(unmatched, q.listed.len()) > MANY_UNMATCHED {
        warnings.push(format!(
            "{unmatched} of {} have no intersection ({}): see the reasons below; check whether \
             the list is of this area.",
            count(q.listed.len(), "listed signal"),
            percent(share(unmatched, q.listed.len()))
        ));
    }
    let lost: usize = q.skipped.iter().filter(|s| !chosen(s.reason)).map(|s| s.signals).sum();
    if q.listed.is_empty() && share(lost, q.signals_used + lost) > MANY_SKIPPED {
        warnings.push(format!(
            "{lost} of {} became no intersection ({}): see the reasons below before taking the \
             family for the whole area.",
            count(q.signals_used + lost, "signal"),
            percent(share(lost, q.signals_used + lost))
        ));
    }
    if q.point_mdps == 1 {
        warnings.push(
            "One point MDP is no family: a result on it says nothing about other intersections."
                .to_owned(),
        );
    }
    warnings
}

/// Returns whether signals are left out because the user asked for others only.
fn chosen(reason: Reason) -> bool {
    matches!(reason, Reason::Map(Skip::OutsideBoundary | Skip::NotListed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use signals::city::quality::{CountsSummary, Demand, ListedRow, SkipCount};
    use signals::city::side::CitySide;

    fn rests_on(feature: &'static str, tagged: f64, imputed: f64) -> Provenance {
        Provenance { feature, tagged, spread: 0.0, imputed, default: 1.0 - tagged - imputed }
    }

    /// Ten signals in eight intersections, everything known but the inflow.
    fn city() -> Quality {
        Quality {
            timed_restrictions: (0, 0),
            name: "city".to_owned(),
            version: "0.1.0",
            inputs: Vec::new(),
            written: std::collections::BTreeMap::new(),
            side: CitySide::default(),
            ways: 30,
            signals: 10,
            signals_used: 10,
            intersections: 8,
            approaches: 32,
            point_mdps: 3,
            demand: Demand { hourly_share: 0.09, directional_split: 0.55, peak_heading_deg: 45.0 },
            skipped: Vec::new(),
            provenance: [("lanes", 1.0), ("length", 1.0), ("inflow", 0.0)]
                .map(|(feature, tagged)| rests_on(feature, tagged, 0.0))
                .to_vec(),
            cut_approaches: 0,
            no_way_across: 0,
            counts: None,
            left_out: std::collections::BTreeMap::new(),
            listed: Vec::new(),
            ignored: osm_signals::oddities::Oddities::default(),
            features: Vec::new(),
            spots: Vec::new(),
        }
    }

    fn counts(matched: usize) -> Option<CountsSummary> {
        let field = "AADT2019".to_owned();
        let skipped = Vec::new();
        let (spread, spread_m) = (0, 1000.0);
        Some(CountsSummary {
            field,
            counts: 70,
            approaches: 32,
            matched,
            spread,
            spread_m,
            skipped,
        })
    }

    fn row(intersection: Option<&str>) -> ListedRow {
        ListedRow {
            id: "1".to_owned(),
            line: 2,
            latitude: 40.0,
            longitude: -75.0,
            intersection: intersection.map(str::to_owned),
            distance_m: intersection.map(|_| 4.0),
            on_map: false,
            reason: intersection.is_none().then_some("roundabout"),
            duplicate_of: None,
        }
    }

    fn skip(reason: Skip, signals: usize) -> SkipCount {
        let (reason, text) = (Reason::Map(reason), reason.reason());
        SkipCount { reason, text, signals, examples: Vec::new() }
    }

    fn warned(q: &Quality, part: &str) -> bool {
        warnings(q).iter().any(|w| w.contains(part))
    }

    #[test]
    fn without_counts_the_reader_is_asked_for_some() {
        let q = city();
        assert_eq!(headline(&q), "8 intersections and 3 point MDPs from 10 signals");
        assert_eq!(
            sentences(&q),
            [
                "10 of 10 signals in the extract (100%) belong to an intersection of the family.",
                "Demand: 9.0% of the day\u{2019}s traffic in the hour, 55% of a two-way street\u{2019}s in \
                 its peak direction (north- and eastbound); inflows: all defaults by class of street.",
                "Of the lanes, turn lanes, speeds, lengths and inflows of 32 approaches, 67% come \
                 from the data, 0% are taken from other streets of the same class and 33% are \
                 defaults.",
                "The weakest feature is inflow: no counts were given, so all inflows are defaults \
                 by class of street; give traffic counts with --aadt.",
                "Traffic keeps to the right: assumed.",
            ]
        );
        assert!(warned(&q, "Inflows are defaults on 100% of the approaches"));
    }

    #[test]
    fn counts_that_match_nothing_are_of_another_area() {
        let provenance = vec![rests_on("turn_lanes", 0.0, 0.0), rests_on("inflow", 0.0, 0.0)];
        let q = Quality { counts: counts(0), provenance, ..city() };
        assert!(sentences(&q)[3].contains("none of the 70 counts lies along an approach"));
        assert!(warned(&q, "None of the 70 counts matches an approach"));
    }

    #[test]
    fn few_counts_ask_for_more() {
        let provenance = vec![rests_on("speed", 0.5, 0.5), rests_on("inflow", 0.25, 0.5)];
        let q = Quality { counts: counts(8), provenance, ..city() };
        assert!(sentences(&q)[3].contains("75% of the approaches have no count of their own"));
        assert_eq!(warnings(&q), [""; 0]);
    }

    #[test]
    fn the_weakest_feature_is_the_one_with_the_fewest_known_values() {
        for (feature, what) in [
            ("speed", "96% of the approaches have no speed limit in the map"),
            ("lanes", "96% of the approaches have none in the map"),
            ("turn_lanes", "96% of the approaches have no turn:lanes"),
            ("length", "the extract cuts 12 of 32 approaches"),
        ] {
            let provenance = vec![rests_on("inflow", 0.5, 0.5), rests_on(feature, 0.04, 0.5)];
            let q = Quality { provenance, cut_approaches: 12, ..city() };
            assert!(sentences(&q)[3].contains(what), "{}", sentences(&q)[3]);
        }
    }

    #[test]
    fn a_family_that_is_known_needs_no_advice() {
        let q = Quality { provenance: vec![rests_on("inflow", 0.96, 0.04)], ..city() };
        assert_eq!(sentences(&q)[3], "Every feature is known for at least 95% of the approaches.");
        assert_eq!(warnings(&q), [""; 0]);
    }

    #[test]
    fn listed_signals_are_what_counts_when_there_is_a_list() {
        let q = Quality { listed: vec![row(Some("a")), row(Some("b")), row(None)], ..city() };
        assert_eq!(headline(&q), "8 intersections and 3 point MDPs from 3 listed signals");
        let expected = "2 of 3 listed signals (67%) have an intersection in the extract; at 2 of \
                        them the map has no signal.";
        assert_eq!(sentences(&q)[0], expected);
        assert!(warned(&q, "1 of 3 listed signals have no intersection (33%)"));
    }

    #[test]
    fn signals_left_out_on_purpose_are_no_warning() {
        let skipped = vec![skip(Skip::OutsideBoundary, 90), skip(Skip::Roundabout, 2)];
        assert!(!warned(&Quality { skipped, ..city() }, "became no intersection"));
        let skipped = vec![skip(Skip::OutsideBoundary, 90), skip(Skip::Border, 4)];
        let q = Quality { skipped, ..city() };
        assert!(warned(&q, "4 of 14 signals became no intersection (29%)"));
    }

    #[test]
    fn a_cut_extract_and_a_single_point_mdp_are_warnings() {
        let q = Quality { cut_approaches: 8, point_mdps: 1, ..city() };
        assert!(warned(&q, "The extract cuts 8 of 32 approaches (25%)"));
        assert!(warned(&q, "One point MDP is no family"));
        assert!(!warned(&Quality { cut_approaches: 3, ..city() }, "cuts"));
    }

    #[test]
    fn nearly_all_is_not_all() {
        assert_eq!([0.0, 0.001, 0.996, 1.0].map(percent), ["0%", "<1%", ">99%", "100%"]);
    }
}
