//! The intersection on which is measured, its demand, and the times at which vehicles cross its stop lines.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use osm_signals::Turn;

use super::discharge::Served;
use crate::error::TrafficError;
use crate::network::demand::{DemandSpec, RouteShare, Stream};
use crate::network::error::NetworkError;
use crate::network::intersection::{Arm, IntersectionSpec};
use crate::network::lanes::Connection;
use crate::network::net_file::NetFile;
use crate::network::netconvert::{BuiltNet, Netconvert, links, movement_of_link, write};
use crate::network::retime::timing;
use crate::settings::{DemandSettings, Scenario};
use crate::sim::{Program, ProgramKind, ProgramPhase, Sim, StartOptions};
use crate::timing::Timing;
use basics::files::{self, limits};
use basics::seed;
use basics::units::{SECONDS_PER_HOUR, mph_to_mps};

/// Name of the intersection in messages.
const NAME: &str = "calibration";

/// Speed limit, miles per hour: of a usual street in a town.
const SPEED_MPH: f64 = 30.0;

/// Length of an approach, metres: longer than any queue that a green lets through.
const LENGTH_M: f64 = 400.0;

/// Demand of a lane that is to have a queue always, vehicles per hour.
const SATURATING_VPH: f64 = 1200.0;

/// Greens of the cycle, seconds: through, left, and the crossing street.
pub(super) const GREENS_S: [f64; 3] = [40.0, 30.0, 20.0];

/// Simulated time for queues, and for permissive left turns, seconds.
const QUEUES_S: f64 = 1800.0;
const PERMISSIVE_S: f64 = 3600.0;

/// Time in which queues of permissive left turns form, seconds.
const FILLING_S: f64 = 300.0;

/// How long before its time a state begins to count, seconds: where vehicles are at a step of SUMO is decided by what
/// the signal shows in that step, so a state that begins at 40 s decides how they drive from 39 s on.
const STEP_S: f64 = 1.0;

/// Duration of a green that never ends, seconds.
const FOR_EVER_S: f64 = 100_000.0;

/// When the phases of the cycle serve their lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cycle {
    pub(super) cycle_s: f64,
    pub(super) through: Served,
    pub(super) left: Served,
}

/// When vehicles crossed the stop lines, per lane and ascending, seconds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Crossings {
    pub(super) through: Vec<Vec<f64>>,
    pub(super) left: Vec<Vec<f64>>,
}

/// The intersection.
#[derive(Debug)]
pub(super) struct Street {
    folder: PathBuf,
    demand: DemandSettings,
    built: BuiltNet,
    /// Link of every connection of the layout.
    links: Vec<usize>,
    timing: Timing,
}

impl Street {
    /// Builds the intersection with the settings of a scenario.
    pub(super) fn build(scenario: &Scenario, folder: &Path) -> Result<Self, TrafficError> {
        let arm = |bearing_deg| Arm {
            bearing_deg,
            lanes_in: 3,
            lanes_out: 2,
            left_turn_lanes: 1,
            speed_mps: mph_to_mps(SPEED_MPH),
            length_m: LENGTH_M,
            ..Arm::default()
        };
        let arms = [0.0, 90.0, 180.0, 270.0].map(arm).to_vec();
        let spec =
            IntersectionSpec { point: NAME.to_owned(), arms, side: scenario.network.driving_side };
        let Scenario { network, signal, demand, .. } = scenario;
        let built = Netconvert::find()?.build(&spec, network, signal, demand, folder)?;
        let unsound = |reason| NetworkError::Unsound { point: NAME.to_owned(), reason };
        let net = NetFile::parse(&built.text).map_err(unsound)?;
        let links = links(&built.layout, &net).map_err(unsound)?;
        let movement_of_link = movement_of_link(&built.layout, &links);
        let timing = timing(&spec, &built.layout, &movement_of_link, &scenario.signal);
        let street = Self {
            folder: folder.to_owned(),
            demand: scenario.demand.clone(),
            built,
            links,
            timing,
        };
        write(folder, "n.net.xml", &street.built.text)?;
        let config =
            "<configuration><input><net-file value=\"n.net.xml\"/></input></configuration>\n";
        write(folder, "n.sumocfg", config)?;
        write(folder, "loops.add.xml", &loops())?;
        Ok(street)
    }

