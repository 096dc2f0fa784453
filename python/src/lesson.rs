//! A training that Python drives: what the library calls back is turned inside out.
//!
//! The simulation stays on its thread, which waits for what the class asks for: an episode, a step, its end. The class
//! trains on a thread of its own. One of the two is at work at any time.

use std::collections::BTreeMap;
use std::mem;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use tsc_family::traffic::control::{
    ControlError, Controller, Drive, EpisodeOutcome, GreenPhase, Observation, SignalSpec, Trainer,
};

use crate::answer::choose;
use crate::error::{explained, raised};
use crate::object::Guard;
use crate::observation::{Frame, PyObservation};
use crate::signals::{PySignal, Sizes, signals};
use crate::view;

/// What the class asks for.
enum Request {
    Reset,
    Step(Vec<GreenPhase>),
    Finish,
    Validate,
}

enum Reply {
    /// What the signals' detectors tell, and whether the episode is over.
    Seen(Vec<Observation>, bool),
    Finished(EpisodeOutcome),
    /// It was validated; whether training goes on.
    Validated(bool),
    /// There is nothing more, and why.
    Over(String),
}

/// Validates what a class has learned so far.
pub(crate) type Validate<'a> = dyn FnMut(&mut dyn Trainer) -> Result<(), ControlError> + 'a;

/// Figures that the class has logged since the last row.
type Figures = Arc<Mutex<BTreeMap<String, f64>>>;

/// Signals as the simulation describes them, once it has.
type Specs = Arc<Mutex<Vec<SignalSpec>>>;

/// The class's end of a training.
#[pyclass(frozen, module = "tsc_family._native")]
pub(crate) struct Lesson {
    /// None when the training is over.
    requests: Mutex<Option<Sender<Request>>>,
    replies: Mutex<Receiver<Reply>>,
    figures: Figures,
    specs: Specs,
    seen: Mutex<Vec<Observation>>,
    frame: Mutex<Option<Arc<Frame>>>,
    guard: Guard,
    /// Decisions of an episode.
    #[pyo3(get)]
    decisions: u32,
}

#[pymethods]
impl Lesson {
    /// Starts the next episode, and gives up one that goes on.
    fn reset<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyObservation>> {
        let (seen, _) = self.seen(py, Request::Reset)?;
        self.observation(py, &seen)
    }

    /// Asks for phases and lets the interval go by; says whether the episode is over.
    fn step<'py>(
        &self,
        py: Python<'py>,
        phases: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyObservation>, bool)> {
        let specs = locked(&self.specs).clone();
        let mut chosen = vec![GreenPhase(0); specs.len()];
        choose(phases, &specs, &mut chosen).map_err(|e| raised(format!("step() got {e}")))?;
        let (seen, over) = self.seen(py, Request::Step(chosen))?;
        Ok((self.observation(py, &seen)?, over))
    }

    /// What came of the episode that is over: mean delay per vehicle, seconds.
    fn finish(&self, py: Python<'_>) -> PyResult<f64> {
        match self.ask(py, Request::Finish)? {
            Reply::Finished(outcome) => Ok(outcome.delay_s),
            Reply::Over(reason) => Err(raised(reason)),
            _ => Err(raised("no episode is over")),
        }
    }

    /// Validates what was learned so far, if that is due; says whether training goes on.
    fn validate(&self, py: Python<'_>) -> PyResult<bool> {
        match self.ask(py, Request::Validate)? {
            Reply::Validated(goes_on) => Ok(goes_on),
            Reply::Over(reason) => Err(raised(reason)),
            _ => Err(raised("no episode is over")),
        }
    }

    /// Adds a figure to the row of the episode.
    fn log(&self, name: String, value: f64) {
        locked(&self.figures).insert(name, value);
    }

    /// What may be known of the signals; there is an episode.
    fn signals(&self, py: Python<'_>) -> PyResult<Vec<Py<PySignal>>> {
        let specs = locked(&self.specs);
        signals(py, &specs, Sizes::of(&specs))
    }

    /// Room that the signals need, by name.
    fn sizes(&self) -> BTreeMap<&'static str, usize> {
        Sizes::of(&locked(&self.specs)).named()
    }

    /// What a signal's detectors tell.
    fn observe<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyObservation>> {
        let (specs, seen) = (locked(&self.specs), locked(&self.seen));
        let frame = Frame::new(py, std::slice::from_ref(&specs[signal]), Sizes::of(&specs))?;
        frame.observe(py, std::slice::from_ref(&seen[signal]))
    }

    /// What IDQN sees of a signal.
    fn idqn<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (specs, seen) = (locked(&self.specs), locked(&self.seen));
        view::idqn(py, (&specs[signal], &seen[signal]), Sizes::of(&specs))
    }

    /// What MPLight sees of a signal.
    fn mplight<'py>(&self, py: Python<'py>, signal: usize) -> Bound<'py, PyArray1<f32>> {
        let (specs, seen) = (locked(&self.specs), locked(&self.seen));
        view::mplight(py, (&specs[signal], &seen[signal]), Sizes::of(&specs))
    }

    /// What IDQN is paid for.
    fn wait(&self, signal: usize) -> f32 {
        view::wait(&locked(&self.seen)[signal])
    }

    /// What MPLight is paid for.
    fn pressure(&self, signal: usize) -> f32 {
        view::pressure(&locked(&self.seen)[signal])
    }
}

