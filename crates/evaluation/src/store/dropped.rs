//! `dropped.json`: the methods that a growing run no longer evaluates, because they are surely behind another one.
//!
//! It follows from the records. Where it is missing, the command that began the run writes it again.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Layout;
use super::error::{Remedy, StoreError};
use super::manifest::{Identity, Task};
use crate::sample::SamplePlan;
use basics::files::{FileError, write_atomically};

/// A method that is no longer evaluated.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dropped {
    /// The method.
    pub method: String,
    /// The last look that it has, from 1.
    pub look: usize,
    /// A method that was ahead of it there by more than chance.
    pub behind: String,
}

/// Reads `dropped.json`; nothing where there is none.
pub(super) fn read_dropped(
    layout: &Layout,
    identity: &Identity,
) -> Result<Vec<Dropped>, StoreError> {
    let damaged = |reason: String| StoreError::damaged(layout.dropped(), reason, Remedy::Renew);
    let Some(bytes) = layout.document("dropped.json")? else {
        return Ok(Vec::new());
    };
    let all: Vec<Dropped> = serde_json::from_slice(&bytes).map_err(|e| damaged(e.to_string()))?;
    let looks = identity.sample.growth.as_ref().map_or(0, |growth| growth.looks.len());
    let mut seen = BTreeSet::new();
    for Dropped { method, look, behind } in &all {
        let known = [method, behind].iter().all(|m| identity.methods.contains(m));
        if !known || *method == identity.baseline || method == behind || !seen.insert(method) {
            return Err(damaged(format!("it drops {method:?}, which this run does not")));
        }
        if *look == 0 || *look >= looks {
            return Err(damaged(format!("it drops {method} after look {look} of {looks}")));
        }
    }
    Ok(all)
}

/// Writes `dropped.json`.
pub fn write_dropped(layout: &Layout, all: &[Dropped]) -> Result<(), FileError> {
    let mut bytes = serde_json::to_vec_pretty(all).expect("names and numbers are plain data");
    bytes.push(b'\n');
    write_atomically(&layout.dropped(), &bytes)
}

/// Whether a task is still to be done, or was before its method was dropped.
pub(super) fn is_needed(sample: &SamplePlan, dropped: &[Dropped], task: &Task) -> bool {
    let Some(last) = dropped.iter().find(|d| d.method == task.method) else { return true };
    let looks = sample.growth.as_ref().map_or(&[][..], |growth| &growth.looks);
    let look = looks.get(last.look.saturating_sub(1));
    look.is_some_and(|look| look.draws.iter().any(|draw| draw.point == task.point))
}
