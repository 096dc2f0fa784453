//! What learners of this library see of a signal, and what they are paid for, as arrays.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use tsc_family::traffic::control::state::{
    LANE_WIDTH, lane_rows, lanes, pressure_reward, pressures, wait_reward,
};
use tsc_family::traffic::control::{Observation, SignalSpec};

use crate::signals::Sizes;

/// What IDQN sees: a row per lane or phase, whichever are more.
pub(crate) fn idqn<'py>(
    py: Python<'py>,
    (spec, seen): (&SignalSpec, &Observation),
    sizes: Sizes,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let rows = sizes.lanes.max(sizes.phases).max(lane_rows(spec));
    let mut state = Vec::with_capacity(rows * LANE_WIDTH);
    lanes(spec, seen, &mut state);
    state.resize(rows * LANE_WIDTH, 0.0);
    PyArray1::from_vec(py, state).reshape([rows, LANE_WIDTH])
}

/// What MPLight sees: the phase, and the pressure of every movement.
pub(crate) fn mplight<'py>(
    py: Python<'py>,
    (spec, seen): (&SignalSpec, &Observation),
    sizes: Sizes,
) -> Bound<'py, PyArray1<f32>> {
    let mut state = vec![0.0; 1 + sizes.slots];
    state[0] = seen.phase as f32;
    pressures(spec, seen, &mut state[1..]);
    PyArray1::from_vec(py, state)
}

/// What IDQN is paid for: waiting times, scaled and cut.
pub(crate) fn wait(seen: &Observation) -> f32 {
    wait_reward(seen)
}

/// What MPLight is paid for: queues behind less queues at the signal.
pub(crate) fn pressure(seen: &Observation) -> f32 {
    pressure_reward(seen)
}
