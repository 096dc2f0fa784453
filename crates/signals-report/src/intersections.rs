//! The results by intersection: `intersections.csv` and, for maps, `results.geojson`.
//!
//! An intersection has the results of its point MDP, which stands for all intersections with its
//! features; where that was not simulated, with k-means, those of the point MDP of its cluster. The
//! column `basis` says which.

use geojson::{Feature, FeatureCollection, GeometryValue, JsonObject, JsonValue};

use super::demand::all_defaults;
use super::level_of_service::letter;
use super::shown::{Seen, streets};
use evaluation::analysis::{Analysis, PointResult, PointSummary, Winner};
use evaluation::report::Spot;
use evaluation::report::table::{Cell, Columns, Table};
use signals::places::MappedIntersection;

/// Detail of a family of which every point MDP is an intersection with its own arms.
const PER_APPROACH: &str = "per-approach";

/// Where the results of an intersection come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Basis {
    /// It was simulated itself, with its own arms.
    Simulated,
    /// Its point MDP was.
    PointMdp,
    /// The point MDP of its cluster, or the nearest that was drawn, was.
    Represented,
    /// None that stands for it was.
    None,
}

impl Basis {
    fn word(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::PointMdp => "point MDP",
            Self::Represented => "represented",
            Self::None => "none",
        }
    }
}

/// Returns where the results of an intersection come from, and the position of the point MDP that has
/// them.
pub(super) fn basis(data: &Analysis, place: &MappedIntersection) -> (Basis, Option<usize>) {
    let Some(point) = place.stands.as_deref().and_then(|id| data.position(id)) else {
        return (Basis::None, None);
    };
    let detail = data.manifest.identity.settings.pointer("/family/detail");
    let basis = match place.stands.as_ref() == Some(&place.point) {
        false => Basis::Represented,
        true if detail.and_then(JsonValue::as_str) == Some(PER_APPROACH) => Basis::Simulated,
        true => Basis::PointMdp,
    };
    (basis, Some(point))
}

/// Returns why no probability is given that a method is the best at an intersection: the simulated vehicles are not
/// its own.
fn withheld(data: &Analysis, basis: Basis) -> Option<&'static str> {
    match basis {
        Basis::Represented => Some("another intersection was simulated in its place"),
        Basis::Simulated | Basis::PointMdp => all_defaults(&data.manifest.identity.settings)
            .then_some("all inflows are defaults by class of street"),
        Basis::None => None,
    }
}

