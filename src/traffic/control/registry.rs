//! The controllers by name.

use serde::{Deserialize, Serialize};

use super::actuated::Actuated;
use super::baseline::Baseline;
use super::fixed_time::FixedTime;
use super::idqn::Idqn;
use super::ippo::Ippo;
use super::max_pressure::MaxPressure;
use super::max_pressure_resco::MaxPressureResco;
use super::mplight::MpLight;
use super::program::Program;
use super::webster::Constants;
use super::{ControlError, Controller};
use super::{idqn, ippo, max_pressure, mplight, mplight_star};
use crate::run::method::{Method, Training};
use crate::suggest::did_you_mean;

/// Settings of all controllers; the defaults are the scenario's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlSettings {
    /// Green per phase of the baseline's equal split, seconds; `None` runs the own program.
    pub baseline_equal_split_green_s: Option<f64>,
    /// Constants of `max-pressure`.
    pub max_pressure: max_pressure::Config,
    /// Episodes that tuning of `fixed-time` may use.
    pub fixed_time_simulations: u32,
    /// Time lost per phase in Webster's formula, seconds.
    pub fixed_time_lost_time_s: f64,
    /// Saturation flow in Webster's formula, vehicles per hour and lane.
    pub fixed_time_saturation_flow_vph: f64,
    /// Longest green of `actuated`, seconds.
    pub actuated_max_green_s: f64,
    /// Episodes that learners are trained for.
    pub training_episodes: u32,
    /// Hyper-parameters of `idqn`.
    pub idqn: idqn::Config,
    /// Hyper-parameters of `ippo`.
    pub ippo: ippo::Config,
    /// Hyper-parameters of `mplight`.
    pub mplight: mplight::Config,
    /// Hyper-parameters of `mplight-star`.
    pub mplight_star: mplight_star::Config,
    /// Hyper-parameters of `mplight-star-resco`.
    pub mplight_star_resco: mplight_star::Config,
}

/// All methods, the baseline first.
pub const METHODS: [Method; 11] = [
    Method {
        name: Baseline::NAME,
        summary: "untuned fixed time, the denominator of every score",
        training: Training::None,
        default: true,
    },
    Method {
        name: FixedTime::NAME,
        summary: "fixed time, tuned per point MDP in simulation",
        training: Training::Tuned,
        default: true,
    },
    Method {
        name: MaxPressure::NAME,
        summary: "the phase that relieves the most pressure (Varaiya), at every decision",
        training: Training::None,
        default: true,
    },
    Method {
        name: MaxPressureResco::NAME,
        summary: "the phase whose two main movements have the longest queues (RESCO)",
        training: Training::None,
        default: false,
    },
    Method {
        name: Actuated::NAME,
        summary: "SUMO's gap-based actuated control",
        training: Training::None,
        default: true,
    },
    Method {
        name: Idqn::NAME,
        summary: "deep Q-learning on lanes, a learner per signal (RESCO)",
        training: Training::Learned,
        default: false,
    },
    Method {
        name: Ippo::NAME,
        summary: "proximal policy optimisation on lanes, a learner per signal (RESCO)",
        training: Training::Learned,
        default: false,
    },
    Method {
        name: MpLight::NAME,
        summary: "deep Q-learning on pressure, one FRAP network for all signals (RESCO)",
        training: Training::Learned,
        default: false,
    },
    Method {
        name: mplight_star::NAME,
        summary: "MPLight that also sees waiting times, speeds and arrivals",
        training: Training::Learned,
        default: false,
    },
    Method {
        name: mplight_star::RESCO_NAME,
        summary: "the same with RESCO's mistake in what a movement sees",
        training: Training::Learned,
        default: false,
    },
    Method {
        name: Program::NAME,
        summary: "the network's own signal program, untouched",
        training: Training::None,
        default: false,
    },
];

/// Returns what a method does before it is evaluated; nothing for a name that no method has.
pub fn training(name: &str) -> Training {
    METHODS.iter().find(|m| m.name == name).map_or(Training::None, |m| m.training)
}

/// Returns a controller by name; `seed` is for everything random in it.
///
/// # Errors
///
/// [`ControlError::Unknown`] for a name that no method has.
pub fn create(
    name: &str,
    settings: &ControlSettings,
    seed: u64,
) -> Result<Box<dyn Controller>, ControlError> {
    let s = settings;
    Ok(match name {
        Baseline::NAME => {
            Box::new(Baseline { equal_split_green_s: s.baseline_equal_split_green_s })
        }
        Program::NAME => Box::new(Program),
        MaxPressure::NAME => Box::new(MaxPressure::new(s.max_pressure.clone())),
        MaxPressureResco::NAME => Box::new(MaxPressureResco::default()),
        Actuated::NAME => Box::new(Actuated { max_green_s: s.actuated_max_green_s }),
        FixedTime::NAME => {
            let constants = Constants {
                lost_time_s: s.fixed_time_lost_time_s,
                saturation_flow_vph: s.fixed_time_saturation_flow_vph,
            };
            Box::new(FixedTime::new(constants, s.fixed_time_simulations))
        }
        Idqn::NAME => Box::new(Idqn::new(s.idqn.clone(), s.training_episodes, seed)),
        Ippo::NAME => Box::new(Ippo::new(s.ippo.clone(), s.training_episodes, seed)),
        MpLight::NAME => Box::new(MpLight::new(s.mplight.clone(), s.training_episodes, seed)),
        mplight_star::NAME => {
            Box::new(mplight_star::mplight_star(&s.mplight_star, s.training_episodes, seed))
        }
        mplight_star::RESCO_NAME => {
            let config = &s.mplight_star_resco;
            Box::new(mplight_star::mplight_star_resco(config, s.training_episodes, seed))
        }
        _ => {
            let known: Vec<_> = METHODS.iter().map(|m| m.name).collect();
            let meant = did_you_mean(name, known.iter().copied());
            let known = known.join(", ");
            return Err(ControlError::Unknown { name: name.to_owned(), known, meant });
        }
    })
}
