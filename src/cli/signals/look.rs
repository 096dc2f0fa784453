//! What is known of a scenario's signals.

use std::path::Path;

use osm_signals::DrivingSide;
use osm_signals::Turn;
use serde_json::{Value, json};

use crate::traffic::env::side::driving_side;
use crate::traffic::env::warnings::{folded, warnings};
use crate::traffic::settings::SignalSettings;
use crate::traffic::sim::error::SimError;
use crate::traffic::sim::intake::Intake;
use crate::traffic::sim::obstacle::{Given, in_words};
use crate::traffic::sim::topology::edge;
use crate::traffic::simulator::{Loaded, load};
use crate::traffic::vocabulary::Light;

/// The signals of a scenario and the network around them.
pub(super) struct Look {
    /// Distance up to which controllers see, metres.
    detection_m: f64,
    /// Side of the street that traffic keeps to; movements and turns are those of right-hand traffic.
    pub(super) side: DrivingSide,
    /// What is to be said of the scenario beside its signals.
    pub(super) notes: Vec<String>,
    pub(super) loaded: Loaded,
}

/// Loads a scenario and derives its signals.
pub(super) fn look(
    config: &Path,
    given: &Given,
    settings: &SignalSettings,
) -> Result<Look, SimError> {
    let intake = Intake::read(config, given)?;
    let mut obstacles = intake.obstacles.clone();
    let loaded = match intake.may_load().then(|| load(&intake, settings)).transpose() {
        Ok(loaded) => loaded,
        Err(e) if obstacles.is_empty() => return Err(e),
        Err(_) => None,
    };
    let loaded = match loaded {
        Some(Ok(loaded)) if obstacles.is_empty() => loaded,
        found => {
            obstacles.extend(found.and_then(Result::err).into_iter().flatten());
            return Err(SimError::Obstacles(in_words(&obstacles)));
        }
    };
    let notes = intake.notes.clone();
    let side = driving_side(&intake.config);
    Ok(Look { detection_m: settings.detection_m, side, notes, loaded })
}

impl Look {
    /// Returns what is known of a signal.
    pub(super) fn json(&self, number: usize) -> Value {
        let signal = &self.loaded.signals[number];
        let spec = &signal.spec;
        let lanes = spec.lanes.iter().enumerate().map(|(i, lane)| {
            let of_scene = &self.loaded.scene.lanes[signal.lanes[i]];
            let upstream: Vec<&str> = of_scene.pieces.iter().map(|p| p.id.as_str()).collect();
            json!({
                "lane": lane.id,
                "length_m": lane.length_m,
                "seen_m": signal.seen_m[i].min(self.detection_m),
                "street_width_m": of_scene.street_width_m,
                "upstream": upstream,
            })
        });
        let movements = spec.movements.iter().enumerate().map(|(m, movement)| {
            let lanes = &movement.lanes;
            let lanes: Vec<&str> = lanes.iter().map(|l| spec.lanes[*l].id.as_str()).collect();
            let downstream = movement.downstream.iter();
            let downstream: Vec<&str> = downstream
                .map(|l| self.loaded.scene.lanes[signal.downstream[*l]].id.as_str())
                .collect();
            json!({
                "movement": movement.index,
                "from": lanes.first().map_or("", |lane| edge(lane)),
                "turn": turn(movement.turn, self.side),
                "lanes": lanes,
                "links": signal.movement_links[m],
                "downstream": downstream,
            })
        });
        let index = |m: &usize| spec.movements[*m].index;
        let phases = spec.phases.iter().enumerate().map(|(i, phase)| {
            let served = |wanted: Light| -> Vec<usize> {
                let movements = 0..phase.service.len();
                movements.filter(|m| phase.service[*m] == wanted).map(|m| index(&m)).collect()
            };
            json!({
                "phase": i,
                "state": phase.state,
                "counts": phase.pair.iter().map(index).collect::<Vec<_>>(),
                "right_of_way": served(Light::Protected),
                "yielding": served(Light::Permissive),
            })
        });
        let warnings: Vec<Value> = warnings(signal)
            .iter()
            .map(|warning| {
                let mut value = json!(warning);
                value["text"] = json!(folded(vec![warning.clone()]).concat());
                value
            })
            .collect();
        json!({
            "signal": spec.id,
            "driving_side": self.side,
            "lanes": lanes.collect::<Vec<_>>(),
            "movements": movements.collect::<Vec<_>>(),
            "phases": phases.collect::<Vec<_>>(),
            "greens_without_vehicles": signal.left_out,
            "warnings": warnings,
        })
    }
}

/// Returns the word for a turn as it is on the ground.
fn turn(turn: Turn, side: DrivingSide) -> &'static str {
    let (left, right) = side.swapped(("left", "right"));
    match turn {
        Turn::Right => right,
        Turn::Through => "through",
        Turn::Left => left,
    }
}
