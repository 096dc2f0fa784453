//! What may be wrong with a signal as it was derived; nothing of it keeps a run from starting.

use std::fmt;
use std::mem::discriminant;

use serde::Serialize;

use crate::control::Phase;
use crate::sim::ProgramKind;
use crate::vocabulary::Light;

use super::derive::DerivedSignal;
use super::pairs::Naming;

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
    /// A lane that no phase serves.
    UnservedLane {
        /// SUMO's lane id.
        lane: String,
    },
    /// A movement that no phase serves, although its lanes have green for others.
    UnservedMovement {
        /// Its index.
        movement: usize,
        /// SUMO's ids of its lanes.
        lanes: Vec<String>,
    },
    /// A lane whose movements never have green together.
    NeverWhole {
        /// SUMO's lane id.
        lane: String,
    },
    /// A green that serves no lane for cars.
    NoVehicles {
        /// SUMO's state.
        state: String,
    },
    /// Two phases between which no controller sees a difference.
    SameMovements {
        /// Index of the first phase.
        first: usize,
        /// Index of the second.
        second: usize,
    },
    /// Phases of the program to which it never comes.
    Unreached {
        /// Their states.
        states: Vec<String>,
    },
    /// Phases that two movements do not tell apart.
    NamedByAll,
    /// One phase only.
    OnePhase,
    /// A program that does not run its phases one after the other.
    OtherProgram,
}

impl Warning {
    /// Whether it names lanes, which tell of which signal they are.
    fn names_lanes(&self) -> bool {
        matches!(
            self,
            Self::ShortLane { .. }
                | Self::UnservedLane { .. }
                | Self::UnservedMovement { .. }
                | Self::NeverWhole { .. }
        )
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&said(&[self]))
    }
}

/// Returns the warnings of a signal in words, all of one kind in one sentence, in the order in which the kinds begin.
pub fn folded(warnings: &[Warning]) -> Vec<String> {
    kinds(warnings).iter().map(|kind| said(kind)).collect()
}

/// Returns the warnings of several signals in words. Signals of which the same is to be said share a sentence, and so do
/// all lanes of one kind of warning.
///
/// # Arguments
///
/// * `signals` — the name of each signal, and what is to be said of it.
pub fn of_signals(signals: &[(&str, Vec<Warning>)]) -> Vec<String> {
    let mut groups: Vec<(Vec<&str>, Vec<&Warning>)> = Vec::new();
    for (name, kind) in
        signals.iter().flat_map(|(name, all)| kinds(all).into_iter().map(move |kind| (*name, kind)))
    {
        let joins = |(_, known): &&mut (Vec<&str>, Vec<&Warning>)| {
            discriminant(known[0]) == discriminant(kind[0])
                && (kind[0].names_lanes() || *known == kind)
        };
        match groups.iter_mut().find(joins) {
            Some((names, known)) => {
                names.push(name);
                if kind[0].names_lanes() {
                    known.extend(kind);
                }
            }
            None => groups.push((vec![name], kind)),
        }
    }
    let line = |(names, kind): &(Vec<&str>, Vec<&Warning>)| {
        let signals = if names.len() == 1 { "signal" } else { "signals" };
        format!("{signals} {}: {}", names.join(", "), said(kind))
    };
    groups.iter().map(line).collect()
}

/// Returns warnings by their kind, in the order in which the kinds begin.
fn kinds(warnings: &[Warning]) -> Vec<Vec<&Warning>> {
    let mut kinds: Vec<Vec<&Warning>> = Vec::new();
    for warning in warnings {
        let same = |kind: &&mut Vec<&Warning>| discriminant(kind[0]) == discriminant(warning);
        match kinds.iter_mut().find(same) {
            Some(kind) => kind.push(warning),
            None => kinds.push(vec![warning]),
        }
    }
    kinds
}

