//! What is said to a command and what it answers: one JSON object per line. docs/own-controller.md is for people,
//! docs/controller.schema.json for programs; a test compares the two with what is here.

use serde::{Deserialize, Serialize};

use crate::control::{LaneObservation, LaneSpec, Movement, Observation, SignalSpec};

/// Version of the protocol; a change that a command would have to know raises it.
pub const VERSION: u32 = 2;

/// What is said to a command.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub enum Question {
    /// An episode begins; to be answered with an empty object.
    Begin {
        /// Version of the protocol.
        version: u32,
        /// Name of the method.
        method: String,
        /// Seed of everything random in it; the same in all episodes of a task.
        seed: u64,
        /// The signals, in the order of all lists of signals.
        signals: Vec<Signal>,
    },
    /// A decision is due; to be answered with a phase per signal.
    Act {
        /// What is seen of every signal.
        signals: Vec<Seen>,
    },
    /// The task is over; not to be answered. Standard input closes after it.
    End {},
}

/// A signal.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Signal {
    /// SUMO's id.
    pub id: String,
    /// Incoming lanes.
    pub lanes: Vec<LaneSpec>,
    /// Movements.
    pub movements: Vec<Movement>,
    /// Green phases, the actions.
    pub phases: Vec<Phase>,
}

/// A green phase.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Phase {
    /// SUMO's state, one letter per link.
    pub state: String,
    /// Positions of the movements that the phase is named by.
    pub pair: Vec<usize>,
    /// Per movement its light: `red`, `permissive` or `protected`.
    pub service: Vec<String>,
    /// Positions of the lanes that it serves, ascending.
    pub lanes: Vec<usize>,
    /// Shortest green, seconds.
    pub min_green_s: f64,
    /// Longest green, seconds; null where there is no limit.
    pub max_green_s: Option<f64>,
}

/// What is seen of a signal: of its lanes what detectors tell, a number per lane.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Seen {
    /// The phase that is green or comes next.
    pub phase: usize,
    /// Per lane the vehicles that have halted within the detection distance.
    pub queue: Vec<f64>,
    /// Per lane the other vehicles there.
    pub approach: Vec<f64>,
    /// Per lane the sum of waiting times, seconds.
    pub total_wait_s: Vec<f64>,
    /// Per lane the longest waiting time, seconds.
    pub max_wait_s: Vec<f64>,
    /// Per lane the sum of speeds, metres per second.
    pub total_speed_mps: Vec<f64>,
    /// Queues of lanes at other signals.
    pub downstream_queue: Vec<f64>,
    /// Vehicles that have come so far in the episode, per movement.
    pub seen: Vec<f64>,
}

/// The answer to `begin`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Ready {}

/// The answer to `act`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Decision {
    /// Per signal the position of the phase that it is to have.
    pub phases: Vec<usize>,
}

impl From<&SignalSpec> for Signal {
    fn from(spec: &SignalSpec) -> Self {
        let phases = spec.phases.iter().enumerate().map(|(i, phase)| Phase {
            state: phase.state.clone(),
            pair: phase.pair.clone(),
            service: phase.service.iter().map(|light| light.name().to_owned()).collect(),
            lanes: spec.served_lanes(i),
            min_green_s: spec.limits.min_green_s.get(i).copied().unwrap_or_default(),
            max_green_s: spec.limits.max_green_s.get(i).copied().filter(|s| s.is_finite()),
        });
        Self {
            id: spec.id.clone(),
            lanes: spec.lanes.clone(),
            movements: spec.movements.clone(),
            phases: phases.collect(),
        }
    }
}

impl From<&Observation> for Seen {
    fn from(seen: &Observation) -> Self {
        let per_lane = |value: fn(&LaneObservation) -> f64| seen.lanes.iter().map(value).collect();
        Self {
            phase: seen.phase,
            queue: per_lane(|lane| lane.queue),
            approach: per_lane(|lane| lane.approach),
            total_wait_s: per_lane(|lane| lane.total_wait_s),
            max_wait_s: per_lane(|lane| lane.max_wait_s),
            total_speed_mps: per_lane(|lane| lane.total_speed_mps),
            downstream_queue: seen.downstream_queue.clone(),
            seen: seen.seen.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use serde_json::json;

    use super::*;

    #[test]
    fn the_schema_is_of_what_is_said() {
        let schemas = [
            ("question", schemars::schema_for!(Question)),
            ("ready", schemars::schema_for!(Ready)),
            ("decision", schemars::schema_for!(Decision)),
        ];
        let mut whole = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": "What tsc-family says to a controller and what it answers, one object per line",
            "version": VERSION,
        });
        for (name, schema) in schemas {
            whole[name] = schema.to_value();
        }
        let text = format!("{}\n", serde_json::to_string_pretty(&whole).unwrap());
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/controller.schema.json");
        if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
            fs::write(&path, &text).unwrap();
        }
        let there = fs::read_to_string(&path).unwrap_or_default();
        assert_eq!(there, text, "INSTA_UPDATE=always writes it anew");
    }
}
