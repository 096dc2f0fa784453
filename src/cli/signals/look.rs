//! What is known of a scenario's signals.

use std::path::Path;

use osm_signals::DrivingSide;
use osm_signals::Turn;
use serde_json::{Value, json};

use crate::traffic::env::derive::DerivedSignal;
use crate::traffic::env::warnings;
use crate::traffic::settings::SignalSettings;
use crate::traffic::sim::Scene;
use crate::traffic::sim::error::SimError;
use crate::traffic::sim::topology::Topology;
use crate::traffic::vocabulary::Light;

/// The signals of a scenario and the network around them.
pub(super) struct Look {
    /// Distance up to which controllers see, metres.
    pub(super) detection_m: f64,
    pub(super) scene: Scene,
    pub(super) topology: Topology,
    /// Side of the street that traffic keeps to; movements and turns are those of right-hand traffic.
    pub(super) side: DrivingSide,
    pub(super) signals: Vec<DerivedSignal>,
    /// Ids of level crossings and the like, which are no signals to control.
    pub(super) railways: Vec<String>,
}

#[cfg(feature = "libsumo")]
pub(super) fn look(config: &Path, settings: &SignalSettings) -> Result<Look, SimError> {
    use crate::traffic::env::derive::derive;
    use crate::traffic::env::side::{as_right_hand, driving_side};
    use crate::traffic::sim::libsumo::SumoSim;
    use crate::traffic::sim::sources::sources;
    use crate::traffic::sim::sumocfg::SumoConfig;
    use crate::traffic::sim::{SignalInfo, Sim, StartOptions};
    use crate::traffic::simulator::explained;

    let detection_m = settings.detection_m;
    let options = StartOptions {
        config: config.to_path_buf(),
        trace_m: detection_m,
        ..StartOptions::default()
    };
    let configuration = SumoConfig::read(config)?;
    sources(&configuration)?;
    let mut sim = SumoSim::new()?;
    let scene = sim.start(&options).map_err(|e| explained(e, config))?;
    let side = driving_side(&configuration);
    let scene = as_right_hand(scene, side);
    let topology = sim.topology()?;
    let railways = sim.railways().to_vec();
    sim.close()?;
    let derived = |signal: &SignalInfo| derive(&scene, signal, settings);
    let signals = scene.signals.iter().map(derived).collect::<Result<_, _>>();
    let signals = signals.map_err(|e| explained(e, config))?;
    Ok(Look { detection_m, scene, topology, side, signals, railways })
}

#[cfg(not(feature = "libsumo"))]
pub(super) fn look(_: &Path, _: &SignalSettings) -> Result<Look, SimError> {
    Err(SimError::Unavailable("built without the feature `libsumo`".into()))
}

impl Look {
    /// Returns a line on the signals that no method controls, if there are any.
    pub(super) fn left_alone(&self) -> Option<String> {
        let ids = self.railways.join(", ");
        let line =
            format!("trains steer these level crossings, and no method controls them: {ids}");
        (!ids.is_empty()).then_some(line)
    }

    /// Returns how far a lane of a signal's spec is seen, metres.
    pub(super) fn seen_m(&self, signal: &DerivedSignal, lane: usize) -> f64 {
        signal.seen_m[lane].min(self.detection_m)
    }

    /// Returns the ids of the lanes downstream of a movement.
    pub(super) fn downstream(&self, signal: &DerivedSignal, movement: usize) -> Vec<&str> {
        let lanes = &signal.spec.movements[movement].downstream;
        lanes.iter().map(|l| self.scene.lanes[signal.downstream[*l]].id.as_str()).collect()
    }

    /// Returns the ids of a movement's lanes.
    pub(super) fn lanes<'a>(&self, signal: &'a DerivedSignal, movement: usize) -> Vec<&'a str> {
        let lanes = &signal.spec.movements[movement].lanes;
        lanes.iter().map(|l| signal.spec.lanes[*l].id.as_str()).collect()
    }

    pub(super) fn json(&self, number: usize) -> Value {
        let signal = &self.signals[number];
        let spec = &signal.spec;
        let lanes = spec.lanes.iter().enumerate().map(|(i, lane)| {
            let of_scene = &self.scene.lanes[signal.lanes[i]];
            let upstream: Vec<&str> = of_scene.pieces.iter().map(|p| p.id.as_str()).collect();
            json!({
                "lane": lane.id,
                "length_m": lane.length_m,
                "seen_m": self.seen_m(signal, i),
                "street_width_m": of_scene.street_width_m,
                "upstream": upstream,
            })
        });
        let movements = spec.movements.iter().enumerate().map(|(m, movement)| {
            json!({
                "movement": movement.index,
                "turn": turn(movement.turn, self.side),
                "lanes": self.lanes(signal, m),
                "links": signal.movement_links[m],
                "downstream": self.downstream(signal, m),
            })
        });
        let index = |m: &usize| spec.movements[*m].index;
        let phases = spec.phases.iter().map(|phase| {
            let served = |wanted: Light| -> Vec<usize> {
                (0..phase.service.len())
                    .filter(|m| phase.service[*m] == wanted)
                    .map(|m| index(&m))
                    .collect()
            };
            json!({
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
                value["text"] = json!(warning.to_string());
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
pub(super) fn turn(turn: Turn, side: DrivingSide) -> &'static str {
    let (left, right) = side.swapped(("left", "right"));
    match turn {
        Turn::Right => right,
        Turn::Through => "through",
        Turn::Left => left,
    }
}
