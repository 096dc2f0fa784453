//! What Python answers when it is asked for phases.

use pyo3::prelude::*;
use tsc_family::traffic::control::{GreenPhase, SignalSpec};

/// Most characters of a value that a message quotes.
const QUOTED: usize = 200;

/// Writes the phases that were chosen.
/// The error is what was returned instead, and what is expected.
pub(crate) fn choose(
    answer: &Bound<'_, PyAny>,
    specs: &[SignalSpec],
    phases: &mut [GreenPhase],
) -> Result<(), String> {
    let count = specs.len();
    let expected =
        || format!("{}; it has to be a list of {count}, the phase of every signal", quoted(answer));
    // Texts can be iterated over too, but hold no phases.
    let mut items = answer.try_iter().map_err(|_| expected())?;
    for (spec, phase) in specs.iter().zip(phases.iter_mut()) {
        let item = items.next().ok_or_else(expected)?.map_err(|_| expected())?;
        let most = spec.phases.len().saturating_sub(1);
        let chosen: i64 = item.extract().map_err(|_| {
            let id = &spec.id;
            format!("{} for signal {id}; a phase is a whole number from 0 to {most}", quoted(&item))
        })?;
        *phase = match usize::try_from(chosen) {
            Ok(chosen) if chosen <= most => GreenPhase(chosen),
            _ => {
                return Err(format!(
                    "phase {chosen} for signal {}, which has 0 to {most}",
                    spec.id
                ));
            }
        };
    }
    if items.next().is_some() { Err(expected()) } else { Ok(()) }
}

fn quoted(value: &Bound<'_, PyAny>) -> String {
    let kind = value.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
    let text = value.repr().map_or_else(|_| String::new(), |repr| repr.to_string());
    let mut short: String = text.chars().take(QUOTED).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    format!("{short} ({kind})")
}
