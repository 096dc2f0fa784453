//! The vehicles of an intersection: Poisson streams, written as SUMO routes for any seed.
//!
//! Choices where implementations differ:
//! - **Randomness** of a stream comes from four generators of its own, for arrivals, turns, drivers
//!   and kinds of vehicles. Changing one stream, or one of the four, leaves all others alone. A higher inflow only
//!   squeezes the same arrivals together, and a peak hour factor only moves them within the horizon.
//! - **Drivers** get SUMO's default spread of desired speeds, but drawn here and written into the
//!   file, so that SUMO's own random numbers, which depend on what the signal does, do not decide
//!   who the vehicles are.
//! - **Insertion** is spelled out (`departLane`, `departPos`, `departSpeed`) and so is the vehicle
//!   type, because SUMO 1.27 changed the defaults: delays differ by a quarter.
//! - **Heavy vehicles** are one type, a single-unit truck, instead of the classes of a count. Those of a
//!   smaller share are heavy with a larger one too.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::io::{Error, ErrorKind};
use std::path::Path;

use osm_signals::Turn;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};

use super::bays::{Storage, pieces};
use super::error::NetworkError;
use super::intersection::IntersectionSpec;
use super::movements::{exits, movements};
use crate::family::approaches::{Arrivals, Counted};
use crate::junction::{Movement, incoming_edge};
use crate::settings::{DemandSettings, MIN_PEAK_HOUR_FACTOR, SUMO_SIGMA, is_sumo_sigma, is_zero};
use basics::files::{self, FileError, limits};
use basics::seed;
use basics::units::SECONDS_PER_HOUR;

/// Lane on which vehicles start: of those that lead to their exit, that with the fewest vehicles.
const DEPART_LANE: &str = "best";

/// Speed with which vehicles start: what lane and driver allow, less if a vehicle ahead demands
/// it, so that the entry does not hold them up. The same in all SUMO versions.
const DEPART_SPEED: &str = "max";

/// A type of vehicle, spelled out so that every version of SUMO simulates the same one.
///
/// `speedDev` is 0 because each vehicle brings its own `speedFactor`. Its id; its size, speed and acceleration.
type VehicleType = (&'static str, &'static str);

/// SUMO's default passenger car.
const CAR: VehicleType = (
    "car",
    "vClass=\"passenger\" length=\"5\" minGap=\"2.5\" width=\"1.8\" height=\"1.5\" \
        maxSpeed=\"55.56\" accel=\"2.6\" decel=\"4.5\" emergencyDecel=\"9\" apparentDecel=\"4.5\"",
);

/// A single-unit truck: 30 ft long and 8 ft wide (AASHTO, A Policy on Geometric Design of Highways and
/// Streets, design vehicle SU-30); speed, acceleration and braking of SUMO's default truck.
const HEAVY: VehicleType = (
    "heavy",
    "vClass=\"truck\" length=\"9.1\" minGap=\"2.5\" width=\"2.4\" height=\"2.4\" \
        maxSpeed=\"36.11\" accel=\"1.3\" decel=\"4\" emergencyDecel=\"7\" apparentDecel=\"4\"",
);

/// How every vehicle follows and changes lanes, but for its dawdling: SUMO's defaults for its default models.
const MODELS: &str = "tau=\"1\" speedFactor=\"1\" speedDev=\"0\" \
    carFollowModel=\"Krauss\" laneChangeModel=\"LC2013\"";

/// Distribution of desired speeds relative to the limit: mean, deviation, lowest, highest
/// (SUMO's default for passenger cars, `normc(1,0.1,0.2,2)`).
const SPEED_FACTOR: [f64; 4] = [1.0, 0.1, 0.2, 2.0];

/// Who arrives at an intersection, independent of any seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DemandSpec {
    /// Vehicles arrive from 0 to here, seconds.
    pub horizon_s: f64,
    /// Vehicles of the horizon divided by four times those of its second quarter; 1 is an even flow.
    pub peak_hour_factor: f64,
    /// Share of heavy vehicles.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub heavy_vehicles: f64,
    /// SUMO's `sigma` of every vehicle.
    #[serde(default = "sumo_sigma", skip_serializing_if = "is_sumo_sigma")]
    pub sigma: f64,
    /// SUMO's `impatience` of every vehicle.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub impatience: f64,
    /// Streams of vehicles, one per incoming edge.
    pub streams: Vec<Stream>,
}

