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

macro_rules! describe {
    ($(super::$first:ident $(::$a:ident)?),*; $(super::$then:ident $(::$b:ident)?),*) => {
        /// All methods, the baseline first.
        pub const METHODS: &[Method] = &[$(super::$first::METHOD,)* $(super::$then::METHOD,)*];

        /// Names of the methods' files.
        #[cfg(test)]
        const FILES: &[&str] = &[$(stringify!($first),)* $(stringify!($then),)*];
    };
}
methods!(describe);

/// Returns what a method does before it is evaluated; nothing for a name that no method has.
pub fn training(name: &str) -> Training {
    METHODS.iter().find(|m| m.name == name).map_or(Training::None, |m| m.training)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_s_file_and_its_section_have_its_name() {
        let sections: Vec<String> = METHODS.iter().map(Method::section).collect();
        assert_eq!(sections, FILES);
    }

    #[test]
    fn every_method_describes_itself() {
        for method in METHODS {
            let name = method.name;
            assert!(!method.summary.is_empty() && !method.color.is_empty(), "{name}");
            let learns = method.training == Training::Learned;
            assert_eq!(method.decision_s > 0.0, learns, "{name}: what does its training cost?");
            for setting in method.settings {
                assert!(!setting.summary().is_empty(), "{name}.{}", setting.name);
            }
            if let Training::Tuned { episodes } = method.training {
                let setting = method.settings.iter().find(|s| s.name == episodes);
                assert!(setting.is_some_and(|s| s.limits.is_some()), "{name}.{episodes}");
            }
        }
    }
}
