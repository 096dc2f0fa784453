//! `tsc-family signals`: what is derived of a scenario's signals, as text, JSON lines or drawings.

mod drawing;
mod text;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::ScenarioArg;
use super::build_networks::{default_folder, prepare};
use super::effects::Use;
use super::evaluate::unknown_point;
use super::folder::DRAWINGS;
use super::output::{line, note};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::files::FileError;
use crate::traffic::control::Service;
use crate::traffic::env::derive::DerivedSignal;
use crate::traffic::env::warnings;
use crate::traffic::environment::generated_world;
use crate::traffic::family::load::load_with;
use crate::traffic::settings::SignalSettings;
use crate::traffic::side::DrivingSide;
use crate::traffic::sim::Scene;
use crate::traffic::sim::error::SimError;
use crate::traffic::sim::topology::Topology;

/// The signals of a scenario and the network around them.
pub(super) struct Look {
    /// Distance up to which controllers see, metres.
    detection_m: f64,
    scene: Scene,
    topology: Topology,
    /// Side of the street that traffic keeps to; movements and turns are those of right-hand traffic.
    side: DrivingSide,
    signals: Vec<DerivedSignal>,
}

/// `tsc-family signals`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Of each signal: its lanes and how far they are seen upstream, through nodes without a signal; the
movements with their links and the lanes that they lead to at the next signals; the phases to choose
from with the movements that count for them; warnings. `run --dry-run` prints the warnings too.

Examples:
  tsc-family signals city/a.sumocfg
  tsc-family signals city/a.sumocfg --svg drawings
  tsc-family signals busy smoke --json")]
pub struct SignalsArgs {
    /// SUMO configuration, or id of a point MDP; its network is built if it is missing
    #[arg(value_name = "SUMOCFG|POINT")]
    pub place: String,
    /// Scenario that has the point MDP; of a SUMO configuration only its settings count
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Folder to draw each signal to, as NUMBER-ID.svg
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// Draw into a folder that holds other files
    #[arg(long, requires = "svg")]
    pub force: bool,
    /// Print JSON lines: one per signal
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &SignalsArgs) -> anyhow::Result<u8> {
    let loaded = load_with(&args.scenario.scenario, &args.scenario.settings())?;
    let path = Path::new(&args.place);
    if let Some(folder) = &args.svg {
        DRAWINGS.check(folder, "--svg", Some(args.force))?;
    }
    let imported = path.is_file() || path.extension().is_some_and(|e| e == "sumocfg");
    if imported && args.networks.is_some() {
        return Err(
            Refused("--networks has no effect: a SUMO configuration is given".into()).into()
        );
    }
    let used = Use { family: !imported, networks: !imported, ..Use::BUILD };
    used.check(&loaded, &args.scenario.settings())?;
    let config = if imported {
        path.to_path_buf()
    } else if let Some(index) = loaded.family.position(&args.place) {
        let point = &loaded.family.points[index].id;
        let folder = || default_folder(&args.scenario.scenario, &loaded);
        let networks = args.networks.clone().unwrap_or_else(folder);
        prepare(&loaded, &BTreeSet::from([point.as_str()]), &networks, true)?;
        generated_world(&networks, point)?.config
    } else {
        return Err(unknown_point(&args.place, &loaded, &args.scenario.scenario).into());
    };
    let look = look(&config, &loaded.scenario.signal)?;
    for number in 0..look.signals.len() {
        if args.json {
            line(look.json(number))?;
        } else {
            line(text::text(&look, number))?;
        }
    }
    if let Some(folder) = &args.svg {
        fs::create_dir_all(folder).map_err(FileError::at("create", folder))?;
        for number in 0..look.signals.len() {
            let path = folder.join(file_name(number, &look.scene.signals[number].id));
            let drawing = drawing::svg(&look, number);
            fs::write(&path, drawing).map_err(FileError::at("write", &path))?;
        }
        note(format!("drawings: {} in {}", look.signals.len(), folder.display()));
    }
    Ok(exit::DONE)
}

