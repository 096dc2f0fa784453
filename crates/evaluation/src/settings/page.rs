//! The table of settings as a page, in Markdown.

use super::setting::{Section, Setting};

/// A preset by its name, with its values by section.
pub type Preset<'a> = (&'a str, &'a toml::Table);

/// Returns the tables of sections, which are given by name; headings begin with `of`. A section that a preset changes has a
/// column of the preset's values.
pub fn markdown(
    of: &str,
    sections: &[(&'static str, &dyn Section)],
    preset: Option<Preset<'_>>,
) -> String {
    let table = |(name, section): &(&'static str, &dyn Section)| {
        let own =
            preset.and_then(|(preset, values)| Some((preset, values.get(*name)?.as_table()?)));
        table(of, name, *section, own)
    };
    let tables: Vec<String> = sections.iter().map(table).collect();
    tables.join("\n")
}

/// `preset` has the values of this section.
fn table(of: &str, name: &str, section: &dyn Section, preset: Option<Preset<'_>>) -> String {
    let (about, source) = (section.about(), section.source());
    let rows: String = section.table().iter().map(|s| row(s, source, preset)).collect();
    let (head, rule) = match preset {
        Some((preset, _)) => (format!(" `{preset}` |"), " --- |"),
        None => (String::new(), ""),
    };
    format!(
        "### {of}{name}\n\n{about} Source: {source}.\n\n\
         | setting | default |{head} unit | range | what it is |\n| --- | --- |{rule} --- | --- | --- |\n{rows}"
    )
}

/// Returns a default as TOML has it: a table of numbers in one line.
fn toml(json: &str) -> String {
    let Some(fields) = json.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')) else {
        return json.to_owned();
    };
    let field = |field: &str| field.replacen('"', "", 2).replacen(':', " = ", 1);
    let fields: Vec<String> = fields.split(',').map(field).collect();
    format!("{{ {} }}", fields.join(", "))
}

/// `section` is the source of those that name none of their own.
fn row(setting: &Setting, section: &str, preset: Option<Preset<'_>>) -> String {
    let range = setting.limits.map_or(String::new(), |limits| limits.to_string());
    let default = match (setting.default)().as_str() {
        "null" => String::new(),
        default => format!("`{}`", toml(default)),
    };
    let source = match setting.source == section {
        true => String::new(),
        false => format!(" Source: {}.", setting.source),
    };
    let (name, unit, summary) = (setting.name, setting.unit, setting.summary());
    let own = preset.map_or(String::new(), |(_, values)| {
        values.get(name).map_or(" |".to_owned(), |value| format!(" `{value}` |"))
    });
    format!("| `{name}` | {default} |{own} {unit} | {range} | {summary}{source} |\n")
}
