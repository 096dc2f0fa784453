//! Settings whose names are known, so that one that is misspelt gets the right one proposed.

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// All settings of a file: plain data of which every part can be replaced by its dotted name.
pub trait Named: Serialize + DeserializeOwned {
    /// Returns the dotted names of all settings, such as `demand.horizon_s`.
    fn names() -> &'static [String];
}

/// Returns the dotted names of the settings of a table.
pub fn names_of(table: &Table) -> Vec<String> {
    let mut names = Vec::new();
    gather("", table, &mut names);
    names
}

fn gather(above: &str, table: &Table, names: &mut Vec<String>) {
    for (key, value) in table {
        match value {
            Value::Table(inner) => gather(&format!("{above}{key}."), inner, names),
            _ => names.push(format!("{above}{key}")),
        }
    }
}