fn sumo_sigma() -> f64 {
    SUMO_SIGMA
}

/// The vehicles of one incoming edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stream {
    /// Edge on which they come to the signal, and start where there is none before it.
    pub from: String,
    /// Edges before that, from which they come, in the order in which they drive.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub upstream: Vec<String>,
    /// Turn lanes that are shorter than the street.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub storage: Option<Storage>,
    /// Rate of the Poisson process, vehicles per hour.
    pub inflow_vph: f64,
    /// When they come within the horizon; `None`: as the peak hour factor of the demand says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrivals: Option<Arrivals>,
    /// Share of heavy vehicles; `None`: that of the demand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heavy_vehicles: Option<f64>,
    /// People per hour who cross the street; `None`: as the settings of the signal say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pedestrians_per_h: Option<f64>,
    /// SUMO's `departLane`.
    pub depart_lane: String,
    /// SUMO's `departSpeed`.
    pub depart_speed: String,
    /// Where they go.
    pub routes: Vec<RouteShare>,
}

/// One destination of a stream.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RouteShare {
    /// Edge on which the vehicles leave.
    pub to: String,
    /// Probability; the shares of a stream sum to 1.
    pub share: f64,
}

/// One vehicle of one seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Vehicle {
    /// Index of its stream.
    pub stream: usize,
    /// Running number in its stream.
    pub number: u32,
    /// Index of its route in the stream.
    pub route: usize,
    /// Departure, whole seconds: SUMO inserts at its 1 s steps only, and would count a fraction as
    /// departure delay, half a second on average.
    pub depart_s: u32,
    /// Desired speed relative to the limit.
    pub speed_factor: f64,
    /// Whether it is a heavy vehicle.
    pub is_heavy: bool,
}

impl DemandSpec {
    /// Returns the demand of an intersection: a stream per incoming arm.
    ///
    /// The turn shares are renormalised over the turns that the arm has; several exits of the same turn share its part
    /// equally, unless vehicles were counted by exit. Where all turns of an arm have the share 0, they are equally likely.
    /// The shares are as on the ground. An arm whose turns were counted has the shares, the heavy vehicles and
    /// the quarter hours that were counted.
    /// Fails with [`NetworkError::Intersection`] for an impossible intersection, or vehicles that were counted on a turn that it
    /// does not have.
    pub fn from_intersection(
        spec: &IntersectionSpec,
        settings: &DemandSettings,
    ) -> Result<Self, NetworkError> {
        let movements = movements(spec)?;
        let shares = settings.turn_shares.as_right_hand(spec.side);
        let stream = |(i, inflow_vph): (usize, f64)| {
            let own: Vec<_> = movements.iter().filter(|m| m.from == i).copied().collect();
            let counted = spec.arms[i].counted;
            if let Some(counted) = &counted {
                every_turn_exists(spec, i, &own, counted)?;
            }
            let weight = |turn| counted.map_or_else(|| shares.of(turn), |c| c.turn_vph(turn));
            Ok(Stream {
                from: incoming_edge(i),
                upstream: pieces(spec, i).into_iter().skip(1).map(|p| p.edge).rev().collect(),
                storage: Storage::of(&spec.arms[i]),
                inflow_vph,
                arrivals: counted.and_then(|c| c.arrivals),
                heavy_vehicles: counted.and_then(|c| c.heavy_vehicles),
                pedestrians_per_h: counted.and_then(|c| c.pedestrians_per_h),
                depart_lane: DEPART_LANE.to_owned(),
                depart_speed: DEPART_SPEED.to_owned(),
                routes: routes(&own, by_exit(spec, i, &own).as_deref(), weight),
            })
        };
        let inflows = spec.arms.iter().map(|a| a.inflow_vph).enumerate();
        let streams = inflows.filter(|(i, _)| spec.arms[*i].lanes_in > 0).map(stream);
        Ok(Self::new(settings, streams.collect::<Result<_, NetworkError>>()?))
    }

    /// Returns the demand of streams, with the vehicles of the settings.
    pub fn new(settings: &DemandSettings, streams: Vec<Stream>) -> Self {
        let DemandSettings {
            horizon_s, peak_hour_factor, heavy_vehicles, sigma, impatience, ..
        } = *settings;
        Self { horizon_s, peak_hour_factor, heavy_vehicles, sigma, impatience, streams }
    }

