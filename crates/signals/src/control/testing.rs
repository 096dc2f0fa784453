//! Small signals and a small world for the tests of controllers.

use std::cell::RefCell;

use super::*;
use learners::nn::state::State as _;
use learners::rl::replay::Replay;

/// A signal with one lane, one movement and one phase per queue.
pub(crate) fn two_phase_signal() -> SignalSpec {
    let mut signal = signal_with(&[[Light::Protected, Light::Red], [Light::Red, Light::Protected]]);
    for (m, movement) in signal.movements.iter_mut().enumerate() {
        movement.downstream = vec![m];
    }
    signal
}

/// A signal whose movements have a lane each and are served as given, one row per phase.
pub(crate) fn signal_with<const M: usize>(service: &[[Light; M]]) -> SignalSpec {
    let lane = |m: usize| LaneSpec { id: format!("l{m}_0"), length_m: 200.0 };
    let movement = |m| Movement {
        index: 3 * m + 1,
        turn: Turn::Through,
        lanes: vec![m],
        downstream: vec![],
        inner: vec![],
        share: None,
    };
    let phase = |row: &[Light; M]| Phase {
        state: row.iter().map(|s| ['r', 'g', 'G'][*s as usize]).collect(),
        pair: (0..M).filter(|m| row[*m] == Light::Protected).take(2).collect(),
        service: row.to_vec(),
    };
    SignalSpec {
        id: "s".into(),
        lanes: (0..M).map(lane).collect(),
        movements: (0..M).map(movement).collect(),
        phases: service.iter().map(phase).collect(),
        onward: Vec::new(),
        limits: limits(service.len()),
    }
}

/// RESCO's limits for so many phases: 3 s of yellow between any two, 7 s of green.
pub(crate) fn limits(phases: usize) -> Limits {
    let change = |i, j| if i == j { 0.0 } else { 3.0 };
    Limits {
        min_green_s: vec![7.0; phases],
        needs: (0..phases).map(|i| Need::of_green(i, phases, 7)).collect(),
        max_green_s: vec![f64::INFINITY; phases],
        change_s: (0..phases).map(|i| (0..phases).map(|j| change(i, j)).collect()).collect(),
        min_cycle_s: 20.0,
        max_cycle_s: 120.0,
        own_program: true,
        arrows: false,
    }
}

pub(crate) fn observation(queues: [f64; 2], downstream: [f64; 2]) -> Observation {
    let lanes = queues.map(|queue| LaneObservation { queue, ..LaneObservation::default() });
    Observation {
        phase: 0,
        lanes: lanes.to_vec(),
        downstream_queue: downstream.to_vec(),
        seen: vec![0.0; 2],
    }
}

/// Signals whose lanes fill up and are emptied by their phase: serving the longest queue is best.
pub(crate) struct QueueWorld {
    signals: Vec<SignalSpec>,
    /// What a killed training left.
    pub(crate) saved: Option<Archive>,
    /// The state after every training episode.
    pub(crate) kept: RefCell<Vec<Archive>>,
    /// Episode in which the world ends, as a killed process does.
    pub(crate) dies_at: u32,
    /// What the controller said of every episode.
    pub(crate) figures: Vec<BTreeMap<String, f64>>,
    /// Factor on what is observed.
    pub(crate) scale: f64,
    /// Whether its signals stay at their first phase, whatever they are asked for.
    pub(crate) stubborn: bool,
    /// Whether it validates after every episode.
    pub(crate) validates: bool,
    /// Whether validation has ended the training.
    pub(crate) stops: bool,
    /// Episode, from 1, after which training starts again, once.
    pub(crate) starts_again_after: u32,
    restarts: u32,
}

impl QueueWorld {
    pub(crate) const DECISIONS: u32 = 30;

    pub(crate) fn new(signals: Vec<SignalSpec>) -> Self {
        Self {
            signals,
            saved: None,
            kept: RefCell::default(),
            dies_at: u32::MAX,
            figures: vec![],
            scale: 1.0,
            stubborn: false,
            validates: false,
            stops: false,
            starts_again_after: 0,
            restarts: 0,
        }
    }

