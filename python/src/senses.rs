//! What a learner of this library sees and is paid for where a class in Python says so.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use tsc_family::traffic::control::senses::Senses;
use tsc_family::traffic::control::{LaneObservation, Observation, Setup, SignalSpec};

use crate::object::Object;
use crate::observation::Frame;
use crate::signals::{PySignal, Sizes, signals};

/// Module with the class that learners are made of.
const MODULE: &str = "tsc_family._controller";

/// What a class of learners replaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Replaced {
    pub(crate) reward: bool,
    pub(crate) observation: bool,
}

struct Met {
    signal: Py<PySignal>,
    frame: Frame,
    /// How many numbers the class sees of it.
    width: Option<usize>,
}

/// An object of a class of learners.
pub(crate) struct PySenses {
    object: Object,
    replaced: Replaced,
    specs: Vec<SignalSpec>,
    met: Vec<Met>,
}

impl PySenses {
    pub(crate) fn new(class: &Py<PyAny>, replaced: Replaced, setup: &Setup) -> Self {
        Self { object: Object::new(class, setup), replaced, specs: Vec::new(), met: Vec::new() }
    }

    /// Calls a method of the class with what is seen of a signal.
    fn ask<T>(
        &self,
        method: &str,
        (signal, seen): (usize, &Observation),
        read: impl FnOnce(Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, String> {
        let Met { signal, frame, .. } = &self.met[signal];
        self.object.call(method, |object| {
            let seen = frame.observe(object.py(), std::slice::from_ref(seen))?;
            read(object.call_method1(method, (seen, signal.clone_ref(object.py())))?)
        })
    }

    fn look(&self, signal: usize, seen: &Observation, state: &mut Vec<f32>) -> Result<(), String> {
        state.clear();
        self.ask("observation", (signal, seen), |answer| {
            let numbers = answer.py().import(MODULE)?.call_method1("numbers_of", (answer,))?;
            let numbers: PyReadonlyArray1<'_, f32> = numbers.extract()?;
            state.extend_from_slice(numbers.as_slice()?);
            Ok(())
        })
    }
}

impl Senses for PySenses {
    fn begin(&mut self, specs: &[SignalSpec]) -> Result<(), String> {
        if self.specs != specs {
            let sizes = Sizes::of(specs);
            let made = Python::attach(|py| -> PyResult<Vec<Met>> {
                let all = signals(py, specs, sizes)?.into_iter().zip(specs);
                let met = all.map(|(signal, spec)| {
                    let frame = Frame::new(py, std::slice::from_ref(spec), sizes)?;
                    Ok(Met { signal, frame, width: None })
                });
                met.collect()
            });
            self.met = made.map_err(|e| e.to_string())?;
            self.specs = specs.to_vec();
        }
        self.object.call("begin", |object| {
            let all: Vec<_> =
                self.met.iter().map(|met| met.signal.clone_ref(object.py())).collect();
            object.call_method1("begin", (all,)).map(drop)
        })?;
        if !self.replaced.observation {
            return Ok(());
        }
        for (signal, spec) in specs.iter().enumerate() {
            if self.met[signal].width.is_some() {
                continue;
            }
            let mut state = Vec::new();
            self.look(signal, &nothing(spec), &mut state)?;
            if state.is_empty() {
                return Err("observation() returned no number".to_owned());
            }
            self.met[signal].width = Some(state.len());
        }
        Ok(())
    }

    fn width(&self, signal: usize) -> Option<usize> {
        self.met.get(signal).and_then(|met| met.width)
    }

    fn observe(
        &mut self,
        signal: usize,
        seen: &Observation,
        state: &mut Vec<f32>,
    ) -> Result<(), String> {
        self.look(signal, seen, state)?;
        let (width, id) = (self.width(signal).unwrap_or_default(), &self.specs[signal].id);
        if state.len() != width {
            return Err(format!(
                "observation() returned {} numbers for signal {id}, and {width} for an empty one; return as many each time",
                state.len()
            ));
        }
        match state.iter().position(|number| !number.is_finite()) {
            None => Ok(()),
            Some(at) => Err(format!(
                "observation() returned {} at position {at} for signal {id}; return finite numbers",
                state[at]
            )),
        }
    }

    fn reward(&mut self, signal: usize, seen: &Observation) -> Result<Option<f32>, String> {
        if !self.replaced.reward {
            return Ok(None);
        }
        let reward: f64 = self.ask("reward", (signal, seen), |answer| {
            answer.py().import(MODULE)?.call_method1("number_of", (answer,))?.extract()
        })?;
        // Half of the range, so that sums stay finite.
        match reward.is_finite() && reward.abs() < f64::from(f32::MAX) / 2.0 {
            true => Ok(Some(reward as f32)),
            false => Err(format!(
                "reward() returned {reward} for signal {}; return a finite number",
                self.specs[signal].id
            )),
        }
    }
}

/// Returns what detectors tell of a signal without vehicles.
fn nothing(spec: &SignalSpec) -> Observation {
    let downstream = spec.movements.iter().flat_map(|m| &m.downstream).max();
    Observation {
        phase: 0,
        lanes: vec![LaneObservation::default(); spec.lanes.len()],
        downstream_queue: vec![0.0; downstream.map_or(0, |last| last + 1)],
        seen: vec![0.0; spec.movements.len()],
    }
}
