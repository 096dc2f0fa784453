//! Plans that records from before programs were kept have in words.

use std::collections::BTreeMap;

use super::task_plan::Source;
use signals::control::fixed_time::{OWN, PLAN};
use signals::program::{ProgramKind, ProgramPhase, SignalProgram};
use signals::settings::signal::{ChangeInterval, SignalSettings};
use signals::timing::Timing;

/// How much is known, one program per signal, and the cycles that their phases do not say.
pub(super) type Found = (Source, Vec<SignalProgram>, Vec<Option<f64>>);

/// Returns the programs that a record's details describe; `None` where they describe none.
pub(super) fn programs(
    details: &BTreeMap<String, String>,
    settings: &SignalSettings,
) -> Option<Found> {
    let mut plans = details.iter().filter_map(|(k, text)| Some((k.strip_prefix(PLAN)?, text)));
    let (mut programs, mut cycles_s, mut source) = (Vec::new(), Vec::new(), Source::Described);
    for (signal, text) in &mut plans {
        let own = text == OWN;
        let (cycle_s, greens) = if own { (None, Vec::new()) } else { parse(text)? };
        let whole = cycle(&greens, settings).filter(|phases| {
            let total_s: f64 = phases.iter().map(|p| p.duration_s).sum();
            own || cycle_s.is_some_and(|c| (c - total_s).abs() < 1e-6)
        });
        if whole.is_none() && !own {
            source = Source::Greens;
        }
        cycles_s.push(cycle_s.filter(|_| whole.is_none()));
        let phases = whole.unwrap_or(greens);
        let program = SignalProgram::new(signal, ProgramKind::Static, phases);
        programs.push(SignalProgram { own, ..program });
    }
    (!programs.is_empty()).then_some((source, programs, cycles_s))
}

/// Reads `cycle 60 s: GGrr 30 s, rrGG 24 s`.
fn parse(text: &str) -> Option<(Option<f64>, Vec<ProgramPhase>)> {
    let (cycle, greens) = text.strip_prefix("cycle ")?.split_once(" s: ")?;
    let green = |text: &str| {
        let (state, seconds) = text.strip_suffix(" s")?.split_once(' ')?;
        Some(ProgramPhase::fixed(state, seconds.parse().ok()?))
    };
    let greens: Option<Vec<_>> = greens.split(", ").map(green).collect();
    Some((Some(cycle.parse().ok()?), greens?))
}

/// Returns greens with the changes between them; `None` where these depend on the streets.
fn cycle(greens: &[ProgramPhase], settings: &SignalSettings) -> Option<Vec<ProgramPhase>> {
    if settings.change_interval != ChangeInterval::Fixed {
        return None;
    }
    let timing = Timing::new(settings, Vec::new(), Vec::new());
    let mut phases = Vec::new();
    for (i, green) in greens.iter().enumerate() {
        let next = &greens[(i + 1) % greens.len()];
        phases.push(green.clone());
        let changes = timing.between(&green.state, &next.state).into_iter();
        phases
            .extend(changes.map(|(state, seconds)| ProgramPhase::fixed(state, f64::from(seconds))));
    }
    Some(phases)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn details(text: &str) -> BTreeMap<String, String> {
        BTreeMap::from([("plan c".to_owned(), text.to_owned()), ("simulations".into(), "9".into())])
    }

    fn phases(found: &Found) -> Vec<(&str, f64)> {
        found.1[0].phases.iter().map(|p| (p.state.as_str(), p.duration_s)).collect()
    }

    #[test]
    fn a_plan_in_words_is_whole_where_changes_are_the_same_everywhere() {
        let text = details("cycle 25 s: GGrr 12 s, rrGG 7 s");
        let found = programs(&text, &SignalSettings::default()).unwrap();
        assert_eq!(phases(&found), [("GGrr", 12.0), ("yyrr", 3.0), ("rrGG", 7.0), ("rryy", 3.0)]);
        assert_eq!((found.0, found.2[0]), (Source::Described, None));
    }

    #[test]
    fn a_plan_in_words_has_only_greens_where_changes_depend_on_the_streets() {
        let settings = SignalSettings {
            change_interval: ChangeInterval::Kinematic,
            ..SignalSettings::default()
        };
        let found = programs(&details("cycle 60 s: GGrr 30 s, rrGG 20 s"), &settings).unwrap();
        assert_eq!(phases(&found), [("GGrr", 30.0), ("rrGG", 20.0)]);
        assert_eq!((found.0, found.2[0]), (Source::Greens, Some(60.0)));
        // A cycle that the settings do not explain is not made up.
        let text = details("cycle 99 s: GGrr 30 s, rrGG 20 s");
        assert_eq!(programs(&text, &SignalSettings::default()).unwrap().0, Source::Greens);
    }

    #[test]
    fn the_own_program_and_other_details_are_no_phases() {
        let found = programs(&details(OWN), &SignalSettings::default()).unwrap();
        assert!(found.1[0].own && found.1[0].phases.is_empty());
        let other = BTreeMap::from([("simulations".to_owned(), "9".to_owned())]);
        assert_eq!(programs(&other, &SignalSettings::default()), None);
        assert_eq!(programs(&details("something else"), &SignalSettings::default()), None);
    }
}