    fn observe(&self, queues: &[Vec<f64>], phases: &[GreenPhase]) -> Vec<Observation> {
        let lane = |queue: &f64| LaneObservation {
            queue: queue * self.scale,
            total_wait_s: 10.0 * queue * self.scale,
            ..LaneObservation::default()
        };
        queues
            .iter()
            .zip(phases)
            .map(|(queues, phase)| Observation {
                phase: phase.0,
                lanes: queues.iter().map(lane).collect(),
                downstream_queue: vec![0.0; queues.len()],
                seen: vec![0.0; queues.len()],
            })
            .collect()
    }
}

impl Trainer for QueueWorld {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        if seed >= self.dies_at {
            return Err(ControlError::Episode("killed".into()));
        }
        let drives = controller.begin(&self.signals)?;
        let decides = drives.contains(&Drive::Decisions);
        let mut phases = vec![GreenPhase(0); self.signals.len()];
        let mut queues: Vec<Vec<f64>> =
            self.signals.iter().map(|s| vec![0.0; s.lanes.len()]).collect();
        let mut waiting = 0.0;
        for t in 0..Self::DECISIONS {
            if decides {
                controller.act(&self.observe(&queues, &phases), &mut phases)?;
                if self.stubborn {
                    phases.fill(GreenPhase(0));
                }
            }
            for (s, (queues, phase)) in queues.iter_mut().zip(&phases).enumerate() {
                // Two vehicles arrive per interval, for some time on the same lane.
                let lane = (t / 3 + seed + s as u32) as usize % queues.len();
                queues[lane] += 2.0;
                queues[phase.0] = 0.0;
                waiting += queues.iter().sum::<f64>();
            }
            if decides {
                let seen = self.observe(&queues, &phases);
                controller.observe(&seen, t + 1 == Self::DECISIONS);
            }
        }
        self.figures.push(controller.figures());
        Ok(EpisodeOutcome { delay_s: waiting, ..EpisodeOutcome::default() })
    }

    fn decisions_per_episode(&self) -> u32 {
        Self::DECISIONS
    }

    fn saved(&mut self) -> Option<Archive> {
        self.saved.take()
    }

    fn validate(&mut self, controller: &mut dyn Controller) -> Result<(), ControlError> {
        if self.validates {
            controller.set_validation(true);
            self.episode(controller, 1000)?;
            controller.set_validation(false);
        }
        Ok(())
    }

    fn stops(&self) -> bool {
        self.stops
    }

    fn restarts(&self) -> u32 {
        self.restarts
    }

    fn starts_again(&mut self, is_alive: bool) -> bool {
        assert!(is_alive, "what learns is alive");
        let again =
            self.restarts == 0 && self.kept.borrow().len() as u32 == self.starts_again_after;
        let again = again && self.starts_again_after > 0;
        self.restarts += u32::from(again);
        again
    }

    fn checkpoint(&mut self, state: &dyn Fn() -> Archive) -> Result<(), ControlError> {
        self.kept.borrow_mut().push(state());
        Ok(())
    }
}

/// Returns what a checkpoint remembers of decisions.
pub(crate) fn remembered(checkpoint: &Archive, prefix: &str, width: usize) -> Replay {
    let mut replay = Replay::new(10_000, width);
    replay.restore(prefix, checkpoint).unwrap();
    replay
}

/// Checks that a learner remembers the phase that was shown, not the one that it asked for.
///
/// # Arguments
///
/// * `prefix`, `width` — where its checkpoints have what is remembered, and the numbers of a state.
pub(crate) fn check_shown(learner: &mut dyn Controller, prefix: &str, width: usize) {
    let mut world = QueueWorld::new(vec![two_phase_signal()]);
    world.stubborn = true;
    learner.train(&mut world).unwrap();
    let last = world.kept.borrow_mut().pop().expect("a state per episode");
    let replay = remembered(&last, prefix, width);
    assert_eq!(replay.len(), 2 * QueueWorld::DECISIONS as usize);
    assert!((0..replay.len()).all(|place| replay.get(place).action == 0));
}

