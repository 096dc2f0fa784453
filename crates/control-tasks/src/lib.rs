//! Families of control tasks: dynamics with a context, and the methods that learn in them.
//!
//! A task is one file: its [`dynamics`](episodes::Dynamics), its family and what evaluation has to know of it, as a
//! [`task::Task`]. All else is generic: [`episodes`], `context`, [`task::scenario`], `problem` and
//! [`domain`]. A method is one file of `methods` with its settings; what it computes is in the crate of learners.

pub mod acrobot;
pub mod cartpole;
mod context;
pub mod domain;
pub mod episodes;
pub mod half_cheetah;
mod methods;
pub mod mountain_car;
pub mod mujoco;
pub mod pendulum;
pub mod pendulum_swing_up;
mod problem;
pub mod quad;
pub mod swimmer;
pub mod task;