    /// Returns yellow and all-red after the through green together, seconds.
    pub(super) fn change_s(&self) -> u32 {
        let [through, left, _] = self.greens();
        self.timing.change(&through, &left).map_or(0, |change| change.total_s())
    }

    /// Measures queues on through and left lanes of the street in a fixed cycle.
    pub(super) fn queues(
        &self,
        sim: &mut dyn Sim,
        k: u32,
    ) -> Result<(Cycle, Crossings), TrafficError> {
        let greens = self.greens();
        let mut phases = Vec::new();
        let mut served = Vec::new();
        let mut time_s = 0.0;
        for (i, green) in greens.iter().enumerate() {
            let begin_s = time_s;
            time_s += GREENS_S[i];
            phases.push(ProgramPhase::fixed(green, GREENS_S[i]));
            let end_s = time_s;
            for (state, seconds) in self.timing.between(green, &greens[(i + 1) % greens.len()]) {
                time_s += f64::from(seconds);
                phases.push(ProgramPhase::fixed(state, f64::from(seconds)));
            }
            served.push(Served {
                green: (begin_s - STEP_S, end_s - STEP_S),
                until_s: time_s - STEP_S,
            });
        }
        let cycle = Cycle { cycle_s: time_s, through: served[0], left: served[1] };
        // From two arms, as vehicles that find no room on an edge hold up those behind them.
        let streams = vec![stream(0, 2, 2.0 * SATURATING_VPH), stream(2, 3, SATURATING_VPH)];
        let mut times = self.simulate(sim, phases, streams, QUEUES_S, k)?;
        let mut of = |lanes: &[&str]| -> Vec<Vec<f64>> {
            lanes.iter().map(|lane| times.remove(*lane).unwrap_or_default()).collect()
        };
        let through = of(&["in0_0", "in0_1"]);
        let left = of(&["in2_2"]);
        Ok((cycle, Crossings { through, left }))
    }

    /// Returns the flow of a lane of permissive left turns, vehicles per hour.
    pub(super) fn permissive_vph(
        &self,
        sim: &mut dyn Sim,
        opposing_vph: f64,
        k: u32,
    ) -> Result<f64, TrafficError> {
        let green = self.state(|c| match (c.movement.from, c.movement.turn) {
            (0 | 2, Turn::Left) => 'g',
            (0 | 2, _) => 'G',
            _ => 'r',
        });
        let phases = vec![ProgramPhase::fixed(green, FOR_EVER_S)];
        let streams = vec![stream(2, 0, opposing_vph), stream(0, 1, SATURATING_VPH)];
        let times = self.simulate(sim, phases, streams, PERMISSIVE_S, k)?;
        let crossed = times.get("in0_2").into_iter().flatten().filter(|t| **t >= FILLING_S).count();
        Ok(crossed as f64 * SECONDS_PER_HOUR / (PERMISSIVE_S - FILLING_S))
    }

    /// Returns the greens of the cycle: through, left, the crossing street.
    fn greens(&self) -> [String; 3] {
        let green = |is: fn(&Connection) -> bool| self.state(|c| if is(c) { 'G' } else { 'r' });
        [
            green(|c| c.movement.from % 2 == 0 && c.movement.turn == Turn::Through),
            green(|c| c.movement.from % 2 == 0 && c.movement.turn == Turn::Left),
            green(|c| c.movement.from % 2 == 1 && c.movement.turn == Turn::Through),
        ]
    }

    /// Returns a state of the signal by a letter per connection.
    fn state(&self, letter: impl Fn(&Connection) -> char) -> String {
        let mut state = vec!['r'; self.links.len()];
        for (c, link) in self.built.layout.connections.iter().zip(&self.links) {
            state[*link] = letter(c);
        }
        state.into_iter().collect()
    }

