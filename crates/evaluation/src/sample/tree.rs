//! Rows of numbers in a tree of boxes, which finds the near ones without looking at all.
//!
//! Nothing that is found depends on the tree: a box is passed by only where no row in it can count. The distance to a
//! box is summed as that to a row is, column by column, so that rounding keeps it from being larger.

/// Rows that are not divided further.
const LEAF: usize = 8;

/// Rows of numbers in a tree of boxes.
pub(super) struct Tree<'a> {
    rows: &'a [Vec<f64>],
    /// Positions of rows, box by box.
    order: Vec<usize>,
    nodes: Vec<Node>,
    /// The least and the largest value of every column of every box.
    bounds: Vec<(f64, f64)>,
    columns: usize,
}

/// A box and the rows in it.
struct Node {
    begin: usize,
    end: usize,
    halves: Option<[usize; 2]>,
}

/// Returns the squared Euclidean distance of two rows.
pub(super) fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum()
}

impl<'a> Tree<'a> {
    /// The box of all rows.
    const ROOT: usize = 0;

    /// Returns the tree of some rows.
    pub(super) fn of(rows: &'a [Vec<f64>], some: Vec<usize>) -> Self {
        let columns = rows.first().map_or(0, Vec::len);
        let end = some.len();
        let mut tree = Self { rows, order: some, nodes: Vec::new(), bounds: Vec::new(), columns };
        tree.add(0, end);
        tree
    }

    /// Adds the box of the rows at some places in the order, and the boxes in it; returns its number.
    fn add(&mut self, begin: usize, end: usize) -> usize {
        let number = self.nodes.len();
        self.nodes.push(Node { begin, end, halves: None });
        for column in 0..self.columns {
            let values = self.order[begin..end].iter().map(|row| self.rows[*row][column]);
            let bounds = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            self.bounds.push(bounds);
        }
        let width = |column: &usize| {
            let (low, high) = self.bounds[number * self.columns + column];
            high - low
        };
        let widest = (0..self.columns).max_by(|a, b| width(a).total_cmp(&width(b)));
        if let Some(column) = widest.filter(|column| end - begin > LEAF && width(column) > 0.0) {
            let middle = (end - begin) / 2;
            let rows = self.rows;
            self.order[begin..end].select_nth_unstable_by(middle, |a, b| {
                rows[*a][column].total_cmp(&rows[*b][column])
            });
            let middle = begin + middle;
            let halves = [self.add(begin, middle), self.add(middle, end)];
            self.nodes[number].halves = Some(halves);
        }
        number
    }

    /// Returns the number of boxes.
    fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the two boxes within a box; `None` where it is not divided.
    fn halves(&self, node: usize) -> Option<[usize; 2]> {
        self.nodes[node].halves
    }

    /// Returns the positions of the rows in a box.
    fn rows(&self, node: usize) -> &[usize] {
        &self.order[self.nodes[node].begin..self.nodes[node].end]
    }

    /// Returns the squared distance to a box: no row in it is nearer.
    fn distance(&self, node: usize, from: &[f64]) -> f64 {
        let bounds = &self.bounds[node * self.columns..][..self.columns];
        let beyond = |(x, (low, high)): (&f64, &(f64, f64))| {
            let outside = if x < low {
                low - x
            } else if x > high {
                x - high
            } else {
                0.0
            };
            outside.powi(2)
        };
        from.iter().zip(bounds).map(beyond).sum()
    }

    /// Shows all rows that are no farther than a squared distance, and others, the near ones first.
    ///
    /// # Arguments
    ///
    /// * `within` — the squared distance that counts at first.
    /// * `enter` — whether a box is of any interest.
    /// * `found` — is given the position of a row and its squared distance; returns the one that counts from now on.
    fn near(
        &self,
        from: &[f64],
        within: f64,
        enter: &impl Fn(usize) -> bool,
        found: &mut impl FnMut(usize, f64) -> f64,
    ) {
        self.look(Self::ROOT, from, within, enter, found);
    }

