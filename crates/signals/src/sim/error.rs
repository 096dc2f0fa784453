//! Why a simulation could not start or continue.

use std::path::PathBuf;

use basics::files::FileError;

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
    /// libsumo is not where whoever started this program looked for it; what to do depends on that.
    #[error("SUMO cannot be used: {0}")]
    Absent(String),
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
    /// All that is in the way of a SUMO scenario, with the options that pass it.
    #[error("{0}")]
    Obstacles(String),
    /// No such SUMO configuration.
    #[error("{} does not exist; give the path of a .sumocfg file", .0.display())]
    NoConfig(PathBuf),
    /// A signal that no controller here can handle.
    #[error("signal {signal}: {reason}")]
    Signal {
        /// SUMO's id of the signal.
        signal: String,
        /// What is wrong and the way out.
        reason: String,
    },
    /// SUMO's tripinfo output cannot be understood.
    #[error("{}: {reason}", .path.display())]
    Tripinfo {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file of SUMO's that has no end. SUMO says nothing when it cannot write, and goes on.
    #[error("{}: SUMO could not write all of it; is the disk full?", .0.display())]
    CutOff(PathBuf),
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
