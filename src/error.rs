//! One error enum per boundary; every message says what was wrong and what to do next.

use std::path::PathBuf;

use crate::control::ControlError;
use crate::env::episode::EpisodeError;
use crate::sample::SampleError;

pub use crate::files::FileError;

/// Why a simulation could not start or continue.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// libsumo keeps its state in statics, so a second start would corrupt the first.
    #[error("a simulation is already running in this process; run it in its own worker")]
    AlreadyRunning,
    /// A step or read without a simulation.
    #[error("no simulation is running; call `start` first")]
    NotRunning,
    /// libsumo could not be loaded.
    #[error(
        "SUMO's library cannot be loaded: {0}; install SUMO (Debian: `apt-get install sumo \
         libpython3.11`) or rebuild with SUMO_HOME set, then run `tsc-family doctor`"
    )]
    Unavailable(String),
    /// A recoverable TraCI error, for example an unknown lane id.
    #[error("sumo rejected `{call}`: {message}")]
    Traci {
        /// Shim function that failed.
        call: &'static str,
        /// SUMO's own text, unedited.
        message: String,
    },
    /// SUMO ended the simulation; its reason is on standard error.
    #[error("sumo failed in `{call}`: {message}")]
    Fatal {
        /// Shim function that failed.
        call: &'static str,
        /// SUMO's own text, unedited.
        message: String,
    },
    /// A SUMO configuration that cannot be used.
    #[error("{}: {reason}", .path.display())]
    Config {
        /// The configuration.
        path: PathBuf,
        /// What is wrong and the way out.
        reason: String,
    },
    /// No such SUMO configuration.
    #[error("{} does not exist; give the path of a .sumocfg file", .0.display())]
    NoConfig(PathBuf),
    /// A scenario without anything to control.
    #[error("{} has no traffic signal; give a scenario with at least one tlLogic", .0.display())]
    NoSignals(PathBuf),
    /// A signal that no controller here can handle.
    #[error("signal {signal}: {reason}")]
    Signal {
        /// SUMO's id of the signal.
        signal: String,
        /// What is wrong and the way out.
        reason: String,
    },
    /// A file of the scenario is missing on disk.
    #[error("{} does not exist; run `tsc-family build-networks` first", .0.display())]
    Missing(PathBuf),
    /// SUMO's tripinfo output cannot be understood.
    #[error("{}: {reason}", .path.display())]
    Tripinfo {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// An episode whose delay is undefined.
    #[error(
        "no vehicle is to depart in the episode of seed {0}, so that it has no delay; let more \
         vehicles arrive, or see that those of an imported scenario depart between begin and end"
    )]
    NoVehicles(u64),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// A request that makes no sense, with the reason and the way out.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);

