//! A scenario file: where the family comes from and every setting of networks, demand and signals.
//!
//! Every setting is declared once, with its default and range: here, or in the file of its method. The
//! default of `name` is the file's, see `default_name.rs`. Unknown fields are errors.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use osm_signals::DrivingSide;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::control;
use crate::control::registry::methods;
use evaluation::run::selection::training_settings;
use evaluation::settings::named::{Named, names_of};
use evaluation::settings::setting::{self, Section, Setting, settings};
use evaluation::stats::{Limit, Side};

pub use demand::{DemandSettings, MAX_APPROACH_SPREAD, TurnShares};
pub(crate) use demand::{MIN_PEAK_HOUR_FACTOR, SUMO_SIGMA, is_sumo_sigma, is_zero};
pub use signal::{Actions, ChangeInterval, LeftTurns, Preset, SignalSettings};

pub mod check;
mod demand;
pub mod signal;

/// Declares the scenario, with the section of every method that has settings.
macro_rules! scenario {
    ($(super::$first:ident $(::$first_config:ident)?),*; $(super::$then:ident $(::$then_config:ident)?),*) => {
        /// A scenario as written in TOML.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct Scenario {
            /// Which domain reads the file, by which it was chosen; manifests do not say it.
            #[serde(default, skip_serializing)]
            pub domain: IgnoredAny,
            /// Name of the family; also the default folder of its networks. By default that of the
            /// file.
            #[serde(default)]
            pub name: String,
            /// One sentence for people.
            #[serde(default)]
            pub title: String,
            /// Number of the family's definition; a change of data or rules that moves results raises
            /// it.
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
            $($(
                #[doc = concat!("Settings of the method in `control/", stringify!($first), ".rs`.")]
                #[serde(default)]
                pub $first: control::$first::$first_config,
            )?)*
            /// How long learners are trained.
            #[serde(default)]
            pub training: TrainingSettings,
            $($(
                #[doc = concat!("Settings of the method in `control/", stringify!($then), ".rs`.")]
                #[serde(default)]
                pub $then: control::$then::$then_config,
            )?)*
        }

        impl Scenario {
            /// Returns its sections by name.
            pub fn sections(&self) -> Vec<(&'static str, &dyn Section)> {
                let mut sections: Vec<(&'static str, &dyn Section)> = vec![
                    ("family", &self.family),
                    ("network", &self.network),
                    ("demand", &self.demand),
                    ("signal", &self.signal),
                    ("simulation", &self.simulation),
                    ("training", &self.training),
                ];
                $($({
                    let section: &control::$first::$first_config = &self.$first;
                    sections.push((stringify!($first), section));
                })?)*
                $($({
                    let section: &control::$then::$then_config = &self.$then;
                    sections.push((stringify!($then), section));
                })?)*
                sections
            }
        }
    };
}
methods!(scenario);

/// Version of a scenario that says none.
fn first_version() -> u32 {
    1
}