/// Returns warnings of one kind in a sentence.
fn said(kind: &[&Warning]) -> String {
    let one = kind.len() == 1;
    let number = |singular: &'static str, plural: &'static str| if one { singular } else { plural };
    let named = |name: fn(&Warning) -> Option<String>| {
        kind.iter().filter_map(|warning| name(warning)).collect::<Vec<_>>().join(", ")
    };
    let lanes = named(|warning| match warning {
        Warning::ShortLane { lane, .. }
        | Warning::UnservedLane { lane }
        | Warning::NeverWhole { lane } => Some(lane.clone()),
        _ => None,
    });
    match kind[0] {
        Warning::ShortLane { seen_m, .. } => {
            let seen_m = kind.iter().filter_map(|warning| match warning {
                Warning::ShortLane { seen_m, .. } => Some(*seen_m),
                _ => None,
            }).fold((*seen_m, *seen_m), |(low, high), m| (low.min(m), high.max(m)));
            let far = match format!("{:.1}", seen_m.0) == format!("{:.1}", seen_m.1) {
                true => format!("{:.1} m", seen_m.0),
                false => format!("{:.1} to {:.1} m", seen_m.0, seen_m.1),
            };
            format!(
                "{} {lanes} {} seen for {far} only; upstream the network ends or a signal stands",
                number("lane", "lanes"),
                number("is", "are")
            )
        }
        Warning::UnservedLane { .. } => {
            let (lane, has) = (number("lane", "lanes"), number("has", "have"));
            format!("{lane} {lanes} {has} no green in any phase")
        }
        Warning::UnservedMovement { .. } => {
            let movements = named(|warning| match warning {
                Warning::UnservedMovement { movement, lanes } => {
                    Some(format!("{movement}, from {}", lanes.join(" and ")))
                }
                _ => None,
            });
            match one {
                true => format!("movement {movements}, has no green in any phase"),
                false => format!("movements {} have no green in any phase", movements.replace(", from ", " from ")),
            }
        }
        Warning::NeverWhole { .. } => format!(
            "the movements of {} {lanes} never have green together, so that its first vehicle may keep those behind it from \
             using theirs",
            number("lane", "each of the lanes")
        ),
        Warning::NoVehicles { .. } => {
            let greens = named(|warning| match warning {
                Warning::NoVehicles { state } => Some(state.clone()),
                _ => None,
            });
            format!(
                "the {} {greens} {} no lane for cars, so {}: whoever {} for (pedestrians, or buses, trams and bicycles on lanes \
                 of their own) has {} only while the network's own program runs, and waits under every other method",
                number("green", "greens"),
                number("serves", "serve"),
                number("it is no phase to choose", "they are no phases to choose"),
                number("it is", "they are"),
                number("it", "them"),
            )
        }
        Warning::SameMovements { .. } => {
            let phases = named(|warning| match warning {
                Warning::SameMovements { first, second } => Some(format!("{first} and {second}")),
                _ => None,
            });
            format!(
                "phases {phases} count the same movements: max-pressure chooses the first {}, learners see no difference",
                number("of them", "of every two")
            )
        }
        Warning::NamedByAll => {
            "some phases have the same two main movements, so each counts all movements that it serves".to_owned()
        }
        Warning::Unreached { states } => format!(
            "the program never comes to {}, since no `next` leads there from the first phase; they are none to choose",
            states.join(", ")
        ),
        Warning::OnePhase => "there is one green only, so that no method decides anything: the network's own program runs \
                              under every method"
            .to_owned(),
        Warning::OtherProgram => {
            "the program is of a type that methods cannot install, such as NEMA or delay_based: they choose among its greens, \
             of NEMA among the pairs of phases that it may show"
                .to_owned()
        }
    }
}

