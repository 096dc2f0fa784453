//! Methods that are not the program's own: what the command line says of them, and how workers are told.

use crate::cli::exit::without_effect;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use anyhow::Context;

use super::values::at_least_a_second;
use crate::cli::method_arguments::{add, add_model, add_named, add_plan, learner_of};
use crate::domains;
use crate::run::domain::Domain;
use crate::run::executor::Launcher;
use crate::run::model::SavedModel;
use crate::store::Layout;
use crate::store::error::StoreError;
use crate::store::manifest::Manifest;
use crate::traffic::domain::Traffic;
use crate::traffic::model::SignalModel;
use crate::traffic::own::Host;

/// Time that a command may take for an answer, seconds.
const ANSWER_TIMEOUT_S: u64 = 60;

/// How this program is started again; empty for its executable alone.
static START: OnceLock<Vec<OsString>> = OnceLock::new();

/// The manifest of the results directory that the command is about.
static READ: OnceLock<(PathBuf, Arc<Manifest>)> = OnceLock::new();

/// What opens classes, where this program has it.
static HOST: OnceLock<Box<dyn Host>> = OnceLock::new();

/// Methods that are not the program's own.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct ControllersArgs {
    /// Your own controller: a command that answers over pipes, or a class in Python, as
    /// FILE.py:CLASS?name=value&name=value (repeatable). Only the command of the Python package takes classes
    #[arg(long = "controller", value_name = "NAME=exec:COMMAND|NAME=FILE.py:CLASS")]
    pub controllers: Vec<String>,
    /// Plans of signals as a method of this name, such as a plan that is proposed: a table with a row per phase, or UTDF
    /// (repeatable)
    #[arg(long = "plan-file", value_name = "NAME=FILE")]
    pub plans: Vec<String>,
    /// Saved model as a method of this name: a file of the folder models of a results directory. It is not trained again. A
    /// model of a class of your own needs that --controller too (repeatable)
    #[arg(long = "model", value_name = "NAME=FILE")]
    pub models: Vec<String>,
    /// Time that a command may take for an answer
    #[arg(long, value_name = "SECONDS", default_value_t = ANSWER_TIMEOUT_S, value_parser = at_least_a_second())]
    pub answer_timeout: u64,
}

impl ControllersArgs {
    /// Returns classes of somebody's own, to which saved models are added.
    pub(super) fn of_classes(classes: &[String]) -> Self {
        Self { controllers: classes.to_vec(), answer_timeout: ANSWER_TIMEOUT_S, ..Self::default() }
    }

    fn given(&self) -> impl Iterator<Item = (&'static str, &String)> {
        let options = [
            ("--controller", &self.controllers),
            ("--plan-file", &self.plans),
            ("--model", &self.models),
        ];
        options.into_iter().flat_map(|(option, all)| all.iter().map(move |given| (option, given)))
    }

    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        self.given().map(|(_, given)| name_of(given))
    }

    /// Refuses controllers of signals where something else is evaluated, and a limit that nothing is subject to.
    pub(super) fn check(&self, domain: &dyn Domain) -> anyhow::Result<()> {
        let is_known = |name: &String| domain.methods().iter().any(|m| m.name == name);
        let is_command = self.controllers.iter().any(|given| is_command(given));
        let is_other = self.answer_timeout != ANSWER_TIMEOUT_S;
        let options = self.given().map(|(option, given)| {
            (option, !is_known(&name_of(given)), "only signals have methods of your own")
        });
        let timeout = ("--answer-timeout", is_other && !is_command, "no controller is a command");
        without_effect(&options.chain([timeout]).collect::<Vec<_>>())
    }

    /// Returns the saved models that were given, each with what it is called.
    pub(super) fn read_models(&self) -> anyhow::Result<Vec<(String, SignalModel)>> {
        let read = |given: &String| {
            let (name, file) = given.split_once('=').unwrap_or(("", given));
            let saved = SavedModel::read(Path::new(file))?;
            Ok((name.to_owned(), SignalModel::new(saved, domains::traffic().methods())?))
        };
        self.models.iter().map(read).collect()
    }

    /// Returns how workers are started that have these methods too.
    pub(super) fn launcher(&self) -> anyhow::Result<Launcher> {
        let mut start = START.get().cloned().unwrap_or_default().into_iter();
        let program = match start.next() {
            Some(program) => program.into(),
            None => std::env::current_exe().context("cannot find this program")?,
        };
        let own = self.given().map(|(option, given)| {
            let mut arguments: Vec<OsString> = vec![option.into(), given.into()];
            if self.answer_timeout != ANSWER_TIMEOUT_S && is_command(given) {
                let timeout = self.answer_timeout.to_string();
                arguments.extend(["--answer-timeout".into(), timeout.into()]);
            }
            (name_of(given), arguments)
        });
        let learners = self.models.iter().map(|given| Ok((name_of(given), learner_of(given)?)));
        let learners = learners.collect::<anyhow::Result<_>>()?;
        let own = own.collect();
        Ok(Launcher { program, first: start.collect(), own, learners })
    }

    /// Adds the controllers that were given.
    fn add_to(&self, mut traffic: Traffic, host: Option<&dyn Host>) -> anyhow::Result<Traffic> {
        let answer = Duration::from_secs(self.answer_timeout);
        for given in &self.controllers {
            traffic = add(traffic, given, host, answer)?;
        }
        for given in &self.plans {
            traffic = add_plan(traffic, given)?;
        }
        for given in &self.models {
            traffic = add_model(traffic, given)?;
        }
        Ok(traffic)
    }
}

fn name_of(given: &str) -> String {
    given.split_once('=').map_or(given, |(name, _)| name).to_owned()
}

fn is_command(given: &str) -> bool {
    given.contains("=exec:")
}

/// Makes the methods known that a command is about: the program's, those that were given, and those that only the
/// results directory has, which can be read and not played.
pub(super) fn set_up(
    (given, dir): (Option<&ControllersArgs>, Option<&Path>),
    mut traffic: Traffic,
    start: Vec<OsString>,
    host: Option<Box<dyn Host>>,
) -> anyhow::Result<()> {
    // A process sets this up once.
    let _ = START.set(start);
    if let Some(host) = host {
        let _ = HOST.set(host);
    }
    if let Some(given) = given {
        traffic = given.add_to(traffic, HOST.get().map(AsRef::as_ref))?;
    }
    // Whoever needs the manifest says what is wrong with it.
    let read = dir.and_then(|dir| Some((dir, Manifest::read(&Layout::new(dir)).ok()?)));
    if let Some((dir, manifest)) = read {
        for about in &manifest.identity.controllers {
            traffic = add_named(traffic, about);
        }
        let _ = READ.set((dir.to_path_buf(), Arc::new(manifest)));
    }
    domains::set_traffic(traffic);
    Ok(())
}

/// Returns the manifest of the results directory that the command is about, which [`set_up`] has read, if that can be.
pub(super) fn manifest_of(layout: &Layout) -> Result<Arc<Manifest>, StoreError> {
    match READ.get() {
        Some((root, manifest)) if root == layout.root() => Ok(manifest.clone()),
        _ => Manifest::read(layout).map(Arc::new),
    }
}

/// Returns where a class is just now, for the record of one that hangs.
pub(super) fn stack() -> Option<String> {
    HOST.get()?.stack()
}
