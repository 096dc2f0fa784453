//! When a sample is large enough, as it is asked for on the command line.

use super::refused::Refused;
use crate::sample::Until;

/// What stands for deciding which method is the best, in place of pairs.
const FIRST_PLACE: &str = "first-place";

/// When a run stops before its budget is spent.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct UntilArgs {
    /// Stop at the first look at which every pair of methods is decided, or every pair that is given, or it is decided
    /// which method is the best; methods that are surely behind drop out before
    #[arg(long, value_name = "A:B,...|first-place", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub until_decided: Option<String>,
}

impl UntilArgs {
    /// Returns the flag that was given.
    pub fn flag(&self) -> Option<&'static str> {
        self.until_decided.as_ref().map(|_| "--until-decided")
    }

    /// Returns what was asked for; nothing, if nothing was.
    ///
    /// # Arguments
    ///
    /// * `judged` — methods that are asked about where no pair is named, in order.
    /// * `methods` — all that there are.
    pub fn until(&self, judged: &[String], methods: &[String]) -> anyhow::Result<Option<Until>> {
        Ok(match &self.until_decided {
            Some(asked) if asked == FIRST_PLACE => {
                if judged.len() < 2 {
                    let reason = "it takes two methods to decide between";
                    return Err(Refused(format!("--until-decided={FIRST_PLACE}: {reason}")).into());
                }
                Some(Until::FirstPlace(judged.to_vec()))
            }
            Some(pairs) => Some(Until::Decided(asked(pairs, judged, methods)?)),
            None => None,
        })
    }
}

/// Returns the pairs of methods that are asked about.
fn asked(
    pairs: &str,
    judged: &[String],
    methods: &[String],
) -> anyhow::Result<Vec<(String, String)>> {
    let refuse = |reason: &str| Err(Refused(format!("--until-decided: {reason}")).into());
    let mut all: Vec<(String, String)> = Vec::new();
    if pairs.is_empty() {
        for (i, first) in judged.iter().enumerate() {
            all.extend(judged[i + 1..].iter().map(|second| (first.clone(), second.clone())));
        }
        if all.is_empty() {
            return refuse("it takes two methods to decide between");
        }
        return Ok(all);
    }
    for pair in pairs.split(',') {
        let Some((a, b)) = pair.split_once(':').filter(|(a, b)| a != b) else {
            return refuse(&format!(
                "{pair:?} is no pair of methods; write it as idqn:actuated, several with commas between"
            ));
        };
        for method in [a, b] {
            if !methods.iter().any(|m| m == method) {
                let all = methods.join(", ");
                return refuse(&format!("{method} is not among the methods ({all})"));
            }
        }
        let same = |(c, d): &(String, String)| [c, d] == [a, b] || [d, c] == [a, b];
        if !all.iter().any(same) {
            all.push((a.to_owned(), b.to_owned()));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    fn decided(pairs: &str) -> anyhow::Result<Option<Until>> {
        let args = UntilArgs { until_decided: Some(pairs.to_owned()) };
        args.until(&names(&["a", "b", "c"]), &names(&["base", "a", "b", "c"]))
    }

    fn pairs(of: &[(&str, &str)]) -> Option<Until> {
        let pair = |(a, b): &(&str, &str)| ((*a).to_owned(), (*b).to_owned());
        Some(Until::Decided(of.iter().map(pair).collect()))
    }

    #[test]
    fn every_two_are_asked_about_unless_pairs_are_named() {
        assert_eq!(decided("").unwrap(), pairs(&[("a", "b"), ("a", "c"), ("b", "c")]));
        assert_eq!(decided("c:base,a:b,b:a").unwrap(), pairs(&[("c", "base"), ("a", "b")]));
    }

    #[test]
    fn what_is_no_pair_is_refused() {
        for wrong in ["a", "a:a", "a:b,", "a:d"] {
            let e = decided(wrong).unwrap_err().to_string();
            assert!(e.contains("no pair of methods") || e.contains("d is not among"), "{e}");
        }
        let one = UntilArgs { until_decided: Some(String::new()) };
        assert!(one.until(&names(&["a"]), &names(&["a"])).is_err());
    }
}
