//! FRAP, the network of MPLight: values of phases from the demand of their movements, by comparing
//! phases in pairs.
//!
//! Its parameters depend neither on the number of movements nor on that of phases, so one network
//! serves signals of different layout. For a movement `m` with phase bit `b` and demand `d`:
//!
//! ```text
//! h_m  = relu(Linear[8 -> 16](sigmoid(Embedding[2 -> 4](b)), sigmoid(Linear[k -> 4](d))))
//! P_a  = sum of h over the movements that phase a is named by, mostly two
//! z_ab = relu(Conv[32 -> 20](P_a, P_b))           for every ordered pair of phases a != b
//! r_ab = relu(Conv[4 -> 20](relu(Embedding[2 -> 4](whether a and b share some, not all movements))))
//! Q_a  = sum over b of Conv[20 -> 1](relu(Conv[20 -> 20](z_ab * r_ab)))
//! ```
//!
//! A convolution over pairs is a product with one matrix: `z_ab` takes `P_a` through its upper and
//! `P_b` through its lower half, so both halves are computed once per phase, not once per pair. The
//! backward pass visits only phases whose value has a gradient, for Q-learning one per row.
//!
//! Source: Zheng et al., "Learning phase competition for traffic signal control" (CIKM 2019); Chen et
//! al., "Toward a thousand lights" (AAAI 2020); sizes, sigmoids and embeddings as in RESCO,
//! agents/mplight.py.
//!
//! Deviation: a phase may be named by any number of movements; RESCO's always have two, of which two
//! phases share none or exactly one.

mod backward;
mod forward;
mod layout;
mod parts;

pub use layout::PhaseLayout;
pub use parts::{Frap, HEAD};

use super::{Network, Part, linear_parts};
use parts::table;

impl Network for Frap {
    fn inputs(&self) -> usize {
        HEAD + self.demand
    }

    /// The largest number of phases of a layout; phases that a layout does not have are worth
    /// negative infinity.
    fn outputs(&self) -> usize {
        self.actions
    }

    fn parameters(&self) -> usize {
        self.offsets.end
    }

    fn parts(&self) -> Vec<Part> {
        let mut start = 0;
        let part = |(name, inputs, outputs)| {
            let offset = start;
            start += if inputs == 0 { 2 * outputs } else { (inputs + 1) * outputs };
            match inputs {
                0 => vec![Part {
                    name: String::from(name),
                    shape: vec![2, outputs],
                    range: offset..start,
                }],
                _ => linear_parts(name, offset, inputs, outputs).into(),
            }
        };
        table(self.width).into_iter().flat_map(part).collect()
    }

    fn forward(&mut self, parameters: &[f32], inputs: &[f32]) -> &[f32] {
        self.movements_and_phases(parameters, inputs);
        self.compete(parameters);
        self.values(parameters)
    }

    fn single(&mut self, parameters: &[f32], inputs: &[f32]) -> &[f32] {
        self.forward(parameters, inputs)
    }

    fn backward(
        &mut self,
        parameters: &[f32],
        inputs: &[f32],
        output_gradient: &[f32],
        gradient: &mut [f32],
    ) {
        self.differentiate(parameters, inputs, output_gradient, gradient);
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::init::Init;
    use super::super::kernel::sigmoid;
    use super::super::testing::{check_gradient, check_parts};
    use super::*;

    /// RESCO's eight phases of a full intersection.
    const EIGHT: [[usize; 2]; 8] =
        [[1, 7], [2, 8], [1, 2], [7, 8], [4, 10], [5, 11], [10, 11], [4, 5]];

    fn pairs(pairs: &[[usize; 2]]) -> Vec<Vec<usize>> {
        pairs.iter().map(|p| p.to_vec()).collect()
    }

    fn random(count: usize, seed: u64) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
    }

