//! FRAP, the network of MPLight: values of phases from the demand of their movements, by comparing phases in pairs.
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
//! Source: Zheng et al., "Learning phase competition for traffic signal control" (CIKM 2019); Chen et al., "Toward a
//! thousand lights" (AAAI 2020); sizes, sigmoids and embeddings as in RESCO, agents/mplight.py.
//!
//! Deviation: a phase may be named by any number of movements; RESCO's always have two, of which two
//! phases share none or exactly one.

use pulp::Arch;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::init::Init;
use super::kernel::{
    Activation, add_bias_gradient, add_weight_gradient, affine, input_gradient, product, relu,
    sigmoid,
};
use super::{Network, Part, linear_parts, room};

/// Numbers of an embedding, and of a demand after its linear map.
const EMBEDDING: usize = 4;

const MOVEMENT: usize = 16;

const PAIR: usize = 20;

/// Numbers in front of the demand in an input row: the layout, then the current phase.
pub const HEAD: usize = 2;

/// What FRAP needs to know of a signal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhaseLayout {
    /// First demand number per movement that some phase is named by.
    windows: Vec<usize>,
    /// Per phase the movements that it is named by, as indices into `windows`.
    phases: Vec<Vec<usize>>,
    /// Per ordered pair of phases: the other phase, and whether they share some but not all movements.
    rivals: Vec<Vec<(usize, bool)>>,
}

impl PhaseLayout {
    /// Returns the layout of a signal.
    /// * `pairs` — per phase the movements that it is named by, mostly two, by any numbering.
    /// * `stride` — distance between the demand of consecutive movements, in numbers.
    pub fn new(pairs: &[Vec<usize>], stride: usize) -> Self {
        let mut movements: Vec<usize> = pairs.iter().flatten().copied().collect();
        movements.sort_unstable();
        movements.dedup();
        let position = |m: &usize| movements.partition_point(|other| other < m);
        let phases = pairs.iter().map(|pair| pair.iter().map(position).collect()).collect();
        let shared = |a: usize, b: usize| {
            let both = pairs[a].iter().filter(|m| pairs[b].contains(m)).count();
            both > 0 && (both < pairs[a].len() || both < pairs[b].len())
        };
        let others =
            |a: usize| (0..pairs.len()).filter(|b| *b != a).map(|b| (b, shared(a, b))).collect();
        Self {
            rivals: (0..pairs.len()).map(others).collect(),
            windows: movements.iter().map(|m| m * stride).collect(),
            phases,
        }
    }

    fn demand(&self, width: usize) -> usize {
        self.windows.iter().max().map_or(0, |w| w + width)
    }
    fn pairs(&self) -> usize {
        self.rivals.iter().map(Vec::len).sum()
    }
}

/// Where the parameters of each part begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Offsets {
    bit: usize,
    demand: usize,
    movement: usize,
    pair: usize,
    relation: usize,
    relation_map: usize,
    competition: usize,
    value: usize,
    end: usize,
}

/// Returns name, inputs and outputs of each part, in the order of the parameters; embeddings have no inputs.
fn table(width: usize) -> [(&'static str, usize, usize); 8] {
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

#[derive(Debug, Clone, Default)]
struct Buffers {
    /// Per row: its layout, and where its movements and phases begin.
    rows: Vec<(usize, usize, usize)>,
    /// Per movement of every row: its phase bit.
    bits: Vec<bool>,
    demand: Vec<f32>,
    movement: Vec<f32>,
    phase: Vec<f32>,
    /// Both halves of the pair's convolution, shape `[phases, 20]`.
    upper: Vec<f32>,
    lower: Vec<f32>,
    /// `z`, then `z * r`, then what the competition makes of it, shape `[pairs, 20]`.
    z: Vec<f32>,
    zr: Vec<f32>,
    y: Vec<f32>,
    outputs: Vec<f32>,
    // The same for the backward pass, for the pairs that have a gradient.
    active_zr: Vec<f32>,
    dy: Vec<f32>,
    dz: Vec<f32>,
    dupper: Vec<f32>,
    dlower: Vec<f32>,
    dphase: Vec<f32>,
    dmovement: Vec<f32>,
    turned: Vec<f32>,
}

/// The network; its inputs are rows of layout index, current phase and demand.
#[derive(Debug, Clone)]
pub struct Frap {
    layouts: Vec<PhaseLayout>,
    /// Demand numbers per movement.
    width: usize,
    demand: usize,
    actions: usize,
    offsets: Offsets,
    buffers: Buffers,
}

impl Frap {
    /// Returns the network for signals of these layouts, of whose `demand` numbers per row a movement reads `width`;
    /// panics when a layout reads beyond `demand`.
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
fn add_scaled(y: &mut [f32], x: &[f32], scale: f32) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += scale * x;
    }
}

impl Network for Frap {
    fn inputs(&self) -> usize {
        HEAD + self.demand
    }

    /// The largest number of phases of a layout; phases that a layout does not have are worth negative infinity.
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
        gradient.fill(0.0);
        let active = self.value(parameters, output_gradient, gradient);
        if active > 0 {
            self.competition(parameters, output_gradient, gradient, active);
            self.pairs(parameters, gradient);
            self.movements(parameters, inputs, gradient);
        }
    }
}

