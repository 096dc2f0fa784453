//! A replay buffer: the latest transitions, drawn uniformly (Lin, 1992).

use super::random::Generator;
use super::spread;
use crate::nn::archive::{Archive, ArchiveError};
use crate::nn::state::State;

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
    /// Per transition both states, then action, reward and whether it was terminal.
    rows: Vec<f32>,
    cursor: usize,
}

impl Replay {
    /// Returns an empty buffer of `capacity` transitions between states of `width` numbers.
    pub fn new(capacity: usize, width: usize) -> Self {
        Self { capacity, width, rows: Vec::new(), cursor: 0 }
    }

    fn row(&self) -> usize {
        2 * self.width + 3
    }

    /// Number of transitions.
    pub fn len(&self) -> usize {
        self.rows.len() / self.row()
    }

    /// Whether there is no transition.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Adds a transition and returns its place.
    pub fn push(&mut self, transition: &Transition<'_>) -> usize {
        let (place, row) = (self.cursor, self.row());
        self.cursor = (self.cursor + 1) % self.capacity;
        if self.len() < self.capacity {
            self.rows.resize((place + 1) * row, 0.0);
        }
        let (states, rest) = self.rows[place * row..][..row].split_at_mut(2 * self.width);
        states[..self.width].copy_from_slice(transition.state);
        states[self.width..].copy_from_slice(transition.next);
        let Transition { action, reward, terminal, .. } = *transition;
        rest.copy_from_slice(&[action as f32, reward, f32::from(u8::from(terminal))]);
        place
    }

    /// Returns the transition at a place.
    pub fn get(&self, place: usize) -> Transition<'_> {
        let (states, rest) = self.rows[place * self.row()..].split_at(2 * self.width);
        let (state, next) = states.split_at(self.width);
        let (action, reward, terminal) = (rest[0] as usize, rest[1], rest[2] != 0.0);
        Transition { state, action, reward, next, terminal }
    }

    /// Draws different places, as many as `places` has room for; panics when there are fewer transitions.
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
}

impl State for Replay {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(&format!("{prefix}len"), self.len());
        archive.put(&format!("{prefix}cursor"), self.cursor);
        archive.put_f32(format!("{prefix}rows"), &[self.len(), self.row()], &self.rows);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let [len, cursor] = ["len", "cursor"].map(|name| format!("{prefix}{name}"));
        let (count, place): (usize, usize) = (archive.get(&len)?, archive.get(&cursor)?);
        if count > self.capacity || place >= self.capacity {
            return Err(ArchiveError::Card(len));
        }
        self.rows = archive.f32(&format!("{prefix}rows"), &[count, self.row()])?;
        self.cursor = place;
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
