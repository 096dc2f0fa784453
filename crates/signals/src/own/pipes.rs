//! Lines to and from a process, without a thread and never waiting longer than allowed: neither one that does not answer
//! nor one that does not read can hold up whoever asks.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::process::{ChildStdin, ChildStdout};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::{Errno, ioctl_fionbio};

/// Longest line that is read, bytes.
pub(super) const MOST_LINE: usize = 1 << 20;

/// Bytes that are read at once: what a pipe holds.
const AT_ONCE: usize = 1 << 16;

/// Why there is no answer.
#[derive(Debug)]
pub(super) enum Silence {
    /// Not within the time for it.
    Late,
    /// Standard output was closed.
    Closed,
    /// A line of it cannot be used, or the system refused to read.
    Unreadable(io::Error),
}

/// Both pipes of a process.
#[derive(Debug)]
pub(super) struct Pipes {
    /// `None` once nothing can be said any more.
    questions: Option<File>,
    answers: File,
    /// What was read and is not yet handed out.
    read: Vec<u8>,
    /// Whether anything ever came.
    was_heard: bool,
}

impl Pipes {
    /// Takes over both pipes.
    ///
    /// # Errors
    ///
    /// [`io::Error`] when the system refuses to change how they wait.
    pub(super) fn new(questions: ChildStdin, answers: ChildStdout) -> io::Result<Self> {
        let (questions, answers) = (OwnedFd::from(questions), OwnedFd::from(answers));
        // Of our ends alone: the other ends are other descriptions, which wait as they did.
        ioctl_fionbio(&questions, true)?;
        ioctl_fionbio(&answers, true)?;
        let (questions, answers) = (Some(questions.into()), answers.into());
        Ok(Self { questions, answers, read: Vec::new(), was_heard: false })
    }

    /// Whether anything ever came, be it no whole line.
    pub(super) fn was_heard(&self) -> bool {
        self.was_heard
    }

    /// Returns what came without a question since the last answer; nothing where the pipe was closed.
    ///
    /// # Errors
    ///
    /// [`Silence::Unreadable`].
    pub(super) fn unasked(&mut self) -> Result<&[u8], Silence> {
        match self.listen() {
            Ok(()) | Err(Silence::Closed) => Ok(&self.read),
            Err(e) => Err(e),
        }
    }

    /// Says a line and returns the next one that comes back, without its end.
    ///
    /// # Errors
    ///
    /// Why there is none.
    pub(super) fn ask(&mut self, line: &[u8], limit: Duration) -> Result<Vec<u8>, Silence> {
        // None: a limit beyond what clocks count to is none.
        let end = Instant::now().checked_add(limit);
        let mut unsaid = line;
        loop {
            unsaid = self.say(unsaid);
            if unsaid.is_empty()
                && let Some(answer) = self.line()?
            {
                return Ok(answer);
            }
            let mut ready = vec![PollFd::new(&self.answers, PollFlags::IN)];
            if let Some(questions) = self.questions.as_ref().filter(|_| !unsaid.is_empty()) {
                ready.push(PollFd::new(questions, PollFlags::OUT));
            }
            let left = end.map(|end| end.saturating_duration_since(Instant::now()));
            let left = left.and_then(|left| Timespec::try_from(left).ok());
            match poll(&mut ready, left.as_ref()) {
                Ok(0) => return Err(Silence::Late),
                Ok(_) | Err(Errno::INTR) => {}
                Err(e) => return Err(Silence::Unreadable(e.into())),
            }
            self.listen()?;
        }
    }

    /// Says a last line, as far as there is somebody to hear it, and closes that pipe.
    pub(super) fn part(&mut self, line: &[u8]) {
        self.say(line);
        self.questions = None;
    }