    /// Returns the text of a `.demand.json`, which reads back as the same demand.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("strings and finite numbers are JSON") + "\n"
    }

    /// Draws the vehicles of a seed, by departure and then by stream.
    pub fn vehicles(&self, seed: u64) -> Vec<Vehicle> {
        let streams = self.streams.iter().enumerate();
        let mut all: Vec<_> = streams.flat_map(|(i, s)| self.arrivals(i, s, seed)).collect();
        all.sort_by_key(|v| (v.depart_s, v.stream, v.number));
        all
    }

    /// Writes the vehicles of a seed as a SUMO route file and returns their number.
    ///
    /// The same seed gives the same bytes.
    /// Fails with [`FileError`] if the file cannot be written.
    pub fn write_routes(&self, seed: u64, path: &Path) -> Result<u32, FileError> {
        let (vehicles, text) = self.routes(seed);
        std::fs::write(path, text).map_err(FileError::at("write", path))?;
        Ok(vehicles)
    }

    /// Returns how many vehicles a seed has, and the text of their SUMO route file.
    pub fn routes(&self, seed: u64) -> (u32, String) {
        let vehicles = self.vehicles(seed);
        (vehicles.len() as u32, self.routes_xml(&vehicles))
    }

    /// Returns the edges from which and to which every vehicle of a seed drives, by its id.
    pub fn ways(&self, seed: u64) -> BTreeMap<String, (String, String)> {
        let way = |v: Vehicle| {
            let Stream { from, routes, .. } = &self.streams[v.stream];
            (vehicle_id(from, v.number), (from.clone(), routes[v.route].to.clone()))
        };
        self.vehicles(seed).into_iter().map(way).collect()
    }

    /// Draws the vehicles of one stream.
    fn arrivals(&self, index: usize, stream: &Stream, seed: u64) -> Vec<Vehicle> {
        let [mut arrivals, mut turns, mut drivers, mut kinds] =
            ["arrivals", "turns", "drivers", "kinds"].map(|purpose| {
                ChaCha12Rng::seed_from_u64(seed::vehicles(seed, purpose, &stream.from))
            });
        let quarters = match stream.arrivals {
            None => peak(self.peak_hour_factor),
            Some(Arrivals::PeakHourFactor(factor)) => peak(factor),
            Some(Arrivals::QuarterHours(quarters)) => quarters,
        };
        let heavy_vehicles = stream.heavy_vehicles.unwrap_or(self.heavy_vehicles);
        let mut vehicles = Vec::new();
        let mut time_s = 0.0;
        loop {
            // 1 - u lies in (0, 1], whose logarithm is finite.
            let unit_gap = -(1.0 - arrivals.random::<f64>()).ln();
            time_s += unit_gap * SECONDS_PER_HOUR / stream.inflow_vph;
            if time_s.is_nan() || time_s >= self.horizon_s {
                return vehicles;
            }
            vehicles.push(Vehicle {
                stream: index,
                number: vehicles.len() as u32,
                route: stream.route(turns.random()),
                depart_s: depart_s(time_s, self.horizon_s, quarters) as u32,
                speed_factor: speed_factor(&mut drivers),
                is_heavy: kinds.random::<f64>() < heavy_vehicles,
            });
        }
    }

    /// Returns vehicles as the text of a SUMO route file.
    pub fn routes_xml(&self, vehicles: &[Vehicle]) -> String {
        let mut text = "<routes>\n".to_owned();
        self.push_type(&mut text, CAR);
        let heavy = |s: &Stream| s.heavy_vehicles.unwrap_or(self.heavy_vehicles) > 0.0;
        if self.streams.iter().any(heavy) {
            self.push_type(&mut text, HEAVY);
        }
        for stream in &self.streams {
            for RouteShare { to, .. } in &stream.routes {
                let from = &stream.from;
                let upstream: String =
                    stream.upstream.iter().map(|edge| format!("{edge} ")).collect();
                push(
                    &mut text,
                    format_args!("<route id=\"{from}-{to}\" edges=\"{upstream}{from} {to}\"/>"),
                );
            }
        }
        for v in vehicles {
            let stream = &self.streams[v.stream];
            let Stream { from, depart_lane, depart_speed, .. } = stream;
            let (id, to) = (vehicle_id(from, v.number), &stream.routes[v.route].to);
            let factor = v.speed_factor;
            let depart_s = v.depart_s;
            let (kind, _) = if v.is_heavy { HEAVY } else { CAR };
            push(
                &mut text,
                format_args!(
                    "<vehicle id=\"{id}\" type=\"{kind}\" route=\"{from}-{to}\" \
                     depart=\"{depart_s}\" departLane=\"{depart_lane}\" departPos=\"base\" \
                     departSpeed=\"{depart_speed}\" speedFactor=\"{factor:.4}\"/>"
                ),
            );
        }
        text.push_str("</routes>\n");
        text
    }

    /// Adds a type of vehicle, with what the settings say of its drivers.
    fn push_type(&self, text: &mut String, (id, attributes): VehicleType) {
        let sigma = self.sigma;
        let drivers = match self.impatience {
            0.0 => String::new(),
            impatience => format!(" impatience=\"{impatience}\""),
        };
        push(
            text,
            format_args!("<vType id=\"{id}\" {attributes} sigma=\"{sigma}\" {MODELS}{drivers}/>"),
        );
    }
}