/// Why a scenario or a family is unusable.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FamilyError {
    /// Neither a file nor an embedded scenario.
    #[error("no scenario {name:?}: neither a file nor an embedded scenario ({embedded}){meant}")]
    UnknownScenario {
        /// What was asked for.
        name: String,
        /// The embedded names.
        embedded: String,
        /// What may have been meant.
        meant: String,
    },
    /// The TOML does not parse or has unknown or missing fields.
    #[error("{file}: {message}")]
    Toml {
        /// The scenario file, with the line where it is known.
        file: String,
        /// What is wrong, with the setting.
        message: String,
    },
    /// A setting from the command line does not exist or has a value of a wrong type.
    #[error("{flag}: {message}")]
    Override {
        /// What the user wrote.
        flag: String,
        /// What is wrong and what is expected.
        message: String,
    },
    /// A setting is out of range.
    #[error("{file}: {field} = {value}: {expected}")]
    Setting {
        /// The scenario file.
        file: String,
        /// Dotted name of the field.
        field: String,
        /// What it is.
        value: String,
        /// What it should be.
        expected: String,
    },
    /// A CSV row or header is wrong.
    #[error("{file}, line {line}: {message}")]
    Csv {
        /// The table.
        file: String,
        /// One-based line.
        line: u64,
        /// What is wrong and what is expected.
        message: String,
    },
    /// The family is not a probability distribution.
    #[error(
        "{file}: importance sums to {sum}, not to 1; divide each value by the sum, or give counts \
         in a column `intersections` instead"
    )]
    NotADistribution {
        /// The table.
        file: String,
        /// The sum found.
        sum: f64,
    },
    /// A family without point MDPs.
    #[error("{file}: no point MDP; the table needs at least one row below its header")]
    Empty {
        /// The table.
        file: String,
    },
    /// A file could not be read.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Why a network could not be built, checked or found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// No netconvert to build with.
    #[error(
        "netconvert was not found ({tried}); install SUMO (Debian: `apt-get install sumo`) or set \
         SUMO_HOME to the folder above its `bin`"
    )]
    NoNetconvert {
        /// Places looked at.
        tried: String,
    },
    /// netconvert rejected what it was given.
    #[error("{point}: netconvert failed: {message}")]
    Netconvert {
        /// The point MDP.
        point: String,
        /// The last lines of its standard error.
        message: String,
    },
    /// An intersection that cannot exist.
    #[error("{point}: {reason}")]
    Intersection {
        /// The point MDP.
        point: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A built network that fails its checks.
    #[error("{point}: the network is unsound: {reason}")]
    Unsound {
        /// The point MDP.
        point: String,
        /// The failed check.
        reason: String,
    },
    /// A network file that differs from the index.
    #[error(
        "{}: {what} since INDEX.csv was written; repeat the `build-networks` command with --force to build \
         it again",
        .path.display()
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// `was deleted` or `was altered`.
        what: &'static str,
    },
    /// The index itself is wrong.
    #[error("{}: {reason}; repeat the `build-networks` command with --force", .path.display())]
    Index {
        /// The index.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A network file that is not the XML that was expected.
    #[error("{}: {reason}", .path.display())]
    Xml {
        /// The file.
        path: PathBuf,
        /// The parser's message.
        reason: String,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Why a results directory cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// No manifest.
    #[error(
        "{} is not a results directory (it has no manifest.json); give the folder that \
         `tsc-family run --out` wrote",
        .0.display()
    )]
    NotResults(PathBuf),
    /// Written by a version with other files.
    #[error(
        "{}: schema version {found}, but this tsc-family reads {expected}; use the version that \
         wrote it or give another --out",
        .path.display()
    )]
    Version {
        /// The manifest.
        path: PathBuf,
        /// Version found.
        found: String,
        /// Version understood.
        expected: u32,
    },
    /// A file that does not parse.
    #[error("{}: {reason}", .path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The parser's message.
        reason: String,
    },
    /// A record whose content does not match its own checksum or task.
    #[error(
        "{}: {reason}; delete the file and run again, only this task is repeated",
        .path.display()
    )]
    Record {
        /// The record.
        path: PathBuf,
        /// What does not match.
        reason: String,
    },
    /// The directory belongs to another run.
    #[error(
        "{} holds another run: {difference}; give another --out, or repeat the first command ({command}) \
         to continue it",
        .path.display()
    )]
    Mismatch {
        /// The directory.
        path: PathBuf,
        /// What differs, with both values.
        difference: String,
        /// The command that began the run.
        command: String,
    },
    /// Another process works on the directory.
    #[error(
        "{} is in use by another run ({holder}); wait for it, stop it, or give another --out",
        .path.display()
    )]
    Locked {
        /// The directory.
        path: PathBuf,
        /// What the lock file says.
        holder: String,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Why a run cannot be planned or a task not be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// The scenario or family is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A network cannot be built or used.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A method is unknown or failed.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The point MDPs cannot be chosen.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// The results directory cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Two imported scenarios of one name.
    #[error("two --sumocfg files are named {0:?}; rename one, the name is the point MDP's id")]
    DoubledPoint(String),
    /// A task that the plan does not have.
    #[error("{} has no task {task}; its plan has {count}", .path.display())]
    NoTask {
        /// The results directory.
        path: PathBuf,
        /// What was asked for.
        task: usize,
        /// Tasks in the plan.
        count: usize,
    },
    /// A file that is no model, or a model that cannot be used.
    #[error("{}: {reason}", .path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// What is wrong and the way out.
        reason: String,
    },
    /// A point MDP that the scenario does not have.
    #[error("scenario {scenario} has no point MDP {point:?}; it has {some}")]
    NoPoint {
        /// Name of the scenario.
        scenario: String,
        /// What was asked for.
        point: String,
        /// Some that exist, and where to see them all.
        some: String,
    },
    /// A worker found something that would make every other task fail as well.
    #[error("{reason}; nothing is lost, run the same command again once this is mended")]
    Stopped {
        /// What the worker said.
        reason: String,
        /// Whether SUMO is missing.
        no_sumo: bool,
    },
    /// A file that differs from the manifest.
    #[error(
        "{}: the file {what} since the run was planned; restore it, or start a new run with \
         another --out",
        .path.display()
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// `was deleted` or `was altered`.
        what: &'static str,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl From<EpisodeError> for EvalError {
    fn from(error: EpisodeError) -> Self {
        match error {
            EpisodeError::Sim(e) => Self::Sim(e),
            EpisodeError::Control(e) => Self::Control(e),
        }
    }
}
