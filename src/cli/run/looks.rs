//! Runs that stop before their budget is spent: what is asked for, what comes next, what is said of a look.

use crate::cli::exit::Refused;
use serde_json::json;

use super::RunArgs;
use crate::analysis::Standing;
use crate::cli::output::{line, note};
use crate::domains;
use crate::report::findings::found;
use crate::run::domain::Problem;
use crate::run::plan::Draft;
use crate::run::session::Session;
use crate::sample::Until;
use crate::store::dropped::write_dropped;
use crate::store::results::Results;

/// Most pairs of methods that are named.
const NAMED: usize = 6;

/// Lets the sample of a draft grow, if that is asked for.
pub(super) fn grow(
    args: &RunArgs,
    methods: &[String],
    baseline: Option<&str>,
    draft: &mut Draft,
) -> anyhow::Result<()> {
    if !args.until_decided {
        return Ok(());
    }
    // In the order of the draft and each once, whatever the order and number of times that they were given.
    let named = |m: &&String| Some(m.as_str()) != baseline || args.methods.contains(*m);
    let judged = draft.methods.iter().filter(|m| methods.contains(m)).filter(named).cloned();
    let judged: Vec<String> = judged.collect();
    let refused = |reason: &str| Refused(format!("--until-decided: {reason}"));
    if judged.len() < 2 {
        return Err(refused("it takes two methods to decide between").into());
    }
    let looks: Vec<usize> = args.looks.iter().map(|look| look.get()).collect();
    if !draft.sample.sampling.has_design() {
        let reason =
            "it needs a balanced sample, such as --budget N draws, or one by Bayesian quadrature";
        return Err(refused(reason).into());
    }
    let until = match args.within {
        0.0 => Until::FirstPlace(judged),
        within => Until::Within(within, judged),
    };
    Ok(draft.grow(until, &looks).map_err(|e| refused(&e.to_string()))?)
}

/// Returns the results with what is to be done next in them; nothing when the run is complete, or says enough.
pub(super) fn next(
    (session, problem): (&Session<'_>, &dyn Problem),
    done: Option<usize>,
    args: &RunArgs,
) -> anyhow::Result<Option<Results>> {
    let grows = session.manifest.identity.sample.growth.is_some();
    if !grows && done.is_some() {
        return Ok(None);
    }
    let all = Results::load_known(&session.layout, &session.manifest)?;
    if !grows {
        return Ok(Some(all));
    }
    // What was worked on and still lacks tasks is not tried again.
    let is_new = |results: &Results| done.is_none_or(|done| results.plan().len() > done);
    let now = all.clone().so_far();
    if now.missing().next().is_some() {
        return Ok(Some(now).filter(is_new));
    }
    session.stand_in(problem, &now.manifest.identity.sample)?;
    let analysis = domains::analysis(&session.layout, &now)?;
    let Some(standing) = analysis.standing() else { return Ok(None) };
    let mut all = all;
    if standing.goes_on() && !standing.behind.is_empty() {
        all.dropped.extend(standing.behind.iter().cloned());
        write_dropped(&session.layout, &all.dropped)?;
    }
    let next = all.at_look(standing.look).filter(|next| standing.goes_on() && is_new(next));
    if args.json {
        line(json!({
            "event": "look",
            "look": standing.look,
            "looks": standing.looks,
            "points": now.manifest.identity.points.len(),
            "enough": standing.is_enough,
            "open": standing.open,
            "dropped": standing.behind.iter().map(|d| &d.method).collect::<Vec<_>>(),
        }))?;
    } else if !args.quiet {
        let points = now.manifest.identity.points.len();
        let then = next.as_ref().map(|next| next.manifest.identity.points.len());
        note(said(&standing, args.within, points, then));
    }
    Ok(next)
}

/// Returns what a look shows, and what follows from it.
fn said(standing: &Standing, within: f64, points: usize, then: Option<usize>) -> String {
    let Standing { look, looks, answer, open, is_enough, behind } = standing;
    let mut text = format!("look {look} of {looks}, {points} point MDPs: ");
    match answer {
        Some(answer) => text.push_str(&found(answer, within)),
        None => {
            let named = open.iter().take(NAMED).map(|(a, b)| format!("{a} and {b}"));
            text.push_str(&format!("open between {}", named.collect::<Vec<_>>().join(", ")));
            if open.len() > NAMED {
                text.push_str(&format!(" and {} other pairs", open.len() - NAMED));
            }
        }
    }
    text.push_str(&match (is_enough, then) {
        (true, _) => "; that is enough".to_owned(),
        (false, Some(then)) if behind.is_empty() => format!("; continuing to {then}"),
        (false, Some(then)) => {
            let named = behind.iter().map(|d| format!("{} (behind {})", d.method, d.behind));
            let named: Vec<String> = named.collect();
            format!("; continuing to {then} without {}", named.join(", "))
        }
        (false, None) => "; the budget is spent".to_owned(),
    });
    text
}
