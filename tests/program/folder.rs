//! A folder in which the program runs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

use serde_json::Value;

use crate::common::{program, stderr, stdout, succeed};

pub(crate) type Row = BTreeMap<String, String>;

pub(crate) fn repository(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

pub(crate) fn rows(table: &Path) -> Vec<Row> {
    csv::Reader::from_path(table).unwrap().deserialize().map(Result::unwrap).collect()
}

pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self::new();
        files.iter().for_each(|(name, text)| folder.write(name, text));
        folder
    }

    /// A copy of the folder that a command leaves, which runs once for all tests that begin with it.
    pub(crate) fn after(args: &'static str) -> Self {
        static MADE: Mutex<BTreeMap<&str, PathBuf>> = Mutex::new(BTreeMap::new());
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("after-{}", made.len()));
        let kept = made.entry(args).or_insert_with(|| {
            let _ = fs::remove_dir_all(&kept);
            fs::create_dir_all(&kept).unwrap();
            succeed(&kept, args);
            kept
        });
        let folder = Self::new();
        let mut copy = Command::new("cp");
        let copied = copy.args(["-a", "."]).arg(folder.path()).current_dir(kept).status().unwrap();
        assert!(copied.success());
        folder
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn join(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.join(name).exists()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::create_dir_all(self.join(name).parent().unwrap()).unwrap();
        fs::write(self.join(name), text).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    #[track_caller]
    pub(crate) fn edit(&self, name: &str, from: &str, to: &str) {
        let text = self.read(name);
        assert!(text.contains(from), "{name} has no {from}: {text}");
        self.write(name, &text.replace(from, to));
    }

    #[track_caller]
    pub(crate) fn shows(&self, name: &str, words: &[&str]) {
        let text = self.read(name);
        for words in words {
            assert!(text.contains(words), "{name} lacks {words}: {text}");
        }
    }

    pub(crate) fn output(&self, args: &str) -> Output {
        program(self.path()).args(shlex::split(args).unwrap()).output().unwrap()
    }

    #[track_caller]
    pub(crate) fn run(&self, args: &str) -> String {
        let output = self.output(args);
        assert!(output.status.success(), "{args}: {}", stderr(&output));
        stdout(&output)
    }

    /// Runs the program, which must end with this code, and returns what it says on standard error.
    #[track_caller]
    pub(crate) fn says(&self, code: i32, args: &str) -> String {
        let output = self.output(args);
        assert_eq!(output.status.code(), Some(code), "{args}: {}", stderr(&output));
        stderr(&output)
    }

    #[track_caller]
    pub(crate) fn refuses(&self, commands: &[(&str, &str)]) {
        let before = self.names("");
        for (args, expected) in commands {
            let output = self.output(args);
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{args}: {said}");
            assert!(said.contains(expected), "{args}: no {expected:?} in {said}");
            assert!(stdout(&output).is_empty(), "{args}");
            assert_eq!(self.names(""), before, "{args}: nothing is written");
        }
    }

    pub(crate) fn names(&self, folder: &str) -> Vec<String> {
        let names = fs::read_dir(self.join(folder)).unwrap().map(|e| e.unwrap().file_name());
        let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub(crate) fn rows(&self, table: &str) -> Vec<Row> {
        rows(&self.join(table))
    }

    /// The lines of a task's record, without wall-clock values.
    pub(crate) fn record(&self, results: &str, task: usize) -> Vec<Value> {
        crate::outcomes::record(&self.join(results), task)
    }

    /// The records of a run by the names of their files, without wall-clock values.
    pub(crate) fn records(&self, results: &str) -> BTreeMap<String, Vec<Value>> {
        crate::outcomes::records(&self.join(results))
    }
}
