//! A controller that is a command: it is asked over its standard input and answers on its standard output, one JSON
//! object per line ([`super::protocol`]). Its standard error goes to the log, and the end of it into the reason when it
//! fails.
//!
//! One process does a whole task: it is started with the first episode, and told of every episode's begin. Each of its pipes has
//! a thread of its own, so that neither a process that does not answer nor one that does not read can hold up a task.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;

use super::protocol::{Decision, Question, Ready, Seen, Signal, VERSION};
use crate::control::{ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec};

/// Longest line that is read, bytes.
const MOST_LINE: usize = 1 << 20;

/// Most characters of an answer that are quoted.
const QUOTED: usize = 200;

/// Last lines of standard error that are quoted.
const LAST_LINES: usize = 30;

/// What is said of a command from which nothing ever came.
const UNHEARD: &str = " (no line ever came: does it flush its output after every line, and read its input line by line?)";

/// Time that a command has to end when it was told to, and that its last words have to arrive.
const PATIENCE: Duration = Duration::from_secs(2);

/// How often it is looked whether it has ended.
const NAP: Duration = Duration::from_millis(5);

/// A controller that is a command.
#[derive(Debug)]
pub struct Exec {
    name: &'static str,
    /// Program and arguments.
    words: Vec<String>,
    setup: Setup,
    /// Time for an answer.
    answer: Duration,
    /// Phases of every signal.
    phases: Vec<usize>,
    running: Option<Running>,
}

/// The command at work.
#[derive(Debug)]
struct Running {
    child: Child,
    questions: Sender<Vec<u8>>,
    /// Lines without their ends; `None` for one that is too long.
    answers: Receiver<Option<Vec<u8>>>,
    was_heard: bool,
    last_words: Arc<Mutex<VecDeque<String>>>,
    listener: JoinHandle<()>,
}

impl Exec {
    /// Returns a controller that has not been started.
    /// * `words` — program and arguments.
    /// * `answer` — time for an answer.
    pub fn new(name: &'static str, words: Vec<String>, setup: Setup, answer: Duration) -> Self {
        Self { name, words, setup, answer, phases: Vec::new(), running: None }
    }

    fn failed(&mut self, reason: String) -> ControlError {
        let words = self.running.take().map(Running::end).unwrap_or_default();
        let last = if words.is_empty() { "" } else { "; it said last\n" };
        ControlError::Own {
            method: self.name,
            reason: format!("{reason}{last}{}", words.join("\n")),
        }
    }

    /// Asks for something and returns the answer.
    fn ask<A: DeserializeOwned>(
        &mut self,
        question: &Question,
        what: &str,
        form: &str,
    ) -> Result<A, ControlError> {
        let limit = self.answer;
        let running = self.running.as_mut().expect("it was started");
        // An answer that is left over would be taken for that to the next question, and so on to the end.
        if let Ok(unasked) = running.answers.try_recv() {
            let text = quoted(&unasked.unwrap_or_default());
            return Err(self.failed(format!(
                "it said {text:?} without being asked; it answers with one line, and anything else goes to standard error"
            )));
        }
        // One that reads no more may still have answered; if not, that is what is told.
        let _ = running.questions.send(line_of(question));
        match running.answers.recv_timeout(limit) {
            Ok(Some(text)) => {
                running.was_heard = true;
                serde_json::from_slice(&text).map_err(|e| {
                    let text = quoted(&text);
                    let reason =
                        format!("it answered {what} with {text:?}, which is not {form} ({e})");
                    self.failed(reason)
                })
            }
            Ok(None) => Err(self.failed(format!(
                "its answer to {what} cannot be read: its line has more than {MOST_LINE} bytes"
            ))),
            // What it has started may hold its standard output open when it has ended.
            Err(RecvTimeoutError::Timeout) if !running.is_over() => {
                let limit = limit.as_secs_f64();
                let hint = if running.was_heard { "" } else { UNHEARD };
                Err(self.failed(format!(
                    "it did not answer {what} within {limit} s{hint}; --answer-timeout allows more time"
                )))
            }
            Err(_) => {
                let closed = || "closed its standard output".to_owned();
                let how = running.wait().map_or_else(closed, |status| format!("ended ({status})"));
                Err(self.failed(format!("it {how} instead of answering {what}")))
            }
        }
    }
}

