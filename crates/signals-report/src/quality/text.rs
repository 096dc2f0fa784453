//! What the page on the quality of a family says in words: the summary, what to do, warnings.

use osm_signals::intersections::Skip;

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
        false => advice(p),
    }));
    sentences.push(format!("Traffic keeps to the {}.", q.driving_side));
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
fn advice(p: &Provenance) -> String {
    let help = match p.feature {
        "inflow" => "give traffic counts of more streets with --aadt",
        "length" => "give a larger extract",
        _ => "complete the map, or set the defaults with --config",
    };
    format!(
        "The weakest feature is {}: {} of the approaches have none of their own, so {} get one of another block of their \
         street, {} the usual one of their class and {} a default; {help}.",
        p.feature.replace('_', " "),
        percent(1.0 - p.tagged),
        percent(p.spread),
        percent(p.imputed),
        percent(p.default)
    )
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

    #[test]
    fn nearly_all_is_not_all() {
        assert_eq!([0.0, 0.001, 0.996, 1.0].map(percent), ["0%", "<1%", ">99%", "100%"]);
    }
}
