//! From a path to the file that defines what it names.

use std::collections::BTreeSet;

use syn::Type;

use super::modules::{FileId, Kind, Meaning, ModuleId, Sources};

/// What a path leads to.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Target {
    /// An item of a file, with its name there, and what follows the item in the path.
    Item { file: FileId, name: String, kind: Kind, member: Option<String> },
    /// A module as a whole.
    Module(ModuleId),
}

/// Paths that are being followed, so that names which stand for each other come to an end.
type Seen = BTreeSet<(ModuleId, Vec<String>)>;

impl Sources {
    /// Returns what a path that stands in a module leads to within the workspace; nothing for paths of others.
    pub(crate) fn resolve(&self, module: ModuleId, path: &[String]) -> BTreeSet<Target> {
        self.follow(module, path, &mut Seen::new())
    }

    /// Returns a module and those around it.
    pub(crate) fn around(&self, module: ModuleId) -> impl Iterator<Item = ModuleId> {
        std::iter::successors(Some(module), |&m| self.modules[m].parent)
    }

    /// Returns the types, by file and name, that a type as written means.
    pub(crate) fn types_of(&self, module: ModuleId, written: &Type) -> BTreeSet<(FileId, String)> {
        let Type::Path(path) = written else { return BTreeSet::new() };
        let path: Vec<_> = path.path.segments.iter().map(|s| s.ident.to_string()).collect();
        let types = self.resolve(module, &path).into_iter().filter_map(|t| match t {
            Target::Item { file, name, kind: Kind::Type, .. } => Some((file, name)),
            _ => None,
        });
        types.collect()
    }

    fn follow(&self, module: ModuleId, path: &[String], seen: &mut Seen) -> BTreeSet<Target> {
        let Some((head, rest)) = path.split_first() else { return BTreeSet::new() };
        if !seen.insert((module, path.to_vec())) {
            return BTreeSet::new();
        }
        let mut found = match head.as_str() {
            "crate" => self.around(module).last().into_iter().map(Target::Module).collect(),
            "self" | "super" => self.step(module, head, seen),
            name => self.lookup(module, name, seen),
        };
        if found.is_empty() {
            found.extend(self.crates.get(head).map(|&m| Target::Module(m)));
        }
        for (position, segment) in rest.iter().enumerate() {
            let mut next = BTreeSet::new();
            for target in found {
                match target {
                    Target::Module(m) => next.extend(self.step(m, segment, seen)),
                    Target::Item { file, name, kind: Kind::Type, .. } => {
                        let member = rest.get(position).cloned();
                        next.insert(Target::Item { file, name, kind: Kind::Type, member });
                    }
                    Target::Item { .. } => {}
                }
            }
            found = next;
        }
        seen.remove(&(module, path.to_vec()));
        found
    }

    fn step(&self, module: ModuleId, segment: &str, seen: &mut Seen) -> BTreeSet<Target> {
        match segment {
            "self" => [Target::Module(module)].into(),
            "super" => self.modules[module].parent.into_iter().map(Target::Module).collect(),
            name => self.lookup(module, name, seen),
        }
    }

    fn lookup(&self, module: ModuleId, name: &str, seen: &mut Seen) -> BTreeSet<Target> {
        let here = &self.modules[module];
        let mut found = BTreeSet::new();
        for meaning in here.names.get(name).into_iter().flatten() {
            match meaning {
                Meaning::Item(kind) => {
                    let (file, name) = (here.file, name.to_owned());
                    found.insert(Target::Item { file, name, kind: *kind, member: None });
                }
                Meaning::Module(m) => {
                    found.insert(Target::Module(*m));
                }
                Meaning::Alias(path) => found.extend(self.follow(module, path, seen)),
            }
        }
        if found.is_empty() {
            for glob in &here.globs {
                for target in self.follow(module, glob, &mut seen.clone()) {
                    if let Target::Module(m) = target {
                        found.extend(self.lookup_outside(m, name, seen));
                    }
                }
            }
        }
        found
    }

    /// As `lookup`, for a glob: two modules that import all of each other end.
    fn lookup_outside(&self, module: ModuleId, name: &str, seen: &mut Seen) -> BTreeSet<Target> {
        if seen.insert((module, vec!["*".to_owned(), name.to_owned()])) {
            self.lookup(module, name, seen)
        } else {
            BTreeSet::new()
        }
    }
}