impl Stream {
    /// Returns the route at a point of the cumulative distribution.
    fn route(&self, mut point: f64) -> usize {
        for (i, route) in self.routes.iter().enumerate() {
            point -= route.share;
            if point < 0.0 {
                return i;
            }
        }
        self.routes.len() - 1
    }
}

/// Refuses vehicles that were counted on a turn that an arm does not have.
fn every_turn_exists(
    spec: &IntersectionSpec,
    arm: usize,
    own: &[Movement],
    counted: &Counted,
) -> Result<(), NetworkError> {
    for turn in [Turn::Left, Turn::Through, Turn::Right] {
        let vph = counted.turn_vph(turn);
        if vph > 0.0 && !own.iter().any(|m| m.turn == turn) {
            let bearing_deg = spec.side.bearing_deg(spec.arms[arm].bearing_deg);
            let (left, right) = spec.side.swapped(("left_vph", "right_vph"));
            let column = match turn {
                Turn::Left => left,
                Turn::Through => "through_vph",
                Turn::Right => right,
            };
            return Err(NetworkError::Intersection {
                point: spec.point.clone(),
                reason: format!(
                    "{column} = {vph} on the arm with bearing_deg = {bearing_deg}, which has no such turn; correct \
                     movements or the bearings, or give these vehicles to another turn"
                ),
            });
        }
    }
    Ok(())
}

/// Returns the vehicles per hour that were counted to the destination of each movement of an arm; `None` where nobody
/// counted them by exit.
fn by_exit(spec: &IntersectionSpec, arm: usize, own: &[Movement]) -> Option<Vec<f64>> {
    let exits = exits(&spec.arms, arm);
    let mut vph = spec.arms[arm].counted?.exits_vph?.to_vec();
    vph.truncate(exits.len());
    // On the ground the leftmost exit is the first, and in the mirror the last.
    if !spec.side.is_right() {
        vph.reverse();
    }
    let to = |m: &Movement| {
        let exit = exits.iter().position(|exit| exit.to == m.to);
        exit.and_then(|exit| vph.get(exit)).copied().unwrap_or_default()
    };
    Some(own.iter().map(to).collect())
}

/// Returns the destinations of movements by the weights of their turns. Several of one turn divide its weight as
/// vehicles were counted by exit, else equally.
fn routes(
    movements: &[Movement],
    by_exit: Option<&[f64]>,
    weight_of: impl Fn(Turn) -> f64,
) -> Vec<RouteShare> {
    let weight = |(i, m): (usize, &Movement)| {
        let same = || (0..movements.len()).filter(|o| movements[*o].turn == m.turn);
        let sum: f64 = by_exit.map_or(0.0, |vph| same().map(|o| vph[o]).sum());
        match by_exit {
            Some(vph) if sum > 0.0 => weight_of(m.turn) * vph[i] / sum,
            _ => weight_of(m.turn) / same().count() as f64,
        }
    };
    let mut weights: Vec<_> = movements.iter().enumerate().map(weight).collect();
    if weights.iter().sum::<f64>() <= 0.0 {
        weights.fill(1.0);
    }
    let total: f64 = weights.iter().sum();
    let weighted = movements.iter().zip(weights);
    weighted.map(|(m, weight)| RouteShare { to: m.to_edge(), share: weight / total }).collect()
}

