//! Which subsets of a signal's green phases can make up a cycle.

use super::{Light, SignalSpec};

/// Most phases of a signal for which all subsets are looked at.
const MAX_PHASES: usize = 12;

/// Returns sets of phases that serve every movement, none larger than it must be.
///
/// First those in which some movements are served permissively only, then those that protect
/// every movement that can be protected; smaller sets first. With more than 12
/// phases there is one set: all of them.
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
    let served: Vec<u64> = signal
        .phases
        .iter()
        .map(|phase| {
            phase.service.iter().enumerate().fold(0, |bits, (m, service)| {
                let best = signal.phases.iter().map(|p| p.service[m]).max();
                let enough = best.map_or(wanted, |b| b.min(wanted)).max(Light::Permissive);
                bits | (u64::from(*service >= enough) << m)
            })
        })
        .collect();
    let all = served.iter().fold(0, |a, b| a | b);
    let covers = |set: u32| {
        served.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1).fold(0, |a, (_, b)| a | b)
            == all
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
        let signal = signal_with(&[[G, g, N, N], [N, G, N, N], [N, N, G, g], [N, N, N, G]]);
        assert_eq!(covering(&signal), vec![vec![0, 2], vec![0, 1, 2, 3]]);
    }

    #[test]
    fn a_movement_that_no_phase_protects_does_not_rule_out_protected_sets() {
        let signal = signal_with(&[[G, g, N, N], [N, N, G, G]]);
        assert_eq!(covering(&signal), vec![vec![0, 1]]);
    }
}