impl Frap {
    /// What the phase bit adds to a movement before its ReLU, for both bits, and the squashed embeddings themselves.
    fn bit_terms(&self, parameters: &[f32]) -> ([[f32; MOVEMENT]; 2], [[f32; EMBEDDING]; 2]) {
        let o = &self.offsets;
        let (w, bias) = parameters[o.movement..o.pair].split_at(2 * EMBEDDING * MOVEMENT);
        let mut terms = [[0.0; MOVEMENT]; 2];
        let mut embeddings = [[0.0; EMBEDDING]; 2];
        for bit in 0..2 {
            terms[bit].copy_from_slice(bias);
            for i in 0..EMBEDDING {
                let e = sigmoid(parameters[o.bit + bit * EMBEDDING + i]);
                embeddings[bit][i] = e;
                add_scaled(&mut terms[bit], &w[i * MOVEMENT..][..MOVEMENT], e);
            }
        }
        (terms, embeddings)
    }

    /// Returns `r` for pairs that share no movement or all, and for those that share some.
    fn relations(&self, parameters: &[f32]) -> [[f32; PAIR]; 2] {
        let o = &self.offsets;
        let (w, bias) = parameters[o.relation_map..o.competition].split_at(EMBEDDING * PAIR);
        let mut relations = [[0.0; PAIR]; 2];
        for (shared, relation) in relations.iter_mut().enumerate() {
            relation.copy_from_slice(bias);
            for i in 0..EMBEDDING {
                let e = relu(parameters[o.relation + shared * EMBEDDING + i]);
                add_scaled(relation, &w[i * PAIR..][..PAIR], e);
            }
            relation.iter_mut().for_each(|r| *r = relu(*r));
        }
        relations
    }

    /// Fills `demand`, `movement` and `phase` for all rows.
    fn movements_and_phases(&mut self, parameters: &[f32], inputs: &[f32]) {
        let (terms, _) = self.bit_terms(parameters);
        let o = self.offsets;
        let (dw, dbias) = parameters[o.demand..o.movement].split_at(self.width * EMBEDDING);
        let w = &parameters[o.movement + EMBEDDING * MOVEMENT..][..EMBEDDING * MOVEMENT];
        let b = &mut self.buffers;
        b.rows.clear();
        b.bits.clear();
        let (mut movements, mut phases) = (0, 0);
        for row in inputs.chunks_exact(HEAD + self.demand) {
            let index = row[0] as usize;
            let layout = &self.layouts[index];
            b.rows.push((index, movements, phases));
            let current = layout.phases.get(row[1] as usize);
            let bit = |m: usize| current.is_some_and(|phase| phase.contains(&m));
            b.bits.extend((0..layout.windows.len()).map(bit));
            movements += layout.windows.len();
            phases += layout.phases.len();
        }
        let demand = room(&mut b.demand, movements * EMBEDDING);
        let movement = room(&mut b.movement, movements * MOVEMENT);
        let phase = room(&mut b.phase, phases * MOVEMENT);
        for (row, (index, first, first_phase)) in
            inputs.chunks_exact(HEAD + self.demand).zip(&b.rows)
        {
            let layout = &self.layouts[*index];
            for (m, window) in layout.windows.iter().enumerate() {
                let m = first + m;
                let d = &mut demand[m * EMBEDDING..][..EMBEDDING];
                d.copy_from_slice(dbias);
                for (i, x) in row[HEAD + window..][..self.width].iter().enumerate() {
                    add_scaled(d, &dw[i * EMBEDDING..][..EMBEDDING], *x);
                }
                let h = &mut movement[m * MOVEMENT..][..MOVEMENT];
                h.copy_from_slice(&terms[usize::from(b.bits[m])]);
                for (i, d) in d.iter_mut().enumerate() {
                    *d = sigmoid(*d);
                    add_scaled(h, &w[i * MOVEMENT..][..MOVEMENT], *d);
                }
                h.iter_mut().for_each(|h| *h = relu(*h));
            }
            for (a, pair) in layout.phases.iter().enumerate() {
                let p = &mut phase[(first_phase + a) * MOVEMENT..][..MOVEMENT];
                p.fill(0.0);
                for m in pair {
                    add_scaled(p, &movement[(first + m) * MOVEMENT..][..MOVEMENT], 1.0);
                }
            }
        }
    }

