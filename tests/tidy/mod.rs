//! Which file of the sources names what of which other file, and whether that runs in a circle.
//!
//! The sources are parsed, not searched. [`modules`] finds the files of every crate of the workspace and the names
//! that each module has; [`resolve`] follows a path (`crate`, `self`, `super`, what `use` brought in, re-exports)
//! to the file that defines what it names; [`uses`] visits every path of a file, in code, in attributes and within
//! macros' arguments; [`graph`] finds circles; [`table`] compares modules with ARCHITECTURE.md.
//!
//! What counts:
//! - Code under `#[cfg(test)]` does not. Both sides of any other `cfg` do.
//! - `mod x;` is no arrow. Nor is a re-export (`pub use`) from below the module that re-exports: whoever names the
//!   re-exported item depends on the file that defines it. If the parent also uses the item in its code, that is one.
//! - Inherent methods that a file adds to a type of another are found through `Type::name`, `Self::name` and
//!   `self.name`. Methods of a value whose type is not written there are not: nothing here infers types.

pub(crate) mod graph;
pub(crate) mod modules;
mod planted;
mod resolve;
pub(crate) mod table;
mod tokens;
mod uses;

use std::path::Path;

use graph::Graph;

/// Returns the graph of the sources of the workspace at a folder.
///
/// # Errors
///
/// A sentence that names the file which cannot be read, or which belongs to no module.
pub(crate) fn read(root: &Path) -> Result<Graph, String> {
    let mut sources = modules::Sources::read(root)?;
    sources.index_methods();
    let arrows = uses::arrows(&sources);
    Ok(Graph::new(sources, arrows))
}
