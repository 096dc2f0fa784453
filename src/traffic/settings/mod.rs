//! A scenario file: where the family comes from and every setting of networks, demand and signals.
//!
//! All fields but one source of the family have defaults, which live in the `Default` impls below and
//! nowhere else; that of `name` is the file's, see `default_name.rs`. Unknown fields are errors.

pub mod check;
mod demand;
pub mod inflow;
pub mod signal;

use serde::{Deserialize, Serialize};

use crate::traffic::control::{idqn, ippo, max_pressure, mplight, mplight_star};
use crate::traffic::side::DrivingSide;

pub use demand::{DemandSettings, MAX_APPROACH_SPREAD, TurnShares};
use inflow::{EVEN_SPLIT, InflowSources, NORTH_EAST_DEG, is_even, is_north_east};
pub use signal::{Actions, ChangeInterval, Preset, SignalSettings};

/// A scenario as written in TOML.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of the family; also the default folder of its networks. By default that of the file.
    #[serde(default)]
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub title: String,
    /// Number of the family's definition; a change of data or rules that moves results raises it.
    #[serde(default = "first_version")]
    pub version: u32,
    /// Limits of timing and demand that other defaults than the plain ones come from.
    #[serde(default)]
    pub preset: Preset,
    /// Where the point MDPs come from.
    #[serde(default)]
    pub family: FamilySettings,
    /// How intersections become road networks.
    #[serde(default)]
    pub network: NetworkSettings,
    /// Which vehicles arrive.
    #[serde(default)]
    pub demand: DemandSettings,
    /// How signals are timed and what controllers see.
    #[serde(default)]
    pub signal: SignalSettings,
    /// How SUMO is run.
    #[serde(default)]
    pub simulation: SimulationSettings,
    /// The denominator of every score.
    #[serde(default)]
    pub baseline: BaselineSettings,
    /// The tuned fixed-time controller.
    #[serde(default)]
    pub fixed_time: FixedTimeSettings,
    /// Max pressure as Varaiya defines it.
    #[serde(default)]
    pub max_pressure: max_pressure::Config,
    /// SUMO's gap-based control.
    #[serde(default)]
    pub actuated: ActuatedSettings,
    /// How long learners are trained.
    #[serde(default)]
    pub training: TrainingSettings,
    /// Hyper-parameters of `idqn`.
    #[serde(default)]
    pub idqn: idqn::Config,
    /// Hyper-parameters of `ippo`.
    #[serde(default)]
    pub ippo: ippo::Config,
    /// Hyper-parameters of `mplight`.
    #[serde(default)]
    pub mplight: mplight::Config,
    /// Hyper-parameters of `mplight-star`.
    #[serde(default)]
    pub mplight_star: mplight_star::Config,
    /// Hyper-parameters of `mplight-star-resco`.
    #[serde(default)]
    pub mplight_star_resco: mplight_star::Config,
}

/// Version of a scenario that says none.
fn first_version() -> u32 {
    1
}

/// Where the point MDPs come from: exactly one of `approaches` and `points`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FamilySettings {
    /// Table of real approaches, relative to the scenario file; the point MDPs are derived.
    pub approaches: Option<String>,
    /// Table of point MDPs, relative to the scenario file, as written by hand.
    pub points: Option<String>,
    /// Six features per intersection or its real arms; needs `approaches` for the latter.
    pub detail: Detail,
    /// Share of the daily traffic that arrives in the simulated hour: 1/24 is the paper's AADT per
    /// hour, 0.055 fits UDOT's counts, 0.084 is a traffic engineer's design hour.
    pub hourly_share: f64,
    /// Share of the hour's traffic of a two-way street that goes in its peak direction: 0.5 makes the
    /// directions equal, 0.55 is a usual design hour. Left out of manifests where it is 0.5.
    #[serde(skip_serializing_if = "is_even")]
    pub directional_split: f64,
    /// Heading within 90 degrees of which the peak direction of every street lies, degrees clockwise
    /// from north. Left out of manifests where it is 45.
    #[serde(skip_serializing_if = "is_north_east")]
    pub peak_heading_deg: f64,
    /// Upper limit of the inflow, vehicles per hour and lane (IntersectionZoo's cap).
    pub inflow_cap_vph_per_lane: f64,
    /// Lower limit of a point MDP's inflow, vehicles per hour and approach: without vehicles a
    /// score is undefined.
    pub min_inflow_vph: f64,
    /// Factor on every length; 0.757 turns EPSG:3395 lengths at 40.76 degrees north into ground
    /// distances.
    pub length_scale: f64,
    /// Width of the bins that make intersections one point MDP; six-feature detail only.
    pub bins: SixFeatures,
    /// What the inflows of the table rest on, for the pages of results; decides nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inflows: Option<InflowSources>,
}

impl Default for FamilySettings {
    fn default() -> Self {
        Self {
            approaches: None,
            points: None,
            detail: Detail::SixFeatures,
            hourly_share: 1.0 / 24.0,
            directional_split: EVEN_SPLIT,
            peak_heading_deg: NORTH_EAST_DEG,
            inflow_cap_vph_per_lane: 900.0,
            min_inflow_vph: 60.0,
            length_scale: 1.0,
            bins: SixFeatures {
                lanes: 1.0,
                speed_mph: 5.0,
                length_m: 100.0,
                inflow_vph: 250.0,
                left_turn_lanes: 1.0,
                right_turn_lanes: 1.0,
            },
            inflows: None,
        }
    }
}

