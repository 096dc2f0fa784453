//! The table of settings as a page, in Markdown.

use super::setting::{Section, Setting};

/// Returns the tables of sections, which are given by name; headings begin with `of`.
pub fn markdown(of: &str, sections: &[(&'static str, &dyn Section)]) -> String {
    let tables: Vec<String> = sections.iter().map(|(name, s)| table(of, name, *s)).collect();
    tables.join("\n")
}

fn table(of: &str, name: &str, section: &dyn Section) -> String {
    let (about, source) = (section.about(), section.source());
    let rows: String = section.table().iter().map(|setting| row(setting, source)).collect();
    format!(
        "### {of}{name}\n\n{about} Source: {source}.\n\n\
         | setting | default | unit | range | what it is |\n| --- | --- | --- | --- | --- |\n{rows}"
    )
}

/// Returns a default as TOML has it: a table of numbers in one line. JSON and TOML write everything else alike. The crate
/// `toml` would sort the names, and write 1e-8 in full.
fn toml(json: &str) -> String {
    let Some(fields) = json.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')) else {
        return json.to_owned();
    };
    let field = |field: &str| field.replacen('"', "", 2).replacen(':', " = ", 1);
    let fields: Vec<String> = fields.split(',').map(field).collect();
    format!("{{ {} }}", fields.join(", "))
}

/// `section` is the source of those that name none of their own.
fn row(setting: &Setting, section: &str) -> String {
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
    format!("| `{name}` | {default} | {unit} | {range} | {summary}{source} |\n")
}
