//! What stands in the way of somebody's SUMO scenario: where, why, and the option of the command that passes it. All of
//! it is said at once.

use std::collections::BTreeSet;
use std::fmt;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// The option that accepts something.
const ACCEPT: &str = "--accept";

/// Most obstacles that are listed.
const LISTED: usize = 30;

/// Something that a scenario does only when its user says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Accept {
    /// Calibrators and vaporizers stay. The vehicles that they add and remove differ between methods
    Calibrators,
    /// A mesoscopic scenario is simulated lane by lane
    Microscopic,
    /// A saved state is left out, so that the streets are empty at the start
    EmptyStart,
    /// Signals that an option switches off run their programs
    SignalsOn,
    /// Options that this program does not know are left out
    UnknownOptions,
    /// Files of the scenario draw in files that lie outside its folders
    OutsideFiles,
    /// Classes of vehicles that only a newer SUMO knows (container, drone, ...) are left out of networks
    NewerClasses,
}

impl Accept {
    fn name(self) -> String {
        self.to_possible_value().expect("none is hidden").get_name().to_owned()
    }
}

/// What the command line says of SUMO scenarios, in place of what their configurations say.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Given {
    /// Start, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub begin_s: Option<f64>,
    /// End, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_s: Option<f64>,
    /// Length of a step, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_length_s: Option<f64>,
    /// What is accepted.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub accept: BTreeSet<Accept>,
}

/// What stands in the way of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// The file, and the line where it has one.
    pub place: String,
    /// What is wrong.
    pub reason: String,
    /// The option of the command that passes it, with its value; `None`: the files have to change.
    pub way: Option<(&'static str, String)>,
}

impl Obstacle {
    /// Returns an obstacle that goes when something is accepted, or with a change of the files.
    pub fn new(place: String, reason: String, accept: Option<Accept>) -> Self {
        Self { place, reason, way: accept.map(|accept| (ACCEPT, accept.name())) }
    }

    /// Whether it goes when one of these is accepted.
    pub fn goes_with<'a>(&self, accept: impl IntoIterator<Item = &'a Accept>) -> bool {
        accept.into_iter().any(|accept| self.way == Some((ACCEPT, accept.name())))
    }
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.reason)?;
        self.way.as_ref().map_or(Ok(()), |(option, value)| write!(f, "; pass {option} {value}"))
    }
}

/// Returns all obstacles in words: one as a sentence, several as a list with the options that pass them.
pub fn in_words(obstacles: &[Obstacle]) -> String {
    if let [only] = obstacles {
        return only.to_string();
    }
    let lines: String = obstacles.iter().take(LISTED).map(|o| format!("\n  {o}")).collect();
    let text = format!("{} things are in the way:{lines}", obstacles.len());
    let ways: BTreeSet<_> = obstacles.iter().filter_map(|o| o.way.as_ref()).collect();
    if ways.is_empty() {
        return text;
    }
    let ways: Vec<String> =
        ways.iter().map(|(option, value)| format!("{option} {value}")).collect();
    let needs_change = obstacles.iter().any(|obstacle| obstacle.way.is_none());
    let what = if needs_change { "the rest, once the files are changed" } else { "all of it" };
    format!("{text}\npass {} for {what}", ways.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_obstacle_is_a_sentence_and_several_are_a_list_with_all_options() {
        let of =
            |reason: &str, accept| Obstacle::new("a.xml: line 3".into(), reason.into(), accept);
        let end = || Obstacle { way: Some(("--end", "3600".to_owned())), ..of("no end", None) };
        let accept = |what| of("it is so", Some(what));
        assert_eq!(in_words(&[end()]), "a.xml: line 3: no end; pass --end 3600");
        let all = [end(), end(), accept(Accept::EmptyStart), accept(Accept::Calibrators)];
        insta::assert_snapshot!(in_words(&all), @r"
        4 things are in the way:
          a.xml: line 3: no end; pass --end 3600
          a.xml: line 3: no end; pass --end 3600
          a.xml: line 3: it is so; pass --accept empty-start
          a.xml: line 3: it is so; pass --accept calibrators
        pass --accept calibrators --accept empty-start --end 3600 for all of it
        ");
        let mixed = [of("no XML", None), end()];
        let last = in_words(&mixed).lines().last().unwrap().to_owned();
        assert_eq!(last, "pass --end 3600 for the rest, once the files are changed");
        assert!(!in_words(&[of("a", None), of("b", None)]).contains("pass"));
    }
}
