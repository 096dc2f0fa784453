//! A controller on the signals of a world: what evaluation sees of the two is one object.

use std::collections::BTreeMap;

use super::control::fixed_time::{KEPT, SETTING, SIMULATIONS, TUNING};
use super::control::{ControlError, Controller, EpisodeOutcome, Trainer};
use super::controllers::create;
use super::env::SignalEnv;
use super::env::by_movement::MovementTotals;
use super::env::episode::{EpisodeError, EpisodeMetrics, run_episode};
use super::movement_results;
use super::settings::Scenario;
use super::sim::{Sim, SimError};
use super::street_results::ByStreet;
use basics::files::numbers::is_usable;
use basics::seed;
use evaluation::run::domain::{Course, Policy, Trial};
use evaluation::run::fault::TrialError;
use evaluation::run::method::{Method, Training};
use evaluation::run::search::{Choice, tune};
use evaluation::run::together::Together;
use evaluation::settings::overrides::{number, with_numbers};
use evaluation::stats::objectives::best_and_last;
use evaluation::store::input_files::InputFiles;
use evaluation::store::opaque::Opaque;
use evaluation::store::record::{Metrics, Row, RowKind};
use learners::nn::archive::Archive;

/// Name of the metric that scores compare.
pub const DELAY: &str = "delay_s";

/// Name of the metric that counts the vehicles of an episode, also those that did not enter or arrive.
pub const VEHICLES: &str = "vehicles_veh";

/// Name of the metric of people on foot, where they count.
pub const PEDESTRIAN_DELAY: &str = "pedestrian_delay_s";

/// Metric: crosswalks without any walk, which are not in the delay on foot; absent where there are none.
pub const UNSERVED: &str = "unserved_crosswalks";

/// Name of the detail that says which vehicle stood for [`STANDING_S`](super::env::standing::STANDING_S) or longer.
pub const STANDING: &str = "standing";

/// Training episodes over which RESCO's users see a learner's last performance.
const RESCO_LAST: usize = 10;

/// A controller and the signals that it controls.
pub struct SignalTrial<S> {
    /// The signals: those of one point MDP, or of each that it has together.
    pub envs: Vec<SignalEnv<S>>,
    together: Together,
    /// The method.
    pub controller: Box<dyn Controller>,
    /// What is read while it goes on.
    pub held: InputFiles,
    /// The method whose settings are tuned, the scenario, whether it is imported, and the seed; then what was chosen, as details.
    pub tuned: Option<(Method, Scenario, bool, u64)>,
    chosen: BTreeMap<String, String>,
    /// What the evaluation episodes so far are made of.
    movements: Vec<Vec<MovementTotals>>,
    streets: ByStreet,
    standing: Option<String>,
}

impl<S> SignalTrial<S> {
    /// Returns a controller on signals.
    pub fn new(envs: Vec<SignalEnv<S>>, controller: Box<dyn Controller>, held: InputFiles) -> Self {
        let (movements, streets, chosen) = (Vec::new(), ByStreet::default(), BTreeMap::new());
        let (together, tuned, standing) = (Together::default(), None, None);
        Self { envs, together, controller, held, tuned, chosen, movements, streets, standing }
    }
}

impl<S: Sim> SignalTrial<S> {
    /// Makes it one on several point MDPs, on each of which the baseline is played first.
    /// * `baseline` — with the power of its queue by which rewards are divided.
    pub fn share(
        &mut self,
        mut together: Together,
        (mut baseline, power): (Box<dyn Controller>, f64),
    ) -> Result<(), TrialError> {
        for (env, member) in self.envs.iter_mut().zip(&together.members) {
            let mut means = [0.0; 2];
            for k in 0..BASELINE_EPISODES {
                let seed = seed::at_point(seed::validation(0, k), &member.content);
                let metrics = played(env, baseline.as_mut(), seed)?.0;
                let values = [metrics[DELAY], metrics[QUEUE]];
                means = [0, 1].map(|i| means[i] + values[i] / f64::from(BASELINE_EPISODES));
            }
            together.baseline.push([means[0], means[1].max(LEAST_QUEUE_VEH).powf(-power)]);
        }
        self.together = together;
        let places = self.envs.iter().map(|env| env.signals().to_vec()).collect();
        Ok(self.controller.learn_on(places)?)
    }

