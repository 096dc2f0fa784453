//! What of a derived signal changes results; nothing of it keeps a run from starting.

use std::mem::discriminant;

use serde::Serialize;

use crate::sim::ProgramKind;
use crate::vocabulary::Light;

use super::derive::DerivedSignal;

/// Length below which a lane shows a controller next to nothing of its queue, metres: some four
/// vehicles.
const SHORT_M: f64 = 30.0;

/// Something about a signal that its user should know.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Warning {
    /// A lane of which little is seen, although it was traced upstream.
    ShortLane {
        /// SUMO's lane id.
        lane: String,
        /// How far it is seen, metres.
        seen_m: f64,
    },
    /// A movement that no phase serves.
    Unserved {
        /// Its index.
        movement: usize,
        /// SUMO's ids of its lanes.
        lanes: Vec<String>,
    },
    /// A green that serves no lane for cars.
    NoVehicles {
        /// SUMO's state.
        state: String,
    },
    /// A program that does not run its phases one after the other.
    OtherProgram,
}

impl Warning {
    fn subject(&self) -> String {
        match self {
            Self::ShortLane { lane, seen_m } => format!("{lane} ({seen_m:.1} m)"),
            Self::Unserved { movement, lanes } => {
                format!("{movement} from {}", lanes.join(" and "))
            }
            Self::NoVehicles { state } => state.clone(),
            Self::OtherProgram => String::new(),
        }
    }
}

/// Returns warnings of a signal in words, all of one kind in one sentence.
pub fn folded<'a>(warnings: impl IntoIterator<Item = &'a Warning>) -> Vec<String> {
    let kinds = by_kind(warnings.into_iter().map(|warning| ("", warning)));
    kinds.iter().map(|kind| said(kind)).collect()
}

/// Returns the warnings of several signals in words: which signals a sentence is about stands before it.
///
/// # Arguments
///
/// * `signals` — the name of each signal, and what is to be said of it.
pub fn of_signals(signals: &[(&str, Vec<Warning>)]) -> Vec<String> {
    let each = signals.iter().flat_map(|(name, all)| all.iter().map(move |w| (*name, w)));
    let line = |kind: &Vec<(&str, &Warning)>| {
        let mut names: Vec<&str> = kind.iter().map(|(name, _)| *name).collect();
        names.dedup();
        let signals = if names.len() == 1 { "signal" } else { "signals" };
        format!("{signals} {}: {}", names.join(", "), said(kind))
    };
    by_kind(each).iter().map(line).collect()
}

fn by_kind<'a>(
    warnings: impl Iterator<Item = (&'a str, &'a Warning)>,
) -> Vec<Vec<(&'a str, &'a Warning)>> {
    let mut kinds: Vec<Vec<(&str, &Warning)>> = Vec::new();
    for (name, warning) in warnings {
        match kinds.iter_mut().find(|kind| discriminant(kind[0].1) == discriminant(warning)) {
            Some(kind) => kind.push((name, warning)),
            None => kinds.push(vec![(name, warning)]),
        }
    }
    kinds
}

/// Returns warnings of one kind in a sentence.
fn said(kind: &[(&str, &Warning)]) -> String {
    let mut subjects: Vec<String> = kind.iter().map(|(_, warning)| warning.subject()).collect();
    subjects.dedup();
    let all = subjects.join(", ");
    match kind[0].1 {
        Warning::ShortLane { .. } => {
            format!("seen no further than this, since the network ends or a signal stands upstream: lanes {all}")
        }
        Warning::Unserved { .. } => format!("no phase has green for movements {all}"),
        Warning::NoVehicles { .. } => format!(
            "no lane for cars is served by the greens {all}, which are no phases to choose: whoever they are for (pedestrians, \
             or buses, trams and bicycles on lanes of their own) has them only while the network's own program runs, and waits \
             under every other method"
        ),
        Warning::OtherProgram => {
            "the program is of a type that methods cannot install, such as NEMA or delay_based: they choose among its greens, \
             of NEMA among the pairs of phases that it may show"
                .to_owned()
        }
    }
}

/// Returns what of a signal changes results, in the order of lanes, movements and phases.
pub fn warnings(signal: &DerivedSignal) -> Vec<Warning> {
    let spec = &signal.spec;
    let mut warnings = Vec::new();
    for (i, (lane, &seen_m)) in spec.lanes.iter().zip(&signal.seen_m).enumerate() {
        // What comes to a lane between two nodes of the signal is seen at the stop line before.
        let is_inner = spec.movements.iter().any(|m| m.inner.contains(&i));
        if seen_m < SHORT_M && !is_inner {
            warnings.push(Warning::ShortLane { lane: lane.id.clone(), seen_m });
        }
    }
    for (m, movement) in spec.movements.iter().enumerate() {
        if spec.phases.iter().all(|p| p.service[m] == Light::Red) {
            let lanes = movement.lanes.iter().map(|lane| spec.lanes[*lane].id.clone()).collect();
            warnings.push(Warning::Unserved { movement: movement.index, lanes });
        }
    }
    warnings.extend(signal.left_out.iter().map(|s| Warning::NoVehicles { state: s.clone() }));
    if signal.own_kind == ProgramKind::Other {
        warnings.push(Warning::OtherProgram);
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
        let said = folded(&found);
        for (said, expected) in said
            .iter()
            .zip(["lanes e_0 (8.9 m)", "8 from n_0", "the greens rrrrG,", "such as NEMA"])
        {
            assert!(said.contains(expected), "{said}");
        }
        assert!(said.len() == 4 && said[1].contains("from w_0"), "{said:?}");
        let told = of_signals(&[("A", found), ("B", vec![Warning::OtherProgram]), ("C", vec![])]);
        assert_eq!(told.len(), 4);
        assert!(told[0].starts_with("signal A: ") && told[3].starts_with("signals A, B: "));
    }
}
