//! From what the command line says to a method: `NAME=exec:COMMAND`, `NAME=FILE.py:CLASS`, `NAME=SCORES.csv`, and plans of
//! signals.

use std::collections::BTreeMap;
use std::env;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::cli::exit::{Refused, refuse};
use crate::traffic::control::registry::METHODS;
use crate::traffic::control::{Controller, Setup};
use crate::traffic::domain::Traffic;
use crate::traffic::model::SignalModel;
use crate::traffic::own::exec::Exec;
use crate::traffic::own::{Host, Own, Play};
use basics::files::FileError;
use evaluation::run::domain::Domain;
use evaluation::run::method::{Method, Training};
use evaluation::run::model::{ModelCard, SavedModel, TRAINED_ON};
use evaluation::store::own::{OwnKind, OwnMethod};

/// What a command begins with.
const EXEC: &str = "exec:";

/// How a plan is given.
const PLAN_FORM: &str = "write NAME=FILE, with a table of phases or UTDF";

/// How a model is given.
const MODEL_FORM: &str = "write NAME=FILE, with a file of the folder models of a results directory";

/// Names that mean something else: all methods, and in tables that no method is better or that this is open.
const RESERVED: [&str; 4] = ["all", "none", "open", "tie"];

const MOST_NAME: usize = 40;

/// Adds a controller to those of signals.
///
/// # Arguments
///
/// * `given` — `NAME=exec:COMMAND` or `NAME=FILE.py:CLASS`.
/// * `host` — opens classes, where there is one.
/// * `answer` — time that a command has for an answer.
pub(crate) fn add(
    traffic: Traffic,
    given: &str,
    host: Option<&dyn Host>,
    answer: Duration,
) -> anyhow::Result<Traffic> {
    let wrong = |reason: String| Refused(format!("{given:?}: {reason}"));
    let form = "write NAME=exec:COMMAND or NAME=FILE.py:CLASS";
    let (name, source) = named(given, form)?;
    check_name(&traffic, &name).map_err(wrong)?;
    if let Some(line) = source.strip_prefix(EXEC) {
        let words = shlex::split(line).filter(|words| !words.is_empty());
        let words = words.ok_or_else(|| wrong("no command can be read there".to_owned()))?;
        let (words, files) = command(&words).map_err(wrong)?;
        let label: Vec<String> = words.iter().map(|word| label(word)).collect();
        let leaked: &'static str = name.clone().leak();
        let create = move |setup: &Setup| {
            Box::new(Exec::new(leaked, words.clone(), setup.clone(), answer)) as Box<dyn Controller>
        };
        let about = OwnMethod::new(&name, OwnKind::Exec, format!("{EXEC}{}", label.join(" ")));
        let method = Method::new(leaked, "a command of your own", Training::None);
        let play = Play::Controller(Box::new(create));
        return Ok(traffic.with_own(method, Own { about, files, play }));
    }
    if !source.contains(':') {
        return Err(wrong(form.to_owned()).into());
    }
    let Some(host) = host else {
        return Err(wrong(
            "this program has no Python; classes are for the tsc-family of the Python package (pip install, \
             docs/own-controller.md), commands for every one (NAME=exec:COMMAND)"
                .to_owned(),
        )
        .into());
    };
    let hosted = host.open(source);
    let mut hosted = hosted.map_err(|reason| Refused(format!("controller {name}: {reason}")))?;
    hosted.summary = hosted.summary.replace(char::is_control, " ");
    // Where it lies is no part of what it is.
    let (file, class) = source.split_once(".py:").unwrap_or((source, ""));
    let file = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
    let built_on = match &hosted.play {
        Play::Learner { learner, .. } => Some(built_in_learner(learner).map_err(wrong)?),
        _ => None,
    };
    let about = OwnMethod {
        summary: hosted.summary.clone(),
        versions: hosted.versions,
        learner: built_on.map(|m| m.name.to_owned()),
        learns: hosted.training == Training::Learned,
        ..OwnMethod::new(&name, OwnKind::Python, format!("{file}.py:{class}"))
    };
    let summary = match hosted.summary.as_str() {
        "" => "a class of your own",
        summary => summary.to_owned().leak(),
    };
    let method = Method {
        decision_s: built_on.map_or(0.0, |m| m.decision_s),
        ..Method::new(name.clone().leak(), summary, hosted.training)
    };
    Ok(traffic.with_own(method, Own { about, files: hosted.files, play: hosted.play }))
}

/// Returns a learner of this library, or why there is none of that name.
fn built_in_learner(name: &str) -> Result<&'static Method, String> {
    let learners = || METHODS.iter().filter(|m| m.training == Training::Learned);
    learners().find(|m| m.name == name).ok_or_else(|| {
        let known: Vec<&str> = learners().map(|m| m.name).collect();
        format!("{name:?} is no learner of this library; method can be {}", known.join(", "))
    })
}

