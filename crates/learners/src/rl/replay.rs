//! A replay buffer: the latest transitions, drawn uniformly (Lin, 1992).

use super::persist::spread;
use super::random::Generator;
use crate::nn::archive::{Archive, ArchiveError};

/// What happened in one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition<'a> {
    /// State before.
    pub state: &'a [f32],
    /// Action taken.
    pub action: usize,
    /// Reward received.
    pub reward: f32,
    /// State after.
    pub next: &'a [f32],
    /// Whether nothing can follow, so that the state after is worth nothing.
    pub terminal: bool,
}

/// The latest transitions; the oldest is replaced when it is full.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    capacity: usize,
    width: usize,
    states: Vec<f32>,
    nexts: Vec<f32>,
    actions: Vec<u32>,
    rewards: Vec<f32>,
    terminals: Vec<u32>,
    cursor: usize,
}

impl Replay {
    /// Returns an empty buffer of `capacity` transitions between states of `width` numbers.
    pub fn new(capacity: usize, width: usize) -> Self {
        Self {
            capacity,
            width,
            states: Vec::new(),
            nexts: Vec::new(),
            actions: Vec::new(),
            rewards: Vec::new(),
            terminals: Vec::new(),
            cursor: 0,
        }
    }

    /// Number of transitions.
    pub fn len(&self) -> usize {
        self.actions.len()
    }

    /// Whether there is no transition.
    pub fn is_empty(&self) -> bool {
        self.actions.is_empty()
    }

    /// Adds a transition and returns its place.
    pub fn push(&mut self, transition: &Transition<'_>) -> usize {
        let place = self.cursor;
        self.cursor = (self.cursor + 1) % self.capacity;
        if self.len() < self.capacity {
            self.states.extend_from_slice(transition.state);
            self.nexts.extend_from_slice(transition.next);
            self.actions.push(transition.action as u32);
            self.rewards.push(transition.reward);
            self.terminals.push(u32::from(transition.terminal));
        } else {
            let numbers = place * self.width..(place + 1) * self.width;
            self.states[numbers.clone()].copy_from_slice(transition.state);
            self.nexts[numbers].copy_from_slice(transition.next);
            self.actions[place] = transition.action as u32;
            self.rewards[place] = transition.reward;
            self.terminals[place] = u32::from(transition.terminal);
        }
        place
    }

    /// Returns the transition at a place.
    pub fn get(&self, place: usize) -> Transition<'_> {
        let numbers = place * self.width..(place + 1) * self.width;
        Transition {
            state: &self.states[numbers.clone()],
            action: self.actions[place] as usize,
            reward: self.rewards[place],
            next: &self.nexts[numbers],
            terminal: self.terminals[place] != 0,
        }
    }

    /// Draws different places, as many as `places` has room for.
    ///
    /// # Panics
    ///
    /// When there are fewer transitions than that.
    pub fn draw(&self, places: &mut [usize], generator: &mut Generator) {
        assert!(places.len() <= self.len(), "a batch is larger than the replay buffer");
        // Floyd's algorithm: every set is as likely as any other.
        let left_out = self.len() - places.len();
        for i in 0..places.len() {
            let place = generator.below(left_out + i + 1);
            let seen = places[..i].contains(&place);
            places[i] = if seen { left_out + i } else { place };
        }
    }

    /// Returns the states before some transitions from all over the buffer.
    pub fn probes(&self) -> Vec<f32> {
        spread(self.len()).flat_map(|place| self.get(place).state).copied().collect()
    }

    /// Adds the transitions to an archive.
    pub fn save(&self, prefix: &str, archive: &mut Archive) {
        let (rows, width) = (self.len(), self.width);
        archive.put_f32(format!("{prefix}replay.states"), &[rows, width], &self.states);
        archive.put_f32(format!("{prefix}replay.nexts"), &[rows, width], &self.nexts);
        archive.put_u32(format!("{prefix}replay.actions"), &[rows], &self.actions);
        archive.put_f32(format!("{prefix}replay.rewards"), &[rows], &self.rewards);
        archive.put_u32(format!("{prefix}replay.terminals"), &[rows], &self.terminals);
        archive.put(&format!("{prefix}replay.rows"), rows);
        archive.put(&format!("{prefix}replay.cursor"), self.cursor);
    }

    /// Takes the transitions from an archive.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when they are missing or of another shape.
    pub fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let name = |part: &str| format!("{prefix}replay.{part}");
        let rows: usize = archive.get(&name("rows"))?;
        let cursor: usize = archive.get(&name("cursor"))?;
        if rows > self.capacity || cursor >= self.capacity {
            return Err(ArchiveError::Card(name("rows")));
        }
        self.states = archive.f32(&name("states"), &[rows, self.width])?.to_vec();
        self.nexts = archive.f32(&name("nexts"), &[rows, self.width])?.to_vec();
        self.actions = archive.u32(&name("actions"), &[rows])?.to_vec();
        self.rewards = archive.f32(&name("rewards"), &[rows])?.to_vec();
        self.terminals = archive.u32(&name("terminals"), &[rows])?.to_vec();
        self.cursor = cursor;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(capacity: usize, count: usize) -> Replay {
        let mut replay = Replay::new(capacity, 2);
        for i in 0..count {
            let (x, y) = (i as f32, i as f32 + 0.5);
            replay.push(&Transition {
                state: &[x, y],
                action: i,
                reward: -x,
                next: &[y, x],
                terminal: i % 2 == 1,
            });
        }
        replay
    }

    #[test]
    fn the_oldest_transition_is_replaced() {
        let replay = filled(3, 5);
        let actions: Vec<_> = (0..3).map(|i| replay.get(i).action).collect();
        assert_eq!(actions, [3, 4, 2]);
        assert_eq!(
            replay.get(1),
            Transition {
                state: &[4.0, 4.5],
                action: 4,
                reward: -4.0,
                next: &[4.5, 4.0],
                terminal: false
            }
        );
    }

    #[test]
    fn places_are_different_and_equally_likely() {
        let replay = filled(10, 10);
        let mut generator = Generator::new(1, &[]);
        let mut counts = [0; 10];
        for _ in 0..20_000 {
            let mut places = [0; 4];
            replay.draw(&mut places, &mut generator);
            places.iter().for_each(|p| counts[*p] += 1);
            places.sort_unstable();
            assert!(places.windows(2).all(|w| w[0] < w[1]));
        }
        // Expected 8000 each, with a deviation of 70.
        assert!(counts.iter().all(|c| (7700..8300).contains(c)), "{counts:?}");
    }

    #[test]
    fn a_restored_buffer_is_the_same() {
        for count in [2, 5] {
            let replay = filled(3, count);
            let mut archive = Archive::default();
            replay.save("a.", &mut archive);
            let mut other = Replay::new(3, 2);
            other.restore("a.", &archive).unwrap();
            assert_eq!(replay, other);
            assert!(Replay::new(1, 2).restore("a.", &archive).is_err());
        }
    }
}
