//! FRAP's gradient, for the phases whose value has one.

use super::super::kernel::{Activation, add_bias_gradient, add_weight_gradient, input_gradient};
use super::super::room;
use super::parts::{EMBEDDING, Frap, HEAD, MOVEMENT, PAIR, add_scaled};

impl Frap {
    pub(super) fn differentiate(
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

    /// From values to what the competition made of a pair; returns the pairs with a gradient.
    fn value(&mut self, parameters: &[f32], dq: &[f32], gradient: &mut [f32]) -> usize {
        let o = self.offsets;
        let w = &parameters[o.value..][..PAIR];
        let (dw, dbias) = gradient[o.value..o.end].split_at_mut(PAIR);
        let b = &mut self.buffers;
        let most =
            self.layouts.iter().map(super::PhaseLayout::pairs).max().unwrap_or(0) * b.rows.len();
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

    /// Through the competition's map to both halves of the pairs' map and to the relations.
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