/// Adds a plan of signals as a method.
///
/// # Arguments
///
/// * `given` — `NAME=FILE`.
pub(crate) fn add_plan(traffic: Traffic, given: &str) -> anyhow::Result<Traffic> {
    let (name, source) = named(given, PLAN_FORM)?;
    let wrong = |reason: String| Refused(format!("{given:?}: {reason}"));
    check_name(&traffic, &name).map_err(wrong)?;
    let path = std::path::absolute(source).map_err(FileError::at("find", source.as_ref()))?;
    let file = label(source);
    let about = OwnMethod::new(&name, OwnKind::Plan, file.clone());
    let method = Method::new(name.leak(), OwnKind::Plan.in_words(), Training::None);
    let own = Own { about, files: BTreeMap::from([(file, path)]), play: Play::Plan };
    Ok(traffic.with_own(method, own))
}

/// Adds a saved model as a method that does not learn.
///
/// # Arguments
///
/// * `given` — `NAME=FILE`.
pub(crate) fn add_model(traffic: Traffic, given: &str) -> anyhow::Result<Traffic> {
    let (name, source) = named(given, MODEL_FORM)?;
    let wrong = |reason: String| Refused(format!("{given:?}: {reason}"));
    check_name(&traffic, &name).map_err(wrong)?;
    let model = SignalModel::new(SavedModel::read(Path::new(source))?, traffic.methods())?;
    let path = std::path::absolute(source).map_err(FileError::at("find", source.as_ref()))?;
    let several = model.saved.domain.get(TRAINED_ON).cloned().map(serde_json::from_value);
    let trained_on = several.transpose().map_err(|e| wrong(format!("{TRAINED_ON}: {e}")))?;
    let ModelCard { method: learner, point, replicate, .. } = model.saved.card;
    let file = label(source);
    let mut files = BTreeMap::from([(file.clone(), path.clone())]);
    // A class of somebody's own decides with it.
    files.extend(traffic.files_of(&learner));
    let of = if replicate == 0 { String::new() } else { format!(", training {}", replicate + 1) };
    let about = OwnMethod {
        summary: format!("{learner} trained on {point}{of}"),
        trained_on: trained_on.unwrap_or_default(),
        ..OwnMethod::new(&name, OwnKind::Model, file)
    };
    let method = Method::new(name.leak(), OwnKind::Model.in_words(), Training::None);
    Ok(traffic.with_own(method, Own { about, files, play: Play::Model { file: path, learner } }))
}

/// Returns the learner of a model as the command line gives it.
pub(crate) fn learner_of(given: &str) -> anyhow::Result<String> {
    let (_, source) = named(given, MODEL_FORM)?;
    Ok(SavedModel::read(Path::new(source))?.card.method)
}

/// Returns what a model is called where nobody says: its method and the point MDP of its training.
///
/// # Arguments
///
/// * `taken` — names that others have.
pub(crate) fn model_name(method: &str, point: &str, replicate: u32, taken: &[String]) -> String {
    let allowed = |c: char| if is_plain_character(c) { c } else { '-' };
    let point: String = point.to_ascii_lowercase().chars().map(allowed).collect();
    let training = if replicate == 0 { String::new() } else { format!("-{}", replicate + 1) };
    let name = format!("{method}-of-{point}{training}");
    let is_free = |name: &String| name.len() <= MOST_NAME && !taken.contains(name);
    if is_free(&name) {
        return name;
    }
    let mut numbered = (1..).map(|number| format!("{method}-of-{number}"));
    numbered.find(is_free).unwrap_or(name)
}

/// Returns name and file of plans as the command line gives them.
pub(crate) fn plan_file(given: &str) -> anyhow::Result<(String, &Path)> {
    named(given, PLAN_FORM).map(|(name, file)| (name, Path::new(file)))
}

/// Adds a method that records have and that nobody gave, so that they can be read; of these only plans can be played,
/// which the manifest keeps.
pub(crate) fn add_named(traffic: Traffic, about: &OwnMethod) -> Traffic {
    if check_name(&traffic, &about.name).is_err() {
        return traffic;
    }
    let training = if about.learns { Training::Learned } else { Training::None };
    let summary: &'static str = about.kind.in_words();
    let method = Method::new(about.name.clone().leak(), summary, training);
    let play = if about.kind == OwnKind::Plan { Play::Plan } else { Play::Absent };
    let own = Own { about: about.clone(), files: BTreeMap::new(), play };
    traffic.with_own(method, own)
}

/// Returns name and source of `NAME=SOURCE`.
fn named<'a>(given: &'a str, form: &str) -> anyhow::Result<(String, &'a str)> {
    let given_plainly = given.escape_debug().to_string();
    let wrong = |reason| refuse(format!("{given_plainly:?}: {reason}"));
    match given.split_once('=') {
        // A manifest says it in a line.
        Some((_, source)) if source.chars().any(char::is_control) => wrong(
            "it has a line break or another control character; put such a command into a script",
        ),
        Some((name, source)) if !source.is_empty() => Ok((name.to_owned(), source)),
        _ => wrong(form),
    }
}

