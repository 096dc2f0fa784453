//! The table of everything: a row per instance where their places are known, else per point MDP, to be sorted and
//! filtered; and where the choice of a method matters most.

use minijinja::{Value, context};

use super::error::ReportError;
use super::format;
use super::page::render;
use super::sections::Spot;
use super::whole::Report;
use crate::analysis::{PointSummary, Winner};
use crate::store::manifest::FeatureColumn;

const TEMPLATE: &str = include_str!("templates/all.html");

/// Point MDPs that are listed because the choice of a method matters there.
const CHOICES: usize = 10;

/// Returns the section; `None` where no point MDP has a result.
///
/// # Errors
///
/// [`ReportError::Template`].
pub(super) fn section(data: &Report) -> Result<Option<String>, ReportError> {
    if data.winners.iter().all(Option::is_none) {
        return Ok(None);
    }
    render("all.html", TEMPLATE, values(data)).map(Some).map_err(ReportError::Template)
}

/// Returns what the section is called.
pub(super) fn title(data: &Report) -> String {
    match data.sections.spots(data) {
        Some(_) => format!("All {}s", data.words.instance),
        None => "All point MDPs".to_owned(),
    }
}

fn values(data: &Report) -> Value {
    let placed = data.sections.spots(data);
    let (is_placed, linked) =
        (placed.is_some(), placed.iter().flatten().any(|spot| spot.dot.is_some()));
    let spots = placed.unwrap_or_else(|| data.points.iter().map(|p| of_point(data, p)).collect());
    let mut row_of: Vec<Option<usize>> = vec![None; data.points.len()];
    for (row, spot) in spots.iter().enumerate() {
        if let Some(of_point) = spot.point.and_then(|point| row_of.get_mut(point)) {
            of_point.get_or_insert(row);
        }
    }
    let columns = &data.manifest.identity.features;
    let first = if is_placed { data.words.instance.as_str() } else { "point MDP" };
    context! {
        title => title(data),
        first => format::capitalised(first),
        linked,
        amount => data.words.amount.as_str(),
        heading => data.words.heading(),
        unit => data.words.unit.as_str(),
        unit_in_full => data.words.unit_in_full.as_str(),
        worst_is => format::capitalised(match data.direction().is_lower() {
            true => data.words.sizes[2].as_str(),
            false => "worst",
        }),
        cells => data.sections.point_columns(data).join(", ").to_lowercase(),
        methods => data.manifest.identity.methods.clone(),
        features => columns.iter().map(heading).collect::<Vec<_>>(),
        rows => spots.iter().enumerate().map(|(i, s)| row(data, i, s)).collect::<Vec<_>>(),
        choice => choices(data, &row_of),
    }
}

/// Returns a feature's name and unit.
fn heading(feature: &FeatureColumn) -> [String; 2] {
    [format::words(&feature.name, &feature.unit), feature.unit.clone()]
}

/// Returns the row of a point MDP.
fn of_point(data: &Report, p: &PointSummary) -> Spot {
    let name = data.title_of(&p.row.point);
    let stands_for = data.sections.stands_for(&p.row);
    let detail = match name == p.row.point {
        true => stands_for,
        false => format!("{}, {stands_for}", p.row.point),
    };
    Spot { name, detail, point: Some(p.index), dot: None }
}

fn row(data: &Report, number: usize, spot: &Spot) -> Value {
    let point = spot.point.map(|index| &data.points[index]);
    let winner = point.and_then(|p| data.winners[p.index].as_ref());
    let methods = &data.manifest.identity.methods;
    let value = |m: usize| {
        let Some(result) = point.and_then(|p| p.results[m].as_ref()) else { return dash() };
        let mut text = data.words.value(result.objective);
        for cell in data.sections.point_cells(data, result) {
            text.push(' ');
            text.push_str(&cell);
        }
        text
    };
    let ahead = |w: &Winner| {
        let objective = |m: usize| Some(point?.results[m].as_ref()?.objective);
        let next = objective(w.runner_up?)?;
        Some(data.words.value((next - objective(w.best)?).abs()))
    };
    let features = point.map(|p| p.row.features.as_slice()).unwrap_or_default();
    let known = features.iter().map(|f| format::feature(*f));
    let missing = data.manifest.identity.features.len() - features.len();
    context! {
        id => format!("row-{number}"),
        dot => spot.dot.map(|dot| format!("dot-{dot}")),
        name => spot.name.as_str(),
        detail => spot.detail.as_str(),
        best => winner.map_or_else(dash, |w| methods[w.best].clone()),
        decided => decided(winner),
        ahead => winner.and_then(ahead).unwrap_or_else(dash),
        values => (0..methods.len()).map(value).collect::<Vec<_>>(),
        features => known.chain((0..missing).map(|_| dash())).collect::<Vec<_>>(),
    }
}

/// Says whether the lead of a winner is more than chance.
fn decided(winner: Option<&Winner>) -> String {
    match winner {
        Some(w) if w.lead.is_none() => dash(),
        Some(w) if w.is_decided() => "yes".to_owned(),
        Some(_) => "open".to_owned(),
        None => dash(),
    }
}

fn dash() -> String {
    "\u{2013}".to_owned()
}

/// Returns the point MDPs on which the best method differs most from the mean of the others.
fn choices(data: &Report, row_of: &[Option<usize>]) -> Vec<Value> {
    let methods = &data.manifest.identity.methods;
    let mut all: Vec<(f64, Value)> = (data.points.iter())
        .filter_map(|p| {
            let winner = data.winners[p.index].as_ref()?;
            let own = p.results[winner.best].as_ref()?.objective;
            let others: Vec<(usize, f64)> = (0..methods.len())
                .filter(|m| *m != winner.best)
                .filter_map(|m| Some((m, p.results[m].as_ref()?.objective)))
                .collect();
            let worst = others.iter().max_by(|a, b| data.direction().compare(a.1, b.1))?;
            let mean = others.iter().map(|(_, value)| value).sum::<f64>() / others.len() as f64;
            let difference = (mean - own).abs();
            let value = context! {
                row => row_of[p.index].map(|row| format!("row-{row}")),
                name => data.title_of(&p.row.point),
                stands_for => data.sections.stands_for(&p.row),
                best => methods[winner.best].as_str(),
                own => data.words.value(own),
                others => data.words.value(mean),
                difference => data.words.value(difference),
                worst => format!("{} under {}", data.words.value(worst.1), methods[worst.0]),
                decided => decided(Some(winner)),
            };
            Some((difference, value))
        })
        .filter(|(difference, _)| *difference > 0.0)
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().take(CHOICES).map(|(_, value)| value).collect()
}
