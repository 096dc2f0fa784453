//! What the command line needs of a domain to read its scenarios; `domains.rs` lists those there are.

use super::domain::{Domain, Problem};
use crate::family::FamilyError;
use crate::settings::overrides::Override;
use crate::settings::setting::Setting;

/// A domain whose problems need nothing of the command line but a scenario and its settings.
#[derive(Clone, Copy)]
pub struct Entry {
    /// The domain.
    pub domain: &'static dyn Domain,
    /// Names of the scenarios that the program carries.
    pub scenarios: &'static [&'static str],
    /// Names of the presets.
    pub presets: &'static [&'static str],
    /// Returns the dotted names of all settings.
    pub names: fn() -> &'static [String],
    /// Returns what a setting is; `None` for what stands outside of sections.
    pub setting: fn(&str) -> Option<&'static Setting>,
    /// Reads a scenario, by path or carried name, with settings replaced.
    pub load: Load,
}

/// Reads a scenario, by path or carried name, with settings replaced.
pub type Load = fn(&str, &[Override]) -> Result<Box<dyn Problem>, FamilyError>;

impl std::fmt::Debug for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Entry").field("domain", &self.domain.name()).finish_non_exhaustive()
    }
}
