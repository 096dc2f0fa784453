//! The section "How sure is the ranking?": every text and number of it, for its own template.

use minijinja::{Value, context};

use super::error::ReportError;
use super::figure::Figure;
use super::figures::label;
use super::page::render;
use super::table::{Cell, Columns, Table};
use super::whole::Report;
use super::{format, text};
use crate::analysis::{Decided, FEWEST_SEEDS_FOR_PLACES, Pair};
use crate::stats::bootstrap::RESAMPLES;

const TEMPLATE: &str = include_str!("templates/sure.html");

/// Most pairs that are all shown at once; of more the neighbours in the ranking are.
const MOST_PAIRS: usize = 10;

/// Least probability of the first place that is worth a word.
const LIKELY: f64 = 0.01;

/// By how much rounding may keep a sum of shares from 1.
const ROUNDING: f64 = 1e-12;

/// Returns the section; `None` where no two methods have a result on the same point MDP.
///
/// # Errors
///
/// [`ReportError::Template`].
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
        better => data.better(),
        resamples => data.manifest.identity.sample.resamples(RESAMPLES),
        ranks => figure("ranks"),
        profiles => figure("profiles"),
        is_relative => !data.reference.is_none(),
        of => data.reference.in_short(),
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
    let mut text = match causes.is_empty() {
        true => "One seed on every point MDP of a family does not show chance. Differences and profiles are those of \
        the records, without probabilities.".to_owned(),
        false => format!(
            "Probabilities and intervals cover only {}.",
            causes.join(" and ")
        ),
    };
    if !causes.is_empty() && seeds < FEWEST_SEEDS_FOR_PLACES {
        text.push_str(&format!(
            " Probabilities of places need at least {FEWEST_SEEDS_FOR_PLACES} evaluation seeds."
        ));
    }
    if evaluated < data.points.len() {
        text.push_str(" Missing results are assumed to be missing at random.");
    }
    if whole && !causes.is_empty() {
        text.push_str(" All point MDPs were evaluated, so their choice adds no chance.");
    }
    let tuned = text::once(data, false);
    if !tuned.is_empty() {
        let names = format!("once per point MDP: {}", tuned.join(", "));
        text.push_str(&match whole {
            true => format!(" They do not cover the luck of tuning ({names})."),
            false => format!(
                " They cover the luck of tuning ({names}) only as far as it differs between point MDPs."
            ),
        });
    }
    let learned = text::once(data, true);
    if !learned.is_empty() {
        text.push_str(&format!(
            " They take all that neighbouring point MDPs differ by for the luck of training of {} (once per point MDP), \
             so they are too wide where trainings go well alike, and too narrow where some fail by chance.",
            learned.join(", ")
        ));
    }
    text
}
