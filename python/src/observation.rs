//! What signals' detectors tell, as arrays.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use tsc_family::traffic::control::{Observation, SignalSpec};

use crate::signals::Sizes;

/// Numbers per lane: queue, approach, total and longest waiting time, speeds.
const LANE_NUMBERS: usize = 5;

/// What the signals' detectors tell at a decision.
#[pyclass(frozen, get_all, module = "tsc_family", name = "Observation")]
pub(crate) struct PyObservation {
    lanes: Py<PyArray3<f32>>,
    phase: Py<PyArray1<i64>>,
    downstream_queue: Py<PyArray2<f32>>,
    seen: Py<PyArray2<f32>>,
    lane_mask: Py<PyArray2<bool>>,
    phase_mask: Py<PyArray2<bool>>,
}

#[pymethods]
impl PyObservation {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.lanes.bind(py).getattr("shape")?;
        Ok(format!("Observation(lanes: float32 {shape}, phase: {})", self.phase.bind(py)))
    }
}

/// The room of arrays, and the masks that all observations of some signals share.
pub(crate) struct Frame {
    /// The room.
    pub(crate) sizes: Sizes,
    lane_mask: Py<PyArray2<bool>>,
    phase_mask: Py<PyArray2<bool>>,
}

impl Frame {
    /// Returns the frame of signals.
    pub(crate) fn new(py: Python<'_>, signals: &[&SignalSpec], sizes: Sizes) -> PyResult<Self> {
        let mask = |size: usize, count: &dyn Fn(&SignalSpec) -> usize| -> PyResult<_> {
            let row = |s: &&SignalSpec| (0..size).map(|i| i < count(s)).collect::<Vec<_>>();
            let rows: Vec<bool> = signals.iter().flat_map(row).collect();
            let array = PyArray1::from_vec(py, rows).reshape([signals.len(), size])?;
            array.readwrite().make_nonwriteable();
            Ok(array.unbind())
        };
        let lane_mask = mask(sizes.lanes, &|s| s.lanes.len())?;
        let phase_mask = mask(sizes.phases, &|s| s.phases.len())?;
        Ok(Self { sizes, lane_mask, phase_mask })
    }

    /// Returns what the signals of the frame see; arrays are new, masks are shared.
    pub(crate) fn observe<'py>(
        &self,
        py: Python<'py>,
        seen: &[&Observation],
    ) -> PyResult<Bound<'py, PyObservation>> {
        let count = seen.len();
        let Sizes { lanes: width, movements, downstream, .. } = self.sizes;
        let lanes = PyArray3::<f32>::zeros(py, [count, width, LANE_NUMBERS], false);
        let mut room = lanes.readwrite();
        for (row, seen) in chunks(room.as_slice_mut()?, width * LANE_NUMBERS).zip(seen) {
            for (cell, lane) in row.as_chunks_mut::<LANE_NUMBERS>().0.iter_mut().zip(&seen.lanes) {
                *cell = [
                    lane.queue as f32,
                    lane.approach as f32,
                    lane.total_wait_s as f32,
                    lane.max_wait_s as f32,
                    lane.total_speed_mps as f32,
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
        };
        Bound::new(py, made)
    }
}

/// Returns the rows of an array, of which there are none where they have no width.
fn chunks(values: &mut [f32], width: usize) -> impl Iterator<Item = &mut [f32]> {
    values.chunks_exact_mut(width.max(1))
}
