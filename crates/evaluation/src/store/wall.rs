//! What is kept beside a record and is no part of the result: how long the task took, and which build did it.

use serde::{Deserialize, Serialize};

use basics::hash::sha256;

/// Time a task took; not part of the result.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Wall-clock time of the task, seconds.
    pub wall_s: f64,
    /// Wall-clock time within the simulator, seconds.
    pub simulator_s: f64,
    /// Attempts, 1 unless the first failed.
    pub attempts: u32,
    /// Largest memory of the process so far, and of those that it had running then, MB; where the system does not tell,
    /// and in records from before it was kept, none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_memory_mb: Option<u64>,
    /// Git revision of the build that did the task, or `unknown`; empty in records from before it was kept.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub git: String,
    /// sha256 over the record's checksum and the other values here; empty before a record is made of them, and in
    /// records from before it was kept.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub checksum: String,
}

impl Wall {
    /// Returns the checksum of the values beside a record with this checksum.
    pub(super) fn sum(&self, record: &str) -> String {
        let bare = Self { checksum: String::new(), ..self.clone() };
        let text = serde_json::to_string(&bare).expect("plain data");
        sha256(format!("{record} {text}").as_bytes())
    }
}