    /// Returns everything but the controller, which meets it.
    fn learned(&mut self) -> Learned<'_, S> {
        let Self { envs, together, controller, .. } = self;
        Learned { envs, together, controller: controller.as_mut() }
    }
}

/// Episodes by which the baseline is known on each of several point MDPs.
const BASELINE_EPISODES: u32 = 2;

/// Shortest mean queue by which rewards are divided, vehicles.
const LEAST_QUEUE_VEH: f64 = 0.1;

/// Name of the metric by which rewards are scaled.
const QUEUE: &str = "queue_veh";

impl<S: Sim> Trial for SignalTrial<S> {
    fn train(&mut self, course: &mut dyn Course) -> Result<(), TrialError> {
        let Self { envs, together, controller, held, chosen, .. } = self;
        let mut school = School { envs, together, course, held };
        let Some((method, scenario, imported, seed)) = self.tuned.take() else {
            return Ok(controller.train(&mut school)?);
        };
        let Training::Tuned { episodes } = method.training else { return Ok(()) };
        let start =
            method.tunes.iter().map(|(s, _)| (*s, number(&scenario.sections(), s))).collect();
        let make = |choice: &Choice<'_>| {
            let other = with_numbers(&scenario, choice.iter().copied());
            let controller = create(method.name, &other, imported, seed);
            (other.signal.delta_time_s, controller.expect("it was made before"))
        };
        let (mut used, most) = (0, number(&scenario.sections(), episodes) as u32);
        let choice = tune(&start, method.tunes, most, &mut |choice, seed| {
            used += 1;
            (school.envs[0].signal_settings.delta_time_s, *controller) = make(choice);
            school.episode(controller.as_mut(), seed).map(|played| played.delay_s)
        })?;
        (envs[0].signal_settings.delta_time_s, *controller) = make(&choice);
        chosen.extend(choice.iter().map(|(name, v)| (format!("{SETTING}{name}"), v.to_string())));
        chosen.insert(SIMULATIONS.to_owned(), used.to_string());
        chosen.extend((choice == start).then(|| (TUNING.to_owned(), KEPT.to_owned())));
        Ok(())
    }

    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        if !self.together.members.is_empty() {
            return self.learned().play(seed);
        }
        let env = &mut self.envs[0];
        env.collects_movements = true;
        let played = played(env, self.controller.as_mut(), seed);
        env.collects_movements = false;
        let (metrics, parts) = played?;
        self.movements.push(parts.movements);
        self.streets.add(parts.streets);
        let standing = parts.standing.map(|text| format!("{text} with the seed {seed}"));
        self.standing = self.standing.take().or(standing);
        Ok(metrics)
    }

    fn validate(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        self.learned().episode(seed)
    }

    fn model(&self) -> Option<Archive> {
        self.controller.model()
    }

    /// Another policy is evaluated from here on.
    fn load(&mut self, model: &Archive) -> Result<(), TrialError> {
        (self.movements, self.streets, self.standing) = (Vec::new(), ByStreet::default(), None);
        Ok(self.controller.load(model.clone())?)
    }

    fn training_metrics(&self, rows: &[Row]) -> Metrics {
        // Episodes on several point MDPs have no best one.
        if self.envs.len() > 1 { Metrics::new() } else { resco(rows) }
    }

    /// What the controller says, the phases of signals that run in two rings, and who stood for long.
    fn details(&self) -> BTreeMap<String, String> {
        let mut details = self.controller.details();
        details.extend(self.chosen.clone());
        details.extend(self.together.details());
        let rings = self.envs[0].dual_rings();
        details.extend(rings.map(|(signal, phases)| (format!("phases {signal}"), phases)));
        details.extend(self.standing.iter().map(|text| (STANDING.to_owned(), text.clone())));
        details
    }

    /// What the signals ran: programs, or phases in two rings; nothing where a controller decides.
    fn programs(&self) -> Opaque {
        let programs = self.envs[0].programs();
        let is_one = self.envs.len() == 1 && !programs.is_empty();
        if is_one { Opaque::of(&programs) } else { Opaque::default() }
    }

    /// Results by movement, means over the evaluation episodes, where ways of vehicles are known; else those by street, where
    /// there are several signals.
    fn parts(&self) -> Opaque {
        let results = movement_results::results(&self.movements);
        match (results.is_empty(), self.streets.streets.is_empty()) {
            (false, _) => Opaque::of(&results),
            (true, false) => Opaque::of(&self.streets),
            (true, true) => Opaque::default(),
        }
    }

    fn simulator_s(&self) -> f64 {
        simulator_s(&self.envs)
    }

    fn verify(&self) -> Result<(), TrialError> {
        Ok(self.held.verify()?)
    }
}

