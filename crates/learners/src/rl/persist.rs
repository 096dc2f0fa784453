//! What a learner leaves behind and goes on from, whatever its algorithm.

use crate::nn::state::{Learned, State};

/// A learner; its state is taken between two episodes, or between two updates.
pub trait Persist: State + Learned {
    /// Whether parameters and moments are numbers; where they are not, training has diverged.
    fn is_finite(&self) -> bool;

    /// Whether what was learned depends on state and action, as far as the states of the last decisions show it: a
    /// network whose units all give zero says the same everywhere, and no gradient brings it back. `true` where there
    /// are no states to ask about.
    fn is_alive(&mut self) -> bool;
}

/// States that are asked about to see whether a network is alive.
const PROBES: usize = 32;

/// Step between two of them, as a share of all states: the golden ratio meets no period, such as the length of an
/// episode, at whose beginnings all states are alike.
const STEP: f64 = 0.618_033_988_749_894_9;

/// Difference below which two outputs of a network count as the same, relative to the larger of them and 1.
const SAME: f32 = 1e-6;

/// Returns places from all over a buffer of so many states.
pub(crate) fn spread(len: usize) -> impl Iterator<Item = usize> {
    (0..PROBES.min(len)).map(move |i| ((i as f64 * STEP).fract() * len as f64) as usize)
}

/// Whether outputs, a row of `width` per state, differ between actions in some state and between states for some action;
/// infinities stand for actions that there are not.
pub(crate) fn depends_on_both(outputs: &[f32], width: usize) -> bool {
    let differs = |a: f32, b: f32| (a - b).abs() > SAME * a.abs().max(b.abs()).max(1.0);
    let rows = || outputs.chunks_exact(width);
    let finite = |row: &[f32]| row.iter().copied().filter(|v| v.is_finite()).collect::<Vec<_>>();
    let spreads = |values: &[f32]| values.iter().any(|v| differs(*v, values[0]));
    let actions = rows().any(|row| spreads(&finite(row)));
    let states = (0..width).any(|action| {
        let column: Vec<f32> = rows().map(|row| row[action]).filter(|v| v.is_finite()).collect();
        spreads(&column)
    });
    rows().len() < 2 || (actions && states)
}

/// Whether outputs, a row of `width` per state, differ between states in any of them.
pub(crate) fn depends_on_state(outputs: &[f32], width: usize) -> bool {
    let mut rows = outputs.chunks_exact(width);
    let Some(first) = rows.next() else { return true };
    let differs = |a: f32, b: f32| (a - b).abs() > SAME * a.abs().max(b.abs()).max(1.0);
    rows.len() == 0 || rows.any(|row| row.iter().zip(first).any(|(a, b)| differs(*a, *b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_within_the_buffer_and_at_different_times_of_episodes() {
        assert_eq!(spread(0).count(), 0);
        for len in [1, 5, 31, 960, 10_000] {
            assert!(spread(len).all(|place| place < len));
        }
        // Thirty-two episodes of thirty decisions.
        let times: std::collections::BTreeSet<usize> =
            spread(960).map(|place| place % 30).collect();
        assert!(times.len() > 10, "{times:?}");
    }

    #[test]
    fn an_action_that_is_the_same_in_all_states_is_no_policy() {
        assert!(depends_on_state(&[1.0, 2.0, 1.0, 2.1], 2));
        assert!(!depends_on_state(&[1.0, 2.0, 1.0, 2.0], 2));
        assert!(depends_on_state(&[1.0, 2.0], 2) && depends_on_state(&[], 2));
    }

    #[test]
    fn a_network_is_alive_when_its_outputs_depend_on_state_and_action() {
        let alive = |outputs: &[f32]| depends_on_both(outputs, 2);
        assert!(alive(&[1.0, 2.0, 1.5, 2.0]));
        assert!(!alive(&[1.0, 2.0, 1.0, 2.0]), "the same in all states");
        assert!(!alive(&[1.0, 1.0, 3.0, 3.0]), "the same for all actions");
        assert!(!alive(&[-900.0, -900.0001, -900.0, -900.0001]), "rounding is no difference");
        let absent = f32::NEG_INFINITY;
        assert!(
            !alive(&[1.0, absent, 1.0, absent]),
            "an action that there is not is no difference"
        );
        assert!(alive(&[1.0, 2.0]), "one state shows nothing");
    }
}
