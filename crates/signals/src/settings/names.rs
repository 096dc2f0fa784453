//! The names of all settings of a scenario.

use std::sync::LazyLock;

use toml::Table;

use super::Scenario;
use evaluation::settings::named::{Named, names_of};

/// A scenario with all settings that can be given.
const WHOLE: &str = "name = \"x\"\nsignal.max_green_s = 50\nsignal.lane_width_m = 3.0\n\
    signal.left_turns = \"permissive\"\n\
    signal.pedestrian_calls_per_h = 1.0\nfamily.points = \"p\"\nfamily.existing = \"e\"\n\
                     family.approaches = \"a\"\nfamily.directional_split = 0.55\n\
                     family.peak_heading_deg = 90\nsignal.turn_on_red = true\n\
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
