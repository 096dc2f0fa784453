//! What is said of traffic on pages that are otherwise the same for every task.

use minijinja::HtmlEscape;
use serde_json::Value;

use super::measures::{GRIDLOCK_EXCESS, GRIDLOCK_SHARE, UNFINISHED};
use super::overloaded::overloaded;
use super::{answers, demand};
use evaluation::analysis::{Analysis, Reference};
use evaluation::report::{About, format};

/// Returns what is said of traffic at a place; `None` where there is nothing to say.
pub(super) fn says(about: About, data: &Analysis) -> Option<String> {
    let constant = |text: &str| Some(text.to_owned());
    match about {
        About::Headline => {
            let on_defaults = demand::on_defaults(&data.manifest.identity.settings);
            on_defaults.then(|| "; most inflows are defaults".to_owned())
        }
        About::Conditions => limits(data),
        About::Gain => {
            let said = [answers::gain(data), answers::on_foot(data), answers::uncoordinated(data)];
            let said: Vec<String> = said.into_iter().flatten().collect();
            (!said.is_empty()).then(|| said.join(" "))
        }
        About::Regimes => {
            overloaded_of(data).map(|o| format!("Under the baseline {}.", o.in_words()))
        }
        About::Summaries => constant(
            "The score weighs every intersection by how often it occurs, whatever its delay. If a few intersections \
             have most of the delay, other summaries can differ from the score. Each answers another question.",
        ),
        About::Episodes => constant("Vehicles that do not arrive"),
        About::BeforeEpisodes => unfinished(data),
        About::AfterEpisodes => Some(format!(
            "An evaluation episode counts as gridlocked when the share of its vehicles that never entered or \
             had not arrived is more than {} points above that under the baseline on the same seed, or above \
             {}, whatever the baseline&#39;s is.",
            (100.0 * GRIDLOCK_EXCESS).round(),
            format::percent(GRIDLOCK_SHARE)
        )),
        About::Training => constant(
            "RESCO reports training instead. Its best episode is optimistic: it is the smallest of many noisy \
             delays, and smaller for a noisier method. The mean of the last ten is not optimistic, but it includes \
             exploration.",
        ),
        About::Points => constant(
            "Where they are derived from approaches and their counts, the rule is this project&#39;s own; the \
             paper does not print one.",
        ),
        About::Worst => constant(
            "Where even the best method does not help, lanes or less demand may be needed instead of other signals.",
        ),
        About::NotCovered => constant(
            "errors in the data or in the networks, drivers who behave otherwise than in the simulator",
        ),
        About::Elsewhere => constant("another city"),
        About::ApplyRanking => Some(format!(
            "0.80 means a fifth less delay than under {}, averaged over intersections as often as they occur. \
             A bar that crosses the dashed line may be no improvement.",
            HtmlEscape(&data.reference.name)
        )),
        About::ApplySummaries => constant(
            "the ratio is what the city as a whole gains or loses, the median what the typical intersection does. At \
             F more vehicles arrive than the baseline can serve, so capacity decides. Up to E timing decides.",
        ),
        About::ApplySpread => constant(
            "a method with a good average but bars far to the right needs a check at those intersections \
             before it is deployed.",
        ),
        About::ApplyTraining => Some(format!(
            "above the dashed line is worse than {}. Drivers would meet this if a method learned on the street.",
            HtmlEscape(&data.reference.name)
        )),
    }
}

/// Returns the part of the family that the baseline leaves at level of service F.
pub(super) fn overloaded_of(data: &Analysis) -> Option<super::Overloaded> {
    overloaded(&data.points, Reference::baseline(&data.manifest.identity).index?)
}

/// Returns under which limits of timing and which demand the results hold, as a sentence; nothing for
/// results from before there were presets.
fn limits(data: &Analysis) -> Option<String> {
    let identity = &data.manifest.identity;
    let text = |pointer: &str| identity.settings.pointer(pointer).and_then(Value::as_str);
    let (preset, actions) = (text("/preset")?, text("/signal/actions")?);
    let of_run = demand::of_run(&identity.settings).filter(|_| identity.scenario != "imported");
    let demand = of_run.map_or_else(String::new, |demand| format!("; {demand}"));
    Some(format!(" Limits of timing: preset {preset}, actions {actions}{demand}."))
}

/// Returns how long an episode lasts and how many vehicles of each method are left at its end; `None`
/// when no record says.
fn unfinished(data: &Analysis) -> Option<String> {
    let shares: Vec<String> = (data.methods.iter())
        .filter_map(|m| {
            let percent = 100.0 * m.episodes.shares[UNFINISHED]?;
            Some(format!("{} {percent:.1}%", HtmlEscape(&m.method)))
        })
        .collect();
    if shares.is_empty() {
        return None;
    }
    let horizon = match demand::horizon_s(&data.manifest.identity) {
        Some(seconds) => format!("after {seconds} s"),
        None => "when its scenario ends".to_owned(),
    };
    Some(format!(
        "An episode ends {horizon}. Vehicles that have not arrived or entered by then count with their delay until \
         then. So if there are many, delays depend on the length of an episode, and a longer episode would make them \
         differ more. Their share, weighted by \
         importance: {}.",
        shares.join(", ")
    ))
}
