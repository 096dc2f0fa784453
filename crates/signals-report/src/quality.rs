//! The quality of a family that was derived from a map, for people: one self-contained page.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use minijinja::{Value, context};

use basics::files::write_atomically;
use evaluation::report::ReportError;
use evaluation::report::format::{self, count};
use evaluation::report::page::render;
use osm_signals::intersections::Skip;
use signals::city::quality::{MATCHED, Provenance, Quality, Spot};
use signals::city::sites::Reason;

use crate::demand;

/// Where elements of the map can be looked at.
const OPENSTREETMAP: &str = "https://www.openstreetmap.org";

/// Rows of intersections that are shown, so that the page stays small; the others are in the files beside it.
const ROWS: usize = 3000;

/// Share of the inflows that are defaults above which results say little about real traffic.
const MANY_DEFAULTS: f64 = 0.5;

/// Share of the approaches above which cut ones are worth a warning.
const MANY_CUT: f64 = 0.1;

/// Share of the signals above which those that are no intersection, or not on the map, are worth a warning.
const MANY_LOST: f64 = 0.2;

/// Writes `quality.json` and `quality.html` to a folder and returns the page's path.
///
/// # Errors
///
/// [`ReportError`] if a file cannot be written or the template does not fit.
pub fn write_quality(folder: &Path, quality: &Quality) -> Result<PathBuf, ReportError> {
    let json = serde_json::to_vec_pretty(quality).expect("quality is plain data");
    let template = include_str!("templates/quality.html");
    let page = render("quality.html", template, values(quality));
    let page = page.map_err(ReportError::Template)?;
    write_atomically(&folder.join("quality.json"), &json)?;
    let path = folder.join("quality.html");
    write_atomically(&path, page.as_bytes())?;
    Ok(path)
}

fn values(q: &Quality) -> Value {
    let of_signals = |n| (n, percent(share(n, q.signals)));
    let explained: usize = q.skipped.iter().map(|s| s.signals).sum();
    let skipped = q.skipped.iter().map(|s| {
        let link = |id: &i64| (id.to_string(), format!("{OPENSTREETMAP}/node/{id}"));
        (s.text, of_signals(s.signals), s.examples.iter().map(link).collect::<Vec<_>>())
    });
    let provenance = q.provenance.iter().map(|p: &Provenance| {
        let shares = [p.tagged, p.spread, p.imputed, p.default].map(percent);
        (p.feature.replace('_', " "), shares)
    });
    let mut outcomes: Vec<(&str, usize)> = q.listed.iter().map(|(what, n)| (*what, *n)).collect();
    outcomes.sort_by_key(|(_, n)| Reverse(*n));
    let inputs = q.inputs.iter().map(|f| [f.role, &f.name, &f.sha256].map(str::to_owned));
    context! {
        scenario => q.name.as_str(),
        version => q.version,
        ways => q.ways,
        signals => q.signals,
        intersections => q.intersections,
        approaches => q.approaches,
        no_way_across => q.no_way_across,
        cut_approaches => q.cut_approaches,
        spots => q.spots.len(),
        inputs => inputs.collect::<Vec<_>>(),
        headline => headline(q),
        sentences => sentences(q),
        warnings => warnings(q),
        used => of_signals(q.signals_used),
        elsewhere => of_signals(q.signals.saturating_sub(q.signals_used + explained)),
        skipped => skipped.collect::<Vec<_>>(),
        provenance => provenance.collect::<Vec<_>>(),
        listed => outcomes,
        rows => q.spots.iter().take(ROWS).map(row).collect::<Vec<_>>(),
        flagged => q.spots.iter().filter(|s| !s.flags.is_empty()).count(),
        ignored => q.ignored.iter().map(|(_, oddity)| oddity.count).sum::<u64>(),
    }
}

fn row(spot: &Spot) -> Value {
    let (latitude, longitude) = (spot.latitude, spot.longitude);
    let place =
        format!("mlat={latitude:.6}&mlon={longitude:.6}#map=19/{latitude:.6}/{longitude:.6}");
    let flags = spot.flags.join("; ");
    context! {
        id => spot.id.as_str(),
        streets => if spot.streets.is_empty() { "streets without a name" } else { &spot.streets },
        link => format!("{OPENSTREETMAP}/?{place}"),
        arms => spot.arms,
        known => percent(spot.known),
        flags => if flags.is_empty() { "\u{2013}".to_owned() } else { flags },
    }
}

/// Returns a share as per cent; less than all is never "100%".
fn percent(share: f64) -> String {
    if (0.995..1.0 - 1e-9).contains(&share) { ">99%".to_owned() } else { format::percent(share) }
}

/// Returns a part of a whole as a share; nothing of nothing is nothing.
fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// Returns how many signals the list has, how many of them have an intersection and how many of these no signal on the map.
fn listed(q: &Quality) -> (usize, usize, usize) {
    let [mapped, unmapped] = MATCHED.map(|outcome| q.listed.get(outcome).copied().unwrap_or(0));
    (q.listed.values().sum(), mapped + unmapped, unmapped)
}

/// Returns the title: what came from how many signals.
fn headline(q: &Quality) -> String {
    let from = match listed(q).0 {
        0 => count(q.signals, "signal"),
        rows => count(rows, "listed signal"),
    };
    let (intersections, points) =
        (count(q.intersections, "intersection"), count(q.point_mdps, "point MDP"));
    format!("{intersections} and {points} from {from}")
}

/// Returns the summary: how many signals are used, and what demand rests on.
fn sentences(q: &Quality) -> Vec<String> {
    let inflow = inflow(q).map(|p| [p.tagged, p.spread, p.imputed, p.default]);
    let demand = format!(
        "Demand: {}; inflows: {}.",
        demand::hour(q.hourly_share, q.directional_split, q.peak_heading_deg),
        demand::sources(inflow.unwrap_or_default())
    );
    vec![used(q), demand, format!("Traffic keeps to the {}.", q.driving_side)]
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
fn warnings(q: &Quality) -> Vec<String> {
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
