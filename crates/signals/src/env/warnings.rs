//! What of a derived signal changes results; nothing of it keeps a run from starting.

use serde::Serialize;

use crate::sim::ProgramKind;
use crate::vocabulary::Light;

use super::derive::DerivedSignal;

/// Length below which a lane shows a controller next to nothing of its queue, metres: some four
/// vehicles.
const SHORT_M: f64 = 30.0;

/// What is said of lanes, movements and greens, which stand in place of `{}`.
const SHORT_LANE: &str =
    "seen no further than this, since the network ends or a signal stands upstream: lanes {}";
const UNSERVED: &str = "no phase has green for movements {}";
const NO_VEHICLES: &str = "no lane for cars is served by the greens {}, which are no phases to choose: whoever they are for \
    (pedestrians, or buses, trams and bicycles on lanes of their own) has them only while the network's own program runs, and \
    waits under every other method";
const OTHER_PROGRAM: &str = "the program is of a type that methods cannot install, such as NEMA or delay_based: they choose \
    among its greens, of NEMA among the pairs of phases that it may show";

/// Something about a signal that its user should know.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Warning {
    /// The lane, movement or green that it is about.
    pub about: String,
    /// The sentence.
    #[serde(skip)]
    text: &'static str,
}

/// Returns warnings of a signal in words, all of one kind in one sentence.
pub fn folded(warnings: Vec<Warning>) -> Vec<String> {
    of_signals(&[("", warnings)])
}

/// Returns the warnings of several signals in words: which signals a sentence is about stands before it.
///
/// # Arguments
///
/// * `signals` — the name of each signal, and what is to be said of it.
pub fn of_signals(signals: &[(&str, Vec<Warning>)]) -> Vec<String> {
    // Sentences with their signals and what they are about.
    let mut kinds: Vec<(&str, Vec<&str>, Vec<&str>)> = Vec::new();
    for (name, w) in signals.iter().flat_map(|(name, all)| all.iter().map(move |w| (*name, w))) {
        match kinds.iter_mut().find(|kind| kind.0 == w.text) {
            Some((_, names, subjects)) => (names.push(name), subjects.push(&w.about)),
            None => ((), kinds.push((w.text, vec![name], vec![&w.about]))),
        };
    }
    let line = |(text, mut names, mut subjects): (&str, Vec<&str>, Vec<&str>)| {
        names.dedup();
        subjects.dedup();
        let said = text.replace("{}", &subjects.join(", "));
        match &names[..] {
            [""] => said,
            [name] => format!("signal {name}: {said}"),
            names => format!("signals {}: {said}", names.join(", ")),
        }
    };
    kinds.into_iter().map(line).collect()
}

/// Returns what of a signal changes results, in the order of lanes, movements and phases.
pub fn warnings(signal: &DerivedSignal) -> Vec<Warning> {
    let spec = &signal.spec;
    let mut warnings = Vec::new();
    let mut warn = |text, about: String| warnings.push(Warning { about, text });
    for (i, (lane, &seen_m)) in spec.lanes.iter().zip(&signal.seen_m).enumerate() {
        // What comes to a lane between two nodes of the signal is seen at the stop line before.
        let is_inner = spec.movements.iter().any(|m| m.inner.contains(&i));
        if seen_m < SHORT_M && !is_inner {
            warn(SHORT_LANE, format!("{} ({seen_m:.1} m)", lane.id));
        }
    }
    for (m, movement) in spec.movements.iter().enumerate() {
        if spec.phases.iter().all(|p| p.service[m] == Light::Red) {
            let lanes: Vec<&str> = movement.lanes.iter().map(|l| &*spec.lanes[*l].id).collect();
            warn(UNSERVED, format!("{} from {}", movement.index, lanes.join(" and ")));
        }
    }
    signal.left_out.iter().for_each(|state| warn(NO_VEHICLES, state.clone()));
    if signal.own_kind == ProgramKind::Other {
        warn(OTHER_PROGRAM, String::new());
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::derive::derive;
    use crate::env::testing::crossing;
    use crate::settings::SignalSettings;

    #[test]
    fn every_fault_is_told_once_and_those_of_several_signals_share_a_sentence() {
        let lanes = [("n_0", 0.0, "sl"), ("e_0", 90.0, "s"), ("w_0", 270.0, "r")];
        let mut scene = crossing(&lanes, &["Grrr", "rrGr", "rrGrG", "rrrrG"]);
        scene.signals[0].links.push(vec![]);
        scene.lanes[1].length_m = 8.93;
        scene.signals[0].programs[0].kind = ProgramKind::Other;
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        let found = warnings(&derived);
        let said = folded(found.clone());
        let parts = ["lanes e_0 (8.9 m)", "8 from n_0", "the greens rrrrG,", "such as NEMA"];
        assert!(said.iter().zip(parts).all(|(said, part)| said.contains(part)), "{said:?}");
        assert!(said.len() == 4 && said[1].contains("from w_0"), "{said:?}");
        let last = found[found.len() - 1].clone();
        let told = of_signals(&[("A", found), ("B", vec![last]), ("C", vec![])]);
        assert_eq!(told.len(), 4);
        assert!(told[0].starts_with("signal A: ") && told[3].starts_with("signals A, B: "));
    }
}