/// Returns the wall-clock time within the simulator so far, seconds.
fn simulator_s<S>(envs: &[SignalEnv<S>]) -> f64 {
    envs.iter().map(|env| env.simulator.as_secs_f64()).sum()
}

/// Plays the episode of a seed and returns its metrics by name, and all that it is judged by.
fn played<S: Sim>(
    env: &mut SignalEnv<S>,
    controller: &mut dyn Controller,
    seed: u64,
) -> Result<(Metrics, EpisodeMetrics), TrialError> {
    let metrics = run_episode(env, controller, seed).map_err(|e| match e {
        EpisodeError::Sim(e) => TrialError::from(e),
        EpisodeError::Control(e) => e.into(),
    })?;
    Ok((named(&metrics, seed)?, metrics))
}

/// What a controller has learned so far, on the signals on which it trains.
struct Learned<'a, S> {
    envs: &'a mut [SignalEnv<S>],
    together: &'a Together,
    controller: &'a mut dyn Controller,
}

impl<S: Sim> Learned<'_, S> {
    /// Plays the episode of a seed; on several point MDPs a seed of its own on each.
    fn play(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        if self.together.members.is_empty() {
            return Ok(played(&mut self.envs[0], self.controller, seed)?.0);
        }
        let members = self.envs.iter_mut().zip(&self.together.members);
        let all = members.map(|(env, member)| {
            Ok(played(env, self.controller, seed::at_point(seed, &member.content))?.0)
        });
        let all = all.collect::<Result<Vec<_>, TrialError>>()?;
        Ok(self.together.mean(&all, DELAY))
    }
}

impl<S: Sim> Policy for Learned<'_, S> {
    fn episode(&mut self, seed: u64) -> Result<Metrics, TrialError> {
        self.controller.set_validation(true);
        let metrics = self.play(seed);
        self.controller.set_validation(false);
        metrics
    }

    fn model(&self) -> Option<Archive> {
        self.controller.model()
    }
}

/// Where a controller trains: the signals, and the task that keeps what comes of it.
struct School<'a, S> {
    envs: &'a mut [SignalEnv<S>],
    together: &'a Together,
    course: &'a mut dyn Course,
    held: &'a InputFiles,
}

