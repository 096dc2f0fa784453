//! Settings and flags that can have no effect in a run are refused, with the reason: who gives one
//! believes that it has. What a scenario file or a preset sets is not looked at, since one file serves
//! several commands.

use crate::cli::refused::Refused;
use crate::domains;
use crate::run::method::Training;
use crate::settings::overrides::Override;
use crate::traffic::control::registry::METHODS;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::settings::Detail;

/// Settings that only derive a family from approaches.
const OF_APPROACHES: [&str; 7] = [
    "family.directional_split",
    "family.peak_heading_deg",
    "family.detail",
    "family.hourly_share",
    "family.inflow_cap_vph_per_lane",
    "family.min_inflow_vph",
    "family.length_scale",
];

/// What a command does with a scenario.
#[derive(Debug, Clone, Copy)]
pub(super) struct Use<'a> {
    /// Its family and how that is derived.
    pub(super) family: bool,
    /// Its networks and vehicles, and the limits of their signals.
    pub(super) networks: bool,
    /// The signals, also those of SUMO scenarios.
    pub(super) signals: bool,
    /// How SUMO is run.
    pub(super) simulation: bool,
    /// The methods that run, if any do.
    pub(super) methods: Option<&'a [String]>,
}

impl Use<'_> {
    /// Of `list`.
    pub(super) const LIST: Self =
        Self { family: true, networks: false, signals: false, simulation: false, methods: None };

    /// Of `build-networks`.
    pub(super) const BUILD: Self = Self { networks: true, signals: true, ..Self::LIST };

    /// Refuses what is set without effect.
    ///
    /// # Errors
    ///
    /// The flag and why it has no effect.
    pub(super) fn check(
        &self,
        loaded: &LoadedScenario,
        settings: &[Override],
    ) -> anyhow::Result<()> {
        for setting in settings {
            for key in setting.keys() {
                if let Some(reason) = self.without_effect(loaded, &key) {
                    return Err(without_effect(setting, &reason).into());
                }
            }
        }
        Ok(())
    }

    /// Returns why a setting has no effect; nothing if it has one.
    fn without_effect(&self, loaded: &LoadedScenario, key: &str) -> Option<String> {
        let scenario = &loaded.scenario;
        let per_approach = scenario.family.detail == Detail::PerApproach;
        let is = |section: &str| key.starts_with(section);
        let imported = !self.family && !self.networks;
        let plain = |text: &str| Some(text.to_owned());
        if is("family.") && imported {
            return plain("the point MDPs are the given SUMO scenarios");
        }
        if is("network.") && !self.networks {
            return match imported {
                true => plain("the SUMO scenarios bring their networks"),
                false => plain("no network is built here"),
            };
        }
        if is("demand.") && !self.networks {
            return match imported {
                true => plain("SUMO scenarios have their own vehicles"),
                false => plain("no vehicle is simulated here"),
            };
        }
        if key == "signal.left_turns" && imported && self.signals {
            return plain("the SUMO scenarios bring the programs of their signals");
        }
        if is("signal.") && !self.signals {
            return plain("this command reads no signal");
        }
        if is("simulation.") && !self.simulation {
            return plain("nothing is simulated here");
        }
        if is("family.") && scenario.family.points.is_some() {
            if OF_APPROACHES.contains(&key) || is("family.bins.") {
                return plain("the point MDPs come from a table and are not derived");
            }
        } else if is("family.bins.") && per_approach {
            return plain("bins join intersections, and per-approach detail keeps every one");
        }
        if key == "demand.approach_spread" && per_approach {
            return plain("in per-approach detail every arm has its own inflow");
        }
        self.of_method(loaded, key, imported)
    }

    /// Returns why a setting of methods has no effect.
    fn of_method(&self, loaded: &LoadedScenario, key: &str, imported: bool) -> Option<String> {
        let (section, _) = key.split_once('.')?;
        let owner = METHODS.iter().find(|m| m.section() == section).map(|m| m.name);
        if owner.is_none() && section != "training" {
            return None;
        }
        let Some(methods) = self.methods else {
            return Some("no method runs here".to_owned());
        };
        if let Some(method) = owner
            && !methods.iter().any(|m| m == method)
        {
            return Some(not_among(method, methods));
        }
        if section == "training" && !any(methods, Training::Learned) {
            return Some(format!("no method learns ({})", methods.join(", ")));
        }
        let split = loaded.scenario.baseline.program.is_equal_split(imported);
        (key == "baseline.green_s" && !split).then(|| {
            "the baseline runs the networks' own program, not an equal split \
             (baseline.program=equal-split)"
                .to_owned()
        })
    }
}