    /// Fills `z`, `zr` and `y` for all pairs.
    fn compete(&mut self, parameters: &[f32]) {
        let relations = self.relations(parameters);
        let o = self.offsets;
        let b = &mut self.buffers;
        let phases: usize = b.rows.iter().map(|r| self.layouts[r.0].phases.len()).sum();
        let pairs: usize = b.rows.iter().map(|r| self.layouts[r.0].pairs()).sum();

        let (w, bias) = parameters[o.pair..o.relation].split_at(2 * MOVEMENT * PAIR);
        let (upper_w, lower_w) = w.split_at(MOVEMENT * PAIR);
        let phase = &b.phase[..phases * MOVEMENT];
        let upper = room(&mut b.upper, phases * PAIR);
        affine(phase, upper_w, bias, upper);
        let lower = room(&mut b.lower, phases * PAIR);
        product(phase, lower_w, PAIR, lower);

        let z = room(&mut b.z, pairs * PAIR);
        let zr = room(&mut b.zr, pairs * PAIR);
        let (rows, layouts) = (&b.rows, &self.layouts);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let mut pairs = z.as_chunks_mut::<PAIR>().0.iter_mut().zip(zr.as_chunks_mut().0);
                let (upper, lower) = (upper.as_chunks::<PAIR>().0, lower.as_chunks::<PAIR>().0);
                for (index, _, first) in rows {
                    for (a, rivals) in layouts[*index].rivals.iter().enumerate() {
                        for (rival, shared) in rivals {
                            let (z, zr) = pairs.next().expect("there is room for every pair");
                            compare(
                                &upper[first + a],
                                &lower[first + rival],
                                &relations[usize::from(*shared)],
                                z,
                                zr,
                            );
                        }
                    }
                }
            },
        );
        let (w, bias) = parameters[o.competition..o.value].split_at(PAIR * PAIR);
        let y = room(&mut b.y, pairs * PAIR);
        affine(zr, w, bias, y);
        Activation::Relu.apply(y);
    }

    fn values(&mut self, parameters: &[f32]) -> &[f32] {
        let o = self.offsets;
        let b = &mut self.buffers;
        let (w, bias) = parameters[o.value..o.end].split_at(PAIR);
        let outputs = room(&mut b.outputs, b.rows.len() * self.actions);
        let mut y = b.y.as_chunks::<PAIR>().0.iter();
        for ((index, ..), outputs) in b.rows.iter().zip(outputs.chunks_exact_mut(self.actions)) {
            outputs.fill(f32::NEG_INFINITY);
            for (q, rivals) in outputs.iter_mut().zip(&self.layouts[*index].rivals) {
                let value = |y: &[f32; PAIR]| -> f32 { y.iter().zip(w).map(|(y, w)| y * w).sum() };
                *q = y.by_ref().take(rivals.len()).map(|y| value(y) + bias[0]).sum();
            }
        }
        outputs
    }
}

/// What a pair of phases makes of its halves and its relation.
#[inline(always)]
fn compare(
    upper: &[f32; PAIR],
    lower: &[f32; PAIR],
    relation: &[f32; PAIR],
    z: &mut [f32; PAIR],
    zr: &mut [f32; PAIR],
) {
    for i in 0..PAIR {
        z[i] = relu(upper[i] + lower[i]);
        zr[i] = z[i] * relation[i];
    }
}