/// Draws a desired speed; like SUMO, draws again outside the bounds.
fn speed_factor(rng: &mut ChaCha12Rng) -> f64 {
    let [mean, deviation, low, high] = SPEED_FACTOR;
    let normal = Normal::new(mean, deviation).expect("the deviation is positive");
    loop {
        let factor = normal.sample(rng);
        if (low..=high).contains(&factor) {
            return factor;
        }
    }
}

/// Returns SUMO's id of a vehicle.
fn vehicle_id(from: &str, number: u32) -> String {
    format!("{from}.{number}")
}

fn push(text: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(text, "    {line}").expect("writing to a string cannot fail");
}

/// Most vehicles of an episode on average: what the settings allow on the largest intersection, and far more than
/// fit on its roads.
const MOST_VEHICLES: f64 = 5e7;

/// How far the shares of a stream may be from 1 together: they may be written with two digits.
const SHARES_SLACK: f64 = 0.02;

/// Longest episode, seconds.
const LONGEST_S: f64 = 86_400.0;

impl DemandSpec {
    /// Reads a `.demand.json`.
    /// Fails with [`FileError`] if it cannot be read or is not a demand.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(&files::read(path, limits::NETWORK)?, path)
    }

    /// Returns what a `.demand.json` holds; the path is for messages.
    /// Fails with [`FileError`] if it is not a demand, or one that no intersection has.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, FileError> {
        let demand: Self =
            serde_json::from_slice(bytes).map_err(|e| FileError::at("parse", path)(e.into()))?;
        let wrong = |what: String| {
            let reason = format!("{what}, which no intersection has; build its network again");
            FileError::at("use", path)(Error::new(ErrorKind::InvalidInput, reason))
        };
        if !demand.is_possible() {
            return Err(wrong("a duration, a number of vehicles or a share".to_owned()));
        }
        let stream = demand.streams.iter().find(|stream| !stream.is_possible());
        stream.map_or(Ok(()), |s| Err(wrong(format!("a stream from {:?}", s.from))))?;
        Ok(demand)
    }

    fn is_possible(&self) -> bool {
        let vehicles_vph: f64 = self.streams.iter().map(|stream| stream.inflow_vph.max(0.0)).sum();
        (0.0..=LONGEST_S).contains(&self.horizon_s)
            && vehicles_vph * self.horizon_s / SECONDS_PER_HOUR <= MOST_VEHICLES
            && is_factor(self.peak_hour_factor)
            && [self.heavy_vehicles, self.impatience, self.sigma].into_iter().all(is_share)
    }
}

impl Stream {
    fn is_possible(&self) -> bool {
        let comes = match self.arrivals {
            None => true,
            Some(Arrivals::PeakHourFactor(factor)) => is_factor(factor),
            Some(Arrivals::QuarterHours(quarters)) => {
                let sum: f64 = quarters.iter().sum();
                quarters.iter().all(|quarter| *quarter >= 0.0) && sum > 0.0 && sum.is_finite()
            }
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-.#:".contains(c);
        let is_name = |name: &String| !name.is_empty() && name.chars().all(plain);
        let names = self.routes.iter().map(|route| &route.to).chain(&self.upstream);
        let sum: f64 = self.routes.iter().map(|route| route.share).sum();
        comes
            && self.inflow_vph >= 0.0
            && is_share(self.heavy_vehicles.unwrap_or_default())
            && names.chain([&self.from, &self.depart_lane, &self.depart_speed]).all(is_name)
            && self.routes.iter().all(|route| is_share(route.share))
            && (sum - 1.0).abs() <= SHARES_SLACK
    }
}

fn is_share(value: f64) -> bool {
    (0.0..=1.0).contains(&value)
}

fn is_factor(value: f64) -> bool {
    (MIN_PEAK_HOUR_FACTOR..=1.0).contains(&value)
}

/// Quarters of a horizon, of which one is the peak.
const QUARTERS: f64 = 4.0;

/// Returns the vehicles of the quarters of a horizon with a peak hour factor, above 1/4, up to a common factor.
fn peak(factor: f64) -> [f64; 4] {
    let peak = 1.0 / factor;
    let other = (QUARTERS - peak) / (QUARTERS - 1.0);
    [other, peak, other, other]
}

/// Returns when a vehicle arrives that would arrive at the time `even_s` of an even flow, seconds, if the quarters of
/// the horizon have these vehicles, up to a common factor.
/// * `even_s` — from 0 up to but without `horizon_s`, as the result is.
/// * `quarters` — not negative, their sum above 0.
fn depart_s(even_s: f64, horizon_s: f64, quarters: [f64; 4]) -> f64 {
    if quarters == [1.0; 4] {
        return even_s;
    }
    let quarter_s = horizon_s / QUARTERS;
    let mut rest = even_s / horizon_s * quarters.iter().sum::<f64>();
    for (i, vehicles) in quarters.iter().enumerate() {
        if rest < *vehicles {
            let time_s = quarter_s * (i as f64 + rest / vehicles);
            return time_s.min((quarter_s * (i + 1) as f64).next_down());
        }
        rest -= vehicles;
    }
    // Rounding has carried the last vehicle past the last quarter that has any.
    let last =
        quarters.iter().rposition(|vehicles| *vehicles > 0.0).map_or(QUARTERS, |i| (i + 1) as f64);
    (quarter_s * last).next_down()
}

#[cfg(test)]
mod tests {
    use super::super::movements::shapes::{cross, star, tee, wye};
    use super::*;
    use crate::settings::TurnShares;

