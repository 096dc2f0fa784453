//! The modules of the workspace's crates, their files and the names in them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::{Attribute, Ident, ImplItem, Item, Meta, UseTree, Visibility};

use super::tokens;

pub(crate) type FileId = usize;
pub(crate) type ModuleId = usize;

/// What can stand after an item's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// A type or trait: its variants and functions may follow.
    Type,
    /// A function, constant or static.
    Value,
    /// `macro_rules!`.
    Macro,
}

/// A meaning of a name in a module.
#[derive(Debug, Clone)]
pub(crate) enum Meaning {
    Item(Kind),
    Module(ModuleId),
    /// `use` of a path.
    Alias(Vec<String>),
}

pub(crate) struct Module {
    pub(crate) parent: Option<ModuleId>,
    pub(crate) file: FileId,
    pub(crate) names: BTreeMap<String, Vec<Meaning>>,
    /// Paths of `use path::*`.
    pub(crate) globs: Vec<Vec<String>>,
    /// Its code: items of a file, or of a `mod` with a body.
    pub(crate) items: Vec<Item>,
}

/// Types, by file and name, and the files that add a function to them.
pub(crate) type Methods = BTreeMap<(FileId, String), BTreeMap<String, BTreeSet<FileId>>>;

#[derive(Default)]
pub(crate) struct Sources {
    /// Paths from the root of the workspace.
    pub(crate) files: Vec<PathBuf>,
    pub(crate) modules: Vec<Module>,
    /// Roots of libraries, by the name that code has for them.
    pub(crate) crates: BTreeMap<String, ModuleId>,
    pub(crate) methods: Methods,
    /// Files of tests within the sources.
    tests: Vec<PathBuf>,
}

/// One path that a `use` names.
pub(crate) struct Leaf<'a> {
    pub(crate) path: Vec<String>,
    /// Name that it gets here; `None` for a glob.
    pub(crate) name: Option<String>,
    pub(crate) ident: Option<&'a Ident>,
}

/// Returns the folders of the package at the root and of the members of its workspace, with their manifests.
///
/// # Errors
///
/// A sentence that names the manifest which cannot be read.
pub(crate) fn crates(root: &Path) -> Result<Vec<(PathBuf, toml::Table)>, String> {
    let read = |folder: &Path| -> Result<toml::Table, String> {
        let path = root.join(folder).join("Cargo.toml");
        let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        text.parse().map_err(|e| format!("{}: {e}", path.display()))
    };
    let top = read(Path::new(""))?;
    let members = top.get("workspace").and_then(|w| w.get("members"));
    let members = members.and_then(toml::Value::as_array).cloned().unwrap_or_default();
    let mut found = vec![(PathBuf::new(), top)];
    for member in members.iter().filter_map(toml::Value::as_str) {
        found.push((PathBuf::from(member), read(Path::new(member))?));
    }
    Ok(found)
}

/// Returns whether a `cfg` holds in tests only.
pub(crate) fn is_test(attributes: &[Attribute]) -> bool {
    fn needs_test(meta: &Meta) -> bool {
        match meta {
            Meta::Path(path) => path.is_ident("test"),
            Meta::NameValue(_) => false,
            Meta::List(list) => {
                let parts = list.parse_args_with(
                    syn::punctuated::Punctuated::<Meta, syn::Token![,]>::parse_terminated,
                );
                let parts = parts.unwrap_or_default();
                (list.path.is_ident("all") && parts.iter().any(needs_test))
                    || (list.path.is_ident("any") && parts.iter().all(needs_test))
            }
        }
    }
    attributes.iter().any(|a| {
        a.path().is_ident("test")
            || a.path().is_ident("cfg")
                && a.parse_args::<Meta>().is_ok_and(|condition| needs_test(&condition))
    })
}

/// Returns the attributes of an item.
pub(crate) fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Union(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

/// Returns whether a `use` only passes something on.
pub(crate) fn is_passed_on(visibility: &Visibility) -> bool {
    !matches!(visibility, Visibility::Inherited)
}

/// Returns every path of a `use`.
pub(crate) fn leaves(tree: &UseTree) -> Vec<Leaf<'_>> {
    let mut found = Vec::new();
    collect(tree, &mut Vec::new(), &mut found);
    found
}

