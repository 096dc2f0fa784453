//! What the page on the quality of a family says in words: the summary, what to do, warnings.

use osm_signals::intersections::Skip;

use crate::demand;
use evaluation::report::format::{self, count};
use signals::city::quality::{MATCHED, Provenance, Quality};
use signals::city::sites::Reason;

/// Share of the inflows that are defaults above which results say little about real traffic.
const MANY_DEFAULTS: f64 = 0.5;

/// Share of the approaches above which cut ones are worth a warning.
const MANY_CUT: f64 = 0.1;

/// Share of the signals above which those that are no intersection, or not on the map, are worth a warning.
const MANY_LOST: f64 = 0.2;

/// Returns a share as per cent; less than all is never "100%".
pub(super) fn percent(share: f64) -> String {
    if (0.995..1.0 - 1e-9).contains(&share) { ">99%".to_owned() } else { format::percent(share) }
}

/// Returns a part of a whole as a share; nothing of nothing is nothing.
pub(super) fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// Returns how many signals the list has, how many of them have an intersection and how many of these no signal on the map.
fn listed(q: &Quality) -> (usize, usize, usize) {
    let [mapped, unmapped] = MATCHED.map(|outcome| q.listed.get(outcome).copied().unwrap_or(0));
    (q.listed.values().sum(), mapped + unmapped, unmapped)
}

/// Returns the title: what came from how many signals.
pub(super) fn headline(q: &Quality) -> String {
    let from = match listed(q).0 {
        0 => count(q.signals, "signal"),
        rows => count(rows, "listed signal"),
    };
    let (intersections, points) =
        (count(q.intersections, "intersection"), count(q.point_mdps, "point MDP"));
    format!("{intersections} and {points} from {from}")
}

/// Returns the summary: how many signals are used, what demand rests on, what is weakest.
pub(super) fn sentences(q: &Quality) -> Vec<String> {
    let d = q.demand;
    let inflow = inflow(q).map(|p| [p.tagged, p.spread, p.imputed, p.default]);
    let mut sentences = vec![
        used(q),
        format!(
            "Demand: {}; inflows: {}.",
            demand::hour(d.hourly_share, d.directional_split, d.peak_heading_deg),
            demand::sources(inflow.unwrap_or_default())
        ),
    ];
    // Of equally weak features the last, inflow, is the one that a user can mend at once.
    let weakest =
        q.provenance.iter().rev().min_by(|a, b| {
            a.tagged.total_cmp(&b.tagged).then_with(|| b.default.total_cmp(&a.default))
        });
    sentences.extend(weakest.map(|p| {
        let help = match p.feature {
            "inflow" => "give traffic counts of more streets with --aadt",
            "length" => "give a larger extract",
            _ => "complete the map, or set the defaults with --config",
        };
        let feature = p.feature.replace('_', " ");
        format!(
            "The weakest feature is {feature}, known for {} of the approaches: {help}.",
            percent(p.tagged)
        )
    }));
    sentences.push(format!("Traffic keeps to the {}.", q.driving_side));
    sentences
}

fn inflow(q: &Quality) -> Option<&Provenance> {
    q.provenance.iter().find(|p| p.feature == "inflow")
}

fn used(q: &Quality) -> String {
    let (rows, matched, unmapped) = listed(q);
    if rows == 0 {
        return format!(
            "{} of {} in the extract ({}) belong to an intersection of the family.",
            q.signals_used,
            count(q.signals, "signal"),
            percent(share(q.signals_used, q.signals)),
        );
    }
    let without = match unmapped {
        0 => String::new(),
        n => format!("; at {n} of them the map has no signal"),
    };
    format!(
        "{matched} of {} ({}) have an intersection in the extract{without}.",
        count(rows, "listed signal"),
        percent(share(matched, rows)),
    )
}

/// Returns what a reader must know before using the family.
pub(super) fn warnings(q: &Quality) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(p) = inflow(q).filter(|p| p.default > MANY_DEFAULTS) {
        warnings.push(format!(
            "Inflows are defaults on {} of the approaches: what is measured on this family holds \
             for these streets, not for their real traffic.",
            percent(p.default)
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
    // Not those that are left out because the user asked for others only.
    let chosen = |reason| matches!(reason, Reason::Map(Skip::OutsideBoundary | Skip::NotListed));
    let skipped: usize = q.skipped.iter().filter(|s| !chosen(s.reason)).map(|s| s.signals).sum();
    let (lost, whole, what) = match listed(q) {
        (0, ..) => (skipped, q.signals_used + skipped, "signal"),
        (rows, matched, _) => (rows - matched, rows, "listed signal"),
    };
    if share(lost, whole) > MANY_LOST {
        warnings.push(format!(
            "{lost} of {} became no intersection ({}): see the reasons below before taking the \
             family for the whole area.",
            count(whole, what),
            percent(share(lost, whole))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_all_is_not_all() {
        assert_eq!([0.0, 0.001, 0.996, 1.0].map(percent), ["0%", "<1%", ">99%", "100%"]);
    }
}