    fn demand(spec: &IntersectionSpec) -> DemandSpec {
        DemandSpec::from_intersection(spec, &DemandSettings::default()).unwrap()
    }

    fn shares(spec: &IntersectionSpec, stream: usize) -> Vec<f64> {
        demand(spec).streams[stream].routes.iter().map(|r| r.share).collect()
    }

    #[test]
    fn turn_shares_are_renormalised_over_the_turns_that_exist() {
        assert_eq!(shares(&cross(), 0), [0.1, 0.8, 0.1]);
        assert_eq!(shares(&wye(), 0), [0.5, 0.5]);
        assert_eq!(shares(&tee(), 2), [0.8 / 0.9, 0.1 / 0.9]);
        // Exits of the same turn share its part, and turns without any share are equally likely.
        assert_eq!(shares(&star(5), 0), [0.05, 0.05, 0.8, 0.1]);
        let turn_shares = TurnShares { left: 0.0, through: 1.0, right: 0.0 };
        let settings = DemandSettings { turn_shares, ..DemandSettings::default() };
        let demand = DemandSpec::from_intersection(&wye(), &settings).unwrap();
        assert_eq!(demand.streams[0].routes[0].share, 0.5);
    }

    /// An intersection whose first arm was counted.
    fn counted(mut spec: IntersectionSpec, [left, through, right]: [f64; 3]) -> IntersectionSpec {
        let arm = &mut spec.arms[0];
        arm.counted = Some(Counted {
            left_vph: left,
            through_vph: through,
            right_vph: right,
            arrivals: Some(Arrivals::QuarterHours([100.0, 200.0, 0.0, 100.0])),
            heavy_vehicles: Some(1.0),
            pedestrians_per_h: None,
            exits_vph: None,
        });
        arm.inflow_vph = left + through + right;
        spec
    }

    #[test]
    fn counted_turns_quarters_and_trucks_replace_those_of_the_settings_on_their_arm() {
        let demand = demand(&counted(cross(), [10.0, 70.0, 320.0]));
        let shares =
            |i: usize| demand.streams[i].routes.iter().map(|r| r.share).collect::<Vec<_>>();
        assert_eq!((shares(0), shares(1)), (vec![0.025, 0.175, 0.8], vec![0.1, 0.8, 0.1]));
        let long = DemandSpec { horizon_s: 36_000.0, ..demand };
        let mut quarters = [0_i32; 4];
        for v in long.vehicles(1).iter().filter(|v| v.stream == 0) {
            quarters[(v.depart_s / 9000) as usize] += 1;
            assert!(v.is_heavy);
        }
        // 4,000 vehicles, of which a quarter has 1,000, 2,000, none and 1,000.
        assert_eq!(quarters[2], 0);
        for (quarter, expected) in quarters.iter().zip([1000, 2000, 0, 1000]) {
            assert!((*quarter - expected).abs() < 130, "{quarters:?}");
        }
        assert!(long.vehicles(1).iter().all(|v| v.stream == 0 || !v.is_heavy));
    }

