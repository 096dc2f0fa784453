//! Notices early that a method or a scenario only fails: nobody wants to wait for a thousand tasks of which each fails for
//! the reason of the first.

use std::collections::HashMap;

use crate::store::record::{Outcome, Record};

/// Tasks that have to fail for one reason, before anything else comes of the method or the point MDP.
const ENOUGH: u32 = 3;

/// How the first tasks of every method, and on every point MDP, have ended.
#[derive(Debug, Default)]
pub(super) struct FirstFailures {
    /// How many failed, and why; `None` where something else came too.
    first: HashMap<String, Option<(u32, String)>>,
}

impl FirstFailures {
    /// Adds a record; returns in words that the first tasks of its method or on its point MDP have all failed for one
    /// reason, when that are enough.
    pub(super) fn add(&mut self, record: &Record) -> Option<String> {
        let summary = &record.summary;
        let reason = summary.reason.as_deref().filter(|_| summary.outcome == Outcome::Failed);
        let mut said = None;
        for what in [format!("of {}", summary.method), format!("on {}", summary.point)] {
            let first = self
                .first
                .entry(what.clone())
                .or_insert_with(|| Some((0, plain(reason.unwrap_or_default()))));
            match (&mut *first, reason) {
                (Some((count, known)), Some(reason)) if *known == plain(reason) => {
                    *count += 1;
                    if *count == ENOUGH {
                        said = Some(format!(
                            "the first {count} tasks {what} failed for one reason: {reason}"
                        ));
                    }
                }
                _ => *first = None,
            }
        }
        said
    }
}

/// Returns a reason without its numbers, which are of the single task.
fn plain(reason: &str) -> String {
    let mut text = String::new();
    for c in reason.chars() {
        match c.is_ascii_digit() {
            true if text.ends_with('#') => {}
            true => text.push('#'),
            false => text.push(c),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::manifest::Task;
    use crate::store::record::TaskResult;
    use crate::store::wall::Wall;

    /// Adds tasks that end so, and returns after which something is said.
    fn said(tasks: &[(&str, &str, Option<&str>)]) -> Vec<usize> {
        let mut alike = FirstFailures::default();
        let add = |(i, (method, point, reason)): (usize, &(&str, &str, Option<&str>))| {
            let (method, point) = ((*method).into(), (*point).into());
            let task = Task { task: i, method, point, replicate: 0, seed: 0 };
            let record = match reason {
                Some(reason) => Record::failed(&task, "", (*reason).to_owned(), Wall::default()),
                None => Record::finished(&task, "", TaskResult::default()),
            };
            alike.add(&record).map(|_| i)
        };
        tasks.iter().enumerate().filter_map(add).collect()
    }

    #[test]
    fn a_method_or_a_point_mdp_that_only_fails_for_one_reason_is_noticed() {
        let why = Some("no edge 7");
        let method =
            [("a", "p", why), ("b", "p", None), ("a", "q", Some("no edge 12")), ("a", "r", why)];
        assert_eq!(said(&method), [3]);
        let point = [("a", "p", why), ("b", "p", why), ("c", "q", None), ("c", "p", why)];
        assert_eq!(said(&point), [3]);
    }

    #[test]
    fn what_fails_for_several_reasons_or_not_from_the_beginning_is_not() {
        let (why, other) = (Some("no edge"), Some("it diverged"));
        assert_eq!(
            said(&[("a", "p", why), ("a", "q", other), ("a", "r", why), ("a", "s", why)]),
            [0; 0]
        );
        let later: Vec<_> = ["p", "q", "r", "s"].map(|p| ("a", p, why)).to_vec();
        assert_eq!(said(&[vec![("a", "o", None)], later].concat()), [0; 0]);
    }
}