    /// Says what fits into the pipe, and returns the rest.
    fn say<'a>(&mut self, mut line: &'a [u8]) -> &'a [u8] {
        while let Some(questions) = self.questions.as_mut().filter(|_| !line.is_empty()) {
            match questions.write(line) {
                Ok(count) => line = &line[count..],
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => return line,
                // One that reads no more may still have answered; if not, that is what is told.
                Err(_) => self.questions = None,
            }
        }
        &[]
    }

    /// Reads what is there.
    fn listen(&mut self) -> Result<(), Silence> {
        let before = self.read.len();
        if before > 2 * MOST_LINE {
            let what = "it says much more than it is asked for";
            return Err(Silence::Unreadable(io::Error::other(what)));
        }
        self.read.resize(before + AT_ONCE, 0);
        let count = self.answers.read(&mut self.read[before..]);
        self.read.truncate(before + count.as_ref().copied().unwrap_or(0));
        match count {
            Ok(0) => Err(Silence::Closed),
            Ok(_) => {
                self.was_heard = true;
                Ok(())
            }
            Err(e) => match e.kind() {
                io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted => Ok(()),
                _ => Err(Silence::Unreadable(e)),
            },
        }
    }

    /// Takes the first whole line of what was read.
    fn line(&mut self) -> Result<Option<Vec<u8>>, Silence> {
        let end = self.read.iter().position(|byte| *byte == b'\n');
        if end.unwrap_or(self.read.len()) >= MOST_LINE {
            let what = format!("its line has more than {MOST_LINE} bytes");
            return Err(Silence::Unreadable(io::Error::other(what)));
        }
        let Some(end) = end else { return Ok(None) };
        let rest = self.read.split_off(end + 1);
        let mut line = std::mem::replace(&mut self.read, rest);
        line.pop();
        Ok(Some(line))
    }
}

#[cfg(test)]
mod tests {
    use std::process::{Child, Command, Stdio};

    use super::*;

    fn shell(script: &str) -> (Child, Pipes) {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let pipes = Pipes::new(child.stdin.take().unwrap(), child.stdout.take().unwrap()).unwrap();
        (child, pipes)
    }

    #[test]
    fn lines_of_any_length_go_both_ways() {
        let (mut child, mut pipes) = shell("exec cat");
        let limit = Duration::from_secs(20);
        assert_eq!(pipes.ask(b"one\ntwo\n", limit).unwrap(), b"one");
        assert_eq!(pipes.ask(b"three\n", limit).unwrap(), b"two", "in the order of what is said");
        assert_eq!(pipes.ask(b"", limit).unwrap(), b"three");
        // More than both pipes hold: whoever only said and then listened would wait for good.
        let mut long = vec![b'x'; MOST_LINE - 1];
        long.push(b'\n');
        assert_eq!(pipes.ask(&long, limit).unwrap().len(), MOST_LINE - 1);
        long.insert(0, b'x');
        assert!(matches!(pipes.ask(&long, limit), Err(Silence::Unreadable(_))));
        drop(pipes);
        child.wait().unwrap();
    }

    #[test]
    fn what_comes_without_a_question_is_seen_before_the_next_one() {
        let (mut child, mut pipes) = shell("read x; echo one; read x; printf 'two\\nmore'; read x");
        let limit = Duration::from_secs(20);
        assert_eq!(pipes.ask(b"x\n", limit).unwrap(), b"one");
        assert_eq!(pipes.unasked().unwrap(), b"");
        assert_eq!(pipes.ask(b"x\n", limit).unwrap(), b"two");
        pipes.part(b"");
        child.wait().unwrap();
        assert_eq!(pipes.unasked().unwrap(), b"more");
    }

    #[test]
    fn one_that_neither_reads_nor_answers_is_not_waited_for() {
        let (mut child, mut pipes) = shell("exec sleep 20");
        let begin = Instant::now();
        let long = vec![b'x'; 1 << 20];
        assert!(matches!(pipes.ask(&long, Duration::from_millis(50)), Err(Silence::Late)));
        pipes.part(&long);
        assert!(begin.elapsed() < Duration::from_secs(10));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(matches!(pipes.ask(b"", Duration::from_secs(20)), Err(Silence::Closed)));
    }

    #[test]
    fn one_that_answers_without_reading_is_heard() {
        let (mut child, mut pipes) = shell("exec <&-; echo here");
        child.wait().unwrap();
        let limit = Duration::from_secs(20);
        assert_eq!(pipes.ask(&vec![b'x'; 1 << 20], limit).unwrap(), b"here");
        assert!(matches!(pipes.ask(b"x\n", limit), Err(Silence::Closed)));
    }

    #[test]
    fn one_that_talks_without_end_is_not_listened_to_without_end() {
        let (mut child, mut pipes) = shell("exec yes");
        let long = vec![b'x'; 1 << 20];
        let answer = pipes.ask(&long, Duration::from_secs(20));
        assert!(matches!(answer, Err(Silence::Unreadable(_))), "{answer:?}");
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