    #[test]
    fn vehicles_that_were_counted_by_exit_go_there() {
        // From the arm in the north two exits on the left, one ahead and one on the right.
        let mut spec = counted(star(5), [80.0, 20.0, 0.0]);
        if let Some(counted) = &mut spec.arms[0].counted {
            counted.exits_vph = Some([60.0, 20.0, 20.0, 0.0, 0.0]);
        }
        assert_eq!(shares(&spec, 0), [0.6, 0.2, 0.2, 0.0]);
        // In the mirror of left-hand traffic the last exit on the ground is the first.
        spec.side = osm_signals::DrivingSide::Left;
        if let Some(counted) = &mut spec.arms[0].counted {
            counted.exits_vph = Some([0.0, 20.0, 20.0, 60.0, 0.0]);
        }
        assert_eq!(shares(&spec, 0), [0.6, 0.2, 0.2, 0.0]);
    }

    #[test]
    fn vehicles_that_were_counted_on_a_turn_that_does_not_exist_are_refused() {
        let mut spec = counted(tee(), [1.0, 9.0, 30.0]);
        let refused = |spec: &IntersectionSpec| {
            let demand = DemandSpec::from_intersection(spec, &DemandSettings::default());
            demand.unwrap_err().to_string()
        };
        assert_eq!(
            refused(&spec),
            "p: right_vph = 30 on the arm with bearing_deg = 0, which has no such turn; correct movements or the \
             bearings, or give these vehicles to another turn"
        );
        spec.side = osm_signals::DrivingSide::Left;
        assert!(refused(&spec).contains("left_vph = 30"));
    }

    #[test]
    fn arrivals_come_at_the_rate_of_the_stream() {
        let mut demand = demand(&cross());
        demand.horizon_s = 360_000.0;
        let count = demand.vehicles(1).iter().filter(|v| v.stream == 2).count() as f64;
        // 400 per hour for 100 hours; the deviation is 200.
        assert!((count - 40_000.0).abs() < 800.0, "{count}");
    }

    #[test]
    fn changing_one_stream_leaves_the_others_alone() {
        let demand = demand(&cross());
        let mut other = demand.clone();
        other.streams[1].inflow_vph = 900.0;
        other.streams[1].routes.remove(0);
        let rest = |d: &DemandSpec| -> Vec<_> {
            d.vehicles(3).into_iter().filter(|v| v.stream != 1).collect()
        };
        assert_eq!(rest(&demand), rest(&other));
    }

    #[test]
    fn a_higher_inflow_squeezes_the_same_arrivals_together() {
        let demand = demand(&cross());
        let mut other = demand.clone();
        other.streams[0].inflow_vph *= 2.0;
        let first = |d: &DemandSpec| d.vehicles(3).into_iter().find(|v| v.stream == 0).unwrap();
        let (slow, fast) = (first(&demand), first(&other));
        assert!(slow.depart_s.abs_diff(2 * fast.depart_s) <= 1);
        assert_eq!((slow.route, slow.speed_factor), (fast.route, fast.speed_factor));
    }

    #[test]
    fn a_peak_moves_the_same_vehicles_within_the_horizon() {
        let identity = |v: &Vehicle| (v.stream, v.number, v.route, v.speed_factor.to_bits());
        let of = [1.0, 0.92, 0.26].map(|peak_hour_factor| {
            let vehicles = DemandSpec { peak_hour_factor, ..demand(&cross()) }.vehicles(3);
            vehicles.iter().map(identity).collect::<std::collections::BTreeSet<_>>()
        });
        assert!(of[0] == of[1] && of[1] == of[2]);
    }

