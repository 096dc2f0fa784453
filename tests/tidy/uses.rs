//! Every path of the code and the file that it leads to.

use std::collections::BTreeSet;

use proc_macro2::Span;
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, Item, LitStr, Meta, Pat};

use super::modules::{FileId, Kind, ModuleId, Sources, attributes, is_passed_on, is_test, leaves};
use super::resolve::Target;
use super::tokens;

/// A file names something of another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Arrow {
    pub(crate) from: FileId,
    pub(crate) to: FileId,
    /// Line in `from`.
    pub(crate) line: usize,
    /// The path as written.
    pub(crate) path: String,
    /// Whether an item of the file is named, not its module alone. Only that counts between files.
    pub(crate) item: bool,
}

/// Returns all arrows.
pub(crate) fn arrows(sources: &Sources) -> BTreeSet<Arrow> {
    let mut found = BTreeSet::new();
    for (module, content) in sources.modules.iter().enumerate() {
        let mut visitor = Visitor {
            sources,
            module,
            file: content.file,
            of: Vec::new(),
            bound: Vec::new(),
            found: &mut found,
        };
        content.items.iter().for_each(|item| visitor.visit_item(item));
    }
    found
}

struct Visitor<'a> {
    sources: &'a Sources,
    module: ModuleId,
    file: FileId,
    /// Types of the `impl` blocks around.
    of: Vec<BTreeSet<(FileId, String)>>,
    /// Local names of the functions around.
    bound: Vec<BTreeSet<String>>,
    found: &'a mut BTreeSet<Arrow>,
}

/// Local names of a function.
struct Bound(BTreeSet<String>);

impl Visit<'_> for Bound {
    fn visit_pat_ident(&mut self, pattern: &syn::PatIdent) {
        self.0.insert(pattern.ident.to_string());
        visit::visit_pat_ident(self, pattern);
    }
}

impl Visitor<'_> {
    fn add(&mut self, to: FileId, span: Span, path: &[String], item: bool) {
        if to != self.file {
            let (line, path) = (span.start().line, path.join("::"));
            self.found.insert(Arrow { from: self.file, to, line, path, item });
        }
    }

    /// Notes what a path leads to; a name alone only if it is an item.
    fn path(&mut self, path: &[String], span: Span) {
        if path[0] == "Self" {
            if let Some(member) = path.get(1) {
                self.member(member, span);
            }
            return;
        }
        for target in self.sources.resolve(self.module, path) {
            match target {
                Target::Item { file, name, member, kind } => {
                    self.add(file, span, path, true);
                    if let (Some(member), Kind::Type) = (member, kind) {
                        self.method(file, name, &member, span);
                    }
                }
                Target::Module(m) if path.len() > 1 => {
                    self.add(self.sources.modules[m].file, span, path, false);
                }
                Target::Module(_) => {}
            }
        }
    }

    /// Notes the file that adds a function to a type.
    fn method(&mut self, file: FileId, name: String, member: &str, span: Span) {
        let path = [name.clone(), member.to_owned()];
        let of_type = self.sources.methods.get(&(file, name));
        for file in of_type.and_then(|t| t.get(member)).into_iter().flatten() {
            self.add(*file, span, &path, true);
        }
    }

    /// Notes the file that adds a function to the type of the `impl` around.
    fn member(&mut self, member: &str, span: Span) {
        for (file, name) in self.of.last().cloned().into_iter().flatten() {
            self.method(file, name, member, span);
        }
    }

    fn is_bound(&self, name: &str) -> bool {
        self.bound.iter().any(|b| b.contains(name))
    }

    fn tokens(&mut self, tokens: proc_macro2::TokenStream) {
        for found in tokens::paths(tokens) {
            if found.path.len() > 1 || found.called || !self.is_bound(&found.path[0]) {
                self.path(&found.path, found.span);
            }
        }
    }

    fn reexport(&mut self, item: &syn::ItemUse) {
        let passed_on = is_passed_on(&item.vis);
        for leaf in leaves(&item.tree) {
            let span = leaf.ident.map_or_else(|| item.use_token.span, proc_macro2::Ident::span);
            for target in self.sources.resolve(self.module, &leaf.path) {
                let (file, is_item) = match target {
                    Target::Item { file, .. } => (file, true),
                    Target::Module(m) => (self.sources.modules[m].file, leaf.name.is_none()),
                };
                if !(passed_on && self.is_below(file)) {
                    self.add(file, span, &leaf.path, is_item);
                }
            }
        }
    }

    /// Returns whether a file holds a module below this one.
    fn is_below(&self, file: FileId) -> bool {
        let root = self.sources.modules.iter().position(|m| m.file == file);
        root.is_some_and(|m| self.sources.around(m).any(|m| m == self.module))
    }

    fn within(&mut self, bound: BTreeSet<String>, visit: impl FnOnce(&mut Self)) {
        self.bound.push(bound);
        visit(self);
        self.bound.pop();
    }
}