impl Frap {
    /// From values to what the competition made of a pair; returns the pairs with a gradient.
    fn value(&mut self, parameters: &[f32], dq: &[f32], gradient: &mut [f32]) -> usize {
        let o = self.offsets;
        let w = &parameters[o.value..][..PAIR];
        let (dw, dbias) = gradient[o.value..o.end].split_at_mut(PAIR);
        let b = &mut self.buffers;
        let most = self.layouts.iter().map(PhaseLayout::pairs).max().unwrap_or(0) * b.rows.len();
        let dy = room(&mut b.dy, most * PAIR);
        let active_zr = room(&mut b.active_zr, most * PAIR);
        let (mut pair, mut active) = (0, 0);
        for ((index, ..), dq) in b.rows.iter().zip(dq.chunks_exact(self.actions)) {
            for (rivals, dq) in self.layouts[*index].rivals.iter().zip(dq) {
                if *dq != 0.0 {
                    for i in pair..pair + rivals.len() {
                        let from = i * PAIR..(i + 1) * PAIR;
                        let to = active * PAIR..(active + 1) * PAIR;
                        let y = &b.y[from.clone()];
                        add_scaled(dw, y, *dq);
                        let dy = &mut dy[to.clone()];
                        dy.fill(0.0);
                        add_scaled(dy, w, *dq);
                        Activation::Relu.gradient(y, dy);
                        active_zr[to].copy_from_slice(&b.zr[from]);
                        active += 1;
                    }
                    dbias[0] += dq * rivals.len() as f32;
                }
                pair += rivals.len();
            }
        }
        active
    }

    fn competition(&mut self, parameters: &[f32], dq: &[f32], gradient: &mut [f32], active: usize) {
        let o = self.offsets;
        let relations = self.relations(parameters);
        let b = &mut self.buffers;
        let (w, _) = parameters[o.competition..o.value].split_at(PAIR * PAIR);
        let (dw, dbias) = gradient[o.competition..o.value].split_at_mut(PAIR * PAIR);
        let dy = &b.dy[..active * PAIR];
        add_weight_gradient(&b.active_zr[..active * PAIR], dy, dw, active);
        add_bias_gradient(dy, dbias);
        let dz = room(&mut b.dz, active * PAIR);
        b.turned.resize(PAIR * PAIR, 0.0);
        input_gradient(dy, w, PAIR, &mut b.turned, dz, false);

        let phases: usize = b.rows.iter().map(|r| self.layouts[r.0].phases.len()).sum();
        let dupper = room(&mut b.dupper, phases * PAIR);
        dupper.fill(0.0);
        let dlower = room(&mut b.dlower, phases * PAIR);
        dlower.fill(0.0);
        let mut drelations = [[0.0; PAIR]; 2];
        let mut dz = dz.as_chunks::<PAIR>().0.iter();
        let (z, dupper, dlower) = (
            b.z.as_chunks::<PAIR>().0,
            dupper.as_chunks_mut::<PAIR>().0,
            dlower.as_chunks_mut::<PAIR>().0,
        );
        let mut pair = 0;
        for ((index, _, first), dq) in b.rows.iter().zip(dq.chunks_exact(self.actions)) {
            for ((a, rivals), dq) in self.layouts[*index].rivals.iter().enumerate().zip(dq) {
                for (i, (rival, shared)) in rivals.iter().enumerate() {
                    if *dq == 0.0 {
                        break;
                    }
                    let dzr = dz.next().expect("as many as have a gradient");
                    let z = &z[pair + i];
                    let shared = usize::from(*shared);
                    let (up, low) = (&mut dupper[first + a], &mut dlower[first + rival]);
                    for k in 0..PAIR {
                        drelations[shared][k] += dzr[k] * z[k];
                        let d = if z[k] > 0.0 { dzr[k] * relations[shared][k] } else { 0.0 };
                        up[k] += d;
                        low[k] += d;
                    }
                }
                pair += rivals.len();
            }
        }
        self.relation_gradient(parameters, &relations, &mut drelations, gradient);
    }

    fn relation_gradient(
        &self,
        parameters: &[f32],
        relations: &[[f32; PAIR]; 2],
        drelations: &mut [[f32; PAIR]; 2],
        gradient: &mut [f32],
    ) {
        let o = self.offsets;
        for shared in 0..2 {
            let d = &mut drelations[shared];
            Activation::Relu.gradient(&relations[shared], d);
            add_scaled(&mut gradient[o.relation_map + EMBEDDING * PAIR..][..PAIR], d, 1.0);
            for i in 0..EMBEDDING {
                let at = o.relation + shared * EMBEDDING + i;
                let e = parameters[at].max(0.0);
                let weights = o.relation_map + i * PAIR..o.relation_map + (i + 1) * PAIR;
                if e > 0.0 {
                    gradient[at] += dot(&parameters[weights.clone()], d);
                }
                add_scaled(&mut gradient[weights], d, e);
            }
        }
    }

