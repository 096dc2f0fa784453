//! A controller that learns: what it does around its algorithm is the same for every one.
//!
//! Each signal has an agent of its own, or all signals share one. Signals with a single phase stay green and learn nothing.
//!
//! Source: RESCO, agents/agent.py (`IndependentAgent`, `SharedAgent`).

use std::collections::BTreeMap;
use std::ops::Range;

use super::Light;
use super::senses::{Senses, View};
use super::state::{lane_rows, lanes, wait_reward};
use super::{ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec, Trainer};
use basics::seed;
use learners::nn::archive::{Archive, ArchiveError};
use learners::nn::state::State as _;
use learners::rl::normalise::Normaliser;
use learners::rl::persist::Persist;

/// Kinds of archives: what a learner has learned, and what a training goes on from.
const MODEL: &str = "model";
const CHECKPOINT: &str = "checkpoint";

/// Phases below which a signal has nothing to decide.
const MIN_PHASES: usize = 2;

/// A learning method: its agents, what they see and what they are paid for.
pub(super) trait Learner {
    type Agent: Agent;

    /// Whether one agent serves all signals.
    const IS_SHARED: bool = false;

    /// Numbers at the beginning of a state that are not normalised.
    const HEAD: usize = 0;

    const REWARD: fn(&Observation) -> f32 = wait_reward;

    /// Returns agents that have learned nothing yet: one, or one per signal with something to decide, of which `views` has
    /// the index and what is seen, and at most `at_once` have a part in an episode.
    fn agents(
        &mut self,
        signals: &[SignalSpec],
        views: &[(usize, View)],
        at_once: usize,
        seed: u64,
    ) -> Result<Vec<Self::Agent>, String>;

    /// Returns what shifts and scales observations by their running mean and deviation, where that is asked for.
    fn normaliser(&self, view: View) -> Option<Normaliser>;

    /// Writes what is seen of the `number`-th signal with something to decide.
    fn look(&self, number: usize, signal: &SignalSpec, seen: &Observation, state: &mut Vec<f32>) {
        let _ = number;
        lanes(signal, seen, state);
    }
}

/// The algorithm of one signal, or of all.
pub(super) trait Agent {
    /// Chooses one of so many phases: as training does in a training episode, else as evaluation does.
    fn choose(&mut self, state: &[f32], phases: usize, training: &TrainingState) -> usize;

    fn learn(&mut self, step: &Step<'_>);

    /// Returns what was measured in the episode that ends.
    fn curve(&mut self, training: &TrainingState) -> Curve;

    /// Begins an episode of validation, in which every policy draws the same random numbers.
    fn begin_validation(&mut self) {}

    fn kept(&self) -> &dyn Persist;

    fn kept_mut(&mut self) -> &mut dyn Persist;
}

/// A decision and what came of it.
#[derive(Debug)]
pub(super) struct Step<'a> {
    /// What was seen before.
    pub(super) state: &'a [f32],
    /// The phase that was asked for.
    pub(super) asked: usize,
    /// The phase that the lights are at or changing to afterwards: not what was asked for where the limits
    /// of timing did not allow it.
    pub(super) shown: usize,
    pub(super) reward: f32,
    /// What was seen afterwards.
    pub(super) next: &'a [f32],
    /// Whether the episode ends with it.
    pub(super) truncated: bool,
}

/// What the last episode was like.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Curve {
    /// Sum of rewards over decisions and signals.
    pub(super) reward: f64,
    /// Mean loss of the updates.
    pub(super) loss: Option<f64>,
    /// Mean entropy of the policy in the updates.
    pub(super) entropy: Option<f64>,
    /// Share of random actions at the end.
    pub(super) epsilon: Option<f64>,
}

/// Where a training stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct TrainingState {
    /// Episodes in all.
    episodes: u32,
    /// Episodes done.
    done: u32,
    /// Whether what has been learned is more than what it began with.
    updated: bool,
    /// Whether this is a training episode.
    pub(super) active: bool,
    /// Whether this is an episode of validation.
    pub(super) validates: bool,
    /// Decisions per episode.
    decisions: u32,
    /// A model or checkpoint that the next episode begins with.
    pending: Option<Archive>,
    /// The model that signals begin with, however often they change.
    model: Option<Archive>,
    /// The running or last episode.
    curve: Curve,
}

