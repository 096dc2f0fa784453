//! The graph of files and of modules, its circles and how they read.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write as _;
use std::path::Path;

use super::modules::{FileId, Sources};
use super::uses::Arrow;

/// Who names whom.
pub(crate) struct Graph {
    sources: Sources,
    arrows: BTreeSet<Arrow>,
}

/// Neighbours of each node.
pub(crate) type Neighbours<T> = BTreeMap<T, BTreeSet<T>>;

/// Returns the module that a file belongs to: `family`, `traffic/env`, or the name of a crate beside.
pub(crate) fn module_of(path: &Path) -> String {
    let mut parts = path.iter().map(|p| p.to_string_lossy().trim_end_matches(".rs").to_owned());
    let first = parts.next().unwrap_or_default();
    if first != "src" {
        return first;
    }
    let module = parts.next().unwrap_or_default();
    match parts.next() {
        Some(part) if module == "traffic" && part != "mod" => format!("{module}/{part}"),
        _ => module,
    }
}

/// Returns the groups of nodes of which each reaches each other, the smallest first. A node alone is none.
pub(crate) fn circles<T: Ord + Clone>(neighbours: &Neighbours<T>) -> Vec<BTreeSet<T>> {
    let reached: BTreeMap<&T, BTreeSet<T>> =
        neighbours.keys().map(|n| (n, reached(neighbours, n))).collect();
    let mut groups = BTreeSet::new();
    for (node, from_node) in &reached {
        if from_node.contains(node) {
            let back = |n: &&T| reached.get(*n).is_some_and(|r| r.contains(node));
            groups.insert(from_node.iter().filter(back).cloned().collect::<BTreeSet<T>>());
        }
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(BTreeSet::len);
    groups
}

fn reached<T: Ord + Clone>(neighbours: &Neighbours<T>, from: &T) -> BTreeSet<T> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(node) = open.pop() {
        for next in neighbours.get(node).into_iter().flatten() {
            if found.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    found
}

/// Returns a shortest way from a node back to itself, without its end.
fn shortest<T: Ord + Clone>(neighbours: &Neighbours<T>, start: &T) -> Option<Vec<T>> {
    let mut before: BTreeMap<T, T> = BTreeMap::new();
    let mut open = VecDeque::from([start.clone()]);
    while let Some(node) = open.pop_front() {
        for next in neighbours.get(&node).into_iter().flatten() {
            if next == start {
                let mut way = vec![node];
                while let Some(previous) = before.get(&way[way.len() - 1]) {
                    way.push(previous.clone());
                }
                way.reverse();
                return Some(way);
            }
            if !before.contains_key(next) {
                before.insert(next.clone(), node.clone());
                open.push_back(next.clone());
            }
        }
    }
    None
}

impl Graph {
    pub(crate) fn new(sources: Sources, arrows: BTreeSet<Arrow>) -> Self {
        Self { sources, arrows }
    }

    pub(crate) fn files(&self) -> usize {
        self.sources.files.len()
    }

    /// Returns the modules.
    pub(crate) fn modules(&self) -> BTreeSet<String> {
        self.sources.files.iter().map(|f| module_of(f)).collect()
    }

    pub(crate) fn name(&self, file: FileId) -> String {
        self.sources.files[file].display().to_string()
    }

    /// Returns which file names items of which others.
    pub(crate) fn between_files(&self) -> Neighbours<FileId> {
        let mut found = Neighbours::new();
        for arrow in self.arrows.iter().filter(|a| a.item) {
            found.entry(arrow.from).or_insert_with(BTreeSet::new).insert(arrow.to);
        }
        found
    }

    /// Returns which module names which others, each with the place of its first arrow.
    pub(crate) fn between_modules(&self) -> BTreeMap<(String, String), String> {
        let mut found = BTreeMap::new();
        for arrow in &self.arrows {
            let (from, to) = (self.module(arrow.from), self.module(arrow.to));
            if from != to {
                found.entry((from, to)).or_insert_with(|| self.place(arrow));
            }
        }
        found
    }

    fn module(&self, file: FileId) -> String {
        module_of(&self.sources.files[file])
    }

    fn place(&self, arrow: &Arrow) -> String {
        format!("{}:{} names `{}`", self.name(arrow.from), arrow.line, arrow.path)
    }

    /// Returns every place where a file outside a set of modules names one within them, by file.
    pub(crate) fn named_from_outside(
        &self,
        within: impl Fn(&str) -> bool,
        may: impl Fn(&str) -> bool,
    ) -> BTreeMap<String, Vec<String>> {
        let mut found = BTreeMap::new();
        for arrow in self.arrows.iter().filter(|a| within(&self.module(a.to))) {
            let from = self.module(arrow.from);
            if !within(&from) && !may(&from) {
                let places: &mut Vec<String> = found.entry(self.name(arrow.from)).or_default();
                places.push(self.place(arrow));
            }
        }
        found
    }

    /// Returns the arrows between the files of a circle, one line each: every name that makes it, with its first
    /// line.
    pub(crate) fn inner_arrows(&self, circle: &BTreeSet<FileId>) -> String {
        let mut names: BTreeMap<(FileId, FileId), BTreeMap<&str, usize>> = BTreeMap::new();
        let within = |f: &FileId| circle.contains(f);
        for a in self.arrows.iter().filter(|a| a.item && within(&a.from) && within(&a.to)) {
            names.entry((a.from, a.to)).or_default().entry(&a.path).or_insert(a.line);
        }
        let mut text = String::new();
        for ((from, to), names) in names {
            let names: Vec<_> =
                names.iter().map(|(path, line)| format!("{path} ({line})")).collect();
            let names = names.join(", ");
            let _ = writeln!(text, "  {} -> {}: {names}", self.name(from), self.name(to));
        }
        text
    }

    /// Returns a shortest chain of files through a circle, with the line that names each next one.
    pub(crate) fn chain(&self, circle: &BTreeSet<FileId>) -> String {
        let mut within = self.between_files();
        within.retain(|from, _| circle.contains(from));
        let ways = circle.iter().filter_map(|start| shortest(&within, start));
        let way = ways.min_by_key(Vec::len).unwrap_or_default();
        let mut text = format!("circle of {} files, the shortest way round:\n", circle.len());
        for (position, from) in way.iter().enumerate() {
            let to = way[(position + 1) % way.len()];
            let arrow = self.arrows.iter().find(|a| a.item && a.from == *from && a.to == to);
            let place = arrow.map(|a| self.place(a)).unwrap_or_default();
            let _ = writeln!(text, "  {place} of {}", self.name(to));
        }
        text
    }
}
