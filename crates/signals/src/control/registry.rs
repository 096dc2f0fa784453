//! The list of methods.

use evaluation::run::method::{Method, Training};

/// Hands the list of methods to a macro: one line each, the name of the method's file, with the type of
/// its settings if it has any. The file has the rest: `METHOD`, the settings and `create`.
///
/// The baseline comes first. In a scenario the settings of `training` stand where the semicolon is.
macro_rules! methods {
    ($callback:ident) => {
        $callback! {
            super::baseline::Config,
            super::fixed_time::Config,
            super::max_pressure::Config,
            super::max_pressure_resco,
            super::actuated::Config,
            super::nema::Config,
            super::coordinated::Config,
            super::retime::Config;
            super::idqn::Config,
            super::ippo::Config,
            super::mplight::Config,
            super::mplight_star::Config,
            super::program,
            super::existing
        }
    };
}
pub(crate) use methods;

/// Returns the description of a method of which settings are tuned per point MDP, with as many simulations as fixed time.
const fn tuned(of: Method, name: &'static str) -> Method {
    let training = Training::Tuned { episodes: "fixed_time.simulations" };
    let summary = "the same method, with settings that are tuned per point MDP in simulation";
    Method { name, summary, default: false, training, dash: "6 2", settings: &[], ..of }
}

macro_rules! describe {
    ($(super::$first:ident $(::$a:ident)?),*; $(super::$then:ident $(::$b:ident)?),*) => {
        /// All methods, the baseline first.
        pub const METHODS: &[Method] = &[$(super::$first::METHOD,)* $(super::$then::METHOD,)*
            tuned(super::max_pressure::METHOD, "max-pressure-tuned"), tuned(super::actuated::METHOD, "actuated-tuned"),
            tuned(super::nema::METHOD, "nema-tuned")];

        /// Names of the methods' files.
        #[cfg(test)]
        const FILES: &[&str] = &[$(stringify!($first),)* $(stringify!($then),)*];
    };
}
methods!(describe);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::defaults;
    use evaluation::run::search::Choice;
    use evaluation::settings::overrides::{number, with_numbers};

    #[test]
    fn a_method_s_file_and_its_section_have_its_name() {
        let sections = METHODS.iter().filter(|m| !m.is_tuned()).map(Method::section);
        let sections: Vec<String> = sections.collect();
        assert_eq!(sections, FILES);
    }

    #[test]
    fn every_method_describes_itself() {
        for method in METHODS {
            let name = method.name;
            assert!(!method.summary.is_empty() && !method.color.is_empty(), "{name}");
            let learns = method.training == Training::Learned;
            assert_eq!(method.decision_s > 0.0, learns, "{name}: what does its training cost?");
            assert!(method.settings.iter().all(|s| !s.summary().is_empty()), "{name}");
            let last: Choice = method.tunes.iter().map(|(s, values)| (*s, values[0])).collect();
            let other = with_numbers(&defaults(), last.iter().copied());
            assert!(last.iter().all(|(s, value)| number(&other.sections(), s) == *value), "{name}");
            if let Training::Tuned { episodes } = method.training {
                assert!(number(&defaults().sections(), episodes) > 0.0, "{name}");
            }
        }
    }
}
