//! The table of all settings.

use super::Scenario;
use evaluation::settings::setting::{self, Setting};

/// Returns a setting by its dotted name; `None` for what stands outside of sections or deeper in them.
pub fn find(name: &str) -> Option<&'static Setting> {
    setting::find(&defaults().sections(), name)
}

/// Returns a scenario of defaults.
pub fn defaults() -> Scenario {
    toml::from_str("").expect("every setting has a default")
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
}
