//! The arrows between modules as ARCHITECTURE.md has them.
//!
//! The first fenced block below the heading `## Arrows`, one line for each module: `a -> b c`, `a -> nothing`. What
//! the line `any -> ...` lists may be used by every module and uses nothing but each other. Lines stand in order: a
//! module uses those above it, so that there is no circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::graph::Graph;

/// Module that stands for every other.
const ANY: &str = "any";

/// What the block says.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Table {
    any: BTreeSet<String>,
    lines: Vec<(String, BTreeSet<String>)>,
}

impl Table {
    /// Returns the table of a page.
    ///
    /// # Errors
    ///
    /// A sentence that quotes the line which cannot be read.
    pub(crate) fn read(page: &str) -> Result<Self, String> {
        let below = page.split("\n## Arrows\n").nth(1).ok_or("no heading `## Arrows`")?;
        let block = below.split("\n```").nth(1).ok_or("no fenced block below `## Arrows`")?;
        let mut table = Self { any: BTreeSet::new(), lines: Vec::new() };
        for line in block.lines().skip(1).filter(|l| !l.trim().is_empty()) {
            let (from, to) =
                line.split_once(" -> ").ok_or_else(|| format!("no arrow in `{line}`"))?;
            let to = to.split_whitespace().filter(|t| *t != "nothing").map(str::to_owned);
            if from == ANY {
                table.any.extend(to);
            } else if table.position(from).is_some() {
                return Err(format!("`{from}` stands twice in the table of arrows"));
            } else {
                table.lines.push((from.to_owned(), to.collect()));
            }
        }
        Ok(table)
    }

    fn position(&self, module: &str) -> Option<usize> {
        self.lines.iter().position(|(from, _)| from == module)
    }

    /// Returns the arrows to a module that stands further below, which could make a circle.
    pub(crate) fn against_the_order(&self) -> Vec<String> {
        let mut found = Vec::new();
        for (position, (from, uses)) in self.lines.iter().enumerate() {
            for to in uses.iter().filter(|to| self.position(to) >= Some(position)) {
                found.push(format!("{from} -> {to}"));
            }
        }
        found
    }

    /// Returns what of the sources is not as the table has it, a sentence each.
    pub(crate) fn differences(&self, graph: &Graph) -> Vec<String> {
        let (arrows, modules) = (graph.between_modules(), graph.modules());
        let lines: BTreeMap<&String, &BTreeSet<String>> =
            self.lines.iter().map(|(from, uses)| (from, uses)).collect();
        let any = &self.any;
        let mut wrong = Vec::new();
        for ((from, to), place) in &arrows {
            let listed = lines.get(from).is_some_and(|t| t.contains(to));
            if any.contains(from) && !any.contains(to) {
                wrong.push(format!(
                    "{place}: `{from}` may be used by any and so may not use `{to}`"
                ));
            } else if !listed && !any.contains(to) {
                wrong.push(format!("{place}: no arrow `{from} -> {to}` in ARCHITECTURE.md"));
            }
        }
        for (from, uses) in &self.lines {
            if !modules.contains(from) {
                wrong.push(format!("ARCHITECTURE.md has `{from}`, which is no module"));
            }
            for to in uses {
                let needed = arrows.contains_key(&(from.clone(), to.clone()));
                if any.contains(to) {
                    wrong.push(format!("ARCHITECTURE.md: `{from} -> {to}` is said by `any`"));
                } else if modules.contains(from) && !needed {
                    wrong
                        .push(format!("ARCHITECTURE.md has `{from} -> {to}`, which nothing needs"));
                }
            }
        }
        for module in any.iter().filter(|m| !arrows.keys().any(|(_, to)| to == *m)) {
            wrong.push(format!("ARCHITECTURE.md has `any -> {module}`, which nothing needs"));
        }
        for module in modules.iter().filter(|m| !any.contains(*m) && !lines.contains_key(*m)) {
            wrong.push(format!("ARCHITECTURE.md has no line for `{module}`"));
        }
        wrong
    }

    /// Returns the table as the sources have it, in the order of this one, to paste.
    pub(crate) fn remade(&self, graph: &Graph) -> String {
        let mut uses: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for module in graph.modules().into_iter().filter(|m| !self.any.contains(m)) {
            uses.insert(module, Vec::new());
        }
        for (from, to) in graph.between_modules().into_keys() {
            if let Some(line) = uses.get_mut(&from).filter(|_| !self.any.contains(&to)) {
                line.push(to);
            }
        }
        let any: Vec<_> = self.any.iter().map(String::as_str).collect();
        let mut text = format!("{ANY} -> {}\n", any.join(" "));
        let mut line = |from: &String, to: &Vec<String>| {
            let to = if to.is_empty() { "nothing".to_owned() } else { to.join(" ") };
            let _ = writeln!(text, "{from} -> {to}");
        };
        for (from, _) in &self.lines {
            if let Some(to) = uses.remove(from) {
                line(from, &to);
            }
        }
        uses.iter().for_each(|(from, to)| line(from, to));
        text
    }
}