    /// Simulates a program and returns when vehicles crossed, by lane.
    fn simulate(
        &self,
        sim: &mut dyn Sim,
        phases: Vec<ProgramPhase>,
        streams: Vec<Stream>,
        end_s: f64,
        k: u32,
    ) -> Result<BTreeMap<String, Vec<f64>>, TrafficError> {
        let settings =
            DemandSettings { horizon_s: end_s, peak_hour_factor: 1.0, ..self.demand.clone() };
        let seed = seed::evaluation(0, k);
        let routes = self.folder.join("n.rou.xml");
        DemandSpec::new(&settings, streams).write_routes(seed, &routes)?;
        let path = |name: &str| self.folder.join(name).display().to_string();
        let args = [
            ("--route-files", routes.display().to_string()),
            ("--additional-files", path("loops.add.xml")),
            ("--begin", "0".to_owned()),
            ("--end", end_s.to_string()),
            ("--step-length", "1".to_owned()),
            ("--time-to-teleport", "-1".to_owned()),
            ("--seed", seed.to_string()),
        ];
        let args = args.into_iter().flat_map(|(name, value)| [name.to_owned(), value]).collect();
        let (config, tripinfo) = (self.folder.join("n.sumocfg"), self.folder.join("tripinfo.xml"));
        sim.start(&StartOptions { config, args, trace_m: 0.0, tripinfo })?;
        sim.install(0, &Program::new(NAME, ProgramKind::Static, phases))?;
        sim.step(end_s as u32)?;
        sim.close()?;
        let path = self.folder.join("loops.xml");
        Ok(crossings(&String::from_utf8_lossy(&files::read(&path, limits::NETWORK)?)))
    }
}

/// Returns a loop before the stop line of every lane of the street.
fn loops() -> String {
    let mut text = "<additional>\n".to_owned();
    for lane in [0, 2].iter().flat_map(|arm| (0..3).map(move |lane| format!("in{arm}_{lane}"))) {
        text += &format!(
            "    <instantInductionLoop id=\"{lane}\" lane=\"{lane}\" pos=\"-0.1\" file=\"loops.xml\"/>\n"
        );
    }
    text + "</additional>\n"
}

/// Returns vehicles from one arm to another.
fn stream(from: usize, to: usize, inflow_vph: f64) -> Stream {
    Stream {
        from: format!("in{from}"),
        upstream: Vec::new(),
        storage: None,
        inflow_vph,
        arrivals: None,
        heavy_vehicles: None,
        pedestrians_per_h: None,
        depart_lane: "best".to_owned(),
        depart_speed: "max".to_owned(),
        routes: vec![RouteShare { to: format!("out{to}"), share: 1.0 }],
    }
}

/// Returns when vehicles entered SUMO's instant loops, by loop.
fn crossings(text: &str) -> BTreeMap<String, Vec<f64>> {
    let value = |line: &str, name: &str| {
        let (_, rest) = line.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    let mut times = BTreeMap::<String, Vec<f64>>::new();
    for line in text.lines().filter(|line| line.contains(" state=\"enter\"")) {
        let time_s = value(line, "time").and_then(|time| time.parse().ok());
        if let (Some(id), Some(time_s)) = (value(line, "id"), time_s) {
            times.entry(id).or_default().push(time_s);
        }
    }
    times.values_mut().for_each(|times| times.sort_by(f64::total_cmp));
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_vehicles_that_enter_a_loop_cross() {
        let text = "<instantE1>\n  <instantOut id=\"in0_1\" time=\"4.50\" state=\"enter\" vehID=\"a\"/>\n  \
                    <instantOut id=\"in0_1\" time=\"4.90\" state=\"leave\" vehID=\"a\"/>\n</instantE1>\n";
        assert_eq!(crossings(text), BTreeMap::from([("in0_1".to_owned(), vec![4.5])]));
    }
}