impl TrainingState {
    /// Returns the transitions over which exploration falls: this share of the episodes, cut to whole
    /// ones, with as many transitions per decision as there are signals that learn together.
    pub(super) fn exploration_span(&self, fraction: f64, signals: usize) -> u64 {
        let episodes = (fraction * f64::from(self.episodes)).floor() as u64;
        episodes * u64::from(self.decisions) * signals as u64
    }
}

/// A signal with something to decide.
#[derive(Debug, Default)]
struct Decider {
    /// Index of the signal.
    signal: usize,
    state: Vec<f32>,
    next: Vec<f32>,
    asked: usize,
    /// Time since each phase was shown last, seconds.
    unshown_s: Vec<f64>,
}

/// A learner as a controller.
pub(super) struct Learning<L: Learner> {
    learner: L,
    name: &'static str,
    seed: u64,
    /// The seed of this start of the training.
    start_seed: u64,
    training: TrainingState,
    /// Time between decisions, and the longest wait, seconds.
    guard_s: [f64; 2],
    /// The signals that episodes may have, by point MDP, where there are several.
    places: Vec<Vec<SignalSpec>>,
    reward_scale: f32,
    signals: Vec<SignalSpec>,
    /// Those of the episode.
    acting: Range<usize>,
    deciders: Vec<Decider>,
    pub(super) agents: Vec<(L::Agent, Option<Normaliser>)>,
    /// What it sees and is paid for where somebody replaces its own.
    senses: Option<Box<dyn Senses>>,
    /// Why a reward or an observation of somebody's own failed.
    fault: Option<String>,
}

impl<L: Learner> Learning<L> {
    /// Returns an untrained controller.
    pub(super) fn new(name: &'static str, learner: L, setup: &Setup) -> Self {
        let Setup { seed, episodes, decision_s, longest_wait_s, .. } = *setup;
        Self {
            learner,
            name,
            seed,
            start_seed: seed,
            guard_s: [decision_s.into(), longest_wait_s],
            training: TrainingState { episodes, ..TrainingState::default() },
            places: Vec::new(),
            reward_scale: 1.0,
            signals: Vec::new(),
            acting: 0..0,
            deciders: Vec::new(),
            agents: Vec::new(),
            senses: None,
            fault: None,
        }
    }

    /// Returns an error of senses that are somebody's own.
    fn own(&self, reason: String) -> ControlError {
        ControlError::Own { method: self.name, reason }
    }

    /// Begins from nothing, on the signals that it knows.
    fn meet(&mut self) -> Result<(), ControlError> {
        let deciding = self.signals.iter().enumerate().filter(|(_, signal)| decides(signal));
        let view = |(i, signal)| match self.senses.as_ref().and_then(|senses| senses.width(i)) {
            None => (i, View::Lanes(lane_rows(signal))),
            Some(width) => (i, View::Own(width)),
        };
        let views: Vec<(usize, View)> = deciding.map(view).collect();
        self.deciders =
            views.iter().map(|(i, _)| Decider { signal: *i, ..Decider::default() }).collect();
        let counts = self.places.iter().map(|place| place.iter().filter(|s| decides(s)).count());
        let at_once = counts.max().unwrap_or(views.len());
        let agents = match views.is_empty() {
            true => Vec::new(),
            false => (self.learner.agents(&self.signals, &views, at_once, self.start_seed))
                .map_err(|reason| self.own(reason))?,
        };
        let normalisers = views.iter().map(|(_, view)| self.learner.normaliser(*view));
        self.agents = agents.into_iter().zip(normalisers).collect();
        Ok(())
    }

    fn decide(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), String> {
        let acting = self.acting.clone();
        let deciders = self.deciders.iter_mut().enumerate();
        for (number, own) in deciders.filter(|(_, own)| acting.contains(&own.signal)) {
            let place = own.signal - acting.start;
            let (signal, seen) = (&self.signals[own.signal], &observations[place]);
            match own_view(&mut self.senses, own.signal) {
                None => self.learner.look(number, signal, seen, &mut own.state),
                Some(senses) => senses.observe(own.signal, seen, &mut own.state)?,
            }
            let (agent, normaliser) = &mut self.agents[if L::IS_SHARED { 0 } else { number }];
            if let Some(normaliser) = normaliser {
                normaliser.take_in(&mut own.state[L::HEAD..], self.training.active);
            }
            own.asked = agent.choose(&own.state, signal.phases.len(), &self.training);
            let overdue = overdue(signal, seen, &mut own.unshown_s, self.guard_s);
            phases[place] = GreenPhase(overdue.unwrap_or(own.asked));
        }
        Ok(())
    }

