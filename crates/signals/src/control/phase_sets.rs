//! Which subsets of a signal's green phases can make up a cycle.

use osm_signals::Turn;

use super::{Light, SignalSpec};

/// Most phases of a signal for which all subsets are looked at.
const MAX_PHASES: usize = 12;

/// Returns sets of phases that serve every movement, none larger than it must be.
///
/// First those in which some movements are served permissively only, then those that protect
/// every movement that can be protected; smaller sets first. Where [`Limits`](super::Limits) ask for arrows, all sets
/// protect left turns. With more than 12 phases there is one set: all of them.
pub fn covering(signal: &SignalSpec) -> Vec<Vec<usize>> {
    let count = signal.phases.len();
    if count > MAX_PHASES {
        return vec![(0..count).collect()];
    }
    let mut sets = minimal(signal, Light::Permissive);
    for set in minimal(signal, Light::Protected) {
        if !sets.contains(&set) {
            sets.push(set);
        }
    }
    sets
}

/// Returns the sets that serve every movement at least as well as `wanted`, or as well as any
/// phase does, and from which no phase can be left out.
fn minimal(signal: &SignalSpec, wanted: Light) -> Vec<Vec<usize>> {
    // By phase and movement.
    let served: Vec<Vec<bool>> = signal
        .phases
        .iter()
        .map(|phase| {
            let enough = |(m, service): (usize, &Light)| {
                let needs_arrow = signal.limits.arrows && signal.movements[m].turn == Turn::Left;
                let wanted = if needs_arrow { Light::Protected } else { wanted };
                let best = signal.phases.iter().map(|p| p.service[m]).max();
                *service >= best.map_or(wanted, |b| b.min(wanted)).max(Light::Permissive)
            };
            phase.service.iter().enumerate().map(enough).collect()
        })
        .collect();
    let ever = |m: &usize| served.iter().any(|phase| phase[*m]);
    let all: Vec<usize> = (0..signal.movements.len()).filter(ever).collect();
    let covers = |set: u32| {
        let serves = |m: &usize| (0..served.len()).any(|i| set >> i & 1 == 1 && served[i][*m]);
        all.iter().all(serves)
    };
    let mut sets: Vec<u32> = (1..1u32 << served.len())
        .filter(|set| covers(*set))
        .filter(|set| (0..served.len()).all(|i| set >> i & 1 == 0 || !covers(set & !(1 << i))))
        .collect();
    sets.sort_by_key(|set| (set.count_ones(), *set));
    sets.into_iter().map(|set| (0..served.len()).filter(|i| set >> i & 1 == 1).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::signal_with;
    use super::*;

    use Light::{Permissive as g, Protected as G, Red as N};

    #[test]
    fn permissive_lefts_make_a_cycle_of_two_phases_and_protected_lefts_one_of_four() {
        // Movements: through NS, left NS, through EW, left EW.
        let mut signal = signal_with(&[[G, g, N, N], [N, G, N, N], [N, N, G, g], [N, N, N, G]]);
        assert_eq!(covering(&signal), vec![vec![0, 2], vec![0, 1, 2, 3]]);
        for left in [1, 3] {
            signal.movements[left].turn = Turn::Left;
        }
        signal.limits.arrows = true;
        assert_eq!(covering(&signal), vec![vec![0, 1, 2, 3]], "arrows are shown");
    }

    #[test]
    fn many_movements_are_told_apart() {
        let (mut first, mut last) = ([G; 65], [N; 65]);
        (first[64], last[64]) = (N, G);
        assert_eq!(covering(&signal_with(&[first, last])), vec![vec![0, 1]]);
    }

    #[test]
    fn a_movement_that_no_phase_protects_does_not_rule_out_protected_sets() {
        let signal = signal_with(&[[G, g, N, N], [N, N, G, G]]);
        assert_eq!(covering(&signal), vec![vec![0, 1]]);
    }
}