settings! {
    /// Where the point MDPs come from: exactly one of `approaches` and `points`.
    pub struct FamilySettings, source "Jayawardana et al. (NeurIPS 2022), appendix" {
        /// Table of real approaches, relative to the scenario file; the point MDPs are derived.
        approaches: Option<String> = None;
        /// Table of point MDPs, relative to the scenario file, as written by hand.
        points: Option<String> = None;
        /// Description of an intersection: `six-features`, or `per-approach`, its real arms. A scenario of your own
        /// with `approaches` has `per-approach` unless it says otherwise.
        detail: Detail = Detail::SixFeatures;
        /// Share of the daily traffic that arrives in the simulated hour: 1/24 is the paper's AADT per
        /// hour, 0.055 fits UDOT's counts, 0.084 is a traffic engineer's design hour.
        hourly_share: f64 = 1.0 / 24.0, in 1e-6..=1.0;
        /// Share of the hour's traffic of a two-way street that goes in its peak direction: 0.5 makes the
        /// directions equal, 0.55 is a usual design hour.
        #[serde(skip_serializing_if = "is_even")]
        directional_split: f64 = EVEN_SPLIT, in EVEN_SPLIT..=1.0;
        /// Heading, clockwise from north. The peak direction of every street lies within 90 degrees of it.
        #[serde(skip_serializing_if = "is_north_east")]
        peak_heading_deg: f64 = NORTH_EAST_DEG, in 0.0..=360.0, unit "degrees";
        /// Upper limit of the inflow.
        inflow_cap_vph_per_lane: f64 = 900.0, in 1.0..=3600.0, unit "veh/h per lane", source "IntersectionZoo's cap";
        /// Lower limit of a point MDP's inflow: without vehicles a score is undefined.
        min_inflow_vph: f64 = 60.0, in 1.0..=3600.0, unit "veh/h per approach", source "our choice";
        /// Factor on every length; 0.757 turns EPSG:3395 lengths at 40.76 degrees north into ground
        /// distances.
        length_scale: f64 = 1.0, in 0.01..=100.0;
        /// Width of the bins in which intersections are one point MDP; only with `six-features`.
        bins: SixFeatures = SixFeatures {
            lanes: 1.0,
            speed_mph: 5.0,
            length_m: 100.0,
            inflow_vph: 250.0,
            left_turn_lanes: 1.0,
            right_turn_lanes: 1.0,
        };
        /// Hours per year of each period that the table of approaches has, such as `{ am = 500, pm = 750 }`: a period's
        /// point MDPs have importance in proportion to them. Without it all periods count equally.
        #[serde(skip_serializing_if = "Option::is_none")]
        periods: Option<BTreeMap<String, f64>> = None;
        /// Table of the plans that signals have today, relative to the scenario file; the method `existing` runs them.
        #[serde(skip_serializing_if = "Option::is_none")]
        existing: Option<String> = None;
        /// Whether pedestrian counts of 0 are counts of nobody where a file has no other. Otherwise nobody counted there, and
        /// pedestrians have recall. It has an effect only on `build-networks` with UTDF or turning counts.
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        zero_pedestrians: bool = false;
        /// Sources of the table's inflows, shown on the pages of results. They change no result.
        #[serde(skip_serializing_if = "Option::is_none")]
        inflows: Option<InflowSources> = None;
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
            self.lanes, self.speed_mph, self.length_m, self.inflow_vph, self.left_turn_lanes,
            self.right_turn_lanes,
        ]
    }

    /// Returns the features from values in the order of [`Self::COLUMNS`].
    pub fn from_array(values: [f64; 6]) -> Self {
        let [lanes, speed_mph, length_m, inflow_vph, left_turn_lanes, right_turn_lanes] = values;
        Self { lanes, speed_mph, length_m, inflow_vph, left_turn_lanes, right_turn_lanes }
    }
}

settings! {
    /// How intersections become road networks.
    pub struct NetworkSettings, source "netconvert's defaults where it has one, else our choice" {
        /// Length of outgoing edges. They cost simulation time and do not change results.
        exit_length_m: f64 = 60.0, in 10.0..=10_000.0, unit "m";
        /// Green of each phase of the program `phases` in a network's file. This program lists the phases of
        /// `all-pairs`, and no method runs it.
        phase_green_s: f64 = 30.0, in 1.0..=300.0, unit "s";
        /// Cycle that netconvert's default program gets.
        default_cycle_s: f64 = 90.0, in 20.0..=600.0, unit "s";
        /// Duration of left-turn phases in netconvert's default program, within the limits of
        /// `[signal]`. In left-hand traffic these are the phases of right turns, which cross opposing
        /// traffic there.
        default_left_green_s: f64 = 6.0, in 1.0..=100.0, unit "s";
        /// Side of the street that traffic keeps to, `right` or `left`. Tables and shares of turns are as on the ground;
        /// networks of left-hand traffic are the mirror image of right-hand ones.
        #[serde(skip_serializing_if = "DrivingSide::is_right")]
        driving_side: DrivingSide = DrivingSide::Right;
    }
}

settings! {
    /// How SUMO is run.
    pub struct SimulationSettings, source "RESCO" {
        /// Waiting time after which SUMO teleports a vehicle; negative: never.
        time_to_teleport_s: f64 = -1.0, in -1.0..=86_400.0, unit "s";
    }
}

training_settings! {
    {
        /// How long learners are trained, and which of their policies is evaluated. A row of training is an episode.
        pub struct TrainingSettings, source "RESCO, main.py"
    }
    /// Episodes of training per task, for every learner.
    episodes: u32 = 100, in 1.0..=1e6, unit "episodes";
    /// Power of the baseline's mean queue at each intersection by which `train` divides its rewards: 0 leaves them, 1 makes
    /// intersections count equally. It has no effect elsewhere.
    #[serde(skip_serializing_if = "is_whole")]
    reward_scale: f64 = 1.0, in 0.0..=1.0, source "our choice";
}

/// Mean waiting per vehicle above which a controller fails at an intersection, seconds.
///
/// Source: Jayawardana et al. (NeurIPS 2022), appendix, "Further experiments on approximation algorithms".
const FAILED_WAITING_S: f64 = 20.0;