    fn learn(&mut self, observations: &[Observation], truncated: bool) -> Result<(), String> {
        let acting = self.acting.clone();
        let deciders = self.deciders.iter_mut().enumerate();
        for (number, own) in deciders.filter(|(_, own)| acting.contains(&own.signal)) {
            let place = own.signal - acting.start;
            let (signal, seen) = (&self.signals[own.signal], &observations[place]);
            let senses = self.senses.as_mut();
            let reward = senses.map_or(Ok(None), |senses| senses.reward(own.signal, seen))?;
            let reward = reward.unwrap_or_else(|| L::REWARD(seen));
            self.training.curve.reward += f64::from(reward);
            match own_view(&mut self.senses, own.signal) {
                None => self.learner.look(number, signal, seen, &mut own.next),
                Some(senses) => senses.observe(own.signal, seen, &mut own.next)?,
            }
            let (agent, normaliser) = &mut self.agents[if L::IS_SHARED { 0 } else { number }];
            if let Some(normaliser) = normaliser {
                normaliser.apply(&mut own.next[L::HEAD..]);
            }
            let reward = reward * self.reward_scale;
            let Decider { state, next, asked, .. } = &*own;
            agent.learn(&Step { state, asked: *asked, shown: seen.phase, reward, next, truncated });
        }
        if truncated {
            let agents = self.agents.iter_mut();
            let curves: Vec<Curve> = agents.map(|(agent, _)| agent.curve(&self.training)).collect();
            let curve = &mut self.training.curve;
            curve.loss = mean(curves.iter().filter_map(|c| c.loss));
            curve.entropy = mean(curves.iter().filter_map(|c| c.entropy));
            curve.epsilon = curves.first().and_then(|c| c.epsilon);
        }
        Ok(())
    }

    /// Returns what the names of what an agent keeps begin with.
    fn prefix(&self, agent: usize) -> String {
        match L::IS_SHARED {
            true => String::new(),
            false => format!("signal{}.", self.deciders[agent].signal),
        }
    }

    /// Returns what has been learned; of a checkpoint everything that learning goes on from.
    fn archive(&self, kind: &str) -> Archive {
        let mut archive = Archive::default();
        archive.put("kind", kind);
        archive.put("method", self.name);
        match kind == CHECKPOINT {
            true => {
                archive.put("episodes", self.training.done);
                archive.put("updated", self.training.updated);
            }
            false => archive.put("signals", shapes(&self.signals)),
        }
        for (number, (agent, normaliser)) in self.agents.iter().enumerate() {
            let prefix = self.prefix(number);
            match kind == CHECKPOINT {
                true => agent.kept().save(&prefix, &mut archive),
                false => agent.kept().learned(&prefix, &mut archive),
            }
            if let Some(normaliser) = normaliser {
                normaliser.save(&prefix, &mut archive);
            }
        }
        archive
    }

    /// Takes over a model or a checkpoint.
    fn adopt(&mut self, archive: &Archive) -> Result<(), ControlError> {
        let is_checkpoint = archive.get::<String>("kind").is_ok_and(|kind| kind == CHECKPOINT);
        if !is_checkpoint && !L::IS_SHARED {
            check_shape(archive, &self.signals)?;
        }
        for number in 0..self.agents.len() {
            let prefix = self.prefix(number);
            let (agent, normaliser) = &mut self.agents[number];
            match is_checkpoint {
                true => agent.kept_mut().restore(&prefix, archive)?,
                false => agent.kept_mut().load(&prefix, archive)?,
            }
            if let Some(normaliser) = normaliser {
                normaliser.restore(&prefix, archive)?;
            }
        }
        Ok(())
    }
}