/// Returns the beginning of what was said.
fn quoted(said: &[u8]) -> String {
    String::from_utf8_lossy(said).trim_end().chars().take(QUOTED).collect()
}

impl Controller for Exec {
    fn name(&self) -> &'static str {
        self.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        if self.running.is_none() {
            let started = Running::start(&self.words);
            let name = &self.words[0];
            self.running = Some(started.map_err(|e| ControlError::Own {
                method: self.name,
                reason: format!("{name} cannot be started: {e}"),
            })?);
        }
        self.phases = signals.iter().map(|signal| signal.phases.len()).collect();
        let begin = Question::Begin {
            version: VERSION,
            method: self.name.to_owned(),
            seed: self.setup.seed,
            signals: signals.iter().map(Signal::from).collect(),
        };
        self.ask::<Ready>(&begin, "begin", "{}")?;
        Ok(vec![Drive::Decisions; signals.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        let act = Question::Act { signals: observations.iter().map(Seen::from).collect() };
        let decision: Decision = self.ask(&act, "act", "{\"phases\":[...]}")?;
        let (given, signals) = (decision.phases.len(), phases.len());
        if given != signals {
            let reason = format!("it decided for {given} signals, and there are {signals}");
            return Err(self.failed(reason));
        }
        let wrong =
            decision.phases.iter().zip(&self.phases).position(|(phase, count)| phase >= count);
        if let Some(signal) = wrong {
            let (phase, count) = (decision.phases[signal], self.phases[signal]);
            return Err(self.failed(format!(
                "it chose phase {phase} of signal {signal}, which has {count}, from 0"
            )));
        }
        phases.iter_mut().zip(decision.phases).for_each(|(to, phase)| *to = GreenPhase(phase));
        Ok(())
    }
}

impl Drop for Exec {
    fn drop(&mut self) {
        if let Some(running) = self.running.take() {
            running.end();
        }
    }
}

impl Running {
    fn start(words: &[String]) -> io::Result<Self> {
        let mut command = Command::new(&words[0]);
        command.args(&words[1..]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(mut stdin), Some(stdout), Some(stderr)) = pipes else { unreachable!("piped") };
        let (questions, asked) = mpsc::channel::<Vec<u8>>();
        // One that talks without end is not listened to without end.
        let (answer, answers) = mpsc::sync_channel(1);
        let last_words = Arc::new(Mutex::new(VecDeque::new()));
        let kept = Arc::clone(&last_words);
        let say = move || drop(asked.iter().try_for_each(|line| stdin.write_all(&line)));
        let hear = move || {
            for_each_line(stdout, |line| match line.strip_suffix(b"\n") {
                Some(line) => answer.send(Some(line.to_vec())).is_ok(),
                // Too long, or the end of what was said.
                None => {
                    let _ = (line.len() == MOST_LINE).then(|| answer.send(None));
                    false
                }
            });
        };
        let listen = move || {
            for_each_line(stderr, |line| {
                // A log that cannot be written is noticed elsewhere.
                let _ = io::stderr().write_all(line);
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.push_back(String::from_utf8_lossy(line).trim_end().to_owned());
                let more = kept.len().saturating_sub(LAST_LINES);
                kept.drain(..more);
                true
            });
        };
        spawn(say);
        spawn(hear);
        let listener = spawn(listen);
        Ok(Self { child, questions, answers, was_heard: false, last_words, listener })
    }

    /// Whether it has ended.
    fn is_over(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_some())
    }

