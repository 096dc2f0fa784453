//! What signals' detectors tell, as arrays.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use tsc_family::traffic::control::{Observation, SignalSpec};

use crate::error::raised;
use crate::signals::Sizes;
use crate::view;

/// Numbers per lane: queue, approach, total and longest waiting time, speeds.
const LANE_NUMBERS: usize = 5;

/// What the signals' detectors tell at a decision.
#[pyclass(frozen, module = "tsc_family", name = "Observation")]
pub(crate) struct PyObservation {
    #[pyo3(get)]
    lanes: Py<PyArray3<f32>>,
    #[pyo3(get)]
    phase: Py<PyArray1<i64>>,
    #[pyo3(get)]
    downstream_queue: Py<PyArray2<f32>>,
    #[pyo3(get)]
    seen: Py<PyArray2<f32>>,
    #[pyo3(get)]
    lane_mask: Py<PyArray2<bool>>,
    #[pyo3(get)]
    phase_mask: Py<PyArray2<bool>>,
    signals: Arc<Vec<SignalSpec>>,
    sizes: Sizes,
    plain: Vec<Observation>,
}

#[pymethods]
impl PyObservation {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.lanes.bind(py).getattr("shape")?;
        Ok(format!("Observation(lanes: float32 {shape}, phase: {})", self.phase.bind(py)))
    }

    /// What IDQN sees of a signal: a row per lane or phase, whichever are more.
    #[pyo3(signature = (signal = 0))]
    fn idqn<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        view::idqn(py, self.of(signal)?, self.sizes)
    }

    /// What MPLight sees of a signal: its phase, and the pressure of every movement.
    #[pyo3(signature = (signal = 0))]
    fn mplight<'py>(&self, py: Python<'py>, signal: usize) -> PyResult<Bound<'py, PyArray1<f32>>> {
        Ok(view::mplight(py, self.of(signal)?, self.sizes))
    }

    /// What IDQN is paid for: waiting times, scaled and cut.
    #[pyo3(signature = (signal = 0))]
    fn wait(&self, signal: usize) -> PyResult<f32> {
        Ok(view::wait(self.of(signal)?.1))
    }

    /// What MPLight is paid for: queues behind less queues at the signal.
    #[pyo3(signature = (signal = 0))]
    fn pressure(&self, signal: usize) -> PyResult<f32> {
        Ok(view::pressure(self.of(signal)?.1))
    }
}

impl PyObservation {
    fn of(&self, signal: usize) -> PyResult<(&SignalSpec, &Observation)> {
        let both = self.signals.get(signal).zip(self.plain.get(signal));
        both.ok_or_else(|| {
            raised(format!("there are {} signals, and none {signal}", self.signals.len()))
        })
    }
}

/// The room of arrays, and the masks that all observations of some signals share.
pub(crate) struct Frame {
    sizes: Sizes,
    signals: Arc<Vec<SignalSpec>>,
    lane_mask: Py<PyArray2<bool>>,
    phase_mask: Py<PyArray2<bool>>,
}

impl Frame {
    pub(crate) fn new(py: Python<'_>, signals: &[SignalSpec], sizes: Sizes) -> PyResult<Self> {
        let mask = |size: usize, count: &dyn Fn(&SignalSpec) -> usize| -> PyResult<_> {
            let row = |s: &SignalSpec| (0..size).map(|i| i < count(s)).collect::<Vec<_>>();
            let rows: Vec<bool> = signals.iter().flat_map(row).collect();
            let array = PyArray1::from_vec(py, rows).reshape([signals.len(), size])?;
            array.readwrite().make_nonwriteable();
            Ok(array.unbind())
        };
        let lane_mask = mask(sizes.lanes, &|s| s.lanes.len())?;
        let phase_mask = mask(sizes.phases, &|s| s.phases.len())?;
        Ok(Self { sizes, signals: Arc::new(signals.to_vec()), lane_mask, phase_mask })
    }

    /// Returns what the signals of the frame see; arrays are new, masks are shared.
    pub(crate) fn observe<'py>(
        &self,
        py: Python<'py>,
        seen: &[Observation],
    ) -> PyResult<Bound<'py, PyObservation>> {
        let count = seen.len();
        let Sizes { lanes: width, movements, downstream, .. } = self.sizes;
        let lanes = PyArray3::<f32>::zeros(py, [count, width, LANE_NUMBERS], false);
        let mut room = lanes.readwrite();
        for (row, seen) in chunks(room.as_slice_mut()?, width * LANE_NUMBERS).zip(seen) {
            for (cell, lane) in row.as_chunks_mut::<LANE_NUMBERS>().0.iter_mut().zip(&seen.lanes) {
                *cell = [
                    lane.queue as f32, lane.approach as f32, lane.total_wait_s as f32,
                    lane.max_wait_s as f32, lane.total_speed_mps as f32,
                ];
            }
        }
        let padded = |width: usize, values: &dyn Fn(&Observation) -> &[f64]| -> PyResult<_> {
            let array = PyArray2::<f32>::zeros(py, [count, width], false);
            let mut room = array.readwrite();
            for (row, seen) in chunks(room.as_slice_mut()?, width).zip(seen) {
                row.iter_mut().zip(values(seen)).for_each(|(cell, value)| *cell = *value as f32);
            }
            Ok(array.unbind())
        };
        let phase = PyArray1::from_iter(py, seen.iter().map(|s| s.phase as i64));
        let made = PyObservation {
            lanes: lanes.unbind(),
            phase: phase.unbind(),
            downstream_queue: padded(downstream, &|s| &s.downstream_queue)?,
            seen: padded(movements, &|s| &s.seen)?,
            lane_mask: self.lane_mask.clone_ref(py),
            phase_mask: self.phase_mask.clone_ref(py),
            signals: Arc::clone(&self.signals),
            sizes: self.sizes,
            plain: seen.to_vec(),
        };
        Bound::new(py, made)
    }
}

fn chunks(values: &mut [f32], width: usize) -> impl Iterator<Item = &mut [f32]> {
    values.chunks_exact_mut(width.max(1))
}