impl<L: Learner> Controller for Learning<L> {
    fn name(&self) -> &'static str {
        self.name
    }

    /// The learner drives each signal. Where there is a single phase it is that phase, for ever, which
    /// is what RESCO and an equal split do there too: greens that serve no vehicle are none of either.
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let place = self.places.iter().position(|place| place == signals);
        let before = self.places[..place.unwrap_or(0)].iter().map(Vec::len).sum();
        self.acting = before..before + signals.len();
        let signals = place.map_or_else(|| signals.to_vec(), |_| self.places.concat());
        let changed = self.signals != signals;
        let senses = self.senses.as_mut();
        let begun = senses.map_or(Ok(()), |senses| senses.begin(&signals));
        begun.map_err(|reason| self.own(reason))?;
        if changed {
            self.signals = signals;
            self.meet()?;
        }
        let pending = self.training.pending.take();
        if let Some(archive) = pending.or_else(|| self.training.model.clone().filter(|_| changed)) {
            self.adopt(&archive)?;
        }
        self.deciders.iter_mut().for_each(|own| own.unshown_s.clear());
        if self.training.validates {
            self.agents.iter_mut().for_each(|(agent, _)| agent.begin_validation());
        }
        Ok(vec![Drive::Decisions; self.acting.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        let decided = match self.fault.take() {
            Some(reason) => Err(reason),
            None => self.decide(observations, phases),
        };
        decided.map_err(|reason| self.own(reason))
    }

    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        if self.training.active && self.fault.is_none() {
            self.fault = self.learn(observations, truncated).err();
        }
    }

    /// Trains, from a checkpoint if there is one.
    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        self.training.decisions = trainer.decisions_per_episode();
        if let Some(checkpoint) = trainer.saved() {
            self.training.done = checkpoint.get("episodes")?;
            self.training.updated = checkpoint.get("updated")?;
            self.training.pending = Some(checkpoint);
        }
        self.start_seed = seed::restart(self.seed, trainer.restarts());
        self.training.active = true;
        while !trainer.stops() && self.training.done < self.training.episodes {
            let episode = self.training.done;
            self.training.curve = Curve::default();
            trainer.episode(self, episode)?;
            if let Some(reason) = self.fault.take() {
                return Err(self.own(reason));
            }
            if self.agents.is_empty() {
                break;
            }
            self.training.done += 1;
            // An episode without an update has no loss.
            let loss = self.training.curve.loss;
            let finite = loss.is_none_or(f64::is_finite);
            if !finite || !self.agents.iter().all(|(agent, _)| agent.kept().is_finite()) {
                let what = if finite { "a parameter" } else { "the loss" };
                return Err(ControlError::Diverged { episode, what });
            }
            self.training.updated |= loss.is_some();
            // With several agents one dead network is enough.
            let mut agents = self.agents.iter_mut();
            let is_alive = !self.training.updated || agents.all(|(a, _)| a.kept_mut().is_alive());
            if trainer.starts_again(is_alive) {
                (self.training.done, self.training.updated) = (0, false);
                self.training.curve = Curve::default();
                self.start_seed = seed::restart(self.seed, trainer.restarts());
                self.meet()?;
                continue;
            }
            self.training.active = false;
            let validated = trainer.validate(self);
            self.training.active = true;
            validated?;
            trainer.checkpoint(&|| self.archive(CHECKPOINT))?;
        }
        self.training.active = false;
        Ok(())
    }

    fn learn_on(&mut self, places: Vec<Vec<SignalSpec>>) -> Result<(), ControlError> {
        if !L::IS_SHARED || self.senses.is_some() {
            return Err(self.own("it shares nothing between several point MDPs".to_owned()));
        }
        self.places = places;
        Ok(())
    }

    fn set_reward_scale(&mut self, scale: f32) {
        self.reward_scale = scale;
    }

    fn set_senses(
        &mut self,
        name: &'static str,
        senses: Box<dyn Senses>,
    ) -> Result<(), ControlError> {
        self.name = name;
        self.senses = Some(senses);
        Ok(())
    }

    /// What to know of a training and its signals: that it was too short to learn anything, signals without a choice, and
    /// lanes that no phase serves.
    fn details(&self) -> BTreeMap<String, String> {
        let mut details = BTreeMap::new();
        let TrainingState { done, decisions, updated, .. } = self.training;
        if done > 0 && !updated {
            let text = format!(
                "too short for one update ({done} episodes of {decisions} decisions), so the model is as it began; \
                 train for more episodes"
            );
            details.insert(format!("training of {}", self.name), text);
        }
        for signal in &self.signals {
            if !decides(signal) {
                let text = "one phase, so nothing to control: it keeps its own program";
                details.insert(format!("signal {}", signal.id), text.to_owned());
            }
            let unserved = signal.unserved_lanes();
            if !unserved.is_empty() {
                let name = format!("lanes that no phase of {} serves", signal.id);
                details.insert(name, unserved.join(", "));
            }
        }
        details
    }

    fn figures(&self) -> BTreeMap<String, f64> {
        let Curve { reward, loss, entropy, epsilon } = self.training.curve;
        [("return", Some(reward)), ("loss", loss), ("entropy", entropy), ("epsilon", epsilon)]
            .into_iter()
            .filter_map(|(name, value)| Some((name.to_owned(), value?)))
            .collect()
    }

    fn model(&self) -> Option<Archive> {
        (!self.agents.is_empty()).then(|| self.archive(MODEL))
    }

    fn set_validation(&mut self, is_validation: bool) {
        self.training.validates = is_validation;
    }

    fn load(&mut self, model: Archive) -> Result<(), ControlError> {
        for (name, wanted, is_a) in [("kind", MODEL, ""), ("method", self.name, "model of ")] {
            let found: String = model.get(name)?;
            if found != wanted {
                let what = format!("{name} {wanted:?}; it is a {is_a}{found}");
                return Err(ArchiveError::Card(what).into());
            }
        }
        self.training.model = Some(model.clone());
        self.training.pending = Some(model);
        Ok(())
    }
}

