//! Renders a page from its template, in which everything that is missing is an error.

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior, Value};

/// What all pages have around their own: a page says `{% extends "page.html" %}` and gives a block `body`, values
/// `headline` and `scenario`, and a block `script` where it has tables to sort.
const BASE: &str = include_str!("templates/page.html");

/// Style of all pages.
const STYLE: &str = include_str!("templates/style.css");

/// What sorts and filters tables, and leads from a dot on a map to its row.
const SCRIPT: &str = include_str!("templates/page.js");

/// Returns a page or a part of one; its name ends in `.html`, so that values are escaped.
///
/// # Errors
///
/// The template engine's message.
pub fn render(name: &str, template: &str, values: Value) -> Result<String, String> {
    let mut environment = Environment::new();
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    environment.set_syntax(syntax.map_err(|e| e.to_string())?);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_global("style", STYLE);
    environment.add_global("script", SCRIPT);
    for (name, template) in [("page.html", BASE), (name, template)] {
        environment.add_template(name, template).map_err(|e| e.to_string())?;
    }
    let template = environment.get_template(name).map_err(|e| e.to_string())?;
    template.render(values).map_err(|e| format!("{e:#}"))
}