    fn wait(&mut self) -> Option<ExitStatus> {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) => sleep(NAP),
                Err(_) => return None,
            }
        }
        None
    }

    /// Ends it, and returns its last words on standard error.
    fn end(mut self) -> Vec<String> {
        // With the sender its standard input closes.
        let _ = std::mem::replace(&mut self.questions, mpsc::channel().0)
            .send(line_of(&Question::End {}));
        if self.wait().is_none() {
            // It may have ended by itself meanwhile.
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        // Processes that it has started may hold its standard error open: they are not waited for.
        let begin = Instant::now();
        while !self.listener.is_finished() && begin.elapsed() < PATIENCE {
            sleep(NAP);
        }
        let words = self.last_words.lock().unwrap_or_else(PoisonError::into_inner);
        words.iter().cloned().collect()
    }
}

/// Returns a question as a line.
fn line_of(question: &Question) -> Vec<u8> {
    let mut line = serde_json::to_vec(question).expect("plain data");
    line.push(b'\n');
    line
}

/// Hands over every line with its end, in pieces where it is too long, to the end or until nobody wants more.
fn for_each_line(from: impl Read, mut wants_more: impl FnMut(&[u8]) -> bool) {
    let mut reader = BufReader::with_capacity(1 << 16, from);
    loop {
        let mut line = Vec::new();
        let read = reader.by_ref().take(MOST_LINE as u64).read_until(b'\n', &mut line);
        if !matches!(read, Ok(1..)) || !wants_more(&line) {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::testing::{observation, two_phase_signal};

    /// A command that is a shell's.
    fn exec(script: &str) -> Exec {
        let words = ["sh", "-c", script].map(str::to_owned).to_vec();
        Exec::new("mine", words, Setup::default(), Duration::from_millis(400))
    }

    fn play(exec: &mut Exec) -> Result<usize, String> {
        let mut phases = [GreenPhase(9)];
        exec.begin(&[two_phase_signal()]).map_err(|e| e.to_string())?;
        let seen = [observation([2.0, 3.0], [0.0, 0.0])];
        exec.act(&seen, &mut phases).map_err(|e| e.to_string())?;
        Ok(phases[0].0)
    }

    #[test]
    fn a_command_decides_and_is_told_of_every_episode() {
        let mut exec = exec(
            r#"n=0; while read -r line; do case $line in
               *'"event":"begin"'*) n=$((n + 1)); echo '{}';;
               *'"event":"act"'*) echo "{\"phases\":[$((n - 1))]}";;
               esac; done"#,
        );
        assert_eq!(play(&mut exec), Ok(0));
        assert_eq!(play(&mut exec), Ok(1), "the same process goes on with the next episode");
    }

    #[test]
    fn whatever_a_command_does_instead_of_answering_is_said() {
        let act = |answer: &str| format!("read -r a; echo '{{}}'; read -r b; {answer}; cat");
        let cases = [
            (
                "echo no such thing >&2; exit 3".to_owned(),
                "it ended (exit status: 3) instead of answering begin; it said last\nno such thing",
            ),
            (
                "sleep 5".to_owned(),
                "it did not answer begin within 0.4 s (no line ever came: does it flush its output",
            ),
            (act("sleep 5"), "it did not answer act within 0.4 s; --answer-timeout"),
            (
                "read -r a; echo hello; cat".to_owned(),
                "it answered begin with \"hello\", which is not {}",
            ),
            (act("kill -9 $$"), "it ended (signal: 9 (SIGKILL)) instead of answering act"),
            (
                act("exec >&-; exec sleep 5"),
                "it closed its standard output instead of answering act",
            ),
            (act("echo '{\"phases\":[2]}'"), "it chose phase 2 of signal 0, which has 2, from 0"),
            (act("echo '{\"phases\":[0,0]}'"), "it decided for 2 signals, and there are 1"),
            (act("head -c 2000000 /dev/zero"), "its line has more than 1048576 bytes"),
        ];
        // Most of them are waited for.
        std::thread::scope(|scope| {
            for (script, expected) in &cases {
                scope.spawn(move || {
                    let e = play(&mut exec(script)).unwrap_err();
                    assert!(e.starts_with("mine: ") && e.contains(expected), "{script}: {e}");
                });
            }
        });
        let mut missing = Exec::new("mine", vec!["/nowhere".into()], Setup::default(), PATIENCE);
        assert!(play(&mut missing).unwrap_err().starts_with("mine: /nowhere cannot be started"));
    }
}