fn collect<'a>(tree: &'a UseTree, before: &mut Vec<String>, found: &mut Vec<Leaf<'a>>) {
    let mut leaf = |ident: &'a Ident, name: &Ident| {
        let mut path = before.clone();
        let mut name = name.to_string();
        if ident != "self" || path.is_empty() {
            path.push(ident.to_string());
        } else if name == "self" {
            name = path.last().cloned().unwrap_or_default();
        }
        found.push(Leaf { path, name: Some(name), ident: Some(ident) });
    };
    match tree {
        UseTree::Name(name) => leaf(&name.ident, &name.ident),
        UseTree::Rename(rename) => leaf(&rename.ident, &rename.rename),
        UseTree::Glob(_) => found.push(Leaf { path: before.clone(), name: None, ident: None }),
        UseTree::Path(path) => {
            before.push(path.ident.to_string());
            collect(&path.tree, before, found);
            before.pop();
        }
        UseTree::Group(group) => group.items.iter().for_each(|t| collect(t, before, found)),
    }
}

impl Sources {
    /// Reads every crate: the package at the root and the members of its workspace.
    pub(crate) fn read(root: &Path) -> Result<Self, String> {
        let mut sources = Self::default();
        for (folder, manifest) in crates(root)? {
            let name = manifest.get("package").and_then(|p| p.get("name"));
            let name = name.and_then(toml::Value::as_str).ok_or("a package without a name")?;
            let name = name.replace('-', "_");
            for (file, name) in [("lib.rs", Some(name)), ("main.rs", None)] {
                let path = folder.join("src").join(file);
                if root.join(&path).exists() {
                    let module = sources.file(root, path, None)?;
                    sources.crates.extend(name.map(|n| (n, module)));
                }
            }
            // A package of benchmarks alone has none.
            let folder = folder.join("src");
            if root.join(&folder).is_dir() {
                sources.refuse_orphans(root, &folder)?;
            }
        }
        Ok(sources)
    }

    /// Refuses a file that no `mod` declares: nothing builds it.
    fn refuse_orphans(&self, root: &Path, folder: &Path) -> Result<(), String> {
        for entry in fs::read_dir(root.join(folder)).map_err(|e| e.to_string())? {
            let path = folder.join(entry.map_err(|e| e.to_string())?.file_name());
            let stem = path.with_extension("");
            if self.tests.iter().any(|t| path.starts_with(t) || stem == *t) {
                continue;
            }
            if root.join(&path).is_dir() {
                self.refuse_orphans(root, &path)?;
            } else if path.extension().is_some_and(|e| e == "rs") && !self.files.contains(&path) {
                return Err(format!("{} belongs to no module", path.display()));
            }
        }
        Ok(())
    }

