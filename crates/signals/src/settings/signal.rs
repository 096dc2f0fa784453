//! How signals are timed, the same for every method, and the presets that decide it.
//!
//! The limits bind every method and the baseline of generated networks: whoever chooses a phase or a
//! cycle does so within them. What they mean for a signal is computed in [`crate::timing`].

use serde::{Deserialize, Serialize};

use super::is_zero;
use evaluation::settings::setting::settings;

/// What the settings that a scenario does not name are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// The literature's limits: 3 s of yellow, no all-red, 7 s of least green, no pedestrians.
    #[default]
    Resco,
    /// What a cabinet in the street would allow: change intervals by speed and width, greens that
    /// let pedestrians cross, a shortest cycle, a longest green; unequal approaches with a peak.
    Field,
}

impl Preset {
    /// Returns the settings in which the preset differs from the defaults, as TOML.
    pub fn text(self) -> &'static str {
        match self {
            Self::Resco => "",
            Self::Field => include_str!("../../../../scenarios/presets/field.toml"),
        }
    }

    /// Returns the name that the preset has in a scenario.
    pub fn name(self) -> &'static str {
        match self {
            Self::Resco => "resco",
            Self::Field => "field",
        }
    }
}

/// Which greens a controller chooses from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Actions {
    /// The greens of the signal's own program, as in RESCO.
    OwnGreens,
    /// On generated networks every pair of movements that can be green together; imported networks
    /// have no more than their own greens.
    AllPairs,
}

/// How long yellow and all-red last between two greens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangeInterval {
    /// `yellow_time_s` and `all_red_s` everywhere.
    Fixed,
    /// By approach speed and crossing width, and no less than these two (ITE's kinematic formula).
    Kinematic,
}

/// How left turns that cross opposing traffic are signalled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LeftTurns {
    /// As netconvert does it, and as the eight phases of RESCO have it.
    Network,
    /// They yield.
    Permissive,
    /// They have an arrow, and red otherwise.
    Protected,
    /// They have an arrow, and yield otherwise.
    ProtectedPermissive,
    /// One of these for each approach, by lanes, volumes and speed.
    ByRule,
    /// As the existing plan has them; without one, by rule.
    Existing,
}

impl LeftTurns {
    /// Whether it is left to the network.
    pub fn is_network(&self) -> bool {
        *self == Self::Network
    }

    /// Whether those of an approach have an arrow; the last two are no approach's.
    pub fn has_arrow(self) -> bool {
        self != Self::Permissive
    }
}