/// Returns what counts as a failure.
pub fn failure() -> Limit {
    Limit { metric: "waiting_s".to_owned(), side: Side::Above, value: FAILED_WAITING_S }
}

/// Share of each direction of a street whose directions are equal.
pub const EVEN_SPLIT: f64 = 0.5;

/// Heading around which the peak direction of streets lies, degrees clockwise from north.
pub const NORTH_EAST_DEG: f64 = 45.0;

/// What the inflows of a table of approaches rest on: shares of the approaches, which sum to 1. Pages
/// of results say it; it decides nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InflowSources {
    /// A traffic count on the approach.
    pub counted: f64,
    /// A traffic count elsewhere on the same street.
    pub spread: f64,
    /// The mean of counted streets of its class.
    pub imputed: f64,
    /// A default by class of street.
    pub default: f64,
    /// Vehicles by turn in the simulated hour; among `counted`. The table of approaches says it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub by_turn: f64,
}

impl InflowSources {
    /// Returns the shares in the order of their worth.
    pub fn to_array(self) -> [f64; 4] {
        [self.counted, self.spread, self.imputed, self.default]
    }
}

/// Returns whether a share is that of equal directions.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_even(share: &f64) -> bool {
    *share == EVEN_SPLIT
}

/// Returns whether a power is the default.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_whole(power: &f64) -> bool {
    *power == 1.0
}

/// Returns whether a heading is the default.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_north_east(heading_deg: &f64) -> bool {
    *heading_deg == NORTH_EAST_DEG
}

/// Returns a setting by its dotted name; `None` for what stands outside of sections or deeper in them.
pub fn find(name: &str) -> Option<&'static Setting> {
    setting::find(&defaults().sections(), name)
}

/// Returns a scenario of defaults.
pub fn defaults() -> Scenario {
    toml::from_str("").expect("every setting has a default")
}

/// A scenario with all settings that can be given.
const WHOLE: &str = "name = \"x\"\nsignal.max_green_s = 50\nsignal.longest_wait_s = 1\nsignal.lane_width_m = 3.0\n\
    signal.left_turns = \"permissive\"\n\
    signal.pedestrian_calls_per_h = 1.0\nfamily.points = \"p\"\nfamily.zero_pedestrians = true\nfamily.existing = \"e\"\n\
                     family.approaches = \"a\"\nfamily.directional_split = 0.55\n\
                     family.peak_heading_deg = 90\nsignal.turn_on_red = true\nsignal.no_merging_greens = true\n\
                     demand.heavy_vehicles = 0.03\ndemand.sigma = 0.2\ndemand.impatience = 0.5";

static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let scenario: Scenario = toml::from_str(WHOLE).expect("the text is a scenario");
    names_of(&Table::try_from(scenario).expect("a scenario is plain data"))
});

impl Named for Scenario {
    fn names() -> &'static [String] {
        &NAMES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::settings::named::Named;

    #[test]
    fn every_setting_of_a_section_is_in_the_table() {
        for name in Scenario::names().iter().filter(|name| name.split('.').count() == 2) {
            assert!(find(name).is_some(), "{name}");
        }
        assert_eq!(find("idqn.batch_size").map(|s| s.unit), Some("transitions"));
        assert!(find("idqn.batch").is_none() && find("title").is_none());
    }

    #[test]
    fn every_number_with_a_range_has_its_default_within() {
        for (name, section) in defaults().sections() {
            for r in section.ranges() {
                assert!((r.low..=r.high).contains(&r.value), "{name}.{}", r.name);
            }
        }
    }

    #[test]
    fn every_setting_is_named() {
        for table in ["", "family.", "signal.", "demand.", "demand.turn_shares.", "family.bins."] {
            let text = format!("{table}zzz = 1\n{WHOLE}");
            let error = toml::from_str::<Scenario>(&text).unwrap_err();
            let (_, expected) = error.message().split_once("expected").unwrap();
            let names: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
            assert!(names.len() > 2, "{error}");
            // What inflows rest on is written by `build-networks --osm`, not set by people; which domain reads a file
            // is said in the file alone; periods have the names that the table gives them.
            let own = ["inflows", "domain", "periods"];
            for name in names.into_iter().filter(|name| !own.contains(name)) {
                let dotted = format!("{table}{name}");
                let found =
                    NAMES.iter().any(|s| *s == dotted || s.starts_with(&format!("{dotted}.")));
                assert!(found, "{dotted}");
            }
        }
    }
}
