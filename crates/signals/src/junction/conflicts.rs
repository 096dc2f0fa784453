//! How ways across a junction stand to each other: movements, or links of a signal.

use fixedbitset::FixedBitSet;

use super::Movement;
use crate::vocabulary::Light;

/// A set of ways, by number.
pub type Set = FixedBitSet;

/// Which ways meet, and which of them yield there when they are green permissively.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Conflicts {
    meet: Vec<Set>,
    yields: Vec<Set>,
}

impl Conflicts {
    /// Returns the conflicts that the order of the arms implies; whoever is permissive yields.
    pub fn of(movements: &[Movement]) -> Self {
        let meets = |a: usize, b: usize| movements[a].conflicts_with(&movements[b]);
        let yields = matrix(movements.len(), &meets);
        Self { meet: matrix(movements.len(), &|a, b| meets(a, b) || meets(b, a)), yields }
    }

    /// Returns how many ways there are.
    pub fn count(&self) -> usize {
        self.meet.len()
    }

    /// Whether two ways meet; those that are not known do not.
    pub fn meet(&self, a: usize, b: usize) -> bool {
        self.meet.get(a).is_some_and(|met| met.contains(b))
    }

    /// Whether a way yields to another when it is green permissively.
    pub fn yields(&self, way: usize, to: usize) -> bool {
        self.yields.get(way).is_some_and(|yields| yields.contains(to))
    }

    /// Says that a way meets another, and whether it yields there.
    pub fn set(&mut self, way: usize, to: usize, yields: bool) {
        self.meet[way].insert(to);
        self.yields[way].set(to, yields);
    }

    /// Adds that a way meets another, which is so in both orders, or yields to it; there may be more ways than before.
    pub fn add(&mut self, way: usize, to: usize, meets: bool, yields: bool) {
        let count = way.max(to) + 1;
        for sets in [&mut self.meet, &mut self.yields] {
            sets.resize_with(sets.len().max(count), Set::new);
            sets.iter_mut().for_each(|set| set.grow(count));
        }
        if meets {
            self.meet[way].insert(to);
            self.meet[to].insert(way);
        }
        if yields {
            self.yields[way].insert(to);
        }
    }

    /// Returns the most that a way may get beside those that have green.
    pub fn best_light(&self, lights: &[Light], way: usize) -> Light {
        let green: Set = (0..lights.len()).filter(|other| lights[*other] != Light::Red).collect();
        let mut met = &green & &self.meet[way];
        let is_free = met.is_clear();
        met.difference_with(&self.yields[way]);
        match (is_free, met.is_clear()) {
            (true, _) => Light::Protected,
            (false, true) => Light::Permissive,
            (false, false) => Light::Red,
        }
    }
}

/// Returns per way the set of the others for which something holds.
pub fn matrix(count: usize, holds: &dyn Fn(usize, usize) -> bool) -> Vec<Set> {
    let row = |a: usize| {
        let mut row = Set::with_capacity(count);
        row.extend((0..count).filter(|b| holds(a, *b)));
        row
    };
    (0..count).map(row).collect()
}
