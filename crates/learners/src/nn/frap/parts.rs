//! The parts of FRAP that both passes use: sizes, where parameters are, buffers.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::super::init::Init;
use super::layout::PhaseLayout;

/// Numbers of an embedding, and of a demand after its linear map.
pub(super) const EMBEDDING: usize = 4;
/// Numbers of a movement.
pub(super) const MOVEMENT: usize = 16;
/// Numbers of a pair of phases.
pub(super) const PAIR: usize = 20;

/// Numbers in front of the demand in an input row: the layout, then the current phase.
pub const HEAD: usize = 2;

/// Where the parameters of each part begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Offsets {
    pub(super) bit: usize,
    pub(super) demand: usize,
    pub(super) movement: usize,
    pub(super) pair: usize,
    pub(super) relation: usize,
    pub(super) relation_map: usize,
    pub(super) competition: usize,
    pub(super) value: usize,
    pub(super) end: usize,
}

/// Returns name, inputs and outputs of each part, in the order of the parameters; embeddings have no inputs.
pub(super) fn table(width: usize) -> [(&'static str, usize, usize); 8] {
    [
        ("phase-bit", 0, EMBEDDING),
        ("demand", width, EMBEDDING),
        ("movement", 2 * EMBEDDING, MOVEMENT),
        ("pair", 2 * MOVEMENT, PAIR),
        ("relation", 0, EMBEDDING),
        ("relation-map", EMBEDDING, PAIR),
        ("competition", PAIR, PAIR),
        ("value", PAIR, 1),
    ]
}

impl Offsets {
    fn new(width: usize) -> Self {
        let mut end = 0;
        let starts = table(width).map(|(_, inputs, outputs)| {
            let start = end;
            end += if inputs == 0 { 2 * outputs } else { (inputs + 1) * outputs };
            start
        });
        let [bit, demand, movement, pair, relation, relation_map, competition, value] = starts;
        Self { bit, demand, movement, pair, relation, relation_map, competition, value, end }
    }
}

/// Buffers of a pass.
#[derive(Debug, Clone, Default)]
pub(super) struct Buffers {
    /// Per row: its layout, and where its movements and phases begin.
    pub(super) rows: Vec<(usize, usize, usize)>,
    /// Per movement of every row: its phase bit.
    pub(super) bits: Vec<bool>,
    /// Per movement of every row: its demand, squashed; shape `[movements, 4]`.
    pub(super) demand: Vec<f32>,
    /// `h`, shape `[movements, 16]`.
    pub(super) movement: Vec<f32>,
    /// `P`, shape `[phases, 16]`.
    pub(super) phase: Vec<f32>,
    /// Both halves of the pair's convolution, shape `[phases, 20]`.
    pub(super) upper: Vec<f32>,
    pub(super) lower: Vec<f32>,
    /// `z`, then `z * r`, then what the competition makes of it, shape `[pairs, 20]`.
    pub(super) z: Vec<f32>,
    pub(super) zr: Vec<f32>,
    pub(super) y: Vec<f32>,
    pub(super) outputs: Vec<f32>,
    // The same for the backward pass, for the pairs that have a gradient.
    pub(super) active_zr: Vec<f32>,
    pub(super) dy: Vec<f32>,
    pub(super) dz: Vec<f32>,
    pub(super) dupper: Vec<f32>,
    pub(super) dlower: Vec<f32>,
    pub(super) dphase: Vec<f32>,
    pub(super) dmovement: Vec<f32>,
    /// A transposed matrix of weights.
    pub(super) turned: Vec<f32>,
}

/// The network; its inputs are rows of layout index, current phase and demand.
#[derive(Debug, Clone)]
pub struct Frap {
    pub(super) layouts: Vec<PhaseLayout>,
    /// Demand numbers per movement.
    pub(super) width: usize,
    pub(super) demand: usize,
    pub(super) actions: usize,
    pub(super) offsets: Offsets,
    pub(super) buffers: Buffers,
}

impl Frap {
    /// Returns the network for signals of these layouts.
    ///
    /// # Arguments
    ///
    /// * `width` — demand numbers that a movement reads.
    /// * `demand` — demand numbers per row.
    ///
    /// # Panics
    ///
    /// When a layout reads beyond `demand`.
    pub fn new(layouts: Vec<PhaseLayout>, width: usize, demand: usize) -> Self {
        assert!(layouts.iter().all(|l| l.demand(width) <= demand), "movements read beyond the row");
        let actions = layouts.iter().map(|l| l.phases.len()).max().unwrap_or(0);
        let offsets = Offsets::new(width);
        Self { layouts, width, demand, actions, offsets, buffers: Buffers::default() }
    }

    /// Returns parameters to start from: embeddings standard normal, the rest as `init` says.
    pub fn initial(&self, init: Init, rng: &mut ChaCha8Rng) -> Vec<f32> {
        let mut parameters = Vec::with_capacity(self.offsets.end);
        for (_, inputs, outputs) in table(self.width) {
            match inputs {
                0 => parameters
                    .extend((0..2 * outputs).map(|_| rng.sample::<f32, _>(StandardNormal))),
                _ => init.layer(inputs, outputs, rng, &mut parameters),
            }
        }
        parameters
    }
}

/// `y += scale x`.
#[inline(always)]
pub(super) fn add_scaled(y: &mut [f32], x: &[f32], scale: f32) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += scale * x;
    }
}
