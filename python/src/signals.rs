//! What controllers may know of a signal before the first observation, as Python sees it.

use std::collections::BTreeMap;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use tsc_family::traffic::control::state::movement_slots;
use tsc_family::traffic::control::{LaneSpec, Light, Limits, Movement, Phase, SignalSpec};

/// A signal: its lanes, movements and phases, and how long phases may and must be shown.
#[pyclass(frozen, get_all, module = "tsc_family", name = "Signal")]
pub(crate) struct PySignal {
    id: String,
    lanes: Vec<Py<PyLane>>,
    movements: Vec<Py<PyMovement>>,
    phases: Vec<Py<PyPhase>>,
    phase_lanes: Py<PyArray2<bool>>,
    phase_mask: Py<PyArray1<bool>>,
    lane_mask: Py<PyArray1<bool>>,
    limits: Py<PyLimits>,
}

/// An incoming lane.
#[pyclass(frozen, get_all, module = "tsc_family", name = "Lane")]
pub(crate) struct PyLane {
    id: String,
    length_m: f64,
}

/// Vehicles that come from one approach and turn the same way.
#[pyclass(frozen, get_all, module = "tsc_family", name = "Movement")]
pub(crate) struct PyMovement {
    index: usize,
    turn: &'static str,
    lanes: Vec<usize>,
    downstream: Vec<usize>,
    share: Option<f64>,
}

/// A green phase.
#[pyclass(frozen, get_all, module = "tsc_family", name = "Phase")]
pub(crate) struct PyPhase {
    state: String,
    pair: Vec<usize>,
    service: Vec<&'static str>,
}

/// How long phases may and must be shown, seconds.
#[pyclass(frozen, get_all, module = "tsc_family", name = "Limits")]
pub(crate) struct PyLimits {
    min_green_s: Py<PyArray1<f64>>,
    max_green_s: Py<PyArray1<f64>>,
    change_s: Py<PyArray2<f64>>,
    min_cycle_s: f64,
    max_cycle_s: f64,
    own_program: bool,
}

/// Room that arrays have for the parts of a signal; what a signal lacks is masked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sizes {
    pub(crate) lanes: usize,
    pub(crate) phases: usize,
    pub(crate) movements: usize,
    /// Lanes of other signals that movements lead to.
    pub(crate) downstream: usize,
    /// Numbers of movements: three per arm, four arms at least.
    pub(crate) slots: usize,
}

impl Sizes {
    pub(crate) fn of(signals: &[SignalSpec]) -> Self {
        signals.iter().fold(Self::default(), |most, signal| {
            let downstream = signal.movements.iter().flat_map(|m| &m.downstream).max();
            Self {
                lanes: most.lanes.max(signal.lanes.len()),
                phases: most.phases.max(signal.phases.len()),
                movements: most.movements.max(signal.movements.len()),
                downstream: most.downstream.max(downstream.map_or(0, |d| d + 1)),
                slots: most.slots.max(movement_slots(signal)),
            }
        })
    }
}

impl Sizes {
    pub(crate) fn named(self) -> BTreeMap<&'static str, usize> {
        let Self { lanes, phases, movements, downstream, slots } = self;
        BTreeMap::from([
            ("lanes", lanes),
            ("phases", phases),
            ("movements", movements),
            ("downstream", downstream),
            ("slots", slots),
        ])
    }
}

#[pymethods]
impl PySignal {
    fn __repr__(&self) -> String {
        let (lanes, phases) = (self.lanes.len(), self.phases.len());
        format!("Signal(id={:?}, {lanes} lanes, {phases} phases)", self.id)
    }
}

/// Returns signals for Python, with arrays of this room.
pub(crate) fn signals(
    py: Python<'_>,
    specs: &[SignalSpec],
    sizes: Sizes,
) -> PyResult<Vec<Py<PySignal>>> {
    specs.iter().map(|spec| signal(py, spec, sizes)).collect()
}

fn signal(py: Python<'_>, spec: &SignalSpec, sizes: Sizes) -> PyResult<Py<PySignal>> {
    let lane = |l: &LaneSpec| Py::new(py, PyLane { id: l.id.clone(), length_m: l.length_m });
    let movement = |m: &Movement| {
        let (lanes, downstream) = (m.lanes.clone(), m.downstream.clone());
        Py::new(
            py,
            PyMovement { index: m.index, turn: m.turn.name(), lanes, downstream, share: m.share },
        )
    };
    let phase = |p: &Phase| {
        let service = p.service.iter().map(|light| light.name()).collect();
        Py::new(py, PyPhase { state: p.state.clone(), pair: p.pair.clone(), service })
    };
    let mut served = vec![vec![false; sizes.lanes]; spec.phases.len()];
    for (row, phase) in served.iter_mut().zip(&spec.phases) {
        let green = spec.movements.iter().zip(&phase.service).filter(|(_, s)| **s != Light::Red);
        green.flat_map(|(m, _)| &m.lanes).for_each(|lane| row[*lane] = true);
    }
    let made = PySignal {
        id: spec.id.clone(),
        lanes: spec.lanes.iter().map(lane).collect::<PyResult<_>>()?,
        movements: spec.movements.iter().map(movement).collect::<PyResult<_>>()?,
        phases: spec.phases.iter().map(phase).collect::<PyResult<_>>()?,
        phase_lanes: fixed2(py, &served, sizes.lanes)?,
        phase_mask: mask(py, spec.phases.len(), sizes.phases),
        lane_mask: mask(py, spec.lanes.len(), sizes.lanes),
        limits: limits(py, &spec.limits)?,
    };
    Py::new(py, made)
}

fn limits(py: Python<'_>, limits: &Limits) -> PyResult<Py<PyLimits>> {
    let width = limits.change_s.len();
    let made = PyLimits {
        min_green_s: fixed(py, &limits.min_green_s),
        max_green_s: fixed(py, &limits.max_green_s),
        change_s: fixed2(py, &limits.change_s, width)?,
        min_cycle_s: limits.min_cycle_s,
        max_cycle_s: limits.max_cycle_s,
        own_program: limits.own_program,
    };
    Py::new(py, made)
}

/// Returns an array that nobody can change.
fn fixed<T: numpy::Element>(py: Python<'_>, values: &[T]) -> Py<PyArray1<T>> {
    let array = PyArray1::from_slice(py, values);
    array.readwrite().make_nonwriteable();
    array.unbind()
}

/// Returns an array of so many columns that nobody can change.
fn fixed2<T: numpy::Element + Clone>(
    py: Python<'_>,
    rows: &[Vec<T>],
    width: usize,
) -> PyResult<Py<PyArray2<T>>> {
    let array = PyArray1::from_vec(py, rows.concat()).reshape([rows.len(), width])?;
    array.readwrite().make_nonwriteable();
    Ok(array.unbind())
}

/// Returns a mask of which the first `count` of `size` count.
fn mask(py: Python<'_>, count: usize, size: usize) -> Py<PyArray1<bool>> {
    fixed(py, &(0..size).map(|i| i < count).collect::<Vec<_>>())
}