impl Lesson {
    fn ask(&self, py: Python<'_>, request: Request) -> PyResult<Reply> {
        // A copy of this process ends here.
        self.guard.check("train").map_err(raised)?;
        let over = || raised("the training is over");
        let sent = locked(&self.requests).as_ref().map(|requests| requests.send(request));
        sent.ok_or_else(over)?.map_err(|_| over())?;
        py.detach(|| locked(&self.replies).recv()).map_err(|_| over())
    }

    fn seen(&self, py: Python<'_>, request: Request) -> PyResult<(Vec<Observation>, bool)> {
        match self.ask(py, request)? {
            Reply::Seen(seen, over) => {
                locked(&self.seen).clone_from(&seen);
                Ok((seen, over))
            }
            Reply::Over(reason) => Err(raised(reason)),
            _ => Err(raised("the episode is over; call reset() first")),
        }
    }

    fn observation<'py>(
        &self,
        py: Python<'py>,
        seen: &[Observation],
    ) -> PyResult<Bound<'py, PyObservation>> {
        // Signals are the same in all episodes, and so are the masks.
        let known = locked(&self.frame).clone();
        let frame = match known {
            Some(frame) => frame,
            None => {
                let specs = locked(&self.specs).clone();
                let frame = Frame::new(py, &specs, Sizes::of(&specs))?;
                Arc::clone(locked(&self.frame).insert(Arc::new(frame)))
            }
        };
        frame.observe(py, seen)
    }
}

/// The simulation's end: a controller whose phases come from the class.
struct Pupil {
    name: &'static str,
    requests: Receiver<Request>,
    replies: Sender<Reply>,
    figures: Figures,
    specs: Specs,
    /// What was asked for when the episode was over or given up.
    next: Option<Request>,
    /// Whether the episode was given up before its end.
    given_up: bool,
}

impl Pupil {
    fn give_up(&mut self, next: Option<Request>) -> ControlError {
        (self.next, self.given_up) = (next, true);
        ControlError::Own { method: self.name, reason: "the episode was given up".to_owned() }
    }
}

impl Controller for Pupil {
    fn name(&self) -> &'static str {
        self.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        *locked(&self.specs) = signals.to_vec();
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(&mut self, seen: &[Observation], phases: &mut [GreenPhase]) -> Result<(), ControlError> {
        // Whoever has gone away is noticed by what comes next.
        let _ = self.replies.send(Reply::Seen(seen.to_vec(), false));
        loop {
            match self.requests.recv() {
                Ok(Request::Step(chosen)) => {
                    phases.copy_from_slice(&chosen);
                    return Ok(());
                }
                Ok(Request::Finish) => {
                    let reason = "the episode is not over: step() has not said so".to_owned();
                    let _ = self.replies.send(Reply::Over(reason));
                }
                Ok(Request::Validate) => {
                    let reason = "the episode is not over; call validate() between episodes";
                    let _ = self.replies.send(Reply::Over(reason.to_owned()));
                }
                Ok(Request::Reset) => return Err(self.give_up(Some(Request::Reset))),
                Err(_) => return Err(self.give_up(None)),
            }
        }
    }