    #[test]
    fn speed_factors_have_sumos_mean_and_deviation() {
        let mut demand = demand(&cross());
        demand.horizon_s = 360_000.0;
        let factors: Vec<_> = demand.vehicles(1).iter().map(|v| v.speed_factor).collect();
        let n = factors.len() as f64;
        let mean = factors.iter().sum::<f64>() / n;
        let deviation = (factors.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((mean - 1.0).abs() < 0.002 && (deviation - 0.1).abs() < 0.002);
    }

    #[test]
    fn a_car_is_sumos_default_and_nothing_is_said_of_heavy_vehicles_without_any() {
        let text = demand(&cross()).routes_xml(&[]);
        let car = "<routes>\n    <vType id=\"car\" vClass=\"passenger\" length=\"5\" minGap=\"2.5\" width=\"1.8\" \
                   height=\"1.5\" maxSpeed=\"55.56\" accel=\"2.6\" decel=\"4.5\" emergencyDecel=\"9\" \
                   apparentDecel=\"4.5\" sigma=\"0.5\" tau=\"1\" speedFactor=\"1\" speedDev=\"0\" \
                   carFollowModel=\"Krauss\" laneChangeModel=\"LC2013\"/>\n    <route ";
        assert!(text.starts_with(car), "{text}");
        let json = demand(&cross()).to_json();
        assert!(!json.contains("heavy") && !json.contains("impatience"), "{json}");
        let spec = DemandSpec { sigma: 0.3, impatience: 0.7, ..demand(&cross()) };
        let text = spec.routes_xml(&[]);
        assert!(text.contains(" sigma=\"0.3\" tau=\"1\""), "{text}");
        assert!(text.contains(" impatience=\"0.7\"/>"), "{text}");
    }

    #[test]
    fn a_share_of_the_same_vehicles_is_heavy_and_more_with_a_larger_share() {
        let of =
            |heavy_vehicles| DemandSpec { heavy_vehicles, horizon_s: 36_000.0, ..demand(&cross()) };
        let [none, some, more] = [0.0, 0.03, 0.5].map(|share| of(share).vehicles(3));
        let light = |all: &[Vehicle]| -> Vec<Vehicle> {
            all.iter().map(|v| Vehicle { is_heavy: false, ..v.clone() }).collect()
        };
        assert!(none == light(&some) && none == light(&more));
        assert!(some.iter().zip(&more).all(|(a, b)| !a.is_heavy || b.is_heavy));
        let heavy = some.iter().filter(|v| v.is_heavy).count() as f64;
        // 3% of 16,000; the deviation is 22.
        assert!((heavy - 0.03 * some.len() as f64).abs() < 90.0, "{heavy} of {}", some.len());
        let text = of(0.03).routes_xml(&some);
        let first = "departLane=\"best\" departPos=\"base\" departSpeed=\"max\" speedFactor=\"";
        assert!(text.contains(first), "{text}");
        assert!(text.contains("<vType id=\"heavy\" vClass=\"truck\" length=\"9.1\""), "{text}");
        assert_eq!(text.matches("type=\"heavy\"").count() as f64, heavy);
    }

    #[test]
    fn what_no_intersection_has_is_refused() {
        let text = r#"{"horizon_s":60.0,"peak_hour_factor":1.0,"streams":[{"from":"in0","inflow_vph":60.0,
            "depart_lane":"best","depart_speed":"max","routes":[{"to":"out1","share":1.0}]}]}"#;
        let parse = |text: &str| DemandSpec::parse(text.as_bytes(), Path::new("d.json"));
        assert!(parse(text).unwrap().vehicles(1).len() < 10);
        for (from, to) in [
            ("out1", r#"x\"/><include href=\"y.xml"#),
            (r#"{"to":"out1","share":1.0}"#, ""),
            (r#""share":1.0"#, r#""share":0.4"#),
            ("_vph\":60.0", "_vph\":1e300"),
            ("_s\":60.0", "_s\":1e9"),
            ("factor\":1.0", "factor\":1.0,\"sigma\":-1.0"),
        ] {
            let e = parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(e.starts_with("cannot use d.json: "), "{e}");
        }
    }

    #[test]
    fn quarters_have_their_vehicles_in_order_and_an_empty_one_nobody() {
        let hour_s = 3600.0;
        let even = peak(1.0);
        assert!([0.0, 899.999, 1800.1, 3599.9].iter().all(|t| depart_s(*t, hour_s, even) == *t));
        // The second quarter has the volume divided by the peak hour factor.
        assert_eq!(peak(0.8), [2.75 / 3.0, 1.25, 2.75 / 3.0, 2.75 / 3.0]);
        for quarters in [peak(0.26), peak(0.92), [100.0, 0.0, 300.0, 0.0], [250.0; 4]] {
            let times: Vec<f64> =
                (0..4000).map(|k| depart_s(0.9 * f64::from(k), hour_s, quarters)).collect();
            assert!(times.is_sorted() && times[0] == 0.0);
            assert!(depart_s(hour_s.next_down(), hour_s, quarters) < hour_s);
            for (i, expected) in quarters.iter().enumerate() {
                let is_own = |t: &&f64| (**t / 900.0) as usize == i;
                let share = times.iter().filter(is_own).count() as f64 / 4000.0;
                let expected = expected / quarters.iter().sum::<f64>();
                assert!((share - expected).abs() < 1e-3, "{quarters:?}: {i}");
            }
        }
    }
}