/// Whether a name of a method may have a character.
fn is_plain_character(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'
}

/// Whether a text is made as names of methods are.
fn is_plain(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_plain_character)
}

/// Checks that a method can be called so.
fn check_name(traffic: &Traffic, name: &str) -> Result<(), String> {
    if !is_plain(name) || name.len() > MOST_NAME {
        return Err(format!(
            "a name is made of a to z, 0 to 9 and -, begins with a letter and has at most {MOST_NAME} of them"
        ));
    }
    if RESERVED.contains(&name) {
        return Err(format!(
            "{name} means something else in tables and options; take another name"
        ));
    }
    match traffic.methods().iter().any(|m| m.name == name) {
        true => Err(format!("there is a method {name} already; take another name")),
        false => Ok(()),
    }
}

/// Returns a word of a command as manifests have it: of a file its name alone.
fn label(word: &str) -> String {
    let path = Path::new(word);
    let name = path.file_name().filter(|_| path.is_file());
    name.map_or_else(|| word.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Returns a command whose program is named by an absolute path, and the files that it names: the program, and every
/// argument that is one.
fn command(words: &[String]) -> Result<(Vec<String>, BTreeMap<String, PathBuf>), String> {
    let (first, rest) = words.split_first().expect("it has a word");
    let program = program(first)?;
    let mut files = BTreeMap::from([(label(first), program.clone())]);
    for word in rest {
        let path = Path::new(word);
        if path.is_file() {
            let path = std::path::absolute(path).map_err(|e| format!("{word}: {e}"))?;
            let name = label(word);
            let name = if files.contains_key(&name) { format!("{name} ({word})") } else { name };
            files.insert(name, path);
        }
    }
    let program = program.to_str().ok_or("the way to the program is no text in UTF-8")?.to_owned();
    Ok((std::iter::once(program).chain(rest.iter().cloned()).collect(), files))
}

/// Returns the program that a word names, in this folder or on the path.
fn program(word: &str) -> Result<PathBuf, String> {
    let runs = |path: &Path| {
        path.metadata().is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
    };
    if word.contains('/') {
        let path = std::path::absolute(word).map_err(|e| format!("{word}: {e}"))?;
        return match (runs(&path), path.exists()) {
            (true, _) => Ok(path),
            (false, true) => Err(format!("{word} cannot be executed (chmod +x)")),
            (false, false) => Err(format!("there is no {word}")),
        };
    }
    let path = env::var_os("PATH").unwrap_or_default();
    let found = env::split_paths(&path).map(|folder| folder.join(word)).find(|path| runs(path));
    found.ok_or_else(|| {
        format!("there is no program {word} on the path; one in this folder is ./{word}")
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn added(given: &str) -> Result<Traffic, String> {
        add(Traffic::default(), given, None, Duration::from_secs(1)).map_err(|e| e.to_string())
    }

    #[test]
    fn what_is_wrong_with_a_controller_is_said() {
        for (given, expected) in [
            ("mine", "\"mine\": write NAME=exec:COMMAND or NAME=FILE.py:CLASS"),
            ("mine=cmd", "write NAME=exec:COMMAND"),
            ("idqn=exec:true", "there is a method idqn already"),
            ("Mine!=exec:true", "a name is made of a to z"),
            ("mine=exec:", "no command can be read there"),
            ("mine=exec:'x", "no command can be read there"),
            ("mine=exec:no-such-program", "no program no-such-program on the path"),
            ("mine=exec:./nowhere", "there is no ./nowhere"),
            ("mine=exec:/etc/passwd", "cannot be executed"),
            ("mine=a.py:A", "this program has no Python"),
        ] {
            let e = added(given).err().unwrap_or_else(|| panic!("{given} is taken"));
            assert!(e.contains(expected), "{given}: {e}");
        }
    }

    #[test]
    fn a_command_consists_of_its_program_and_the_files_that_it_names() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("weights.txt");
        fs::write(&file, "1").unwrap();
        let traffic = added(&format!("mine=exec:cat {} --fast", file.display())).unwrap();
        let own = traffic.own("mine").unwrap().unwrap();
        assert_eq!(own.source, "exec:cat weights.txt --fast");
        let names: Vec<&String> = own.sha256.keys().collect();
        assert_eq!(names, ["cat", "weights.txt"]);
        fs::write(&file, "2").unwrap();
        let now = traffic.own("mine").unwrap().unwrap();
        assert_eq!(own.difference(&now).unwrap(), "controller mine: weights.txt has changed");
    }

    #[test]
    fn a_method_that_only_records_have_can_be_read_and_not_played() {
        let own = added("mine=exec:true").unwrap().own("mine").unwrap().unwrap();
        let traffic = add_named(Traffic::default(), &own);
        assert!(traffic.methods().iter().any(|m| m.name == "mine"));
        assert_eq!(traffic.own("mine").unwrap(), None);
    }
}