/// Returns the phase that has to be next while a vehicle has waited too long: phases that serve such vehicles best take turns,
/// each for its share of the longest wait at most. One green now and then would not empty a long queue.
fn overdue(
    signal: &SignalSpec,
    seen: &Observation,
    unshown_s: &mut Vec<f64>,
    [decision_s, longest_s]: [f64; 2],
) -> Option<usize> {
    unshown_s.resize(signal.phases.len(), 0.0);
    unshown_s.iter_mut().for_each(|s| *s += decision_s);
    unshown_s[seen.phase] = 0.0;
    let wait_s = |phase: &usize| {
        let service = &signal.phases[*phase].service;
        let is_best = |m: &usize| signal.phases.iter().all(|p| p.service[*m] <= service[*m]);
        let served = (0..service.len()).filter(|m| service[*m] != Light::Red && is_best(m));
        let lanes = served.flat_map(|m| &signal.movements[m].lanes);
        lanes.map(|lane| seen.lanes[*lane].max_wait_s).fold(0.0, f64::max)
    };
    let waits = |phase: &usize| longest_s > 0.0 && wait_s(phase) > longest_s;
    let others = || (0..signal.phases.len()).filter(|phase| *phase != seen.phase);
    let shown_s = others().map(|phase| unshown_s[phase]).fold(f64::INFINITY, f64::min);
    let stays = shown_s < longest_s / signal.phases.len() as f64 && waits(&seen.phase);
    let next = || others().filter(waits).max_by(|a, b| unshown_s[*a].total_cmp(&unshown_s[*b]));
    if stays { Some(seen.phase) } else { next() }
}

/// Returns senses that see something of their own of a signal.
fn own_view(senses: &mut Option<Box<dyn Senses>>, signal: usize) -> Option<&mut Box<dyn Senses>> {
    senses.as_mut().filter(|senses| senses.width(signal).is_some())
}

/// Returns the mean, or nothing of nothing.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Whether a signal has more than one phase to choose from.
fn decides(signal: &SignalSpec) -> bool {
    signal.phases.len() >= MIN_PHASES
}

/// Shapes of signals, on which the networks of some learners depend: lanes and phases.
fn shapes(signals: &[SignalSpec]) -> Vec<BTreeMap<String, usize>> {
    let shape = |s: &SignalSpec| [("lanes", s.lanes.len()), ("phases", s.phases.len())];
    signals.iter().map(|s| shape(s).map(|(name, count)| (name.to_owned(), count)).into()).collect()
}

