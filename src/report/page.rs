//! Renders a page from its template, in which everything that is missing is an error.

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior, Value};

/// Style of all pages.
pub(crate) const STYLE: &str = include_str!("templates/style.css");

/// What sorts and filters tables, and leads from a dot on a map to its row.
pub(crate) const SCRIPT: &str = include_str!("templates/page.js");

/// Returns a page; its name ends in `.html`, so that values are escaped.
///
/// # Errors
///
/// The template engine's message.
pub(crate) fn render(name: &str, template: &str, values: Value) -> Result<String, String> {
    let mut environment = Environment::new();
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    environment.set_syntax(syntax.map_err(|e| e.to_string())?);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_template(name, template).map_err(|e| e.to_string())?;
    let template = environment.get_template(name).map_err(|e| e.to_string())?;
    template.render(values).map_err(|e| format!("{e:#}"))
}
