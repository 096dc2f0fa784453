//! Numbers that go one by one, of which the first, the second and so on can be asked for.

/// Some of the numbers from 0 to a size: sums over blocks of them that halve (P. Fenwick, "A new data structure for
/// cumulative frequency tables", Software: Practice and Experience 24 (1994)).
pub(super) struct Remaining {
    sums: Vec<usize>,
    len: usize,
}

impl Remaining {
    /// Returns some of the numbers below a size.
    pub(super) fn of(some: &[usize], size: usize) -> Self {
        let mut remaining = Self { sums: vec![0; size.next_power_of_two() + 1], len: some.len() };
        some.iter().for_each(|number| remaining.sums[*number + 1] = 1);
        for i in 1..remaining.sums.len() {
            let above = i + (i & i.wrapping_neg());
            if above < remaining.sums.len() {
                remaining.sums[above] += remaining.sums[i];
            }
        }
        remaining
    }

    /// Returns how many there are.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Returns the one at a place in their order; there must be so many.
    pub(super) fn get(&self, mut place: usize) -> usize {
        let (mut at, mut step) = (0, self.sums.len() - 1);
        while step > 0 {
            if at + step < self.sums.len() && self.sums[at + step] <= place {
                at += step;
                place -= self.sums[at];
            }
            step /= 2;
        }
        at
    }

    /// Removes one that is there.
    pub(super) fn remove(&mut self, number: usize) {
        self.len -= 1;
        let mut i = number + 1;
        while i < self.sums.len() {
            self.sums[i] -= 1;
            i += i & i.wrapping_neg();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn they_are_in_order_whatever_goes(
            kept in prop::collection::vec(any::<bool>(), 1..70),
            gone in prop::collection::vec(any::<prop::sample::Index>(), 0..70),
        ) {
            let mut list: Vec<usize> = (0..kept.len()).filter(|i| kept[*i]).collect();
            let mut remaining = Remaining::of(&list, kept.len());
            for index in gone {
                prop_assert_eq!(remaining.len(), list.len());
                for (place, number) in list.iter().enumerate() {
                    prop_assert_eq!(remaining.get(place), *number);
                }
                if list.is_empty() {
                    break;
                }
                remaining.remove(list.remove(index.index(list.len())));
            }
        }
    }
}
