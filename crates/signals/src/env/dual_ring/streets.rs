//! Which approaches are one street, from what the programs of a signal show.

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

use super::links::Links;

/// Least share of an approach's links that are green where it is served.
const SERVED: f64 = 0.5;

/// A street, or an approach alone.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Street {
    pub(super) approaches: Vec<usize>,
    /// Green of a program that serves it.
    pub(super) state: usize,
    /// Per approach, whether its left turns have a phase of their own.
    pub(super) lefts: Vec<bool>,
}

/// Returns the streets of a signal, the main one first; `None` where an approach has no green that serves it.
pub(super) fn streets(links: &Links) -> Option<Vec<Street>> {
    let approaches = links.headings.len();
    let mut pairs: Vec<(f64, Street)> = Vec::new();
    for a in 0..approaches {
        for b in a + 1..approaches {
            let turn = turn_degrees(links.headings[a], links.headings[b]).abs();
            pairs.extend(street(links, a, b).map(|street| ((180.0 - turn).abs().round(), street)));
        }
    }
    // The sort is stable: of pairs that are as opposite the first one.
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken = vec![false; approaches];
    let mut streets = Vec::new();
    for (_, street) in pairs {
        if street.approaches.iter().all(|a| !taken[*a]) {
            street.approaches.iter().for_each(|a| taken[*a] = true);
            streets.push(street);
        }
    }
    for approach in (0..approaches).filter(|a| !taken[*a]) {
        let state = best_state(links, &[approach])?;
        streets.push(Street { approaches: vec![approach], state, lefts: vec![false] });
    }
    let lanes = |street: &Street| {
        let cars = links.cars.iter().flatten();
        let own = cars.filter(|car| street.approaches.contains(&car.approach));
        let mut lanes: Vec<usize> = own.flat_map(|car| car.lanes.iter().copied()).collect();
        lanes.sort_unstable();
        lanes.dedup();
        lanes.len()
    };
    streets.sort_by_key(|s| (std::cmp::Reverse(lanes(s)), s.approaches[0]));
    Some(streets)
}

/// Returns the street that two approaches make, if they do.
fn street(links: &Links, a: usize, b: usize) -> Option<Street> {
    let state = best_state(links, &[a, b])?;
    let of = |approach: usize, left: bool| {
        let is = move |link: &usize| (links.turn(*link) == Some(Turn::Left)) == left;
        links.of_approach(approach).filter(is).collect::<Vec<usize>>()
    };
    let together =
        |x: &[usize], y: &[usize]| x.iter().all(|l| y.iter().all(|m| links.together(*l, *m)));
    if !together(&of(a, false), &of(b, false)) {
        return None;
    }
    let own = |approach: usize, opposing: usize| {
        let lefts = of(approach, true);
        let opposed = |l: &usize| {
            let meets = |m: &usize| links.yields(*l, *m) || !links.together(*l, *m);
            of(opposing, false).iter().any(meets)
        };
        let has_lane = |l: &usize| {
            let lanes = links.cars[*l].iter().flat_map(|car| &car.lanes);
            lanes.clone().all(|lane| links.is_lane_for(*lane, Turn::Left))
        };
        let has_arrow = |l: &usize| !links.arrows_only || !links.always_yields(*l);
        lefts.iter().any(opposed) && lefts.iter().any(has_lane) && lefts.iter().any(has_arrow)
    };
    let mut lefts = vec![own(a, b), own(b, a)];
    // Two left turns that are only ever permissive together may meet each other.
    let pair = of(a, true).iter().all(|l| of(b, true).iter().all(|m| links.free(*l, *m)));
    if lefts == [true, true] && !pair {
        lefts = vec![false, false];
    }
    // A left turn that is not green beside the opposing approach needs its own phase.
    let green = |link: &usize| is_green(&links.states[state], *link);
    let served = |approach: usize, own: bool| own || of(approach, true).iter().all(green);
    (served(a, lefts[0]) && served(b, lefts[1])).then(|| Street {
        approaches: vec![a, b],
        state,
        lefts,
    })
}

/// Returns the green of the programs that serves most of some approaches, and all of them.
fn best_state(links: &Links, approaches: &[usize]) -> Option<usize> {
    let served = |state: &str, approach: usize| {
        let ahead = |link: &usize| links.turn(*link) != Some(Turn::Right);
        let mut counted: Vec<usize> = links.of_approach(approach).filter(ahead).collect();
        if counted.is_empty() {
            counted = links.of_approach(approach).collect();
        }
        let green = counted.iter().filter(|l| is_green(state, **l)).count();
        green as f64 / counted.len() as f64
    };
    let greens = |state: &str| {
        let of = |a: &usize| links.of_approach(*a).filter(|l| is_green(state, *l)).count();
        approaches.iter().map(of).sum::<usize>()
    };
    let fit = |state: &String| approaches.iter().all(|a| served(state, *a) >= SERVED);
    let fitting = links.states.iter().enumerate().filter(|(_, state)| fit(state));
    // The first of the best.
    fitting.rev().max_by_key(|(_, state)| greens(state)).map(|(i, _)| i)
}

pub(super) fn is_green(state: &str, link: usize) -> bool {
    matches!(state.as_bytes().get(link), Some(b'G' | b'g'))
}
