//! The table of all settings.

use super::Scenario;
use crate::settings::setting::{Section, Setting};

/// Returns a setting by its dotted name; `None` for what stands outside of sections or deeper in them.
pub fn find(name: &str) -> Option<&'static Setting> {
    let (section, name) = name.split_once('.')?;
    let scenario = defaults();
    let sections = scenario.sections();
    let (_, section) = sections.iter().find(|(own, _)| *own == section)?;
    section.table().iter().find(|s| s.name == name)
}

/// Returns a scenario of defaults.
pub fn defaults() -> Scenario {
    toml::from_str("").expect("every setting has a default")
}

/// Returns the settings as a page, in Markdown.
pub fn markdown() -> String {
    let scenario = defaults();
    let sections = scenario.sections();
    let parts: Vec<String> = sections.iter().map(|(name, section)| part(name, *section)).collect();
    parts.join("\n")
}

fn part(name: &str, section: &dyn Section) -> String {
    let mut text = format!("## {name}\n\n{} Source: {}.\n\n", section.about(), section.source());
    text += "| setting | default | unit | range | what it is |\n| --- | --- | --- | --- | --- |\n";
    for setting in section.table() {
        let range = setting.limits.map_or(String::new(), |limits| limits.to_string());
        let default = match (setting.default)().as_str() {
            "null" => String::new(),
            default => format!("`{default}`"),
        };
        let source = match setting.source == section.source() {
            true => String::new(),
            false => format!(" Source: {}.", setting.source),
        };
        let (name, unit, summary) = (setting.name, setting.unit, setting.summary());
        text += &format!("| `{name}` | {default} | {unit} | {range} | {summary}{source} |\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::named::Named;

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
