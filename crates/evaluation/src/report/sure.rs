//! The section "How sure is the ranking?": every text and number of it, for its own template.

use minijinja::{Value, context};

use super::error::ReportError;
use super::figure::Figure;
use super::figures::label;
use super::format;
use super::page::render;
use super::table::{Cell, Columns, Table};
use super::whole::Report;
use crate::analysis::{Decided, FEWEST_SEEDS_FOR_PLACES, MethodSummary, Pair};
use crate::stats::bootstrap::RESAMPLES;

const TEMPLATE: &str = include_str!("templates/sure.html");

/// Most pairs that are all shown at once; of more the neighbours in the ranking are.
const MOST_PAIRS: usize = 10;

/// Least probability of the first place that is worth a word.
const LIKELY: f64 = 0.01;

/// By how much rounding may keep a sum of shares from 1.
const ROUNDING: f64 = 1e-12;

/// Returns the section; `None` where no two methods have a result on the same point MDP.
pub(super) fn section(data: &Report, figures: &[Figure]) -> Result<Option<String>, ReportError> {
    if data.comparison.pairs.is_empty() {
        return Ok(None);
    }
    render("sure.html", TEMPLATE, values(data, figures)).map(Some).map_err(ReportError::Template)
}

fn values(data: &Report, figures: &[Figure]) -> Value {
    let figure = |name: &str| figures.iter().find(|f| f.name == name).map(|f| f.svg.clone());
    let pairs = &data.comparison.pairs;
    let many = pairs.len() > MOST_PAIRS;
    let neighbours = |p: &&Pair| !many || p.second == p.first + 1;
    let met = &data.words.met;
    let caption = match many {
        true => format!(
            "Neighbours in the ranking: the lead of a method over the next one, on the same point MDPs and {met}. All {} \
             pairs are below and in pairs.csv.",
            pairs.len()
        ),
        false => format!(
            "Every pair of methods, the better one first, with its lead on the same point MDPs and {met}. Full precision: \
             pairs.csv."
        ),
    };
    context! {
        answer => answer(data),
        covers => covers(data),
        met => data.words.met.as_str(),
        resamples => data.manifest.identity.sample.resamples(RESAMPLES),
        ranks => figure("ranks"),
        pairs => self::pairs(data, pairs.iter().filter(neighbours)).html(&caption),
        all_pairs => many.then(|| {
            self::pairs(data, pairs).html("Every pair of methods, the better one first.")
        }),
        count => pairs.len(),
        left_out => data.unranked().map(|m| m.method.clone()).collect::<Vec<_>>().join(", "),
    }
}

/// Returns pairs of methods with their differences.
pub(super) fn pairs<'a>(data: &'a Report, pairs: impl IntoIterator<Item = &'a Pair>) -> Table {
    let pairs: Vec<&Pair> = pairs.into_iter().collect();
    let name = |m: usize| data.methods[m].method.clone();
    let range = |(low, high): (f64, f64)| {
        (low != high).then(|| format!("{} to {}", format::percent(low), format::percent(high)))
    };
    let better = move |p: &&Pair| match p.decided() {
        Decided::First => name(p.first),
        Decided::Second => name(p.second),
        Decided::Open => "open".to_owned(),
        Decided::Unknown => String::new(),
    };
    let differ = pairs.iter().any(|p| p.points != data.points.len());
    let columns = Columns::new()
        .text("method", "", move |p: &&Pair| name(p.first))
        .text("other", "", move |p| name(p.second))
        .text("", "method", |p| label(data, &data.methods[p.first]))
        .text("", "other", |p| label(data, &data.methods[p.second]))
        .column("points", if differ { "point MDPs" } else { "" }, |p| Cell::count(p.points))
        .column("ahead", "ahead by", |p| {
            let (ahead, interval) = format::lead(p.ahead.value, p.ahead.interval);
            Cell::number(p.ahead.value, |_| ahead).above(interval)
        })
        .file("ahead_low", |p| Cell::exact(p.ahead.interval.map(|i| i.0)))
        .file("ahead_high", |p| Cell::exact(p.ahead.interval.map(|i| i.1)))
        .column("improvement", "probability of improvement", move |p| {
            let below = p.improvement.interval.and_then(range);
            Cell::number(p.improvement.value, format::percent).above(below)
        })
        .file("improvement_low", |p| Cell::exact(p.improvement.interval.map(|i| i.0)))
        .file("improvement_high", |p| Cell::exact(p.improvement.interval.map(|i| i.1)))
        .text("better", "better", better)
        .text("against", "", |_| data.reference.name.clone());
    columns.table(pairs)
}