    /// The row of an episode is written when something else is asked for, so that it has what is logged until then.
    fn observe(&mut self, seen: &[Observation], truncated: bool) {
        if !truncated {
            return;
        }
        let _ = self.replies.send(Reply::Seen(seen.to_vec(), true));
        self.next = loop {
            match self.requests.recv() {
                Ok(Request::Step(_)) => {
                    let reason = "the episode is over; call reset() first".to_owned();
                    let _ = self.replies.send(Reply::Over(reason));
                }
                Ok(request) => break Some(request),
                Err(_) => break None,
            }
        };
    }

    fn figures(&self) -> BTreeMap<String, f64> {
        mem::take(&mut *locked(&self.figures))
    }
}

/// `validate`: validates what the object has learned so far.
/// Fails with [`ControlError::Own`] with what its `train` raised; whatever an episode fails for.
pub(crate) fn teach(
    name: &'static str,
    object: Py<PyAny>,
    episodes: u32,
    trainer: &mut dyn Trainer,
    validate: &mut Validate<'_>,
) -> Result<(), ControlError> {
    let own = |reason: String| ControlError::Own { method: name, reason };
    let (to_simulation, requests) = channel();
    let (replies, from_simulation) = channel();
    let (figures, specs) = (Figures::default(), Specs::default());
    let lesson = Lesson {
        requests: Mutex::new(Some(to_simulation)),
        replies: Mutex::new(from_simulation),
        figures: Arc::clone(&figures),
        specs: Arc::clone(&specs),
        seen: Mutex::default(),
        frame: Mutex::default(),
        decisions: trainer.decisions_per_episode(),
        guard: Guard::new(),
    };
    let guard = Guard::new();
    let work = move || {
        Python::attach(|py| {
            let lesson = Py::new(py, lesson).map_err(|e| explained(py, &e))?;
            let held = lesson.clone_ref(py);
            let module = py.import("tsc_family._training").map_err(|e| explained(py, &e))?;
            let result = module.call_method1("train", (object, lesson, episodes));
            // The object may have kept what it was given.
            locked(&held.get().requests).take();
            guard.check("train")?;
            result.map(drop).map_err(|e| explained(py, &e))
        })
    };
    let thread = thread::Builder::new().name("train".to_owned()).spawn(work);
    let thread = thread.map_err(|e| own(format!("no thread for train(): {e}")))?;
    let (next, given_up) = (None, false);
    let mut pupil = Pupil { name, requests, replies, figures, specs, next, given_up };
    let played = play(&mut pupil, trainer, validate);
    if let Err(e) = &played {
        let reason = format!("the training is over: {e}");
        let _ = pupil.replies.send(Reply::Over(reason));
    }
    // Whoever still waits for the simulation is told that there is none.
    drop(pupil);
    let trained: Result<(), String> =
        thread.join().unwrap_or_else(|_| Err("train() broke off".to_owned()));
    played.and(trained.map_err(own))
}

fn play(
    pupil: &mut Pupil,
    trainer: &mut dyn Trainer,
    validate: &mut Validate<'_>,
) -> Result<(), ControlError> {
    let mut episode = 0;
    let mut over: Option<EpisodeOutcome> = None;
    loop {
        let request = match pupil.next.take() {
            Some(request) => request,
            None => match pupil.requests.recv() {
                Ok(request) => request,
                Err(_) => return Ok(()),
            },
        };
        let refused = match (request, &over) {
            (Request::Reset, _) => {
                pupil.given_up = false;
                match trainer.episode(pupil, episode) {
                    Ok(outcome) => over = Some(outcome),
                    Err(ControlError::Own { .. }) if pupil.given_up => {
                        locked(&pupil.figures).clear();
                        over = None;
                    }
                    Err(e) => return Err(e),
                }
                episode += 1;
                // The class has gone while an episode went on, or after its last.
                if pupil.next.is_none() {
                    return Ok(());
                }
                continue;
            }
            (Request::Finish, Some(outcome)) => {
                let _ = pupil.replies.send(Reply::Finished(outcome.clone()));
                continue;
            }
            (Request::Validate, _) => {
                validate(trainer)?;
                let _ = pupil.replies.send(Reply::Validated(!trainer.stops()));
                continue;
            }
            (Request::Finish, None) => "no episode is over",
            (Request::Step(_), _) => "the episode is over; call reset() first",
        };
        let _ = pupil.replies.send(Reply::Over(refused.to_owned()));
    }
}

/// Returns what a lock holds, also where somebody panicked with it.
fn locked<T>(lock: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}
