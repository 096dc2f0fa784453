//! Which builds did the tasks of a run.

use std::collections::BTreeMap;

use super::wall::Wall;

/// Number of records that each build made; records from before builds were kept are not counted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Builds(BTreeMap<String, usize>);

impl Builds {
    /// Counts a record.
    pub fn add(&mut self, wall: &Wall) {
        if !wall.git.is_empty() {
            *self.0.entry(wall.git.clone()).or_default() += 1;
        }
    }

    /// Says which builds there are; `None` unless there are several.
    pub fn several(&self) -> Option<String> {
        let counts: Vec<String> =
            self.0.iter().map(|(git, records)| format!("{records} by {git}")).collect();
        let counts = counts.join(", ");
        (self.0.len() > 1).then(|| format!("Several builds made the records: {counts}."))
    }

    /// Says what several builds mean for scores; `None` unless there are several.
    pub fn warning(&self) -> Option<String> {
        let several = self.several()?;
        Some(format!(
            "{several} Where these builds measure otherwise, scores mix both. A run in a new folder has records of one build."
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_builds_are_counted_and_one_is_not_worth_a_word() {
        let mut builds = Builds::default();
        let by = |git: &str| Wall { git: git.to_owned(), ..Wall::default() };
        ["a", "", "a"].iter().for_each(|git| builds.add(&by(git)));
        assert_eq!(builds.several(), None);
        builds.add(&by("b"));
        assert_eq!(builds.several().unwrap(), "Several builds made the records: 2 by a, 1 by b.");
    }
}
