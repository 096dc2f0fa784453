//! How a worker is started: a program with what comes before and after the subcommand.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

/// A program that answers the subcommands of workers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Launcher {
    /// The program.
    pub program: PathBuf,
    /// Arguments before the subcommand, as of an interpreter.
    pub first: Vec<OsString>,
    /// Methods that are not the program's own, each with the arguments that give it.
    pub own: Vec<(String, Vec<OsString>)>,
    /// By name of a saved model the method that has learned it, which may be one's own too.
    pub learners: BTreeMap<String, String>,
}

impl Launcher {
    /// Returns a program that needs nothing before and after the subcommand.
    pub fn of(program: impl Into<PathBuf>) -> Self {
        Self {
            program: program.into(),
            first: Vec::new(),
            own: Vec::new(),
            learners: BTreeMap::new(),
        }
    }

    /// Returns the arguments after all others, which give the methods that are not the program's own.
    pub fn last(&self) -> impl Iterator<Item = &OsString> {
        self.own.iter().flat_map(|(_, arguments)| arguments)
    }

    /// Returns a subcommand with its arguments, for a task of a method. Another method of one's own has no part in it:
    /// two may have modules of the same name.
    pub fn command(&self, subcommand: &str, arguments: &[OsString], method: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.first).arg(subcommand).args(arguments);
        let learner = self.learners.get(method);
        let own = self.own.iter().filter(|(name, _)| name == method || learner == Some(name));
        command.args(own.flat_map(|(_, arguments)| arguments));
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_is_given_the_method_of_its_task_and_no_other() {
        let own = ["a", "b"].map(|name| {
            (name.to_owned(), vec!["--controller".into(), format!("{name}=exec:{name}").into()])
        });
        let launcher = Launcher { own: own.to_vec(), ..Launcher::of("tsc-family") };
        let words = |method: &str| {
            let command = launcher.command("worker", &["out".into()], method);
            let words: Vec<_> =
                command.get_args().map(|w| w.to_string_lossy().into_owned()).collect();
            words.join(" ")
        };
        assert_eq!(words("b"), "worker out --controller b=exec:b");
        assert_eq!(words("idqn"), "worker out");
        assert_eq!(launcher.last().count(), 4);
    }

    #[test]
    fn the_worker_of_a_model_is_given_its_class_too() {
        let own = [("mine", "--controller"), ("other", "--controller"), ("mine-of-a", "--model")];
        let own = own.map(|(name, option)| (name.to_owned(), vec![option.into(), name.into()]));
        let learners = [("mine-of-a".to_owned(), "mine".to_owned())].into();
        let launcher = Launcher { own: own.to_vec(), learners, ..Launcher::of("tsc-family") };
        let command = launcher.command("worker", &[], "mine-of-a");
        let words: Vec<_> = command.get_args().map(|w| w.to_string_lossy()).collect();
        assert_eq!(words.join(" "), "worker --controller mine --model mine-of-a");
    }
}
