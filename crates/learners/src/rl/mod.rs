//! Reinforcement learning algorithms, general over network and environment.
//!
//! They see vectors of numbers, numbered actions and rewards; what these mean is the caller's.

pub mod dqn;
pub mod environment;
pub mod normalise;
pub mod persist;
pub mod ppo;
pub mod random;
pub mod replay;
pub mod sb3;
pub mod schedule;

use crate::nn::adam::Adam;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::{Learned, State, kept};
use crate::nn::{self, Network};

/// States that are asked about to see whether a network is alive.
const PROBES: usize = 32;

/// Step between two of them, as a share of all states: the golden ratio meets no period, such as the length of an
/// episode, at whose beginnings all states are alike.
const STEP: f64 = 0.618_033_988_749_894_9;

/// Difference below which two outputs of a network count as the same, relative to the larger of them and 1.
const SAME: f32 = 1e-6;

fn largest(values: &[f32]) -> usize {
    (1..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}

fn huber(error: f32) -> f32 {
    let size = error.abs();
    if size <= 1.0 { 0.5 * error * error } else { size - 0.5 }
}

#[derive(Debug, Clone, Copy, Default)]
struct Losses {
    loss: f64,
    entropy: f64,
    count: u32,
}

impl Losses {
    fn add(&mut self, loss: f64, entropy: f64) {
        self.loss += loss;
        self.entropy += entropy;
        self.count += 1;
    }

    /// Begins anew; nothing of nothing.
    fn take(&mut self) -> (Option<f64>, Option<f64>) {
        let Self { loss, entropy, count } = std::mem::take(self);
        let mean = |sum: f64| (count > 0).then(|| sum / f64::from(count));
        (mean(loss), mean(entropy))
    }
}

#[derive(Debug, Clone)]
struct Followed<N> {
    network: N,
    parameters: Vec<f32>,
    target: Vec<f32>,
    gradient: Vec<f32>,
    adam: Adam,
}

impl<N: Network> Followed<N> {
    fn new(network: N, parameters: Vec<f32>, rate: f32, adam_epsilon: f32) -> Self {
        Self {
            network,
            target: parameters.clone(),
            gradient: vec![0.0; parameters.len()],
            adam: Adam::new(parameters.len(), rate, adam_epsilon),
            parameters,
        }
    }

    /// One step of Adam against the gradient by the outputs of the last forward pass of these inputs, cut to a norm.
    fn descend(&mut self, inputs: &[f32], by_outputs: &[f32], max_norm: Option<f32>) {
        self.network.backward(&self.parameters, inputs, by_outputs, &mut self.gradient);
        self.adam.step(&mut self.parameters, &self.gradient, max_norm);
    }

    fn forward(&mut self, inputs: &[f32]) -> &[f32] {
        self.network.forward(&self.parameters, inputs)
    }

    fn values(&mut self, inputs: &[f32]) -> &[f32] {
        self.network.single(&self.parameters, inputs)
    }

    fn follow(&mut self, tau: f32) {
        let both = self.target.iter_mut().zip(&self.parameters);
        both.for_each(|(t, p)| *t = tau.mul_add(*p - *t, *t));
    }

    fn is_finite(&self) -> bool {
        self.parameters.iter().all(|p| p.is_finite()) && self.adam.is_finite()
    }
}

impl<N: Network> Learned for Followed<N> {
    fn learned(&self, prefix: &str, archive: &mut Archive) {
        nn::save(&self.network, &self.parameters, prefix, archive);
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        self.parameters = nn::load(&self.network, prefix, archive)?;
        self.target.copy_from_slice(&self.parameters);
        Ok(())
    }
}

impl<N> State for Followed<N> {
    kept! { State { "parameters": parameters, "target": target, "": adam } }
}

fn spread(len: usize) -> impl Iterator<Item = usize> {
    (0..PROBES.min(len)).map(move |i| ((i as f64 * STEP).fract() * len as f64) as usize)
}

/// Whether outputs, a row of `width` per state, differ between actions and between states; infinities are absent actions.
fn depends_on_both(outputs: &[f32], width: usize) -> bool {
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

/// Whether outputs, a row of `width` per state, differ between states.
fn depends_on_state(outputs: &[f32], width: usize) -> bool {
    let mut rows = outputs.chunks_exact(width);
    let Some(first) = rows.next() else { return true };
    let differs = |a: f32, b: f32| (a - b).abs() > SAME * a.abs().max(b.abs()).max(1.0);
    rows.len() == 0 || rows.any(|row| row.iter().zip(first).any(|(a, b)| differs(*a, *b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_largest_numbers_is_taken() {
        assert_eq!(
            (largest(&[1.0, 3.0, 3.0]), largest(&[2.0]), largest(&[f32::NAN, 1.0])),
            (1, 0, 0)
        );
    }

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