    fn parameters(network: &Frap) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        network.initial(Init::Uniform, &mut rng)
    }

    fn row(layout: usize, phase: usize, demand: &[f32]) -> Vec<f32> {
        [&[layout as f32, phase as f32], demand].concat()
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        for width in [1, 4] {
            let three = vec![vec![1, 7], vec![0, 7, 8, 10], vec![9]];
            let layouts =
                vec![PhaseLayout::new(&pairs(&EIGHT), width), PhaseLayout::new(&three, width)];
            let mut network = Frap::new(layouts, width, 12 * width);
            assert_eq!(parameters(&network).len(), network.parameters());
            let parameters = random(network.parameters(), 21);
            check_parts(&network);
            let mut inputs = Vec::new();
            for (i, (layout, phase)) in [(0, 0), (1, 2), (0, 7), (1, 0)].into_iter().enumerate() {
                inputs.extend(row(layout, phase, &random(12 * width, i as u64)));
            }
            let mut direction = random(4 * 8, 9);
            for r in [1, 3] {
                direction[r * 8 + 3..(r + 1) * 8].fill(0.0);
            }
            check_gradient(&mut network, &parameters, &inputs, &direction);
            // As in Q-learning: one phase per row.
            let mut one = vec![0.0; 4 * 8];
            for (r, a) in [3, 1, 0, 2].into_iter().enumerate() {
                one[r * 8 + a] = 1.0 - r as f32;
            }
            check_gradient(&mut network, &parameters, &inputs, &one);
        }
    }

    #[test]
    fn values_are_those_of_the_definition() {
        // Straight from the formulas of RESCO's network, without any of the shortcuts above.
        let mut network = Frap::new(vec![PhaseLayout::new(&pairs(&EIGHT), 1)], 1, 12);
        let p = parameters(&network);
        let demand = random(12, 3).iter().map(|d| d * 8.0).collect::<Vec<_>>();
        let found = network.forward(&p, &row(0, 2, &demand)).to_vec();
        let o = network.offsets;
        let layer = |start: usize, x: &[f32], outputs: usize| -> Vec<f32> {
            (0..outputs)
                .map(|j| {
                    let weight = |i: usize| p[start + i * outputs + j];
                    let sum: f32 = x.iter().enumerate().map(|(i, x)| x * weight(i)).sum();
                    sum + p[start + x.len() * outputs + j]
                })
                .collect()
        };
        let relu = |x: Vec<f32>| -> Vec<f32> { x.into_iter().map(|x| x.max(0.0)).collect() };
        let movement = |m: usize| {
            let bit = usize::from(EIGHT[2].contains(&m));
            let mut x: Vec<f32> = (0..4).map(|i| sigmoid(p[o.bit + 4 * bit + i])).collect();
            x.extend(layer(o.demand, &[demand[m]], 4).into_iter().map(sigmoid));
            relu(layer(o.movement, &x, 16))
        };
        let phase = |a: usize| -> Vec<f32> {
            let (i, j) = (movement(EIGHT[a][0]), movement(EIGHT[a][1]));
            i.iter().zip(&j).map(|(x, y)| x + y).collect()
        };
        for a in 0..8 {
            let mut q = 0.0;
            for b in (0..8).filter(|b| *b != a) {
                let both = [phase(a), phase(b)].concat();
                let z = relu(layer(o.pair, &both, 20));
                let shared = EIGHT[a].iter().filter(|m| EIGHT[b].contains(m)).count();
                let e = &p[o.relation + 4 * usize::from(shared == 1)..][..4];
                let r = relu(layer(o.relation_map, &relu(e.to_vec()), 20));
                let zr: Vec<f32> = z.iter().zip(&r).map(|(z, r)| z * r).collect();
                q += layer(o.value, &relu(layer(o.competition, &zr, 20)), 1)[0];
            }
            assert!((q - found[a]).abs() < 1e-4, "{a}: {q} {}", found[a]);
        }
    }

    #[test]
    fn phases_that_a_signal_does_not_have_are_never_the_best() {
        let two = vec![vec![1, 7], vec![4, 10]];
        let mut network =
            Frap::new(vec![PhaseLayout::new(&pairs(&EIGHT), 1), PhaseLayout::new(&two, 1)], 1, 12);
        let parameters = parameters(&network);
        let q = network.forward(&parameters, &row(1, 0, &[0.0; 12]));
        assert!(q[..2].iter().all(|q| q.is_finite()));
        assert_eq!(q[2..], [f32::NEG_INFINITY; 6]);
    }
}
