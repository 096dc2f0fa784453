//! What FRAP needs to know of a signal.

/// What FRAP needs to know of a signal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhaseLayout {
    /// First demand number per movement that some phase is named by.
    pub(super) windows: Vec<usize>,
    /// Per phase the movements that it is named by, as indices into `windows`.
    pub(super) phases: Vec<Vec<usize>>,
    /// Per ordered pair of phases: the other phase, and whether they share some but not all movements.
    pub(super) rivals: Vec<Vec<(usize, bool)>>,
}

impl PhaseLayout {
    /// Returns the layout of a signal.
    ///
    /// # Arguments
    ///
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

    /// Returns the numbers of demand that a row must have.
    pub(super) fn demand(&self, width: usize) -> usize {
        self.windows.iter().max().map_or(0, |w| w + width)
    }
    /// Returns the number of ordered pairs of phases.
    pub(super) fn pairs(&self) -> usize {
        self.rivals.iter().map(Vec::len).sum()
    }
}