/// Checks what holds for every learner; `make` takes a number of episodes.
pub(crate) fn check_learner(make: &dyn Fn(u32) -> Box<dyn Controller>) {
    let signals = || vec![two_phase_signal()];
    let episodes = 120;
    let mut learner = make(episodes);
    let untrained = QueueWorld::new(signals()).episode(learner.as_mut(), 0).unwrap().delay_s;
    let mut world = QueueWorld::new(signals());
    learner = make(episodes);
    learner.train(&mut world).unwrap();
    let figures = learner.figures();
    assert!(figures["return"] < 0.0 && figures["return"].is_finite(), "{figures:?}");

    // It has learned something: serving the queue leaves nobody waiting.
    let trained = world.episode(learner.as_mut(), 0).unwrap().delay_s;
    assert!(trained < 0.7 * untrained, "{trained} after and {untrained} before training");

    // Killed and continued, it ends with the same bytes.
    let model = learner.model().expect("a learner has a model").to_bytes();
    let last = world.kept.borrow().last().expect("a state per episode").to_bytes();
    let mut killed = QueueWorld::new(signals());
    killed.dies_at = 47;
    make(episodes).train(&mut killed).unwrap_err();
    let mut world = QueueWorld::new(signals());
    world.saved = killed.kept.borrow_mut().pop();
    let mut continued = make(episodes);
    continued.train(&mut world).unwrap();
    assert!(world.kept.borrow().last().unwrap().to_bytes() == last);
    assert_eq!(world.kept.borrow().len() as u32, episodes - killed.dies_at);

    // What was kept where a training ends early is not trained further.
    let mut ended = QueueWorld::new(signals());
    ended.saved = killed.kept.borrow_mut().pop();
    ended.stops = true;
    make(episodes).train(&mut ended).unwrap();
    assert!(ended.kept.borrow().is_empty());

    // Validation disturbs neither what is learned nor what evaluation draws.
    let few = 30;
    let short = |change: &dyn Fn(&mut QueueWorld)| {
        let mut world = QueueWorld::new(signals());
        change(&mut world);
        let mut learner = make(few);
        learner.train(&mut world).unwrap();
        let delay_s = QueueWorld::new(signals()).episode(learner.as_mut(), 0).unwrap().delay_s;
        let kept = world.kept.borrow();
        (kept.len() as u32, kept.last().unwrap().to_bytes(), delay_s)
    };
    let plain = short(&|_| ());
    assert!(short(&|world| world.validates = true) == plain);

    // Started again, it learns something else, and what it then learns follows from its seed.
    let again = || short(&|world| world.starts_again_after = 3);
    let second = again();
    assert_eq!(second.0, 3 + few);
    assert!(second.1 != plain.1 && second == again());

    // The model does in another controller what it did in this one.
    let (first, second) = (
        world.episode(continued.as_mut(), 1).unwrap().delay_s,
        world.episode(continued.as_mut(), 2).unwrap().delay_s,
    );
    let model_file = continued.model().unwrap();
    assert!(model_file.to_bytes() == model);
    let mut other = make(episodes);
    other.load(model_file.clone()).unwrap();
    assert_eq!(world.episode(other.as_mut(), 1).unwrap().delay_s, first);
    assert_eq!(world.episode(other.as_mut(), 2).unwrap().delay_s, second);

    // A checkpoint is no model, and neither is a model of another method.
    let checkpoint = world.kept.borrow_mut().pop().unwrap();
    let e = make(episodes).load(checkpoint).unwrap_err().to_string();
    assert!(e.contains("it is a checkpoint"), "{e}");
    let mut foreign = model_file;
    foreign.put("method", "max-pressure");
    let e = make(episodes).load(foreign).unwrap_err().to_string();
    assert!(e.contains("it is a model of max-pressure"), "{e}");

    // With a single phase there is nothing to learn.
    let single = signal_with(&[[Light::Protected, Light::Red]]);
    let mut world = QueueWorld::new(vec![single.clone()]);
    let mut idle = make(episodes);
    idle.train(&mut world).unwrap();
    assert_eq!(idle.begin(&[single]).unwrap(), [Drive::Decisions]);
    assert!(idle.model().is_none() && world.kept.borrow().is_empty());
    let details = idle.details();
    assert!(details["signal s"].contains("nothing to control"), "{details:?}");
    assert_eq!(details["lanes that no phase of s serves"], "l1_0");

    // Numbers that are none end the training.
    let mut world = QueueWorld::new(signals());
    world.scale = f64::NAN;
    let e = make(episodes).train(&mut world).unwrap_err();
    assert!(matches!(e, ControlError::Diverged { .. }), "{e}");
}