/// Returns what may be wrong with a signal, in the order of lanes, movements and phases.
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
    let unserved = spec.unserved_lanes();
    warnings.extend(unserved.iter().map(|l| Warning::UnservedLane { lane: (*l).to_owned() }));
    for (m, movement) in spec.movements.iter().enumerate() {
        let lanes: Vec<String> =
            movement.lanes.iter().map(|lane| spec.lanes[*lane].id.clone()).collect();
        let served = spec.phases.iter().any(|p| p.service[m] != Light::Red);
        if !served && lanes.iter().any(|lane| !unserved.contains(&lane.as_str())) {
            warnings.push(Warning::UnservedMovement { movement: movement.index, lanes });
        }
    }
    for (lane, known) in spec.lanes.iter().enumerate() {
        let of_lane = |m: &usize| spec.movements[*m].lanes.contains(&lane);
        let ever = |m: &usize| spec.phases.iter().any(|p| p.service[*m] != Light::Red);
        let served: Vec<usize> = (0..spec.movements.len()).filter(of_lane).filter(ever).collect();
        let whole = |p: &Phase| served.iter().all(|m| p.service[*m] != Light::Red);
        if !spec.phases.iter().any(whole) {
            warnings.push(Warning::NeverWhole { lane: known.id.clone() });
        }
    }
    warnings.extend(signal.left_out.iter().map(|s| Warning::NoVehicles { state: s.clone() }));
    if !signal.unreached.is_empty() {
        warnings.push(Warning::Unreached { states: signal.unreached.clone() });
    }
    if spec.phases.len() == 1 {
        warnings.push(Warning::OnePhase);
    }
    if signal.own_kind == ProgramKind::Other {
        warnings.push(Warning::OtherProgram);
    }
    if signal.naming == Naming::AllServed {
        warnings.push(Warning::NamedByAll);
    }
    for (second, phase) in spec.phases.iter().enumerate() {
        if let Some(first) = spec.phases[..second].iter().position(|p| p.pair == phase.pair) {
            warnings.push(Warning::SameMovements { first, second });
        }
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::derive::derive;
    use crate::env::testing::crossing;
    use crate::settings::SignalSettings;

    fn texts(lanes: &[(&str, f64, &str)], greens: &[&str]) -> Vec<String> {
        let scene = crossing(lanes, greens);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        warnings(&derived).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_signal_without_fault_has_no_warning() {
        let lanes = [("n_0", 0.0, "s"), ("e_0", 90.0, "s")];
        assert_eq!(texts(&lanes, &["Gr", "rG"]), [""; 0]);
    }

    #[test]
    fn a_signal_with_one_green_has_nothing_to_decide() {
        let told = texts(&[("n_0", 0.0, "s"), ("s_0", 180.0, "s")], &["GG"]);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].starts_with("there is one green only"), "{told:?}");
    }

    #[test]
    fn every_fault_is_told_once() {
        let lanes = [("n_0", 0.0, "sl"), ("e_0", 90.0, "s"), ("w_0", 270.0, "r")];
        let mut scene = crossing(&lanes, &["Grrr", "rrGr", "rrGrG", "rrrrG"]);
        scene.signals[0].links.push(vec![]);
        scene.lanes[1].length_m = 8.93;
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        let found: Vec<String> = warnings(&derived).iter().map(ToString::to_string).collect();
        insta::assert_snapshot!(found.join("\n"), @r"
        lane e_0 is seen for 8.9 m only; upstream the network ends or a signal stands
        lane w_0 has no green in any phase
        movement 8, from n_0, has no green in any phase
        the green rrrrG serves no lane for cars, so it is no phase to choose: whoever it is for (pedestrians, or buses, trams and bicycles on lanes of their own) has it only while the network's own program runs, and waits under every other method
        ");
    }

    #[test]
    fn phases_between_which_nothing_that_is_counted_differs_are_told() {
        let told = texts(&[("n_0", 0.0, "s"), ("e_0", 90.0, "s")], &["Gr", "gr", "rG"]);
        assert!(told.len() == 1 && told[0].starts_with("phases 0 and 1 count"), "{told:?}");
    }

    #[test]
    fn warnings_of_one_kind_are_one_sentence() {
        let lane = |lane: &str, seen_m| Warning::ShortLane { lane: lane.into(), seen_m };
        let movement =
            |movement, lane: &str| Warning::UnservedMovement { movement, lanes: vec![lane.into()] };
        let told = folded(&[
            lane("a_0", 9.04),
            Warning::UnservedLane { lane: "c_0".into() },
            lane("b_0", 0.2),
            movement(8, "n_0"),
            movement(9, "e_0"),
            Warning::NeverWhole { lane: "a_0".into() },
            Warning::NeverWhole { lane: "b_0".into() },
            Warning::NoVehicles { state: "rG".into() },
            Warning::NoVehicles { state: "Gr".into() },
            Warning::SameMovements { first: 0, second: 1 },
            Warning::SameMovements { first: 2, second: 3 },
            Warning::OnePhase,
        ]);
        insta::assert_snapshot!(told.join("\n"));
        let once = folded(&[lane("a_0", 5.0)]);
        assert_eq!(once, [lane("a_0", 5.0).to_string()]);
    }

    #[test]
    fn signals_of_which_the_same_is_said_share_a_sentence() {
        let lane = |lane: &str| Warning::UnservedLane { lane: lane.into() };
        let alike = |second| Warning::SameMovements { first: 0, second };
        let told = of_signals(&[
            ("A", vec![lane("a_0"), Warning::OnePhase, alike(1)]),
            ("B", vec![Warning::OnePhase, lane("b_0"), alike(2)]),
            ("C", vec![alike(1)]),
        ]);
        insta::assert_snapshot!(told.join("\n"), @r"
        signals A, B: lanes a_0, b_0 have no green in any phase
        signals A, B: there is one green only, so that no method decides anything: the network's own program runs under every method
        signals A, C: phases 0 and 1 count the same movements: max-pressure chooses the first of them, learners see no difference
        signal B: phases 0 and 2 count the same movements: max-pressure chooses the first of them, learners see no difference
        ");
    }

    #[test]
    fn a_program_that_may_show_two_phases_at_once_is_told() {
        let mut scene = crossing(&[("n_0", 0.0, "s"), ("e_0", 90.0, "s")], &["Gr", "rG"]);
        scene.signals[0].programs[0].kind = ProgramKind::Other;
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        assert_eq!(warnings(&derived), [Warning::OtherProgram]);
    }

    #[test]
    fn a_lane_whose_movements_never_have_green_together_is_told() {
        let lanes = [("n_0", 0.0, "sl"), ("e_0", 90.0, "sl")];
        let told = texts(&lanes, &["Grrr", "rGrr", "rrGG"]);
        assert!(
            told.len() == 1 && told[0].starts_with("the movements of lane n_0 never"),
            "{told:?}"
        );
    }

    #[test]
    fn phases_to_which_the_program_never_comes_are_told_and_none_to_choose() {
        let mut scene =
            crossing(&[("n_0", 0.0, "s"), ("e_0", 90.0, "s")], &["Gr", "rG", "GG", "rg"]);
        for phase in &mut scene.signals[0].programs[0].phases {
            phase.is_reached = !["GG", "rg"].contains(&phase.state.as_str());
        }
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        let states: Vec<&str> = derived.spec.phases.iter().map(|p| p.state.as_str()).collect();
        assert_eq!(
            (states, &derived.own_greens[..]),
            (vec!["Gr", "rG"], &["Gr", "rG"].map(String::from)[..])
        );
        let told: Vec<String> = warnings(&derived).iter().map(ToString::to_string).collect();
        assert!(
            told.len() == 1 && told[0].starts_with("the program never comes to GG, rg"),
            "{told:?}"
        );
    }

    #[test]
    fn phases_that_differ_in_a_permissive_left_are_told() {
        let lanes = [("n_0", 0.0, "sl"), ("s_0", 180.0, "sl")];
        let found = texts(&lanes, &["GgGg", "GrGr"]);
        assert!(found.len() == 1 && found[0].contains("all movements that it serves"), "{found:?}");
    }
}
