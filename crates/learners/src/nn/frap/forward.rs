//! FRAP's values: movements, phases, pairs.

use pulp::Arch;

use super::super::kernel::{Activation, affine, product, relu, sigmoid};
use super::super::room;
use super::parts::{EMBEDDING, Frap, HEAD, MOVEMENT, PAIR, add_scaled};

impl Frap {
    /// Returns what the phase bit adds to a movement before its ReLU, for both bits, and the squashed
    /// embeddings themselves.
    pub(super) fn bit_terms(
        &self,
        parameters: &[f32],
    ) -> ([[f32; MOVEMENT]; 2], [[f32; EMBEDDING]; 2]) {
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
    pub(super) fn relations(&self, parameters: &[f32]) -> [[f32; PAIR]; 2] {
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
    pub(super) fn movements_and_phases(&mut self, parameters: &[f32], inputs: &[f32]) {
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
    pub(super) fn compete(&mut self, parameters: &[f32]) {
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

    /// Sums what the pairs are worth into the values of phases.
    pub(super) fn values(&mut self, parameters: &[f32]) -> &[f32] {
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