    fn file(
        &mut self,
        root: &Path,
        path: PathBuf,
        parent: Option<ModuleId>,
    ) -> Result<ModuleId, String> {
        let text =
            fs::read_to_string(root.join(&path)).map_err(|e| format!("{}: {e}", path.display()))?;
        let parsed = syn::parse_file(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        let stem = path.file_stem().unwrap_or_default();
        let below = if ["mod", "lib", "main"].iter().any(|s| *s == stem) {
            path.parent().unwrap_or(Path::new("")).to_owned()
        } else {
            path.with_extension("")
        };
        self.files.push(path);
        self.module(root, &below, parsed.items, self.files.len() - 1, parent)
    }

    fn module(
        &mut self,
        root: &Path,
        below: &Path,
        items: Vec<Item>,
        file: FileId,
        parent: Option<ModuleId>,
    ) -> Result<ModuleId, String> {
        let id = self.modules.len();
        let (names, globs) = (BTreeMap::new(), Vec::new());
        self.modules.push(Module { parent, file, names, globs, items: Vec::new() });
        let mut code = Vec::new();
        for mut item in items {
            let test = is_test(attributes(&item));
            if let Item::Mod(declared) = &mut item {
                let folder = below.join(declared.ident.to_string());
                if test {
                    self.tests.push(folder);
                    continue;
                }
                if declared.attrs.iter().any(|a| a.path().is_ident("path")) {
                    return Err(format!("{}: `#[path]` is not followed", declared.ident));
                }
                let child = match declared.content.take() {
                    Some((_, items)) => self.module(root, &folder, items, file, Some(id))?,
                    None => {
                        let alone = folder.with_extension("rs");
                        let alone = root.join(&alone).exists().then_some(alone);
                        self.file(root, alone.unwrap_or(folder.join("mod.rs")), Some(id))?
                    }
                };
                self.name(id, &declared.ident.to_string(), Meaning::Module(child));
            } else if !test {
                self.names(id, &item);
                code.push(item);
            }
        }
        self.modules[id].items = code;
        Ok(id)
    }

    fn name(&mut self, module: ModuleId, name: &str, meaning: Meaning) {
        self.modules[module].names.entry(name.to_owned()).or_default().push(meaning);
    }

    /// Notes the names that an item has in its module, also those of a `use` within a function.
    fn names(&mut self, module: ModuleId, item: &Item) {
        let (name, kind) = match item {
            Item::Const(i) => (&i.ident, Kind::Value),
            Item::Enum(i) => (&i.ident, Kind::Type),
            Item::Fn(i) => (&i.sig.ident, Kind::Value),
            Item::Static(i) => (&i.ident, Kind::Value),
            Item::Struct(i) => (&i.ident, Kind::Type),
            Item::Trait(i) => (&i.ident, Kind::Type),
            Item::Type(i) => (&i.ident, Kind::Type),
            Item::Union(i) => (&i.ident, Kind::Type),
            Item::Macro(i) => {
                for declared in tokens::types(i.mac.tokens.clone()) {
                    self.name(module, &declared, Meaning::Item(Kind::Type));
                }
                match &i.ident {
                    Some(ident) => (ident, Kind::Macro),
                    None => return,
                }
            }
            Item::Use(i) => return self.alias(module, &i.tree),
            _ => return,
        };
        self.name(module, &name.to_string(), Meaning::Item(kind));
    }

    /// Notes what a `use` brings into a module.
    pub(crate) fn alias(&mut self, module: ModuleId, tree: &UseTree) {
        for leaf in leaves(tree) {
            match leaf.name {
                Some(name) => self.name(module, &name, Meaning::Alias(leaf.path)),
                None => self.modules[module].globs.push(leaf.path),
            }
        }
    }

    /// Notes which files add functions to which types.
    pub(crate) fn index_methods(&mut self) {
        self.alias_within_functions();
        let mut methods = Methods::new();
        for (id, module) in self.modules.iter().enumerate() {
            for item in &module.items {
                let Item::Impl(block) = item else { continue };
                if block.trait_.is_some() {
                    continue;
                }
                for (file, name) in self.types_of(id, &block.self_ty) {
                    let of_type = methods.entry((file, name)).or_default();
                    for part in &block.items {
                        let name = match part {
                            ImplItem::Fn(f) if !is_test(&f.attrs) => &f.sig.ident,
                            ImplItem::Const(c) => &c.ident,
                            _ => continue,
                        };
                        of_type.entry(name.to_string()).or_default().insert(module.file);
                    }
                }
            }
        }
        self.methods = methods;
    }

    fn alias_within_functions(&mut self) {
        struct Within<'a>(Vec<&'a syn::ItemUse>);
        impl<'a> syn::visit::Visit<'a> for Within<'a> {
            fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
                self.0.push(item);
            }
        }
        for id in 0..self.modules.len() {
            let items = std::mem::take(&mut self.modules[id].items);
            for item in items.iter().filter(|i| !matches!(i, Item::Use(_))) {
                let mut within = Within(Vec::new());
                syn::visit::Visit::visit_item(&mut within, item);
                within.0.iter().for_each(|u| self.alias(id, &u.tree));
            }
            self.modules[id].items = items;
        }
    }
}
