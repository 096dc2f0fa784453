//! The quality of a family that was derived from a map, for people: one self-contained page.

mod intersections;
mod link;
mod list;
mod map;
mod text;

use std::path::{Path, PathBuf};

use minijinja::{Value, context};
use osm_signals::oddities::Oddity;

use basics::files::write_atomically;
use evaluation::report::page::render;
use evaluation::report::{ReportError, format};
use evaluation::stats::quantile::quantile;
use link::OPENSTREETMAP;
use signals::city::drawing::Drawing;
use signals::city::quality::{CountsSummary, Distribution, Provenance, Quality, SkipCount};
use text::{percent, share};

/// What values rest on.
const SOURCES: [&str; 4] =
    ["known from the data", "counted on its street", "from its class of street", "default"];

const TEMPLATE: &str = include_str!("templates/quality.html");

/// Name of the file with all figures.
pub const QUALITY_FILE: &str = "quality.json";

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
    let page = page(quality, drawing).map_err(ReportError::Template)?;
    write_atomically(&folder.join(QUALITY_FILE), &json)?;
    let path = folder.join("quality.html");
    write_atomically(&path, page.as_bytes())?;
    Ok(path)
}

/// Returns the page, or the template engine's message.
fn page(quality: &Quality, drawing: &Drawing) -> Result<String, String> {
    render("quality.html", TEMPLATE, values(quality, drawing))
}

fn values(q: &Quality, drawing: &Drawing) -> Value {
    let explained: usize = q.skipped.iter().map(|s| s.signals).sum();
    let elsewhere = q.signals.saturating_sub(q.signals_used + explained);
    let ignored = q.ignored.iter().map(|(reason, o)| oddity(reason, o));
    let inputs = q.inputs.iter().map(|f| {
        context! { role => f.role, name => f.name.as_str(), sha256 => f.sha256.as_str() }
    });
    context! {
        scenario => q.name.as_str(),
        version => q.version,
        headline => text::headline(q),
        sentences => text::sentences(q),
        warnings => text::warnings(q),
        signals => q.signals,
        signals_used => q.signals_used,
        used_share => percent(share(q.signals_used, q.signals)),
        not_looked_at => elsewhere,
        not_looked_at_share => percent(share(elsewhere, q.signals)),
        skipped => q.skipped.iter().map(|s| skipped(q, s)).collect::<Vec<_>>(),
        ways => q.ways,
        intersections => q.intersections,
        approaches => q.approaches,
        point_mdps => q.point_mdps,
        no_way_across => q.no_way_across,
        cut => q.cut_approaches,
        sources => SOURCES.to_vec(),
        provenance => provenance(q),
        features => features(q),
        list => list::list(q),
        counts => q.counts.as_ref().map(counts),
        map => map::map(q, drawing),
        thinned => drawing.thinned,
        rows => intersections::rows(q),
        more_rows => intersections::more(q),
        flagged => q.spots.iter().filter(|s| !s.flags.is_empty()).count(),
        categories => intersections::categories(q),
        crosses => drawing.skipped.len(),
        ignored => ignored.collect::<Vec<_>>(),
        inputs => inputs.collect::<Vec<_>>(),
    }
}

fn skipped(q: &Quality, s: &SkipCount) -> Value {
    let example = |id: &i64| context! { id, link => format!("{OPENSTREETMAP}/node/{id}") };
    context! {
        reason => s.text,
        signals => s.signals,
        share => percent(share(s.signals, q.signals)),
        examples => s.examples.iter().map(example).collect::<Vec<_>>(),
    }
}

fn provenance(q: &Quality) -> Vec<Value> {
    let row = |p: &Provenance| {
        context! {
            feature => p.feature.replace('_', " "),
            shares => [p.tagged, p.spread, p.imputed, p.default].map(percent).to_vec(),
        }
    };
    q.provenance.iter().map(row).collect()
}

fn features(q: &Quality) -> Vec<Value> {
    let row = |d: &Distribution| {
        let mut sorted = d.values.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |share| match sorted.is_empty() {
            true => "\u{2013}".to_owned(),
            false => format::score(quantile(&sorted, share)),
        };
        context! {
            name => format::words(&d.name, &d.unit),
            unit => d.unit.as_str(),
            mean => format::score(d.mean),
            sd => format::score(d.sd),
            range => [at(0.0), at(0.5), at(1.0)].to_vec(),
            bin => format::feature(d.bin),
        }
    };
    q.features.iter().map(row).collect()
}

fn counts(c: &CountsSummary) -> Value {
    context! {
        field => c.field.as_str(),
        counts => c.counts,
        approaches => c.approaches,
        matched => c.matched,
        share => percent(share(c.matched, c.approaches)),
        spread => c.spread,
        spread_share => percent(share(c.spread, c.approaches)),
        spread_m => format::feature(c.spread_m),
        skipped => c.skipped.iter().map(|(reason, o)| oddity(reason, o)).collect::<Vec<_>>(),
    }
}

fn oddity(reason: &str, oddity: &Oddity) -> Value {
    let link = link(&oddity.example);
    context! { reason, count => oddity.count, example => oddity.example.as_str(), link }
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
