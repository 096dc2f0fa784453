//! Executes the blocks of every page, each page in a folder of its own. The pages of published results are executed before
//! a release: their commands repeat analyses of records that do not change.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::thread;

use crate::blocks::{Block, Kind};
use crate::nightly::is_nightly;
use crate::snippets::{REPO, all_blocks};

struct Folder {
    folder: tempfile::TempDir,
    path: std::ffi::OsString,
}

impl Folder {
    /// Puts the program on the path, and plain `sumo` in place of its window.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bin = folder.path().join(".bin");
        fs::create_dir(&bin).unwrap();
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_tsc-family"), bin.join("tsc-family"))
            .unwrap();
        let window = bin.join("sumo-gui");
        fs::write(&window, "#!/bin/sh\nexec sumo --no-step-log --end 10 \"$@\"\n").unwrap();
        fs::set_permissions(&window, fs::Permissions::from_mode(0o755)).unwrap();
        let home = std::env::var_os("SUMO_HOME").map(|home| PathBuf::from(home).join("bin"));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let rest = std::env::split_paths(&path);
        let path = std::env::join_paths([bin].into_iter().chain(home).chain(rest)).unwrap();
        Self { folder, path }
    }

    fn shell(&self, script: &str) -> Output {
        let mut command = Command::new("bash");
        command.args(["-euo", "pipefail", "-c", script]).current_dir(self.folder.path());
        command.env("PATH", &self.path).env("REPO", REPO).env("NO_COLOR", "1");
        command.output().unwrap()
    }

    fn must(&self, place: &str, script: &str) {
        let output = self.shell(script);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{place}: {script}\n{}\n{text}", output.status);
    }
}

fn play(blocks: &[Block]) {
    let folder = Folder::new();
    let mut files = Vec::new();
    let mut commands = String::new();
    for block in blocks {
        for command in &block.before {
            folder.must(&block.place, command);
        }
        match &block.kind {
            Kind::File(name) => {
                fs::write(folder.folder.path().join(name), &block.text).unwrap();
                files.push((block, name));
            }
            Kind::Run => {
                let mut script = block.commands();
                for (old, new) in &block.instead {
                    let before = script.clone();
                    script.iter_mut().for_each(|c| *c = c.replace(old, new));
                    assert_ne!(script, before, "{}: `{old}` is not there", block.place);
                }
                for command in script {
                    match command.strip_prefix("make ") {
                        // What it does is what runs these tests.
                        Some(target) => {
                            folder.must(&block.place, &format!("make -C $REPO --dry-run {target}"));
                        }
                        None => folder.must(&block.place, &command),
                    }
                    commands += &command;
                    commands.push('\n');
                }
            }
            Kind::Parse | Kind::Text => {}
        }
    }
    for (block, name) in &files {
        if name.ends_with(".toml") {
            folder.must(&block.place, &format!("tsc-family list {name}"));
        } else {
            let named =
                |other: &Block| matches!(other.kind, Kind::File(_)) && other.text.contains(*name);
            let used = commands.contains(*name) || blocks.iter().any(named);
            assert!(used, "{}: nothing on the page uses {name}", block.place);
        }
    }
}

#[test]
fn every_block_that_can_be_executed_works() {
    let mut pages = all_blocks();
    pages.retain(|(page, _)| is_nightly() || !page.path.starts_with("results"));
    let runs = |blocks: &[Block]| blocks.iter().filter(|b| b.kind == Kind::Run).count();
    let total: usize = pages.iter().map(|(_, blocks)| runs(blocks)).sum();
    assert!(total >= 10, "only {total} blocks are executed");
    thread::scope(|scope| {
        for (_, blocks) in &pages {
            scope.spawn(|| play(blocks));
        }
    });
}
