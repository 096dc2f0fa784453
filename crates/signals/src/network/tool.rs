//! Finds netconvert, runs it as a process, and tells what it says of an intersection from what happened to it.

use std::env;
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use super::error::NetworkError;
use basics::files::FileError;
use basics::machine;

/// Longest time in which a program says its version; that takes a hundredth of a second.
const VERSION_LIMIT: Duration = Duration::from_secs(20);

/// Finds netconvert in `SUMO_HOME/bin`, then on `PATH`, and returns its path and version, such as `1.15.0`.
/// The error is the places looked at.
pub(super) fn find() -> Result<(PathBuf, String), String> {
    find_in(env::var_os("SUMO_HOME").map(PathBuf::from), env::var_os("PATH"))
}

fn find_in(
    sumo_home: Option<PathBuf>,
    path: Option<OsString>,
) -> Result<(PathBuf, String), String> {
    let file = format!("netconvert{}", env::consts::EXE_SUFFIX);
    let home = sumo_home.filter(|home| !home.as_os_str().is_empty());
    let mut tried = match &home {
        Some(home) => home.join("bin").join(&file).display().to_string(),
        None => "SUMO_HOME is not set".to_owned(),
    };
    tried.push_str(", PATH");
    let in_home = home.map(|home| home.join("bin"));
    let on_path = path.iter().flat_map(env::split_paths);
    for candidate in in_home.into_iter().chain(on_path).map(|folder| folder.join(&file)) {
        if candidate.is_file() {
            match version(&candidate) {
                Ok(version) => return Ok((candidate, version)),
                Err(reason) => tried = format!("{tried}; {}: {reason}", candidate.display()),
            }
        }
    }
    Err(tried)
}

/// Returns the version that a program prints.
fn version(path: &Path) -> Result<String, String> {
    let mut command = Command::new(path);
    command.arg("--version");
    let output = output_of(command, VERSION_LIMIT).map_err(|e| e.to_string())?;
    let (_, text, said) = output.ok_or("does not end")?;
    let line = text.lines().find(|line| line.starts_with("Eclipse SUMO netconvert"));
    line.and_then(|line| line.split_whitespace().last())
        .map(|version| version.trim_start_matches(['v', 'V']).replace('_', "."))
        .ok_or_else(|| format!("does not run: {}", last_lines(&said)))
}

/// Lines of its standard error that an error quotes.
const QUOTED_LINES: usize = 3;

/// Attempts to start it where a limit on processes refuses it, and the time between two.
const ATTEMPTS: u32 = 50;
const AGAIN: Duration = Duration::from_millis(100);

/// How often it is looked after.
const NAP: Duration = Duration::from_millis(2);

/// Runs netconvert for a point MDP to its end, at most so long.
/// Fails with [`NetworkError::Netconvert`] for an error of its own, with [`NetworkError::Disturbed`] for one from outside.
pub(super) fn finish(command: Command, limit: Duration, point: &str) -> Result<(), NetworkError> {
    let program = PathBuf::from(command.get_program());
    let point = point.to_owned();
    let ended = output_of(command, limit).map_err(FileError::at("run", &program))?;
    let Some((status, _, said)) = ended else {
        let reason = format!("netconvert did not end within {} s", limit.as_secs_f64());
        return Err(NetworkError::Disturbed { point, reason });
    };
    let message = last_lines(&said);
    Err(match (status.success(), status.signal()) {
        (true, _) => return Ok(()),
        (false, Some(signal)) if machine::is_from_outside(signal) => {
            let reason = format!("netconvert was killed by signal {signal}");
            NetworkError::Disturbed { point, reason }
        }
        (false, _) if machine::is_at_fault(&said) => {
            NetworkError::Disturbed { point, reason: message }
        }
        (false, Some(signal)) => {
            let message = format!(
                "it crashed by signal {signal} ({message}); run the same command again, and where it crashes again, take \
                 another version of SUMO"
            );
            NetworkError::Netconvert { point, message }
        }
        (false, _) => NetworkError::Netconvert { point, message },
    })
}

/// Returns how a command ended and what it wrote to standard output and standard error; `None` where it did not end in time.
/// Time is counted in naps, so that it does not count when this process was stopped itself.
/// Fails when it cannot be started.
fn output_of(
    mut command: Command,
    limit: Duration,
) -> io::Result<Option<(ExitStatus, String, String)>> {
    let [mut text, mut said] = [tempfile::tempfile()?, tempfile::tempfile()?];
    command.stdin(Stdio::null()).stdout(text.try_clone()?).stderr(said.try_clone()?);
    let mut child = patiently(|| command.spawn())?;
    let mut waited = Duration::ZERO;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if waited >= limit {
            let _ = child.kill();
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(NAP);
        waited += NAP;
    };
    let read = |file: &mut File| {
        let mut bytes = Vec::new();
        file.rewind()?;
        file.read_to_end(&mut bytes)?;
        Ok::<_, io::Error>(String::from_utf8_lossy(&bytes).into_owned())
    };
    Ok(Some((status, read(&mut text)?, read(&mut said)?)))
}

/// Starts something, again for a while where a limit on processes refuses it: others may end.
fn patiently<T>(mut start: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    for _ in 0..ATTEMPTS {
        match start() {
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => thread::sleep(AGAIN),
            result => return result,
        }
    }
    start()
}

/// Returns the end of what it said.
fn last_lines(stderr: &str) -> String {
    let said: Vec<_> = stderr
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.contains("SUMO_HOME is not set"))
        .collect();
    match said.len() {
        0 => "it said nothing".to_owned(),
        n => said[n.saturating_sub(QUOTED_LINES)..].join("; "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ended(script: &str, limit_ms: u64) -> String {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        let ended = finish(command, Duration::from_millis(limit_ms), "p");
        ended.map_or_else(|e| e.to_string(), |()| "well".to_owned())
    }

    #[test]
    fn what_ends_netconvert_from_outside_says_nothing_of_the_intersection() {
        let full = "Error: No space left on device";
        for (script, limit_ms, expected) in [
            ("exec sleep 60", 50, "p: netconvert did not end within 0.05 s; this says nothing"),
            ("kill -9 $$", 60_000, "p: netconvert was killed by signal 9; this says nothing"),
            (&format!("echo '{full}' >&2; exit 1"), 60_000, &format!("p: {full}; this says")),
            ("echo 'Error: no' >&2; exit 1", 60_000, "p: netconvert failed: Error: no"),
            ("kill -SEGV $$", 60_000, "p: netconvert failed: it crashed by signal 11 (it said"),
            ("head -c 1000000 /dev/zero >&2", 60_000, "well"),
        ] {
            let ended = ended(script, limit_ms);
            assert!(ended.starts_with(expected), "{script}: {ended}");
        }
    }

    #[test]
    fn the_end_of_standard_error_is_quoted_without_the_remark_on_sumo_home() {
        let stderr = "Warning: SUMO_HOME is not set\nError: a\n\nError: b\nQuitting.\n";
        assert_eq!(last_lines(stderr), "Error: a; Error: b; Quitting.");
    }

    #[test]
    fn what_is_no_netconvert_is_passed_over_and_the_places_looked_at_are_named() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("netconvert"), "").unwrap();
        let e = find_in(None, Some(folder.path().into())).unwrap_err();
        assert!(e.starts_with("SUMO_HOME is not set, PATH; "), "{e}");
        let e = find_in(Some("/nowhere".into()), Some("/also-nowhere".into())).unwrap_err();
        assert_eq!(e, "/nowhere/bin/netconvert, PATH");
    }
}
