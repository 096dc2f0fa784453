//! Results by street, as records keep them: how vehicles fared that drove along all signals of a street.

use serde::{Deserialize, Serialize};

/// What records have of networks of several signals.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ByStreet {
    /// Every direction of every street.
    pub streets: Vec<StreetResult>,
}

impl ByStreet {
    /// Adds an episode.
    pub fn add(&mut self, episode: Vec<StreetResult>) {
        if self.streets.is_empty() {
            self.streets = episode;
            return;
        }
        for (all, one) in self.streets.iter_mut().zip(episode) {
            all.episodes.extend(one.episodes);
        }
    }
}

/// A street in one direction, with its evaluation episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreetResult {
    /// Direction of travel at its first stop line, such as `EB`.
    pub direction: String,
    /// Its stop lines in the order of travel.
    pub stops: Vec<StreetStop>,
    /// The evaluation episodes in the order of their seeds.
    pub episodes: Vec<StreetEpisode>,
}

/// A stop line of a street.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreetStop {
    /// SUMO's id of the signal.
    pub signal: String,
    /// Link indices of the movement straight on: places in the states of programs.
    pub links: Vec<usize>,
    /// Distance from the first stop line, metres.
    pub at_m: f64,
    /// The same at the speed limit, seconds.
    pub after_s: f64,
}

/// Vehicles that drove along the whole street in an episode, from where they were first seen before its first stop line to
/// its last one.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreetEpisode {
    /// How many they were.
    pub vehicles: u32,
    /// Mean time, seconds; 0 without vehicles.
    pub travel_s: f64,
    /// Mean time beyond that at the speed limit, seconds.
    pub delay_s: f64,
    /// Mean number of times that one came below 0.1 m/s.
    pub stops: f64,
}