    fn look(
        &self,
        node: usize,
        from: &[f64],
        mut within: f64,
        enter: &impl Fn(usize) -> bool,
        found: &mut impl FnMut(usize, f64) -> f64,
    ) -> f64 {
        let Some(halves) = self.halves(node) else {
            for row in self.rows(node) {
                within = found(*row, squared_distance(from, &self.rows[*row]));
            }
            return within;
        };
        let mut halves = halves.map(|half| (self.distance(half, from), half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (distance, half) in halves {
            if distance <= within && enter(half) {
                within = self.look(half, from, within, enter, found);
            }
        }
        within
    }

    /// Returns the nearest row, of equally near ones the first.
    ///
    /// # Arguments
    ///
    /// * `guess` — the position of a row that may be it, one of the tree's.
    pub(super) fn nearest(&self, from: &[f64], guess: usize) -> usize {
        let (mut least, mut nearest) = (squared_distance(from, &self.rows[guess]), guess);
        self.near(from, least, &|_| true, &mut |row, distance| {
            if distance < least || (distance == least && row < nearest) {
                (least, nearest) = (distance, row);
            }
            least
        });
        nearest
    }
}

/// Rows of a tree that go one by one.
pub(super) struct Dwindling<'a> {
    tree: Tree<'a>,
    /// How many rows are left in every box.
    left: Vec<usize>,
    is_left: Vec<bool>,
    /// Where every row is in the order of the tree.
    places: Vec<usize>,
}

impl<'a> Dwindling<'a> {
    /// Returns some rows, in ascending order.
    pub(super) fn of(rows: &'a [Vec<f64>], some: Vec<usize>) -> Self {
        let mut is_left = vec![false; rows.len()];
        some.iter().for_each(|row| is_left[*row] = true);
        let tree = Tree::of(rows, some);
        let left = (0..tree.len()).map(|node| tree.rows(node).len()).collect();
        let mut places = vec![0; rows.len()];
        tree.order.iter().enumerate().for_each(|(place, row)| places[*row] = place);
        Self { tree, left, is_left, places }
    }

    /// Returns the rows that are left and nearest to one of them, in ascending order.
    pub(super) fn nearest_others(&self, to: usize) -> Vec<usize> {
        let (mut least, mut near) = (f64::INFINITY, Vec::new());
        let enter = |node: usize| self.left[node] > 0;
        self.tree.near(&self.tree.rows[to], least, &enter, &mut |row, distance| {
            if row == to || !self.is_left[row] {
                return least;
            }
            if distance < least {
                least = distance;
                near.clear();
            }
            if distance == least {
                near.push(row);
            }
            least
        });
        near.sort_unstable();
        near
    }

    /// Removes a row that is left.
    pub(super) fn remove(&mut self, row: usize) {
        self.is_left[row] = false;
        let place = self.places[row];
        let mut node = Some(Tree::ROOT);
        while let Some(at) = node {
            self.left[at] -= 1;
            let half = |half: &usize| {
                let Node { begin, end, .. } = self.tree.nodes[*half];
                (begin..end).contains(&place)
            };
            node = self.tree.halves(at).and_then(|halves| halves.into_iter().find(half));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_found_is_what_looking_at_all_finds(
            rows in prop::collection::vec(prop::collection::vec((-4i8..4).prop_map(f64::from), 3), 1..80),
            from in prop::collection::vec((-5i8..5).prop_map(f64::from), 3),
            guess in any::<prop::sample::Index>(),
            gone in prop::collection::vec(any::<prop::sample::Index>(), 0..40),
        ) {
            let all: Vec<usize> = (0..rows.len()).collect();
            let tree = Tree::of(&rows, all.clone());
            let distance = |row: &usize| squared_distance(&from, &rows[*row]);
            let first = all.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied();
            prop_assert_eq!(Some(tree.nearest(&from, guess.index(rows.len()))), first);
            for node in 0..tree.len() {
                let box_is = tree.distance(node, &from);
                prop_assert!(tree.rows(node).iter().all(|row| distance(row) >= box_is));
            }
            let mut dwindling = Dwindling::of(&rows, all.clone());
            let mut left = all;
            for index in gone {
                if left.len() < 2 {
                    break;
                }
                dwindling.remove(left.remove(index.index(left.len())));
                let to = left[0];
                let distance = |row: &usize| squared_distance(&rows[to], &rows[*row]);
                let others = || left.iter().filter(|row| **row != to);
                let least = others().map(distance).fold(f64::INFINITY, f64::min);
                let near: Vec<usize> = others().filter(|row| distance(row) == least).copied().collect();
                prop_assert_eq!(dwindling.nearest_others(to), near);
            }
        }
    }
}
