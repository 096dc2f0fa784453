//! What was skipped or ignored while reading, counted by reason, so that nothing is lost silently.

use std::collections::BTreeMap;

use serde::Serialize;

/// One reason and how often it applied.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Oddity {
    /// How often.
    pub count: u64,
    /// The first case, such as `way 17, lanes=many`.
    pub example: String,
}

/// Counts by reason.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Oddities {
    reasons: BTreeMap<&'static str, Oddity>,
}

impl Oddities {
    /// Counts one case; `example` is called for the first of a reason only.
    pub fn add(&mut self, reason: &'static str, example: impl FnOnce() -> String) {
        let new = || Oddity { count: 0, example: example() };
        self.reasons.entry(reason).or_insert_with(new).count += 1;
    }

    /// Adds the cases of another part of the same file, which comes later.
    pub fn merge(&mut self, later: Self) {
        for (reason, oddity) in later.reasons {
            let count = oddity.count;
            self.reasons.entry(reason).and_modify(|mine| mine.count += count).or_insert(oddity);
        }
    }

    /// Returns the reasons in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Oddity)> {
        self.reasons.iter().map(|(reason, oddity)| (*reason, oddity))
    }

    /// Returns how often a reason applied.
    pub fn count(&self, reason: &str) -> u64 {
        self.reasons.get(reason).map_or(0, |o| o.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_adds_counts_and_keeps_the_first_example() {
        let mut early = Oddities::default();
        early.add("lanes", || "way 1".to_owned());
        let mut late = Oddities::default();
        late.add("lanes", || "way 2".to_owned());
        late.add("speed", || "way 3".to_owned());
        early.merge(late);
        assert_eq!(early.count("lanes"), 2);
        assert_eq!(early.iter().next().unwrap().1.example, "way 1");
        assert_eq!(early.count("speed"), 1);
    }
}
