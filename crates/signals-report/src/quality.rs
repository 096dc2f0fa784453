//! The quality of a family that was derived from a map, for people: one self-contained page.

mod map;
mod text;

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use minijinja::{Value, context};

use basics::files::write_atomically;
use evaluation::report::ReportError;
use evaluation::report::page::render;
use signals::city::quality::{Provenance, Quality, Spot};
use signals::city::surroundings::Drawing;
use text::{percent, share};

/// Where elements of the map can be looked at.
const OPENSTREETMAP: &str = "https://www.openstreetmap.org";

/// Rows of intersections that are shown, so that the page stays small; the others are in the files beside it.
const ROWS: usize = 3000;

/// Writes `quality.json` and `quality.html` to a folder and returns the page's path.
///
/// # Errors
///
/// [`ReportError`] if a file cannot be written or the template does not fit.
pub fn write_quality(
    folder: &Path,
    quality: &Quality,
    drawing: &Drawing,
) -> Result<PathBuf, ReportError> {
    let json = serde_json::to_vec_pretty(quality).expect("quality is plain data");
    let template = include_str!("templates/quality.html");
    let page = render("quality.html", template, values(quality, drawing));
    let page = page.map_err(ReportError::Template)?;
    write_atomically(&folder.join("quality.json"), &json)?;
    let path = folder.join("quality.html");
    write_atomically(&path, page.as_bytes())?;
    Ok(path)
}

fn values(q: &Quality, drawing: &Drawing) -> Value {
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
    let ignored = q.ignored.iter().map(|(reason, oddity)| {
        let example = oddity.example.as_str();
        context! { reason, count => oddity.count, example, link => link(example) }
    });
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
        headline => text::headline(q),
        sentences => text::sentences(q),
        warnings => text::warnings(q),
        used => of_signals(q.signals_used),
        elsewhere => of_signals(q.signals.saturating_sub(q.signals_used + explained)),
        skipped => skipped.collect::<Vec<_>>(),
        provenance => provenance.collect::<Vec<_>>(),
        listed => by_number(q.listed.iter().map(|(outcome, n)| (*outcome, *n)).collect()),
        map => map::map(q, drawing),
        thinned => drawing.thinned,
        crosses => drawing.skipped.len(),
        rows => q.spots.iter().take(ROWS).map(row).collect::<Vec<_>>(),
        flagged => q.spots.iter().filter(|s| !s.flags.is_empty()).count(),
        categories => categories(q),
        ignored => ignored.collect::<Vec<_>>(),
    }
}

/// Returns what is worth a look, each with the number of intersections, most frequent first.
fn categories(q: &Quality) -> Vec<(&'static str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for flag in q.spots.iter().flat_map(|s| &s.flags) {
        *counts.entry(*flag).or_default() += 1;
    }
    by_number(counts.into_iter().collect())
}

fn by_number(mut counts: Vec<(&'static str, usize)>) -> Vec<(&'static str, usize)> {
    counts.sort_by_key(|(_, n)| Reverse(*n));
    counts
}

fn row(spot: &Spot) -> Value {
    let (latitude, longitude) = (spot.latitude, spot.longitude);
    let place =
        format!("mlat={latitude:.6}&mlon={longitude:.6}#map=19/{latitude:.6}/{longitude:.6}");
    let flags = spot.flags.join("; ");
    context! {
        id => spot.id.as_str(),
        streets => streets(spot),
        link => format!("{OPENSTREETMAP}/?{place}"),
        arms => spot.arms,
        known => percent(spot.known),
        flags => if flags.is_empty() { "\u{2013}".to_owned() } else { flags },
    }
}

fn streets(spot: &Spot) -> &str {
    if spot.streets.is_empty() { "streets without a name" } else { &spot.streets }
}

/// Returns the address of an element that an example starts with, such as `way 17, lanes=many`.
fn link(example: &str) -> Option<String> {
    let (kind, rest) = example.split_once(' ')?;
    let id = rest.split(',').next()?;
    let known = ["node", "way", "relation"].contains(&kind) && id.parse::<u64>().is_ok();
    known.then(|| format!("{OPENSTREETMAP}/{kind}/{id}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_example_links_to_its_element() {
        let expected = Some("https://www.openstreetmap.org/way/17".to_owned());
        assert_eq!(link("way 17, lanes=many"), expected);
        assert_eq!([link("line 3"), link("way x"), link("")], [None, None, None]);
    }
}
