//! By which movements a signal's phases are named, which is what counts for their pressure.
//!
//! A phase is named by the one or two main movements that it serves with right of way, as RESCO's are.
//! Two greens may have the same two although they do not serve the same, for example when they differ
//! in a permissive left turn only. Then max pressure would never choose the second, and FRAP could
//! not tell them apart; and where a phase serves more than two approaches, such as at a signal of two junctions, one
//! may be named by no phase, so that nothing would ever ask for its green. **Where two movements do not tell the phases
//! apart, all are named by all movements that they serve; an approach that no phase names is added to those that
//! serve it**, with the movements that do not have green in every phase anyway.

use std::collections::BTreeSet;

use osm_signals::Turn;

use super::movements::RawMovement;
use crate::vocabulary::Light;

/// By which movements the phases of a signal are named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Naming {
    /// By one or two main movements.
    Main,
    /// By all that a phase serves, because some phases have the same main movements.
    AllServed,
    /// By main movements and those of approaches that these leave out.
    Extended,
}

/// Returns the names of all phases, as indices into `movements`, ascending.
///
/// # Arguments
///
/// * `services` — shape `[phases, movements]`.
pub(super) fn names(
    services: &[Vec<Light>],
    movements: &[RawMovement],
) -> (Naming, Vec<Vec<usize>>) {
    let all: Vec<_> = services.iter().map(|service| served(service)).collect();
    let main: Vec<_> = services.iter().map(|service| pair(service, movements)).collect();
    let approach = |m: &usize| movements[*m].approach;
    let named: BTreeSet<usize> = main.iter().flatten().map(approach).collect();
    let everywhere = |m: &usize| all.iter().all(|served| served.contains(m));
    let left_out = |m: &usize| !named.contains(&approach(m)) && !everywhere(m);
    let extended = main.iter().zip(&all).map(|(pair, served)| {
        let more = served.iter().copied().filter(left_out);
        let mut names: Vec<usize> = pair.iter().copied().chain(more).collect();
        names.sort_unstable();
        names
    });
    let extended: Vec<Vec<usize>> = extended.collect();
    let ambiguous = |a: usize, b: usize| extended[a] == extended[b] && all[a] != all[b];
    if (0..main.len()).any(|b| (0..b).any(|a| ambiguous(a, b))) {
        (Naming::AllServed, all)
    } else if extended == main {
        (Naming::Main, main)
    } else {
        (Naming::Extended, extended)
    }
}

fn served(service: &[Light]) -> Vec<usize> {
    (0..service.len()).filter(|m| service[*m] != Light::Red).collect()
}

/// Returns the one or two movements that a phase is named by: those with right of way, through
/// before left; a right turn only where there is nothing else, from the same approach if possible.
fn pair(service: &[Light], movements: &[RawMovement]) -> Vec<usize> {
    let rank = |m: &usize, first: Option<usize>| {
        let movement = &movements[*m];
        let same = first.is_none_or(|f| movements[f].approach == movement.approach);
        (
            movement.turn == Turn::Right,
            service[*m] != Light::Protected,
            movement.turn == Turn::Right && !same,
            movement.turn == Turn::Left,
            movement.index,
        )
    };
    let served = served(service);
    let Some(first) = served.iter().copied().min_by_key(|m| rank(m, None)) else {
        return Vec::new();
    };
    // A second movement counts if it has right of way, or belongs to the first one's approach.
    let second = served
        .into_iter()
        .filter(|m| *m != first)
        .filter(|m| {
            service[*m] == Light::Protected || movements[*m].approach == movements[first].approach
        })
        .min_by_key(|m| rank(m, Some(first)));
    let mut pair: Vec<usize> = std::iter::once(first).chain(second).collect();
    pair.sort_unstable();
    pair
}

#[cfg(test)]
mod tests {
    use super::super::derive::derive;
    use super::*;
    use crate::env::testing::crossing;
    use crate::settings::SignalSettings;

    /// The numbers of the movements that each phase is named by.
    fn named(lanes: &[(&str, f64, &str)], greens: &[&str]) -> (Naming, Vec<Vec<usize>>) {
        let scene = crossing(lanes, greens);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        let index = |m: &usize| derived.spec.movements[*m].index;
        let phases = &derived.spec.phases;
        (derived.naming, phases.iter().map(|p| p.pair.iter().map(index).collect()).collect())
    }

    const LANES: [(&str, f64, &str); 4] =
        [("n_0", 0.0, "s"), ("n_1", 0.0, "l"), ("s_0", 180.0, "s"), ("s_1", 180.0, "l")];

    #[test]
    fn greens_that_differ_in_permissive_lefts_only_are_named_by_all_that_they_serve() {
        let found = named(&LANES, &["GgGg", "GrGr", "rGrG"]);
        assert_eq!(found, (Naming::AllServed, vec![vec![1, 2, 7, 8], vec![1, 7], vec![2, 8]]));
    }

    #[test]
    fn greens_that_two_movements_tell_apart_are_named_by_them() {
        let found = named(&LANES, &["GgGg", "rGrG", "GGrr"]);
        assert_eq!(found, (Naming::Main, vec![vec![1, 7], vec![2, 8], vec![7, 8]]));
    }

    #[test]
    fn an_approach_that_no_phase_names_is_added_to_those_that_serve_it() {
        // West and east turn, of which two movements of one approach come first.
        let lanes =
            [("n_0", 0.0, "s"), ("s_0", 180.0, "s"), ("w_0", 90.0, "rl"), ("e_0", 270.0, "rl")];
        let found = named(&lanes, &["GGrrrr", "rrGgGg"]);
        assert_eq!(found, (Naming::Extended, vec![vec![1, 7], vec![3, 5, 9, 11]]));
    }

    #[test]
    fn an_approach_is_added_without_what_always_has_green() {
        let lanes = [("n_0", 0.0, "rl"), ("e_0", 90.0, "rl"), ("w_0", 270.0, "r")];
        assert_eq!(named(&lanes, &["GGrrG", "rrGGG"]).0, Naming::Main);
        let found = named(&lanes, &["GGrrr", "GrGGG"]);
        assert_eq!(found, (Naming::Extended, vec![vec![6, 8], vec![3, 9, 11]]));
    }
}