/// Returns one line per warning about the signals of imported scenarios.
///
/// # Errors
///
/// [`SimError`] when a scenario cannot be loaded or a signal cannot be derived.
pub(super) fn warning_lines(
    configs: &[PathBuf],
    settings: &SignalSettings,
) -> Result<Vec<String>, SimError> {
    let mut lines = Vec::new();
    for config in configs {
        let look = look(config, settings)?;
        for signal in &look.signals {
            for warning in warnings(signal) {
                lines.push(format!("{}: signal {}: {warning}", config.display(), signal.spec.id));
            }
        }
    }
    Ok(lines)
}

#[cfg(feature = "libsumo")]
fn look(config: &Path, settings: &SignalSettings) -> Result<Look, SimError> {
    use crate::traffic::env::derive::derive;
    use crate::traffic::env::side::{as_right_hand, driving_side};
    use crate::traffic::env::sumocfg::SumoConfig;
    use crate::traffic::sim::libsumo::SumoSim;
    use crate::traffic::sim::{SignalInfo, Sim, StartOptions};

    let detection_m = settings.detection_m;
    let options = StartOptions {
        config: config.to_path_buf(),
        trace_m: detection_m,
        ..StartOptions::default()
    };
    let mut sim = SumoSim::new()?;
    let scene = sim.start(&options).map_err(|e| super::run::explained(e, config))?;
    let side = driving_side(&SumoConfig::read(config)?);
    let scene = as_right_hand(scene, side);
    let topology = sim.topology()?;
    sim.close()?;
    let derived = |signal: &SignalInfo| derive(&scene, signal, settings);
    let signals = scene.signals.iter().map(derived).collect::<Result<_, _>>()?;
    Ok(Look { detection_m, scene, topology, side, signals })
}

#[cfg(not(feature = "libsumo"))]
fn look(_: &Path, _: &SignalSettings) -> Result<Look, SimError> {
    Err(SimError::Unavailable("built without the feature `libsumo`".into()))
}

impl Look {
    /// Returns how far a lane of a signal's spec is seen, metres.
    fn seen_m(&self, signal: &DerivedSignal, lane: usize) -> f64 {
        signal.seen_m[lane].min(self.detection_m)
    }

    /// Returns the ids of the lanes downstream of a movement.
    fn downstream(&self, signal: &DerivedSignal, movement: usize) -> Vec<&str> {
        let lanes = &signal.spec.movements[movement].downstream;
        lanes.iter().map(|l| self.scene.lanes[signal.downstream[*l]].id.as_str()).collect()
    }

    /// Returns the ids of a movement's lanes.
    fn lanes<'a>(&self, signal: &'a DerivedSignal, movement: usize) -> Vec<&'a str> {
        let lanes = &signal.spec.movements[movement].lanes;
        lanes.iter().map(|l| signal.spec.lanes[*l].id.as_str()).collect()
    }

    fn json(&self, number: usize) -> Value {
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
                "turn": text::turn(movement.turn, self.side),
                "lanes": self.lanes(signal, m),
                "links": signal.movement_links[m],
                "downstream": self.downstream(signal, m),
            })
        });
        let index = |m: &usize| spec.movements[*m].index;
        let phases = spec.phases.iter().map(|phase| {
            let served = |wanted: Service| -> Vec<usize> {
                (0..phase.service.len())
                    .filter(|m| phase.service[*m] == wanted)
                    .map(|m| index(&m))
                    .collect()
            };
            json!({
                "state": phase.state,
                "counts": phase.pair.iter().map(index).collect::<Vec<_>>(),
                "right_of_way": served(Service::Protected),
                "yielding": served(Service::Permissive),
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

/// Returns a file name that any file system takes.
fn file_name(number: usize, id: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    format!("{number:02}-{}.svg", id.chars().map(plain).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_name_has_plain_letters_only() {
        assert_eq!(file_name(3, "a/b#1 ü"), "03-a_b_1__.svg");
    }
}