/// Returns the probability of every place, a row per method and place.
pub(super) fn places(data: &Report) -> Table {
    let all = data.comparison.ranks.iter().flatten().zip(&data.methods);
    let rows = all.flat_map(|(of, m)| of.iter().enumerate().map(move |(place, p)| (m, place, *p)));
    Columns::new()
        .text("method", "", |(m, ..): &(&MethodSummary, usize, f64)| m.method.clone())
        .file("rank", |(_, place, _)| Cell::count(place + 1))
        .file("probability", |(.., p)| Cell::exact(*p))
        .text("against", "", |_| data.reference.name.clone())
        .table(rows)
}

/// Returns the performance profiles, a row per method and score.
pub(super) fn profiles(data: &Report) -> Table {
    let all = data.comparison.profiles.iter();
    let rows = all.flat_map(|p| p.steps.iter().map(|(score, share)| (p.method, *score, *share)));
    Columns::new()
        .text("method", "", |(m, ..): &(usize, f64, f64)| data.methods[*m].method.clone())
        .file("score", |(_, score, _)| Cell::exact(*score))
        .file("share", |(.., share)| Cell::exact(*share))
        .text("against", "", |_| data.reference.name.clone())
        .table(rows)
}

/// Says who is first and how sure that is, and which pairs are open.
fn answer(data: &Report) -> String {
    let pairs = &data.comparison.pairs;
    let mut text = String::new();
    if let Some(ranks) = &data.comparison.ranks {
        let mut first: Vec<(&str, f64)> =
            data.methods.iter().zip(ranks).map(|(m, r)| (m.method.as_str(), r[0])).collect();
        first.sort_by(|a, b| b.1.total_cmp(&a.1));
        let likely: Vec<String> = (first.iter())
            .filter(|(_, p)| *p >= LIKELY)
            .map(|(m, p)| format!("{m} {}", certain(*p)))
            .collect();
        text.push_str(&match first.first() {
            Some((m, p)) if *p >= 1.0 - ROUNDING => format!("{m} is first in every resample. "),
            _ => format!("Probability of the first place: {}. ", likely.join(", ")),
        });
    }
    let open: Vec<String> = (pairs.iter())
        .filter(|p| p.decided() == Decided::Open)
        .map(|p| format!("{} and {}", data.methods[p.first].method, data.methods[p.second].method))
        .collect();
    let known = pairs.iter().filter(|p| p.decided() != Decided::Unknown).count();
    text.push_str(&match (known, open.len()) {
        (0, _) => {
            "There are no intervals, so any difference between methods may be chance.".to_owned()
        }
        (1, 0) => "It is decided which of the two is better.".to_owned(),
        (n, 0) => format!("All {n} pairs are decided."),
        (n, open_pairs) => {
            let named = if open.len() <= MOST_PAIRS {
                open.join("; ")
            } else {
                format!("{}; and others", open[..MOST_PAIRS].join("; "))
            };
            format!(
                "Of {} {open_pairs} {} open: {named}.",
                format::count(n, "pair"),
                if open_pairs == 1 { "is" } else { "are" }
            )
        }
    });
    text
}

/// Returns a probability in per cent that does not claim all of less.
pub(super) fn certain(p: f64) -> String {
    if p > 0.995 { ">99%".to_owned() } else { format::percent(p) }
}

/// Says what the probabilities cover.
fn covers(data: &Report) -> String {
    let identity = &data.manifest.identity;
    let seeds = identity.evaluation_seeds.len();
    let ranked = data.methods.iter().filter(|m| m.rank.is_some());
    let evaluated = ranked.map(|m| m.points).min().unwrap_or(data.points.len());
    let whole = data.estimator().is_whole(identity.sample.family_size, evaluated);
    let repeated: Vec<&str> = (data.methods.iter())
        .map(|m| m.method.as_str())
        .filter(|m| data.trained.contains(*m) && identity.replicates_of(m) > 1)
        .collect();
    let mut causes = Vec::new();
    if !whole {
        causes.push(format!(
            "which {evaluated} of {} point MDPs were evaluated",
            identity.sample.family_size
        ));
    }
    if seeds > 1 {
        causes.push(format!("the choice of {seeds} evaluation seeds"));
    }
    if !repeated.is_empty() {
        causes.push(format!("the luck of the trainings of {}", repeated.join(", ")));
    }
    match causes.is_empty() {
        true => "One seed on every point MDP of a family does not show chance.".to_owned(),
        false if seeds < FEWEST_SEEDS_FOR_PLACES => format!(
            "Probabilities and intervals cover only {}. Probabilities of places need at least {FEWEST_SEEDS_FOR_PLACES} evaluation \
             seeds.",
            causes.join(" and ")
        ),
        false => format!("Probabilities and intervals cover only {}.", causes.join(" and ")),
    }
}