impl<'ast> Visit<'ast> for Visitor<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.reexport(item);
    }

    fn visit_item_impl(&mut self, block: &'ast syn::ItemImpl) {
        self.of.push(self.sources.types_of(self.module, &block.self_ty));
        visit::visit_item_impl(self, block);
        self.of.pop();
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        let mut bound = Bound(BTreeSet::new());
        bound.visit_item_fn(function);
        self.within(bound.0, |v| visit::visit_item_fn(v, function));
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if is_test(&function.attrs) {
            return;
        }
        let mut bound = Bound(BTreeSet::new());
        bound.visit_impl_item_fn(function);
        self.within(bound.0, |v| visit::visit_impl_item_fn(v, function));
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        let mut bound = Bound(BTreeSet::new());
        bound.visit_trait_item_fn(function);
        self.within(bound.0, |v| visit::visit_trait_item_fn(v, function));
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if !is_test(&field.attrs) {
            visit::visit_field(self, field);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<_> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if let Some(first) = path.segments.first() {
            self.path(&names, first.ident.span());
        }
        visit::visit_path(self, path);
    }

    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        let local = path.path.get_ident().is_some_and(|i| self.is_bound(&i.to_string()));
        if !local {
            visit::visit_expr_path(self, path);
        }
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if let Expr::Path(path) = &*call.receiver
            && path.path.is_ident("self")
        {
            self.member(&call.method.to_string(), call.method.span());
        }
        visit::visit_expr_method_call(self, call);
    }

    /// A name alone in a pattern can be a constant or a variant.
    fn visit_pat(&mut self, pattern: &'ast Pat) {
        if let Pat::Ident(name) = pattern {
            let written = name.ident.to_string();
            if written.starts_with(char::is_uppercase) {
                self.path(&[written], name.ident.span());
            }
        }
        visit::visit_pat(self, pattern);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }

    /// `pub(in path)` uses nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    /// Attributes name items in their arguments; serde's also within strings.
    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        let Meta::List(list) = &attribute.meta else { return };
        if ["cfg", "doc", "expect"].iter().any(|n| list.path.is_ident(n)) {
            return;
        }
        self.tokens(list.tokens.clone());
        if list.path.is_ident("serde") {
            for token in list.tokens.clone() {
                let Ok(text) = syn::parse2::<LitStr>(token.clone().into()) else { continue };
                let Ok(path) = text.parse::<syn::Path>() else { continue };
                let names: Vec<_> = path.segments.iter().map(|s| s.ident.to_string()).collect();
                if names.len() > 1 {
                    self.serde_path(&names, token.span());
                } else {
                    self.path(&names, token.span());
                }
            }
        }
    }
}

impl Visitor<'_> {
    /// `with = "module"` uses functions of the module.
    fn serde_path(&mut self, path: &[String], span: Span) {
        self.path(path, span);
        for target in self.sources.resolve(self.module, path) {
            if let Target::Module(m) = target {
                self.add(self.sources.modules[m].file, span, path, true);
            }
        }
    }
}
