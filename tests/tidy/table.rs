//! The arrows between modules as ARCHITECTURE.md has them.
//!
//! The first fenced block below the heading `## Arrows`, one line for each module: `a -> b c`, `a -> nothing`. What
//! the line `any -> ...` lists may be used by every module and uses nothing but each other.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::graph::{Graph, Neighbours};

/// Module that stands for every other.
const ANY: &str = "any";

/// Returns the table of a page.
///
/// # Errors
///
/// A sentence that quotes the line which cannot be read.
pub(crate) fn read(page: &str) -> Result<Neighbours<String>, String> {
    let below = page.split("\n## Arrows\n").nth(1).ok_or("no heading `## Arrows`")?;
    let block = below.split("\n```").nth(1).ok_or("no fenced block below `## Arrows`")?;
    let mut table = Neighbours::new();
    for line in block.lines().skip(1).filter(|l| !l.trim().is_empty()) {
        let (from, to) = line.split_once(" -> ").ok_or_else(|| format!("no arrow in `{line}`"))?;
        let to = to.split_whitespace().filter(|t| *t != "nothing").map(str::to_owned);
        if table.insert(from.trim().to_owned(), to.collect()).is_some() {
            return Err(format!("`{from}` stands twice in the table of arrows"));
        }
    }
    Ok(table)
}

/// Returns what of the sources is not as the table has it, a sentence each.
pub(crate) fn differences(graph: &Graph, table: &Neighbours<String>) -> Vec<String> {
    let arrows = graph.between_modules();
    let mut wrong = Vec::new();
    let any = table.get(ANY).cloned().unwrap_or_default();
    let modules: BTreeSet<String> = graph.modules();
    for ((from, to), place) in &arrows {
        let listed = table.get(from).is_some_and(|t| t.contains(to));
        if any.contains(from) && !any.contains(to) {
            wrong.push(format!("{place}: `{from}` may be used by any and so may not use `{to}`"));
        } else if !listed && !any.contains(to) {
            wrong.push(format!("{place}: no arrow `{from} -> {to}` in ARCHITECTURE.md"));
        }
    }
    for (from, uses) in table.iter().filter(|(from, _)| *from != ANY) {
        if !modules.contains(from) {
            wrong.push(format!("ARCHITECTURE.md has `{from}`, which is no module"));
        }
        for to in uses {
            if any.contains(to) {
                wrong.push(format!("ARCHITECTURE.md: `{from} -> {to}` is said by `any` already"));
            } else if modules.contains(from) && !arrows.contains_key(&(from.clone(), to.clone())) {
                wrong.push(format!("ARCHITECTURE.md has `{from} -> {to}`, which nothing needs"));
            }
        }
    }
    for module in any.iter().filter(|m| !arrows.keys().any(|(_, to)| to == *m)) {
        wrong.push(format!("ARCHITECTURE.md has `any -> {module}`, which nothing needs"));
    }
    for module in modules.iter().filter(|m| !any.contains(*m) && !table.contains_key(*m)) {
        wrong.push(format!("ARCHITECTURE.md has no line for `{module}`"));
    }
    wrong
}

/// Returns the table as the sources have it.
pub(crate) fn from_sources(graph: &Graph, table: &Neighbours<String>) -> String {
    let any = table.get(ANY).cloned().unwrap_or_default();
    let mut lines: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for module in graph.modules().into_iter().filter(|m| !any.contains(m)) {
        lines.insert(module, Vec::new());
    }
    for ((from, to), _) in graph.between_modules() {
        if let Some(line) = lines.get_mut(&from).filter(|_| !any.contains(&to)) {
            line.push(to);
        }
    }
    let mut text = String::new();
    for (from, to) in lines {
        let to = if to.is_empty() { "nothing".to_owned() } else { to.join(" ") };
        let _ = writeln!(text, "{from} -> {to}");
    }
    let any: Vec<_> = any.into_iter().collect();
    let _ = writeln!(text, "{ANY} -> {}", any.join(" "));
    text
}
