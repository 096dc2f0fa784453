//! Methods of somebody's own: compiled in, a command that is asked over pipes, or a class in Python. What one consists of
//! is hashed, so that a run has the method that was planned.

pub mod exec;
pub mod protocol;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::control::senses::Senses;
use super::control::{Controller, Setup};
use basics::files::FileError;
use basics::hash::sha256_file;
use evaluation::run::method::Training;
use evaluation::store::own::{OwnKind, OwnMethod};

/// Makes a controller.
pub type Create = Box<dyn Fn(&Setup) -> Box<dyn Controller> + Send + Sync>;

/// Makes the senses of a learner.
pub type MakeSenses = Box<dyn Fn(&Setup) -> Box<dyn Senses> + Send + Sync>;

/// How a method of somebody's own is played.
pub enum Play {
    /// By a controller.
    Controller(Create),
    /// By a learner of this library that sees or is paid for something else.
    Learner {
        /// The learner's name.
        learner: String,
        /// Makes what it sees and is paid for.
        senses: MakeSenses,
    },
    /// As the plan of each point MDP that the manifest keeps under its name.
    Plan,
    /// As what a method has learned elsewhere.
    Model {
        /// The file of the model.
        file: PathBuf,
        /// The method that has learned it.
        learner: String,
    },
    /// It is known by name, as records have it, but nobody said where it is.
    Absent,
}

/// A method of somebody's own.
pub struct Own {
    /// What it is; hashes are those of [`Self::files`].
    pub about: OwnMethod,
    /// What it consists of, by name.
    pub files: BTreeMap<String, PathBuf>,
    /// How it is played.
    pub play: Play,
}

impl Own {
    /// Returns a method that is compiled into this program.
    pub fn compiled(name: &str, summary: &str, learns: bool, create: Create) -> Self {
        let program = std::env::current_exe().ok();
        let about = OwnMethod {
            summary: summary.to_owned(),
            learns,
            ..OwnMethod::new(name, OwnKind::Program, "the program".to_owned())
        };
        let files = program.map(|path| ("program".to_owned(), path)).into_iter().collect();
        Self { about, files, play: Play::Controller(create) }
    }

    /// Returns what it is, with the hashes that its files have now; `None` where nobody said where it is.
    /// Fails with [`FileError`] when a file cannot be read.
    pub fn described(&self) -> Result<Option<OwnMethod>, FileError> {
        if matches!(self.play, Play::Absent) {
            return Ok(None);
        }
        // The manifest keeps the plans, so whoever reads them needs no file.
        if self.files.is_empty() {
            return Ok(Some(self.about.clone()));
        }
        let hash = |(name, path): (&String, &PathBuf)| Ok((name.clone(), sha256_file(path)?));
        let sha256 = self.files.iter().map(hash).collect::<Result<_, FileError>>()?;
        Ok(Some(OwnMethod { sha256, ..self.about.clone() }))
    }

    /// Returns the files that a task reads. The program itself is none of them: what runs stays what it was when it was
    /// started.
    pub fn read(&self) -> impl Iterator<Item = &Path> {
        let is_read = self.about.kind != OwnKind::Program;
        self.files.values().filter(move |_| is_read).map(PathBuf::as_path)
    }
}

/// Opens controllers that are written in another language, within this process.
pub trait Host: Send + Sync {
    /// Opens a controller.
    /// * `source` — what stands after `NAME=`, such as `mine.py:Mine`.
    ///
    /// The error is why it cannot be used, in words, with the traceback where there is one.
    fn open(&self, source: &str) -> Result<Hosted, String>;

    /// Returns where the controller is just now, for the record of one that hangs; `None` where nobody can say.
    fn stack(&self) -> Option<String>;
}

/// A controller that a [`Host`] has opened.
pub struct Hosted {
    /// A sentence for people; empty where nobody wrote one.
    pub summary: String,
    /// What it does before it is evaluated.
    pub training: Training,
    /// What it consists of, by name.
    pub files: BTreeMap<String, PathBuf>,
    /// Versions of what runs it.
    pub versions: BTreeMap<String, String>,
    /// How it is played: by a controller or by a learner.
    pub play: Play,
}
