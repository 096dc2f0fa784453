//! What the page on the quality of a family says in words: the summary, what to do, warnings.

use crate::osm::intersections::Skip;
use crate::osm::quality::{Provenance, Quality};
use crate::report::format::{self, count};

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
    sentences.push(format!(
        "Of the lanes, turn lanes, speeds, lengths and inflows of {}, {} come from the data, {} \
         are taken from other streets of the same class and {} are defaults.",
        count(q.approaches, "approach").replace("approachs", "approaches"),
        mean(|p| p.tagged),
        mean(|p| p.imputed),
        mean(|p| p.default),
    ));
    let weakest = q
        .provenance
        .iter()
        .min_by(|a, b| a.tagged.total_cmp(&b.tagged).then_with(|| b.default.total_cmp(&a.default)));
    sentences.extend(weakest.map(|p| match p.tagged >= KNOWN {
        true => {
            format!("Every feature is known for at least {} of the approaches.", percent(KNOWN))
        }
        false => advice(q, p),
    }));
    sentences
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
            "The weakest feature is inflow: {unknown} of the approaches have no count, of which \
             those of classes with counts get their mean ({imputed} of all) and the others a \
             default ({default}); give counts of more streets with --aadt."
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
    let inflow = q.provenance.iter().find(|p| p.feature == "inflow");
    if let Some(p) = inflow.filter(|p| p.default > MANY_DEFAULTS) {
        warnings.push(format!(
            "Inflows are defaults on {} of the approaches: what is measured on this family holds \
             for these streets, not for their real traffic.",
            percent(p.default)
        ));
    }
    if let Some(c) = q.counts.as_ref().filter(|c| c.matched == 0) {
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
fn chosen(reason: Skip) -> bool {
    matches!(reason, Skip::OutsideBoundary | Skip::NotListed)
}

/// Says what a reason means and what helps.
pub(super) fn meaning(reason: Skip) -> &'static str {
    match reason {
        Skip::NotOnStreet => "On a railway, a path, a motorway or a service road.",
        Skip::NoJunction => "Mostly pedestrian crossings in mid-block: right to leave out.",
        Skip::Border => "The junction or one of its arms is cut off: give a larger extract.",
        Skip::Roundabout => "Circulating traffic is no point MDP.",
        Skip::FewArms => "A bend, or a junction with a path, a driveway or a service road.",
        Skip::FewApproaches => "One-way streets leave only one stream to serve.",
        Skip::ManyArms => "No network is built for it; look at the map for joined junctions.",
        Skip::ManyLanes => "Mostly a mistake in the lanes of the map: correct it there.",
        Skip::OutsideBoundary => "Left out as asked with --boundary.",
        Skip::NotListed => "Left out as asked with --signals.",
        Skip::NoNetwork => "Its arms allow no sound network; quality.json says what fails.",
    }
}

/// Says what the values of a feature rest on.
pub(super) fn basis(feature: &str) -> &'static str {
    match feature {
        "lanes" => {
            "Known: lanes of the street. From its class: the usual number in this extract. \
             Default: streets.default_lanes."
        }
        "turn_lanes" => {
            "Known: turn:lanes of the street. Default: without marked turns no lane is for turns \
             only."
        }
        "speed" => {
            "Known: maxspeed of the street. From its class: the usual limit in this extract. \
             Default: streets.default_speed_mph."
        }
        "length" => {
            "Known: measured along the street to the next junction. Default: the extract ends \
             before it, so the length is too small."
        }
        "inflow" => {
            "Known: a traffic count along the street (--aadt). From its class: the mean of \
             counted streets. Default: traffic.default_aadt_per_lane."
        }
        _ => "",
    }
}