settings! {
    /// How signals are timed and what controllers see.
    pub struct SignalSettings, source "RESCO's settings for single intersections" {
        /// Greens that a controller chooses from: `own-greens` are those of the signal's own program, as in RESCO, and
        /// `all-pairs` are all pairs of movements that can be green together. Imported networks have only their own
        /// greens.
        actions: Actions = Actions::OwnGreens;
        /// Time between decisions.
        delta_time_s: u32 = 10, in 1.0..=300.0, unit "s";
        /// Distance to the signal within which vehicles are detected.
        detection_m: f64 = 200.0, in 1.0..=10_000.0, unit "m";
        /// Length of yellow and all-red: `fixed` is as `yellow_time_s` and `all_red_s` say, `kinematic` depends on
        /// approach speed and crossing width (ITE's formula).
        change_interval: ChangeInterval = ChangeInterval::Fixed;
        /// Yellow of links whose green ends; with `kinematic` the minimum.
        yellow_time_s: u32 = 3, in 0.0..=10.0, unit "s";
        /// All-red after yellow; with `kinematic` the minimum.
        all_red_s: u32 = 0, in 0.0..=30.0, unit "s";
        /// Shortest green.
        min_green_s: u32 = 7, in 1.0..=100.0, unit "s";
        /// Shortest green of a phase for left turns alone; in left-hand traffic for right turns alone,
        /// which cross opposing traffic there.
        min_left_green_s: u32 = 7, in 1.0..=100.0, unit "s";
        /// Longest green; without it there is no limit.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max_green_s: Option<u32> = None, in 1.0..=3600.0, unit "s";
        /// Time after which methods that learn must serve who waits: while a vehicle has waited longer, the phases that serve
        /// such vehicles best take turns. 0 leaves it to them. It holds in training and for saved models.
        #[serde(skip_serializing_if = "is_zero")]
        longest_wait_s: f64 = 0.0, in 0.0..=3600.0, unit "s", source "our choice";
        /// Whether greens beside a crosswalk last until pedestrians have crossed. If consecutive greens serve one
        /// crosswalk or movement, their sum is long enough for it.
        pedestrians: bool = false;
        /// Whether vehicles may turn on red to the near side (right, in left-hand traffic left) from the lane beside
        /// the kerb, after they stopped and where nobody with priority comes. It holds for every method on generated
        /// networks. In an imported network it holds for links whose own programs show SUMO's letter `s`. Such a link
        /// may show red (`r`) only beside a permissive green that meets it.
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        turn_on_red: bool = false;
        /// Pedestrians per hour who push the button of each crosswalk. It has an effect only if `pedestrians` is true.
        /// Without it every green beside a crosswalk lasts until they have crossed (recall). With it that time is given
        /// when somebody waits, except in fixed cycles and `actuated`, whose cycles let pedestrians cross every time. At an
        /// intersection with counted pedestrians, these push the buttons, and there is no recall.
        #[serde(skip_serializing_if = "Option::is_none")]
        pedestrian_calls_per_h: Option<f64> = None, in 0.0..=3600.0, unit "pedestrians/h", source "our choice";
        /// Width of lanes that crosswalks and all-red (with `change_interval = "kinematic"`) lead over, where the network says
        /// none; without it SUMO's 3.2 m.
        #[serde(skip_serializing_if = "Option::is_none")]
        lane_width_m: Option<f64> = None, in 2.0..=6.0, unit "m", source "SUMO";
        /// How left turns are signalled in generated networks: `permissive`, `protected`, `protected-permissive`,
        /// `by-rule`, one of these for each approach from lanes, volumes and speed, or `existing`, as the intersection's
        /// existing plan has them, and by rule without one. It decides the greens of the program and
        /// of all pairs. Left turns without a lane of their own stay permissive. `network` is netconvert's program, in which lefts yield and those with lanes of their own get a stage. In left-hand traffic these are right
        /// turns.
        #[serde(skip_serializing_if = "LeftTurns::is_network")]
        left_turns: LeftTurns = LeftTurns::Network, source "Signal Timing Manual (2nd ed., NCHRP Report 812), chapter 4; HCM";
        /// Whether no two movements have the right of way into one leg at the same time, right turns apart. netconvert's
        /// programs let them where there are lanes for both, as at a continuous-green T. Those that do so in the existing plan
        /// may. It holds for generated networks.
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        no_merging_greens: bool = false;
        /// Shortest fixed cycle.
        min_cycle_s: u32 = 20, in 1.0..=600.0, unit "s", source "our choice";
        /// Longest fixed cycle, unless the shortest greens make it longer.
        max_cycle_s: u32 = 150, in 10.0..=600.0, unit "s", source "our choice";
    }
}

impl SignalSettings {
    /// Checks what no range of a single number can say; the ranges themselves are elsewhere.
    /// The error is field, value and what was expected.
    pub fn check(&self) -> Result<(), (&'static str, String, &'static str)> {
        if self.min_cycle_s > self.max_cycle_s {
            let value = self.min_cycle_s.to_string();
            return Err(("signal.min_cycle_s", value, "expected at most signal.max_cycle_s"));
        }
        for (field, value) in [
            ("signal.pedestrian_calls_per_h", self.pedestrian_calls_per_h),
            ("signal.lane_width_m", self.lane_width_m),
        ] {
            if let Some(value) = value.filter(|_| !self.pedestrians) {
                let expected = "expected signal.pedestrians = true (preset field), without which nobody crosses";
                return Err((field, value.to_string(), expected));
            }
        }
        let least = self.min_green_s.max(self.min_left_green_s) + self.delta_time_s;
        match self.max_green_s {
            Some(max) if max < least => Err((
                "signal.max_green_s",
                max.to_string(),
                "expected at least the shortest green and signal.delta_time_s together, so that \
                 there is something to decide",
            )),
            _ => Ok(()),
        }
    }
}

impl clap::ValueEnum for Preset {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Resco, Self::Field]
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.name()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_resco_s() {
        let s = SignalSettings::default();
        assert_eq!((s.delta_time_s, s.yellow_time_s, s.all_red_s, s.min_green_s), (10, 3, 0, 7));
        assert_eq!(s.check(), Ok(()));
        // A longest green leaves room for a decision, and nobody pushes buttons without pedestrians.
        let longest = |max| SignalSettings { max_green_s: Some(max), ..s.clone() }.check();
        assert_eq!((longest(16).unwrap_err().0, longest(17)), ("signal.max_green_s", Ok(())));
        let pressed = SignalSettings { pedestrian_calls_per_h: Some(10.0), ..s };
        assert_eq!(pressed.check().unwrap_err().0, "signal.pedestrian_calls_per_h");
        assert_eq!(SignalSettings { pedestrians: true, ..pressed }.check(), Ok(()));
    }

    #[test]
    fn a_preset_s_name_is_the_one_in_a_scenario() {
        for preset in [Preset::Resco, Preset::Field] {
            let name = toml::Value::try_from(preset).unwrap();
            assert_eq!(name.as_str(), Some(preset.name()));
        }
    }
}