/// How much of an intersection its network keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Detail {
    /// Four equal arms from six features, as the paper describes a point MDP.
    SixFeatures,
    /// The real arms, each with its own features; every intersection is a point MDP of its own.
    PerApproach,
}

/// One value per feature of an intersection.
///
/// Source: Jayawardana et al. (NeurIPS 2022), appendix, intersection features.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SixFeatures {
    /// Lanes of an approach, both directions.
    pub lanes: f64,
    /// Speed limit, miles per hour.
    pub speed_mph: f64,
    /// Length of an approach, metres.
    pub length_m: f64,
    /// Arriving vehicles per hour and approach.
    pub inflow_vph: f64,
    /// Left-only lanes per approach.
    pub left_turn_lanes: f64,
    /// Right-only lanes per approach.
    pub right_turn_lanes: f64,
}

impl SixFeatures {
    /// Names and units, in the order of [`Self::to_array`].
    pub const COLUMNS: [(&'static str, &'static str); 6] = [
        ("lanes", "lanes, both directions"),
        ("speed_mph", "mph"),
        ("length_m", "m"),
        ("inflow_vph", "veh/h per approach"),
        ("left_turn_lanes", "lanes per approach"),
        ("right_turn_lanes", "lanes per approach"),
    ];

    /// Returns the values in the order of [`Self::COLUMNS`].
    pub fn to_array(self) -> [f64; 6] {
        [
            self.lanes,
            self.speed_mph,
            self.length_m,
            self.inflow_vph,
            self.left_turn_lanes,
            self.right_turn_lanes,
        ]
    }

    /// Returns the features from values in the order of [`Self::COLUMNS`].
    pub fn from_array(values: [f64; 6]) -> Self {
        let [lanes, speed_mph, length_m, inflow_vph, left_turn_lanes, right_turn_lanes] = values;
        Self { lanes, speed_mph, length_m, inflow_vph, left_turn_lanes, right_turn_lanes }
    }
}

/// How intersections become road networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkSettings {
    /// Length of outgoing edges, metres: they cost simulation time and change nothing.
    pub exit_length_m: f64,
    /// Green of each phase in the networks' own eight-phase program, seconds; controllers choose
    /// their own durations.
    pub phase_green_s: f64,
    /// Cycle that netconvert's default program gets, seconds.
    pub default_cycle_s: f64,
    /// Duration of left-turn phases in netconvert's default program, seconds, within the limits of
    /// `[signal]`. In left-hand traffic these are the phases of right turns, which cross opposing
    /// traffic there.
    pub default_left_green_s: f64,
    /// Side of the street that traffic keeps to. Tables and shares of turns are as on the ground;
    /// networks of left-hand traffic are the mirror image of right-hand ones.
    #[serde(skip_serializing_if = "DrivingSide::is_right")]
    pub driving_side: DrivingSide,
}

impl Default for NetworkSettings {
    fn default() -> Self {
        Self {
            exit_length_m: 60.0,
            phase_green_s: 30.0,
            default_cycle_s: 90.0,
            default_left_green_s: 6.0,
            driving_side: DrivingSide::Right,
        }
    }
}

/// How SUMO is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationSettings {
    /// Waiting time after which SUMO teleports a vehicle, seconds; negative: never, as in RESCO.
    pub time_to_teleport_s: f64,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self { time_to_teleport_s: -1.0 }
    }
}

/// The denominator of every score: an untuned fixed-time program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineSettings {
    /// Which program; `auto` is `netconvert` for generated networks and `equal-split` for imported
    /// scenarios.
    pub program: BaselineProgram,
    /// Green per phase of the equal split, seconds; 35 s reproduces the paper's normaliser.
    pub green_s: f64,
}

impl Default for BaselineSettings {
    fn default() -> Self {
        Self { program: BaselineProgram::Auto, green_s: 35.0 }
    }
}

/// Programs that the baseline can run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BaselineProgram {
    /// `netconvert` for generated networks, `equal-split` for imported scenarios.
    Auto,
    /// The program that netconvert gives a signal by default.
    Netconvert,
    /// The same green for every phase.
    EqualSplit,
}

/// The tuned fixed-time controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedTimeSettings {
    /// Simulated episodes that tuning may use.
    pub simulations: u32,
    /// Time lost per phase change in Webster's formula, seconds.
    pub lost_time_s: f64,
    /// Saturation flow in Webster's formula, vehicles per hour and lane (HCM base 1900).
    pub saturation_flow_vph: f64,
}

impl Default for FixedTimeSettings {
    fn default() -> Self {
        Self { simulations: 24, lost_time_s: 4.0, saturation_flow_vph: 1900.0 }
    }
}

/// SUMO's gap-based control.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ActuatedSettings {
    /// Longest green, seconds (SUMO's default), within the limits of `[signal]`.
    pub max_green_s: f64,
}

impl Default for ActuatedSettings {
    fn default() -> Self {
        Self { max_green_s: 50.0 }
    }
}

/// How long learners are trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingSettings {
    /// Episodes of training per task, for every learner.
    pub episodes: u32,
}

impl Default for TrainingSettings {
    fn default() -> Self {
        Self { episodes: 100 }
    }
}
