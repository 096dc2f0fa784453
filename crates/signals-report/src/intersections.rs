//! The results by intersection: `intersections.csv` and, for maps, `results.geojson`.
//!
//! An intersection has the results of its point MDP, which stands for all intersections with its
//! features; where that was not simulated, with k-means, those of the point MDP of its cluster. The
//! column `basis` says which.

use geojson::{Feature, FeatureCollection, GeometryValue, JsonObject, JsonValue};

use super::demand::all_defaults;
use super::level_of_service::letter;
use super::shown::{Seen, streets};
use evaluation::analysis::Analysis;
use evaluation::report::{Spot, csv};
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
    /// Returns the word in tables.
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
pub(super) fn withheld(data: &Analysis, basis: Basis) -> Option<&'static str> {
    match basis {
        Basis::Represented => Some("another intersection was simulated in its place"),
        Basis::Simulated | Basis::PointMdp => all_defaults(&data.manifest.identity.settings)
            .then_some("all inflows are defaults by class of street"),
        Basis::None => None,
    }
}

/// Returns whether a probability is withheld anywhere, so that the tables need a column for the reason.
fn any_withheld(seen: Seen<'_>) -> bool {
    let Seen { data, shown } = seen;
    let of = |place| withheld(data, basis(data, place).0).is_some();
    shown.places.intersections.iter().any(of)
}

/// Returns the columns of an intersection; those of one method come last.
fn columns(data: &Analysis, place: &MappedIntersection, why: bool) -> Vec<(String, JsonValue)> {
    let identity = &data.manifest.identity;
    let (basis, point) = basis(data, place);
    let withheld = withheld(data, basis);
    let point = point.map(|p| &data.points[p]);
    let winner = point.and_then(|p| data.winners[p.index].as_ref());
    let result = |method: Option<usize>| point?.results[method?].as_ref();
    let number = |value: Option<f64>| value.map_or(JsonValue::Null, JsonValue::from);
    let objective = |method: Option<usize>| number(result(method).map(|r| r.objective));
    let name = |method: Option<usize>| JsonValue::from(method.map(|m| identity.methods[m].clone()));
    let best = winner.map(|w| w.best);
    let next = winner.and_then(|w| w.runner_up);
    let level = result(best);
    let (interval, lead) = (winner.and_then(|w| w.interval), winner.and_then(|w| w.lead));
    let of = |of: &str| format!("{of}_{}", identity.objective);
    let mut columns = vec![
        ("id".to_owned(), place.id.clone().into()),
        ("streets".to_owned(), streets(place).unwrap_or_default().into()),
        ("latitude".to_owned(), place.latitude.into()),
        ("longitude".to_owned(), place.longitude.into()),
        ("point".to_owned(), place.point.clone().into()),
        ("basis".to_owned(), basis.word().into()),
        ("results_of".to_owned(), point.map(|p| p.row.point.clone()).into()),
        ("winner".to_owned(), name(best)),
        (of("winner"), objective(best)),
        ("score".to_owned(), number(result(best).and_then(|r| r.score))),
        ("score_low".to_owned(), number(interval.map(|i| i.0))),
        ("score_high".to_owned(), number(interval.map(|i| i.1))),
        ("level_of_service".to_owned(), level.map(|r| letter(r.objective).to_string()).into()),
        ("runner_up".to_owned(), name(next)),
        (of("runner_up"), objective(next)),
        ("lead_low".to_owned(), number(lead.map(|l| l.0))),
        ("lead_high".to_owned(), number(lead.map(|l| l.1))),
        ("against".to_owned(), data.reference.name.clone().into()),
        (
            "winner_probability".to_owned(),
            number(winner.filter(|_| withheld.is_none()).and_then(|w| w.probability)),
        ),
        (
            "winner_fails".to_owned(),
            point.zip(best).and_then(|(p, best)| data.fails(p, best)).into(),
        ),
    ];
    columns.extend(why.then(|| ("winner_probability_withheld".to_owned(), withheld.into())));
    let methods = identity.methods.iter().enumerate();
    columns.extend(methods.map(|(m, method)| (of(method), objective(Some(m)))));
    columns
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

/// Returns `intersections.csv`.
pub(super) fn table(seen: Seen<'_>) -> String {
    let Seen { data, shown } = seen;
    let text = |cell: JsonValue| match cell {
        JsonValue::Null => String::new(),
        JsonValue::String(text) => text,
        JsonValue::Number(n) => n.as_f64().map_or_else(String::new, |n| n.to_string()),
        other => other.to_string(),
    };
    let why = any_withheld(seen);
    let of = |place| columns(data, place, why).into_iter().unzip::<_, _, Vec<_>, Vec<_>>();
    let nowhere = MappedIntersection::default();
    let header = of(&nowhere).0;
    let row = |place| of(place).1.into_iter().map(text).collect();
    csv::table(&header, shown.places.intersections.iter().map(row))
}

/// Returns `results.geojson`: a point per intersection with the columns of the table.
pub(super) fn geojson(seen: Seen<'_>) -> String {
    let Seen { data, shown } = seen;
    let why = any_withheld(seen);
    let at = |name: &str| name == "latitude" || name == "longitude";
    let feature = |place: &MappedIntersection| {
        let properties: JsonObject =
            columns(data, place, why).into_iter().filter(|(name, _)| !at(name)).collect();
        Feature {
            geometry: Some(GeometryValue::new_point([place.longitude, place.latitude]).into()),
            properties: Some(properties),
            ..Feature::default()
        }
    };
    let features = shown.places.intersections.iter().map(feature).collect();
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    let mut text = serde_json::to_string(&collection).expect("features are plain data");
    // A line per intersection, so that two versions can be compared.
    text = text.replace("{\"type\":\"Feature\",", "\n{\"type\":\"Feature\",");
    text + "\n"
}