/// Checks that a model is for signals of this shape.
fn check_shape(archive: &Archive, signals: &[SignalSpec]) -> Result<(), ArchiveError> {
    let (found, wanted) = (archive.get("signals")?, shapes(signals));
    if found == wanted {
        return Ok(());
    }
    let [found, wanted] = [found, wanted].map(|shapes| {
        let count = |s: &BTreeMap<_, _>, name| s.get(name).copied().unwrap_or_default();
        let words = shapes.iter().map(|s| [count(s, "lanes"), count(s, "phases")]);
        let words = words.map(|[lanes, phases]| format!("{lanes} lanes and {phases} phases"));
        words.collect::<Vec<_>>().join(", ")
    });
    Err(ArchiveError::Unfit(format!("it is for signals of {found}, these have {wanted}")))
}

#[cfg(test)]
mod tests {
    use super::super::idqn::{Config, create};
    use super::super::state::LANE_WIDTH;
    use super::super::testing::{QueueWorld, observation, remembered, two_phase_signal};
    use super::super::{Controller, Observation, Setup};
    use super::overdue;

    fn small() -> Config {
        Config { hidden: 16, ..Config::default() }
    }

    fn learner(config: &Config, episodes: u32) -> Box<dyn Controller> {
        create(config, &Setup { seed: 7, episodes, ..Setup::default() })
    }

    #[test]
    fn the_end_of_an_episode_is_terminal_unless_it_is_asked_not_to_be() {
        let count = QueueWorld::DECISIONS as usize;
        for (bootstrap_at_time_limit, expected) in [(false, vec![count - 1]), (true, vec![])] {
            let mut world = QueueWorld::new(vec![two_phase_signal()]);
            let config = Config { bootstrap_at_time_limit, ..small() };
            learner(&config, 1).train(&mut world).unwrap();
            let state = world.kept.borrow_mut().pop().unwrap();
            let replay = remembered(&state, "signal0.replay.", 2 * LANE_WIDTH);
            let terminals = (0..count).filter(|place| replay.get(*place).terminal);
            assert_eq!(terminals.collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn a_training_too_short_for_one_update_says_so_also_when_it_was_continued() {
        let config = Config { learning_starts: 3 * QueueWorld::DECISIONS as usize, ..small() };
        let remark = |episodes| {
            let mut world = QueueWorld::new(vec![two_phase_signal()]);
            let mut whole = learner(&config, episodes);
            whole.train(&mut world).unwrap();
            world.saved = world.kept.borrow_mut().pop();
            let mut continued = learner(&config, episodes);
            continued.train(&mut world).unwrap();
            let [whole, continued] =
                [whole, continued].map(|l| l.details().get("training of idqn").cloned());
            assert_eq!(whole, continued);
            whole
        };
        let expected = format!(
            "too short for one update (2 episodes of {} decisions), so the model is as it began; \
             train for more episodes",
            QueueWorld::DECISIONS
        );
        assert_eq!((remark(2), remark(3)), (Some(expected), None));
    }

    #[test]
    fn a_phase_that_vehicles_wait_for_too_long_is_next() {
        let (signal, mut unshown_s) = (two_phase_signal(), Vec::new());
        let mut next = |phase, wait_s, longest_s| {
            let mut seen = Observation { phase, ..observation([1.0; 2], [0.0; 2]) };
            seen.lanes.iter_mut().for_each(|lane| lane.max_wait_s = wait_s);
            overdue(&signal, &seen, &mut unshown_s, [10.0, longest_s])
        };
        assert_eq!([20.0, 30.0, 40.0].map(|wait| next(0, wait, 25.0)), [None, Some(1), Some(1)]);
        assert_eq!([(20.0, 25.0), (90.0, 0.0)].map(|(wait, most)| next(0, wait, most)), [None; 2]);
        assert_eq!([90.0; 3].map(|wait| next(1, wait, 25.0)), [Some(1), Some(0), Some(0)]);
    }

    #[test]
    fn exploration_ends_after_four_fifths_of_the_episodes() {
        let mut world = QueueWorld::new(vec![two_phase_signal()]);
        learner(&small(), 10).train(&mut world).unwrap();
        let epsilons: Vec<f64> = world.figures.iter().map(|f| f["epsilon"]).collect();
        let expected = [0.875, 0.75, 0.625, 0.5, 0.375, 0.25, 0.125, 0.0, 0.0, 0.0];
        assert_eq!(epsilons, expected);
    }
}
