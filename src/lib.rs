//! Evaluates methods over a whole family of tasks, with a budget: which traffic signal controller, for the
//! intersections of *my* city, and how sure are we?
//!
//! A **family** is a set of point MDPs with named features and an importance. A **domain** has methods and
//! makes trials of them: [`Traffic`] is the first, [`cartpole`] the second. Everything between, from the sample
//! of point MDPs to intervals and pages, is the same code for all.
//!
//! The command line is a layer of arguments and terminal on this library. What it plans, a program can:
//!
//! ```
//! use tsc_family::family::MdpFamily;
//! use tsc_family::sample::{Sampling, choose};
//! use tsc_family::traffic::family::load::load;
//!
//! // 164 point MDPs stand for the 282 signalised intersections of Salt Lake City.
//! let family: MdpFamily = load("salt-lake-city")?.family;
//! assert_eq!(family.points.len(), 164);
//!
//! // Twenty of them, chosen by k-means on their features, with the weights of their clusters.
//! let sample = choose(&family, Sampling::KMeans, 20, 0)?;
//! let weights: f64 = sample.draws.iter().map(|draw| draw.weight).sum();
//! assert!((weights - 1.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! And what it runs: [`evaluate`] goes from a [`Request`] to records, in this process; [`run::session`] is the
//! same step by step, with workers, progress and interruption. [`cli::main_with`] is the whole command line with
//! methods of one's own, as `examples/own_controller.rs` has it.
//!
//! # Where to look
//!
//! | | |
//! | --- | --- |
//! | a method of one's own for signals | [`traffic::control::Controller`], [`Traffic::with`], [`cli::main_with`], `examples/own_controller.rs` |
//! | another domain | [`run::domain`], with [`cartpole`] as the example |
//! | who does the tasks | [`run::executor`] |
//! | from a sample to the family | [`analysis::estimator`] |
//! | tables, figures, the page | [`report`]; [`report::Plain`] for a domain that adds nothing |
//! | families, samples | [`family`], [`sample`] |
//! | results on disk, read back | [`store`] |
//! | scores, ranking, intervals | [`analysis`], [`stats`] |
//! | networks and learning algorithms, for any task | [`nn`], [`rl`] |

pub mod cli;
pub mod domains;

pub use basics::{files, hash, heartbeat, machine, seed, suggest, units};
pub use control_tasks::{self, cartpole};
pub use evaluation::{
    analysis, family, model, published, report, run, sample, settings, stats, store, study,
};
pub use learners::{nn, rl};

/// Signalised intersections in SUMO: everything that knows of traffic.
pub mod traffic {
    pub use signals::*;
    pub use signals_report as report;
}

pub use run::domain::{Domain, Problem, Trial};
pub use run::method::{Method, Training};
pub use run::plan::Request;
pub use run::session::evaluate;
pub use traffic::domain::Traffic;
pub use traffic::problem::SignalProblem;