/// Returns a row per intersection; the columns of one method come last.
pub(super) fn table(seen: Seen<'_>) -> Table {
    type Row<'a> = (&'a MappedIntersection, Basis, Option<&'a PointSummary>, Option<&'a Winner>);
    let Seen { data, shown } = seen;
    let identity = &data.manifest.identity;
    let row = |place| {
        let (basis, point) = basis(data, place);
        let point = point.map(|p| &data.points[p]);
        (place, basis, point, point.and_then(|p| data.winners[p.index].as_ref()))
    };
    let best = |w: &Option<&Winner>| w.map(|w| w.best);
    let next = |w: &Option<&Winner>| w.and_then(|w| w.runner_up);
    let name = |m: Option<usize>| m.map(|m| identity.methods[m].clone()).unwrap_or_default();
    let result =
        |p: &Option<&PointSummary>, m: Option<usize>| p.and_then(|p| p.results[m?].clone());
    let objective =
        move |p: &Option<&PointSummary>, m| Cell::exact(result(p, m).map(|r| r.objective));
    let of = |of: &str| format!("{of}_{}", identity.objective);
    let level = |r: PointResult| letter(r.objective).to_string();
    let withheld = |basis: &Basis| withheld(data, *basis);
    let mut columns = Columns::new()
        .text("id", "", |(place, ..): &Row<'_>| place.id.clone())
        .text("streets", "", |(place, ..)| streets(place).unwrap_or_default())
        .file("latitude", |(place, ..)| Cell::exact(place.latitude))
        .file("longitude", |(place, ..)| Cell::exact(place.longitude))
        .text("point", "", |(place, ..)| place.point.clone())
        .text("basis", "", |(_, basis, ..)| basis.word().to_owned())
        .text("results_of", "", |(_, _, p, _)| p.map(|p| p.row.point.clone()).unwrap_or_default())
        .text("winner", "", move |(.., w)| name(best(w)))
        .file(of("winner"), move |(_, _, p, w)| objective(p, best(w)))
        .file("score", move |(_, _, p, w)| Cell::exact(result(p, best(w)).and_then(|r| r.score)))
        .file("score_low", |(.., w)| Cell::exact(w.and_then(|w| Some(w.interval?.0))))
        .file("score_high", |(.., w)| Cell::exact(w.and_then(|w| Some(w.interval?.1))))
        .text("level_of_service", "", move |(_, _, p, w)| {
            result(p, best(w)).map(level).unwrap_or_default()
        })
        .text("runner_up", "", move |(.., w)| name(next(w)))
        .file(of("runner_up"), move |(_, _, p, w)| objective(p, next(w)))
        .file("lead_low", |(.., w)| Cell::exact(w.and_then(|w| Some(w.lead?.0))))
        .file("lead_high", |(.., w)| Cell::exact(w.and_then(|w| Some(w.lead?.1))))
        .text("against", "", |_| data.reference.name.clone())
        .file("winner_probability", move |(_, basis, _, w)| {
            let given = w.filter(|_| withheld(basis).is_none());
            Cell::exact(given.and_then(|w| w.probability))
        })
        .file("winner_fails", |(_, _, p, w)| {
            Cell::flag(p.zip(*w).and_then(|(p, w)| data.fails(p, w.best)))
        });
    if shown.places.intersections.iter().any(|place| withheld(&basis(data, place).0).is_some()) {
        columns = columns.text("winner_probability_withheld", "", move |(_, basis, ..)| {
            withheld(basis).unwrap_or_default().to_owned()
        });
    }
    for (m, method) in identity.methods.iter().enumerate() {
        columns = columns.file(of(method), move |(_, _, p, _)| objective(p, Some(m)));
    }
    columns.table(shown.places.intersections.iter().map(row))
}

/// Returns the rows of the table of intersections on the page, each with its dot on the map.
pub(super) fn spots(seen: Seen<'_>) -> Vec<Spot> {
    let Seen { data, shown } = seen;
    let mapped = data.best().is_some();
    let of = |(number, place): (usize, &MappedIntersection)| {
        let (basis, point) = basis(data, place);
        let own = shown.called(data, &place.point);
        let detail = match (basis, point) {
            (Basis::Represented, Some(p)) => {
                format!("results of {}", shown.called(data, &data.points[p].row.point))
            }
            (Basis::None, _) => format!("{own}: not simulated"),
            _ => own,
        };
        let name = match (streets(place), place.id.as_str()) {
            (Some(streets), "") => streets,
            (Some(streets), id) => format!("{streets} ({id})"),
            (None, "") => format!("{:.5}, {:.5}", place.latitude, place.longitude),
            (None, id) => format!("{id}: {:.5}, {:.5}", place.latitude, place.longitude),
        };
        let withheld = withheld(data, basis);
        Spot { name, detail, point, dot: mapped.then_some(number), withheld }
    };
    shown.places.intersections.iter().enumerate().map(of).collect()
}

/// Returns `results.geojson`: a point per intersection with the columns of the table.
pub(super) fn geojson(seen: Seen<'_>) -> String {
    let feature = |(place, mut properties): (&MappedIntersection, JsonObject)| {
        properties.retain(|name, _| name != "latitude" && name != "longitude");
        Feature {
            geometry: Some(GeometryValue::new_point([place.longitude, place.latitude]).into()),
            properties: Some(properties),
            ..Feature::default()
        }
    };
    let rows = seen.shown.places.intersections.iter().zip(table(seen).json());
    let features = rows.map(feature).collect();
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    let mut text = serde_json::to_string(&collection).expect("features are plain data");
    // A line per intersection, so that two versions can be compared.
    text = text.replace("{\"type\":\"Feature\",", "\n{\"type\":\"Feature\",");
    text + "\n"
}
