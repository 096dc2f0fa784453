//! `dropped.json`: the methods that a growing run no longer evaluates, because they are surely behind another one.
//!
//! It follows from the records. Where it is missing, the command that began the run writes it again.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::Layout;
use super::manifest::{Identity, Task};
use crate::sample::SamplePlan;
use crate::store::error::StoreError;
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
///
/// # Errors
///
/// [`StoreError::Malformed`] where it is not of the run.
pub fn read_dropped(layout: &Layout, identity: &Identity) -> Result<Vec<Dropped>, StoreError> {
    let path = layout.dropped();
    let malformed = |reason: String| StoreError::Malformed {
        path: path.clone(),
        reason: format!(
            "{reason}; remove it and repeat the command that began the run, which writes it again"
        ),
    };
    let Some(bytes) = layout.document("dropped.json")? else {
        return Ok(Vec::new());
    };
    let all: Vec<Dropped> = serde_json::from_slice(&bytes).map_err(|e| malformed(e.to_string()))?;
    let looks = identity.sample.growth.as_ref().map_or(0, |growth| growth.looks.len());
    let mut seen = BTreeSet::new();
    for Dropped { method, look, behind } in &all {
        let known = [method, behind].iter().all(|m| identity.methods.contains(m));
        if !known || *method == identity.baseline || method == behind || !seen.insert(method) {
            return Err(malformed(format!("it drops {method:?}, which this run does not")));
        }
        if *look == 0 || *look >= looks {
            return Err(malformed(format!("it drops {method} after look {look} of {looks}")));
        }
    }
    Ok(all)
}

/// Writes `dropped.json`.
///
/// # Errors
///
/// [`FileError`] when the directory cannot be written.
pub fn write_dropped(layout: &Layout, all: &[Dropped]) -> Result<(), FileError> {
    let mut bytes = serde_json::to_vec_pretty(all).expect("names and numbers are plain data");
    bytes.push(b'\n');
    write_atomically(&layout.dropped(), &bytes)
}

/// Which tasks are left when methods are dropped.
#[derive(Debug)]
pub struct Needed<'a> {
    points: BTreeMap<&'a str, BTreeSet<&'a str>>,
}

impl<'a> Needed<'a> {
    /// Takes the methods that are dropped, each with the point MDPs of its last look.
    pub fn of(sample: &'a SamplePlan, dropped: &'a [Dropped]) -> Self {
        let looks = sample.growth.as_ref().map_or(&[][..], |growth| &growth.looks);
        let points = |d: &'a Dropped| {
            let draws = looks.get(d.look.saturating_sub(1)).map_or(&[][..], |look| &look.draws);
            (d.method.as_str(), draws.iter().map(|draw| draw.point.as_str()).collect())
        };
        Self { points: dropped.iter().map(points).collect() }
    }

    /// Whether a task is still to be done, or was before its method was dropped.
    pub fn has(&self, task: &Task) -> bool {
        self.points.get(&*task.method).is_none_or(|points| points.contains(&*task.point))
    }
}
