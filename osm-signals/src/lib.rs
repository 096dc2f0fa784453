//! From a map to its traffic signals: the signalised intersections of an OpenStreetMap extract, each with its
//! arms, their lanes, turns, speed limits and lengths, and what a city knows of them.
//!
//! Data flows one way. [`read`](read()) keeps the drivable ways, signals and turn restrictions of a file (PBF, XML, gzipped
//! XML) as an [`Extract`], which is as large as its streets, not as its file; [`tags`] gives the values of tags their
//! meaning. `graph` joins ways to pieces; `sites` decides which junctions a signal controls and which are one intersection;
//! `legs` finds the streets that leave it and sets slip lanes aside; [`arms`] joins carriageways; `across` searches the
//! ways across; [`intersections`] puts that together. [`listing`], [`counts`] and [`traffic`] add what a city knows: which
//! signals it operates, and how many vehicles a day were counted where. A [`Survey`] is all of it.
//!
//! Nothing is lost silently: every signal that is no intersection has a reason ([`flags::Skip`]), every
//! value says what it rests on ([`streets::Source`], [`traffic::InflowSource`]), what is worth a look has a
//! [`flags::Flag`], and values of tags that were ignored are counted ([`oddities::Oddities`]).
//!
//! Left-hand traffic is read as right-hand traffic in the mirror ([`mirror`]).
//!
//! # Examples
//!
//! ```
//! use std::path::Path;
//!
//! use osm_signals::{Inputs, Settings, Survey, read};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let extract = read(Path::new("tests/networks/t_junction/input.osm"), &|_, _| {})?;
//! let survey = Survey::new(&extract, &Settings::default(), &Inputs::default());
//! for intersection in &survey.found.intersections {
//!     for (arm, turns) in intersection.arms.iter().zip(&intersection.turns) {
//!         println!("{:3.0} deg: {} lanes in, {turns:?}", arm.bearing_deg, arm.lanes_in);
//!     }
//! }
//! assert_eq!(survey.found.intersections[0].arms.len(), 3);
//! # Ok(())
//! # }
//! ```

mod across;
pub mod angle;
pub mod arms;
pub mod boundary;
pub mod counts;
mod crossings;
pub mod driving_side;
pub mod error;
pub mod extract;
mod features;
pub mod file;
pub mod flags;
pub mod geometry;
mod graph;
pub mod intersections;
mod legs;
pub mod listing;
pub mod mirror;
mod near;
pub mod oddities;
pub mod read;
pub mod settings;
pub mod signals;
mod sites;
pub mod sources;
mod spread;
pub mod streets;
pub mod survey;
mod table;
pub mod tags;
pub mod traffic;
pub mod turn;

pub use arms::Arm;
pub use boundary::Boundary;
pub use counts::Counts;
pub use driving_side::DrivingSide;
pub use error::OsmError;
pub use extract::{Extract, Place};
pub use intersections::Intersection;
pub use read::read;
pub use settings::Settings;
pub use signals::SignalList;
pub use survey::{Inputs, Survey};
pub use turn::{Turn, Turns};

/// The page of the crate, whose code is compiled with the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