impl<S: Sim> Trainer for School<'_, S> {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let member = self.together.schedule.get(seed as usize).copied();
        if let Some(member) = member {
            controller.set_reward_scale(self.together.baseline[member][1] as f32);
        }
        let seed = self.course.seed(seed);
        let env = &mut self.envs[member.unwrap_or(0)];
        let metrics = run_episode(env, controller, seed).map_err(|e| match e {
            EpisodeError::Control(e) => e,
            sim @ EpisodeError::Sim(_) => ControlError::Episode(Box::new(sim)),
        })?;
        let failed = |e: SimError| ControlError::Episode(Box::new(EpisodeError::Sim(e)));
        let outcome = metrics.outcome().ok_or_else(|| failed(SimError::NoVehicles(seed)))?;
        let mut metrics = named(&metrics, seed).map_err(failed)?;
        // No file takes infinities; a figure that is no number to compute with is left out.
        for (name, value) in controller.figures().into_iter().filter(|(_, v)| is_usable(*v)) {
            metrics.entry(name).or_insert(value);
        }
        // Which it was on, from 1, in the order of the manifest.
        metrics.extend(member.map(|member| ("member".to_owned(), (member + 1) as f64)));
        self.course.episode(seed, metrics);
        Ok(outcome)
    }

    fn decisions_per_episode(&self) -> u32 {
        self.envs[0].decisions_per_episode()
    }

    fn saved(&mut self) -> Option<Archive> {
        self.course.saved()
    }

    fn validate(&mut self, controller: &mut dyn Controller) -> Result<(), ControlError> {
        let mut learned = Learned { envs: self.envs, together: self.together, controller };
        self.course.validate(&mut learned).map_err(|e| ControlError::Validation(Box::new(e)))
    }

    fn stops(&self) -> bool {
        self.course.stops()
    }

    fn restarts(&self) -> u32 {
        self.course.restarts()
    }

    fn starts_again(&mut self, is_alive: bool) -> bool {
        self.course.starts_again(is_alive)
    }

    fn checkpoint(&mut self, state: &dyn Fn() -> Archive) -> Result<(), ControlError> {
        // What was learned from files of something else is not kept.
        self.held.verify().map_err(|e| ControlError::Episode(e.into()))?;
        Ok(self.course.checkpoint(state, simulator_s(self.envs))?)
    }
}

