//! Seeds: every source of randomness has its own, derived by hashing what it is for.
//! There is no global generator. Two sources never share a seed, and adding a source leaves the others as they were.

use sha2::{Digest, Sha256};

/// Largest seed that SUMO accepts (a signed 32-bit integer).
const SUMO_SEED_MAX: u64 = 0x7fff_ffff;

/// Evaluation seeds have this bit set and training seeds have it clear, so that they never meet.
const EVALUATION_BIT: u64 = 0x4000_0000;

/// Returns a seed for the source of randomness that `labels` names, below 2^53 so that every JSON reader keeps it exactly.
pub fn derive(base: u64, labels: &[&str]) -> u64 {
    let mut hash = Sha256::new();
    hash.update(base.to_le_bytes());
    for label in labels {
        hash.update((label.len() as u64).to_le_bytes());
        hash.update(label.as_bytes());
    }
    let digest = hash.finalize();
    let bytes: [u8; 8] = digest[..8].try_into().expect("a SHA-256 digest has 32 bytes");
    u64::from_le_bytes(bytes) >> 11
}

/// Returns the seed of the `k`-th evaluation episode before [`at_point`]: the same for every method,
/// so that methods meet the same vehicles.
pub fn evaluation(base: u64, k: u32) -> u64 {
    let seed = derive(base, &["evaluation", &k.to_string()]);
    (seed & SUMO_SEED_MAX) | EVALUATION_BIT
}

/// Returns the evaluation seed that a number stands for, before [`at_point`]: the number itself where it is one, as manifests
/// have them, else one of its own for every number below 2^30; `None` for a number that is too large.
pub fn evaluation_of(number: u64) -> Option<u64> {
    (number <= SUMO_SEED_MAX).then_some(number | EVALUATION_BIT)
}

/// Returns the seed that an evaluation episode has on a point MDP, which vehicles and simulator get:
/// the same for every method there, another on every other point MDP, so that their noise is
/// independent and averages out over the family. An evaluation seed stays one.
/// `content`: what the point MDP is, whatever it is called.
pub fn at_point(seed: u64, content: &str) -> u64 {
    let here = derive(seed, &["point", content]) & SUMO_SEED_MAX & !EVALUATION_BIT;
    here | (seed & EVALUATION_BIT)
}

/// Returns the seed of the `k`-th training episode of a task, which vehicles and simulator get; never an evaluation seed.
pub fn training(task_seed: u64, k: u32) -> u64 {
    derive(task_seed, &["training", &k.to_string()]) & SUMO_SEED_MAX & !EVALUATION_BIT
}

/// Returns the seed of the `k`-th validation episode of a task, which vehicles and simulator get; never an evaluation
/// seed, and another source than the training seeds.
pub fn validation(task_seed: u64, k: u32) -> u64 {
    derive(task_seed, &["validation", &k.to_string()]) & SUMO_SEED_MAX & !EVALUATION_BIT
}

/// Returns the seed of everything random in a method whose training starts again for the `k`-th time.
pub fn restart(task_seed: u64, k: u32) -> u64 {
    if k == 0 { task_seed } else { derive(task_seed, &["restart", &k.to_string()]) }
}

/// Returns the seed of one property (`purpose`) of the vehicles that start on an edge, in the episode
/// of a seed: a stream of vehicles, and each of its properties, is independent of all others.
pub fn vehicles(seed: u64, purpose: &str, edge: &str) -> u64 {
    derive(seed, &["vehicles", purpose, edge])
}

/// Returns the seed of the pedestrians who cross an edge at a signal, in the episode of a seed.
pub fn pedestrians(seed: u64, signal: &str, edge: &str) -> u64 {
    derive(seed, &["pedestrians", signal, edge])
}

/// Returns the seed of a task; it does not depend on the order of tasks or on the other methods.
pub fn task(base: u64, method: &str, content: &str, replicate: u32) -> u64 {
    derive(base, &["task", method, content, &replicate.to_string()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn training_and_evaluation_seeds_never_meet(base: u64, task: u64, j: u32, k: u32) {
            prop_assert_ne!(evaluation(base, j), training(task, k));
            prop_assert_ne!(evaluation(base, j), validation(task, k));
        }

        #[test]
        fn seeds_at_a_point_never_meet_either(base: u64, task: u64, j: u32, k: u32) {
            prop_assert_ne!(at_point(evaluation(base, j), "p"), training(task, k));
        }

        #[test]
        fn sumo_accepts_every_seed(base: u64, k: u32) {
            let at_point = at_point(evaluation(base, k), "p");
            prop_assert!(at_point <= SUMO_SEED_MAX && training(base, k) <= SUMO_SEED_MAX);
        }
    }

    #[test]
    fn a_number_stands_for_an_evaluation_seed() {
        assert_eq!(evaluation_of(7), Some(EVALUATION_BIT + 7));
        assert_eq!(evaluation_of(evaluation(0, 3)), Some(evaluation(0, 3)));
        assert_eq!(evaluation_of(SUMO_SEED_MAX + 1), None);
    }

    #[test]
    fn seeds_stay_the_same_between_versions() {
        assert_eq!(evaluation(0, 0), 1_889_785_958);
        assert_eq!(task(0, "idqn", "p", 0), 2884222854678301);
    }
}
