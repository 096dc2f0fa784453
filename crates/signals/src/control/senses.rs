//! What a learner sees and is paid for, where somebody replaces the learner's own.
//!
//! Everything else stays: network, exploration, updates, validation, checkpoints. So two learners that differ in nothing but
//! the reward, or in nothing but what they see, can be compared.

use super::{Observation, SignalSpec};
use learners::nn::Activation;
use learners::nn::sequential::Sequential;

use super::state::LANE_WIDTH;

/// What a learner sees and is paid for in place of its own.
///
/// Errors are words for people, with the traceback where there is one; they end the training.
pub trait Senses {
    /// Meets the signals that an episode begins on.
    ///
    /// # Errors
    ///
    /// Why it cannot work with them.
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<(), String>;

    /// Returns how many numbers it sees of a signal; `None` where the learner sees its own.
    fn width(&self, signal: usize) -> Option<usize>;

    /// Writes what it sees of a signal, as many numbers as [`Self::width`] says; only called where it says so.
    ///
    /// # Errors
    ///
    /// Why there are none, or other ones.
    fn observe(
        &mut self,
        signal: usize,
        seen: &Observation,
        state: &mut Vec<f32>,
    ) -> Result<(), String>;

    /// Returns what the interval that has passed at a signal was worth; `None` where the learner's own reward counts.
    ///
    /// # Errors
    ///
    /// Why there is none.
    fn reward(&mut self, signal: usize, seen: &Observation) -> Result<Option<f32>, String>;
}

/// What a network sees of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum View {
    /// So many rows of [`LANE_WIDTH`] numbers, which neighbouring rows are convolved of.
    Lanes(usize),
    /// So many numbers of somebody's own.
    Own(usize),
}

impl View {
    /// Returns how many numbers that are.
    pub(super) fn width(self) -> usize {
        match self {
            Self::Lanes(rows) => rows * LANE_WIDTH,
            Self::Own(width) => width,
        }
    }

    /// Returns the hidden layers of a network with this view: RESCO's convolution and two linear ones. Numbers of somebody's
    /// own have no neighbours, so that a linear layer takes the place of the convolution.
    pub(super) fn hidden_layers(self, units: usize) -> Sequential {
        let network = Sequential::new(self.width());
        let network = match self {
            Self::Lanes(_) => network.convolution(LANE_WIDTH, units, Activation::Relu),
            Self::Own(_) => network.linear(units, Activation::Relu),
        };
        network.linear(units, Activation::Relu).linear(units, Activation::Relu)
    }
}

#[cfg(test)]
mod tests {
    use super::super::state::wait_reward;
    use super::super::testing::{QueueWorld, check_learner, two_phase_signal};
    use super::super::{Controller, Setup, idqn, max_pressure, mplight};
    use super::*;

    /// Queues of the lanes in place of the learner's own view if there is a width, and a reward of somebody's own.
    struct Queues {
        width: Option<usize>,
        reward: fn(&Observation) -> Result<Option<f32>, String>,
        episodes: usize,
    }

    impl Senses for Queues {
        fn begin(&mut self, _: &[SignalSpec]) -> Result<(), String> {
            self.episodes += 1;
            Ok(())
        }

        fn width(&self, _: usize) -> Option<usize> {
            self.width
        }

        fn observe(
            &mut self,
            _: usize,
            seen: &Observation,
            state: &mut Vec<f32>,
        ) -> Result<(), String> {
            assert!(self.episodes > 0, "nothing is seen before an episode begins");
            state.clear();
            state.push(seen.phase as f32);
            state.extend(seen.lanes.iter().map(|lane| (lane.queue + lane.approach) as f32 / 28.0));
            Ok(())
        }

        fn reward(&mut self, _: usize, seen: &Observation) -> Result<Option<f32>, String> {
            (self.reward)(seen)
        }
    }

    fn setup(episodes: u32) -> Setup {
        Setup { seed: 7, episodes, ..Setup::default() }
    }

    fn with(mut learner: Box<dyn Controller>, width: Option<usize>) -> Box<dyn Controller> {
        let reward = |seen: &Observation| Ok(Some(wait_reward(seen)));
        learner.set_senses("mine", Box::new(Queues { width, reward, episodes: 0 })).unwrap();
        learner
    }

    fn small() -> idqn::Config {
        idqn::Config { hidden: 16, learning_rate: 3e-3, ..idqn::Config::default() }
    }

    fn trained(learner: &mut dyn Controller) -> Result<(), String> {
        let mut world = QueueWorld::new(vec![two_phase_signal()]);
        learner.train(&mut world).map_err(|e| e.to_string())
    }

    #[test]
    fn the_own_reward_given_from_outside_changes_nothing_but_the_name() {
        let mut own = idqn::create(&small(), &setup(5));
        let mut same = with(idqn::create(&small(), &setup(5)), None);
        for learner in [&mut own, &mut same] {
            trained(&mut **learner).unwrap();
        }
        let mut named = own.model().unwrap();
        assert_ne!(named.to_bytes(), same.model().unwrap().to_bytes());
        named.put("method", "mine");
        assert_eq!(named.to_bytes(), same.model().unwrap().to_bytes());
    }

    #[test]
    fn what_cannot_be_replaced_or_had_is_said() {
        let mut pressure = with(mplight::create(&mplight::Config::default(), &setup(5)), None);
        assert_eq!(trained(&mut *pressure), Ok(()));
        let mut blind = with(mplight::create(&mplight::Config::default(), &setup(5)), Some(3));
        let e = trained(&mut *blind).unwrap_err();
        assert!(e.starts_with("mine: its network is made of movements"), "{e}");

        let mut broken = idqn::create(&small(), &setup(5));
        let reward = |_: &Observation| Err("it is broken".to_owned());
        let senses = Queues { width: None, reward, episodes: 0 };
        broken.set_senses("mine", Box::new(senses)).unwrap();
        assert_eq!(trained(&mut *broken), Err("mine: it is broken".to_owned()));

        let mut rule = max_pressure::create(&max_pressure::Config::default(), &setup(5));
        let senses = Queues { width: None, reward, episodes: 0 };
        let e = rule.set_senses("mine", Box::new(senses)).unwrap_err().to_string();
        assert!(e.contains("max-pressure: it does not learn"), "{e}");
    }

    #[test]
    fn it_learns_from_what_somebody_else_sees_and_goes_on_from_a_checkpoint() {
        check_learner(&|episodes| with(idqn::create(&small(), &setup(episodes)), Some(3)));
    }
}