/// Returns what RESCO reports of a learner: the delay in its best training episode, and beside it the
/// mean over its last ten. Both are of training, on training seeds and with exploration; the best of
/// many episodes is optimistic, and worst for methods that are unstable. Scores do not use them.
///
/// Deviation: RESCO takes the best episode of the curve that is averaged over several trainings;
/// here it is the best of each training.
///
/// Source: RESCO, utils/graph.py (the minimum of the curve for learners, the mean for others).
fn resco(rows: &[Row]) -> Metrics {
    let training = rows.iter().filter(|row| row.kind == RowKind::Training);
    let delays: Vec<f64> = training.filter_map(|r| r.metrics.get(DELAY).copied()).collect();
    let both = best_and_last(&delays, RESCO_LAST).into_iter();
    let both = both
        .flat_map(|both| ["resco_best_delay_s", "resco_last_ten_delay_s"].into_iter().zip(both));
    both.map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Returns the metrics of the episode of a seed by name.
/// Fails with [`SimError::NoVehicles`]: without vehicles there is nothing to judge, and a delay of 0 would be the
/// best one.
pub fn named(metrics: &EpisodeMetrics, seed: u64) -> Result<Metrics, SimError> {
    let trips = &metrics.trips;
    let (Some(delay_s), Some(waiting_s)) = (metrics.delay_s(), metrics.waiting_s()) else {
        return Err(SimError::NoVehicles(seed));
    };
    let named = [
        (DELAY, delay_s),
        ("waiting_s", waiting_s),
        (QUEUE, metrics.queue_veh),
        ("max_queue_veh", metrics.max_queue_veh),
        (VEHICLES, f64::from(trips.vehicles)),
        ("throughput_veh", f64::from(trips.arrived)),
        ("unfinished_veh", f64::from(trips.running + trips.undeparted)),
        ("undeparted_veh", f64::from(trips.undeparted)),
        ("teleports", f64::from(metrics.counts.teleports)),
        ("collisions", f64::from(metrics.counts.collisions)),
    ];
    let people = [
        ("pedestrians", metrics.pedestrians.map(f64::from)),
        (PEDESTRIAN_DELAY, metrics.people.delay_s()),
        (UNSERVED, Some(metrics.people.unserved).filter(|count| *count > 0).map(f64::from)),
    ];
    let people = people.into_iter().filter_map(|(name, value)| Some((name, value?)));
    let all = named.into_iter().chain(people);
    Ok(all.map(|(name, value)| (name.to_owned(), value)).collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::mpsc;

    use super::super::control::{Drive, GreenPhase, Observation, SignalSpec};
    use super::super::env::testing::{env, env_of, minute};
    use super::*;
    use basics::files::FileError;
    use evaluation::run::fault::CheckpointError;

    /// Trains for two episodes and has figures, one of which is no number.
    struct Learner;

    impl Controller for Learner {
        fn name(&self) -> &'static str {
            "learner"
        }
        fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
            Ok(vec![Drive::Decisions; signals.len()])
        }
        fn act(
            &mut self,
            _: &[Observation],
            phases: &mut [GreenPhase],
        ) -> Result<(), ControlError> {
            phases[0] = GreenPhase(0);
            Ok(())
        }
        fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
            (0..2).try_for_each(|seed| trainer.episode(self, seed).map(drop))
        }
        fn figures(&self) -> BTreeMap<String, f64> {
            let figures = [("loss", 0.5), ("epsilon", f64::NAN), ("delay_s", -1.0)];
            figures.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
        }
    }

    /// Keeps the rows of a training.
    #[derive(Default)]
    struct Rows(Vec<Row>);

    impl Course for Rows {
        fn seed(&self, index: u32) -> u64 {
            100 + u64::from(index)
        }
        fn episode(&mut self, seed: u64, metrics: Metrics) {
            let episode = self.0.len() as u32;
            self.0.push(Row { kind: RowKind::Training, episode, seed, metrics });
        }
        fn saved(&mut self) -> Option<Archive> {
            None
        }
        fn checkpoint(&mut self, _: &dyn Fn() -> Archive, _: f64) -> Result<(), CheckpointError> {
            Ok(())
        }
    }

    #[test]
    fn a_training_row_has_the_figures_of_the_learner_that_are_numbers() {
        let dir = tempfile::tempdir().unwrap();
        let (sender, got) = mpsc::channel();
        let routes = Box::new(move |seed, _: &Path| {
            sender.send(seed).unwrap();
            Ok(())
        });
        let env = env_of(minute(Some(routes)), vec![(0.0, 0), (1.0, 1)], dir.path());
        let mut trial = SignalTrial::new(vec![env], Box::new(Learner), InputFiles::default());
        let mut rows = Rows::default();
        trial.train(&mut rows).unwrap();
        let metrics = &rows.0[0].metrics;
        assert_eq!(metrics["loss"], 0.5);
        assert!(metrics[DELAY] > 0.0, "what was measured counts");
        assert!(!metrics.contains_key("epsilon"));
        assert!(!trial.episode(7).unwrap().contains_key("loss"));
        assert_eq!(rows.0.iter().map(|r| r.seed).collect::<Vec<_>>(), [100, 101]);
        assert!(got.try_iter().eq([100, 101, 7]), "vehicles have the seed of the row");
        let best = rows.0.iter().map(|r| r.metrics[DELAY]).fold(f64::INFINITY, f64::min);
        let summary = trial.training_metrics(&rows.0);
        assert_eq!(summary["resco_best_delay_s"], best);
        let mean = (rows.0[0].metrics[DELAY] + rows.0[1].metrics[DELAY]) / 2.0;
        assert_eq!(summary["resco_last_ten_delay_s"], mean);
        assert_eq!(resco(&[]), Metrics::new());
    }

    #[test]
    fn an_episode_without_vehicles_is_an_error_and_no_delay_of_0() {
        let dir = tempfile::tempdir().unwrap();
        let env = env(vec![], dir.path());
        let mut trial = SignalTrial::new(vec![env], Box::new(Learner), InputFiles::default());
        let e = trial.episode(7).unwrap_err();
        assert!(matches!(e, TrialError::Input(_)));
        assert!(e.to_string().starts_with("no vehicle is to depart in the episode of seed 7, so"));
    }

    #[test]
    fn a_disk_error_in_a_training_episode_is_the_machine_s_fault() {
        let file = || FileError::at("write", Path::new("x"))(std::io::Error::other("full"));
        let episode = |e| TrialError::from(ControlError::Episode(Box::new(EpisodeError::Sim(e))));
        assert!(matches!(episode(SimError::Io(file())), TrialError::Machine(_)));
        assert!(matches!(episode(SimError::CutOff("t.xml".into())), TrialError::Machine(_)));
        assert!(matches!(
            TrialError::from(ControlError::Checkpoint(file().into())),
            TrialError::Machine(_)
        ));
        assert!(matches!(episode(SimError::NotRunning), TrialError::Failed(_)));
    }
}