/// Refuses a setting, with the reason why it has no effect.
pub(super) fn without_effect(setting: &Override, reason: &str) -> Refused {
    Refused(format!("{} has no effect: {reason}; leave it out", setting.flag()))
}

/// Says that a method does not run.
pub(super) fn not_among(method: &str, methods: &[String]) -> String {
    format!("{method} is not among the methods ({})", methods.join(", "))
}

/// Whether some of the methods, the user's own included, are trained like this.
pub(super) fn any(methods: &[String], training: Training) -> bool {
    let known = domains::traffic().methods();
    known.iter().any(|m| m.training == training && methods.iter().any(|name| name == m.name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::family::load::load_with;

    fn refused(of: Use<'_>, scenario: &str, settings: &[&str]) -> Option<String> {
        let settings: Vec<Override> = settings.iter().map(|s| s.parse().unwrap()).collect();
        let loaded = load_with(scenario, &settings).unwrap();
        of.check(&loaded, &settings).err().map(|e| e.to_string())
    }

    fn methods(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    #[test]
    fn every_section_has_a_command_without_it() {
        let names = methods(&["baseline", "max-pressure"]);
        let run = Use { simulation: true, methods: Some(&names), ..Use::BUILD };
        let imported = Use { family: false, networks: false, ..run };
        let cases = [
            (imported, "salt-lake-city", "demand.horizon_s=600", "SUMO scenarios have their own"),
            (imported, "salt-lake-city", "network.exit_length_m=80", "bring their networks"),
            (imported, "salt-lake-city", "family={hourly_share=0.1}", "the given SUMO scenarios"),
            (run, "smoke", "family.hourly_share=0.1", "come from a table"),
            (run, "smoke", "fixed_time.simulations=9", "fixed-time is not among the methods"),
            (run, "smoke", "training.episodes=4", "no method learns"),
            (run, "smoke", "idqn.learning_rate=0.1", "idqn is not among"),
            (run, "smoke", "baseline.green_s=20", "own program"),
            (Use::LIST, "smoke", "demand.horizon_s=600", "no vehicle is simulated"),
            (Use::LIST, "smoke", "signal.yellow_time_s=4", "this command reads no signal"),
            (Use::BUILD, "smoke", "simulation.time_to_teleport_s=9", "nothing is simulated"),
            (Use::BUILD, "smoke", "max_pressure.permissive_share=0.1", "no method runs"),
        ];
        for (of, scenario, setting, expected) in cases {
            let e = refused(of, scenario, &[setting]).unwrap_or_default();
            assert!(e.starts_with(&format!("--set {setting} has no effect: ")), "{setting}: {e}");
            assert!(e.contains(expected), "{setting}: {e}");
        }
    }

    #[test]
    fn what_has_an_effect_is_taken() {
        let names = methods(&["baseline", "idqn", "fixed-time"]);
        let run = Use { simulation: true, methods: Some(&names), ..Use::BUILD };
        let imported = Use { family: false, networks: false, ..run };
        for setting in ["idqn.learning_rate=0.1", "training.episodes=3", "fixed_time.simulations=9"]
        {
            assert_eq!(refused(run, "smoke", &[setting]), None, "{setting}");
            assert_eq!(refused(imported, "smoke", &[setting]), None, "{setting}");
        }
        let split = "baseline.program=equal-split";
        assert_eq!(refused(run, "smoke", &[split, "baseline.green_s=20"]), None);
        assert_eq!(refused(imported, "smoke", &["baseline.green_s=20"]), None);
        assert_eq!(refused(Use::LIST, "salt-lake-city", &["family.bins.lanes=2"]), None);
        let detail = ["family.detail=per-approach", "family.bins.lanes=2"];
        assert!(refused(Use::LIST, "salt-lake-city", &detail).unwrap().contains("keeps every one"));
    }
}