    /// Through the pairs' map to phases and on to movements.
    fn pairs(&mut self, parameters: &[f32], gradient: &mut [f32]) {
        let o = self.offsets;
        let b = &mut self.buffers;
        let phases: usize = b.rows.iter().map(|r| self.layouts[r.0].phases.len()).sum();
        let movements = b.bits.len();
        let (dupper, dlower) = (&b.dupper[..phases * PAIR], &b.dlower[..phases * PAIR]);
        let phase = &b.phase[..phases * MOVEMENT];
        let half = MOVEMENT * PAIR;
        let (dw, dbias) = gradient[o.pair..o.relation].split_at_mut(2 * half);
        add_weight_gradient(phase, dupper, &mut dw[..half], phases);
        add_weight_gradient(phase, dlower, &mut dw[half..], phases);
        add_bias_gradient(dupper, dbias);
        let dphase = room(&mut b.dphase, phases * MOVEMENT);
        let w = &parameters[o.pair..][..2 * half];
        input_gradient(dupper, &w[..half], PAIR, &mut b.turned, dphase, false);
        input_gradient(dlower, &w[half..], PAIR, &mut b.turned, dphase, true);
        let dmovement = room(&mut b.dmovement, movements * MOVEMENT);
        dmovement.fill(0.0);
        for (index, first, first_phase) in &b.rows {
            for (a, pair) in self.layouts[*index].phases.iter().enumerate() {
                let d = &dphase[(first_phase + a) * MOVEMENT..][..MOVEMENT];
                for m in pair {
                    add_scaled(&mut dmovement[(first + m) * MOVEMENT..][..MOVEMENT], d, 1.0);
                }
            }
        }
        Activation::Relu.gradient(&b.movement[..movements * MOVEMENT], dmovement);
    }

    /// From movements to demand and phase bits.
    fn movements(&mut self, parameters: &[f32], inputs: &[f32], gradient: &mut [f32]) {
        let o = self.offsets;
        let (_, embeddings) = self.bit_terms(parameters);
        let b = &self.buffers;
        let w = &parameters[o.movement..][..2 * EMBEDDING * MOVEMENT];
        let mut dterms = [[0.0; MOVEMENT]; 2];
        for (row, (index, first, _)) in inputs.chunks_exact(HEAD + self.demand).zip(&b.rows) {
            for (m, window) in self.layouts[*index].windows.iter().enumerate() {
                let m = first + m;
                let dh = &b.dmovement[m * MOVEMENT..][..MOVEMENT];
                add_scaled(&mut dterms[usize::from(b.bits[m])], dh, 1.0);
                let mut dd = [0.0; EMBEDDING];
                for (i, d) in b.demand[m * EMBEDDING..][..EMBEDDING].iter().enumerate() {
                    let at = (EMBEDDING + i) * MOVEMENT;
                    add_scaled(&mut gradient[o.movement + at..][..MOVEMENT], dh, *d);
                    dd[i] = dot(&w[at..][..MOVEMENT], dh) * d * (1.0 - d);
                }
                for (i, x) in row[HEAD + window..][..self.width].iter().enumerate() {
                    add_scaled(&mut gradient[o.demand + i * EMBEDDING..][..EMBEDDING], &dd, *x);
                }
                let bias = o.demand + self.width * EMBEDDING;
                add_scaled(&mut gradient[bias..][..EMBEDDING], &dd, 1.0);
            }
        }
        for bit in 0..2 {
            let d = &dterms[bit];
            let bias = o.movement + 2 * EMBEDDING * MOVEMENT;
            add_scaled(&mut gradient[bias..][..MOVEMENT], d, 1.0);
            for (i, e) in embeddings[bit].iter().enumerate() {
                add_scaled(&mut gradient[o.movement + i * MOVEMENT..][..MOVEMENT], d, *e);
                gradient[o.bit + bit * EMBEDDING + i] +=
                    dot(&w[i * MOVEMENT..][..MOVEMENT], d) * e * (1.0 - e);
            }
        }
    }
}

fn dot(x: &[f32], y: &[f32]) -> f32 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

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
