//! The table of everything: a row per instance where their places are known, else per point MDP, to be sorted and
//! filtered.

use minijinja::{Value, context};

use super::error::ReportError;
use super::first::FEW_SEEDS;
use super::page::render;
use super::sections::{About, Spot};
use super::sure::certain;
use super::whole::Report;
use super::words::limit_in_words;
use super::{format, text};
use crate::analysis::{PointSummary, Winner};
use crate::family::Feature;
use crate::stats::bootstrap::RESAMPLES;

const TEMPLATE: &str = include_str!("templates/all.html");

/// Returns the section; `None` where no point MDP has a result.
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
    let columns = &data.manifest.identity.features;
    let first = if is_placed { data.words.instance.as_str() } else { "point MDP" };
    let probable = data.winners.iter().flatten().any(|w| w.probability.is_some());
    let failure = data.failure.as_ref().filter(|_| fails_known(data)).map(limit_in_words);
    context! {
        title => title(data),
        says => data.sections.says(About::Worst, data),
        first => format::capitalised(first),
        linked,
        amount => data.words.amount.as_str(),
        unit => data.words.unit.as_str(),
        met => data.words.met.as_str(),
        instance => data.words.instance.as_str(),
        resamples => RESAMPLES,
        seeds => data.manifest.identity.evaluation_seeds.len(),
        few => data.manifest.identity.evaluation_seeds.len() < FEW_SEEDS,
        replicated => data.manifest.identity.replicates > 1,
        once => text::trained_once(data).join(", "),
        probable,
        failure,
        cells => data.sections.point_columns(data).join(", ").to_lowercase(),
        methods => &data.manifest.identity.methods,
        features => columns.iter().map(heading).collect::<Vec<_>>(),
        count => spots.len(),
        rows => spots.iter().enumerate().map(|(i, s)| row(data, i, s)).collect::<Vec<_>>(),
    }
}

/// Whether it is known of any winner whether it fails.
fn fails_known(data: &Report) -> bool {
    let of = |(p, w): (&PointSummary, &Option<Winner>)| data.fails(p, w.as_ref()?.best);
    data.points.iter().zip(&data.winners).any(|pair| of(pair).is_some())
}

fn heading(feature: &Feature) -> [String; 2] {
    [format::words(&feature.name, &feature.unit), feature.unit.clone()]
}

fn of_point(data: &Report, p: &PointSummary) -> Spot {
    let name = data.title_of(&p.row.point);
    let stands_for = data.sections.stands_for(&p.row);
    let detail = match name == p.row.point {
        true => stands_for,
        false => format!("{}, {stands_for}", p.row.point),
    };
    Spot { name, detail, point: Some(p.index), dot: None, withheld: None }
}

fn detail(spot: &Spot, winner: Option<&Winner>) -> String {
    let given = winner.is_some_and(|w| w.probability.is_some());
    match spot.withheld.filter(|_| given) {
        Some(why) => format!("{}; no probability, because {why}", spot.detail),
        None => spot.detail.clone(),
    }
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
        detail => detail(spot, winner),
        best => winner.map_or_else(dash, |w| methods[w.best].clone()),
        probability => probability(winner.filter(|_| spot.withheld.is_none())),
        decided => decided(winner),
        fails => match point.zip(winner).and_then(|(p, w)| data.fails(p, w.best)) {
            Some(true) => "yes".to_owned(),
            Some(false) => "no".to_owned(),
            None => dash(),
        },
        ahead => winner.and_then(ahead).unwrap_or_else(dash),
        values => (0..methods.len()).map(value).collect::<Vec<_>>(),
        features => known.chain((0..missing).map(|_| dash())).collect::<Vec<_>>(),
    }
}

fn probability(winner: Option<&Winner>) -> String {
    winner.and_then(|w| w.probability).map_or_else(dash, certain)
}

/// Says whether the leads of a winner are more than chance.
fn decided(winner: Option<&Winner>) -> String {
    match winner {
        Some(w) if w.lead.is_some() => if w.is_decided { "yes" } else { "open" }.to_owned(),
        _ => dash(),
    }
}

pub(super) fn dash() -> String {
    "\u{2013}".to_owned()
}
