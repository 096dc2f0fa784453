//! What stands in the way of somebody's SUMO scenario: where, why, and the option of the command that passes it. All of
//! it is said at once.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

/// Something that a scenario does only when its user says so.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum,
)]
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
    /// Returns its name on the command line.
    pub fn name(self) -> String {
        let name = serde_json::to_value(self).expect("a name is plain data");
        name.as_str().unwrap_or_default().to_owned()
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

/// How to pass an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub enum Way {
    /// With an option of the command, such as `--end 3600`.
    Option(String),
    /// By accepting something.
    Accept(Accept),
    /// By a change of the files, in words; empty where the reason says it.
    Change(&'static str),
}

/// What stands in the way of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// The file, and the line where it has one.
    pub place: String,
    /// What is wrong.
    pub reason: String,
    /// How to pass it.
    pub way: Way,
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, reason, way } = self;
        match way {
            Way::Option(option) => write!(f, "{place}: {reason}; pass {option}"),
            Way::Accept(accept) => write!(f, "{place}: {reason}; pass --accept {}", accept.name()),
            Way::Change("") => write!(f, "{place}: {reason}"),
            Way::Change(change) => write!(f, "{place}: {reason}; {change}"),
        }
    }
}

/// Returns all obstacles in words: one as a sentence, several as a list with the options that pass them.
pub fn in_words(obstacles: &[Obstacle]) -> String {
    if let [only] = obstacles {
        return only.to_string();
    }
    let mut text = format!("{} things are in the way:", obstacles.len());
    for obstacle in obstacles {
        text.push_str(&format!("\n  {obstacle}"));
    }
    let mut options: Vec<String> = Vec::new();
    for obstacle in obstacles {
        if let Way::Option(option) = &obstacle.way
            && !options.contains(option)
        {
            options.push(option.clone());
        }
    }
    let accept = obstacles.iter().filter_map(|obstacle| match obstacle.way {
        Way::Accept(accept) => Some(accept),
        _ => None,
    });
    let accept: Vec<String> =
        accept.collect::<BTreeSet<_>>().into_iter().map(Accept::name).collect();
    if !accept.is_empty() {
        options.push(format!("--accept {}", accept.join(",")));
    }
    let changes = obstacles.iter().filter(|o| matches!(o.way, Way::Change(_))).count();
    if !options.is_empty() {
        let what = if changes == 0 { "all of it" } else { "the rest, once the files are changed" };
        text.push_str(&format!("\npass {} for {what}", options.join(" ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn obstacle(reason: &str, way: Way) -> Obstacle {
        Obstacle { place: "a.xml: line 3".to_owned(), reason: reason.to_owned(), way }
    }

    #[test]
    fn one_obstacle_is_a_sentence_and_several_are_a_list_with_all_options() {
        let end = || obstacle("no end", Way::Option("--end 3600".to_owned()));
        let accept = |what| obstacle("it is so", Way::Accept(what));
        assert_eq!(in_words(&[end()]), "a.xml: line 3: no end; pass --end 3600");
        let all = [end(), end(), accept(Accept::EmptyStart), accept(Accept::Calibrators)];
        insta::assert_snapshot!(in_words(&all), @r"
        4 things are in the way:
          a.xml: line 3: no end; pass --end 3600
          a.xml: line 3: no end; pass --end 3600
          a.xml: line 3: it is so; pass --accept empty-start
          a.xml: line 3: it is so; pass --accept calibrators
        pass --end 3600 --accept calibrators,empty-start for all of it
        ");
        let missing = obstacle("it is missing", Way::Change("add it"));
        let said = in_words(&[end(), missing]);
        assert!(said.ends_with("add it\npass --end 3600 for the rest, once the files are changed"));
    }
}
