//! Lines to and from a process, each direction in a thread of its own: neither a process that does not answer nor one that does
//! not read can hold up whoever asks.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{ChildStdin, ChildStdout};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::Duration;

/// Longest line that is read, bytes.
pub(super) const MOST_LINE: usize = 1 << 20;

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

/// A line without its end, and what had come after it by then.
type Answer = (Vec<u8>, Vec<u8>);

/// Both pipes of a process.
#[derive(Debug)]
pub(super) struct Pipes {
    /// `None` once nothing can be said any more.
    questions: Option<Sender<Vec<u8>>>,
    answers: Receiver<io::Result<Answer>>,
    unasked: Vec<u8>,
    /// Whether anything ever came, be it no whole line.
    was_heard: Arc<AtomicBool>,
}

impl Pipes {
    /// Takes over both pipes.
    ///
    /// # Errors
    ///
    /// [`io::Error`] when the system has no thread more.
    pub(super) fn new(mut questions: ChildStdin, answers: ChildStdout) -> io::Result<Self> {
        let (ask, asked) = mpsc::channel::<Vec<u8>>();
        // One that talks without end is not listened to without end.
        let (answer, answered) = mpsc::sync_channel(1);
        let was_heard = Arc::new(AtomicBool::new(false));
        let heard = Arc::clone(&was_heard);
        let say = move || {
            // One that reads no more may still have answered; if not, that is what is told.
            let _ = asked.iter().try_for_each(|line| questions.write_all(&line));
        };
        let listen = move || {
            let mut reader = BufReader::with_capacity(1 << 16, answers);
            while let Some(line) = next_line(&mut reader, &heard).transpose() {
                let is_last = line.is_err();
                let line = line.map(|line| (line, reader.buffer().to_vec()));
                if answer.send(line).is_err() || is_last {
                    return;
                }
            }
        };
        thread::Builder::new().spawn(say)?;
        thread::Builder::new().spawn(listen)?;
        Ok(Self { questions: Some(ask), answers: answered, unasked: Vec::new(), was_heard })
    }

    /// Whether anything ever came, be it no whole line.
    pub(super) fn was_heard(&self) -> bool {
        self.was_heard.load(Ordering::Relaxed)
    }

    /// Returns what came without a question since the last answer.
    ///
    /// # Errors
    ///
    /// [`Silence::Unreadable`].
    pub(super) fn unasked(&mut self) -> Result<Vec<u8>, Silence> {
        match self.answers.try_recv() {
            Ok(Ok((line, _))) => Ok(line),
            Ok(Err(e)) => Err(Silence::Unreadable(e)),
            Err(_) => Ok(std::mem::take(&mut self.unasked)),
        }
    }

    /// Says a line and returns the next one that comes back, without its end.
    ///
    /// # Errors
    ///
    /// Why there is none.
    pub(super) fn ask(&mut self, line: Vec<u8>, limit: Duration) -> Result<Vec<u8>, Silence> {
        if let Some(questions) = &self.questions {
            // See `say`.
            let _ = questions.send(line);
        }
        match self.answers.recv_timeout(limit) {
            Ok(Ok((line, after))) => {
                self.unasked = after;
                Ok(line)
            }
            Ok(Err(e)) => Err(Silence::Unreadable(e)),
            Err(RecvTimeoutError::Timeout) => Err(Silence::Late),
            Err(RecvTimeoutError::Disconnected) => Err(Silence::Closed),
        }
    }

    /// Says a last line, as far as there is somebody to hear it, and closes that pipe.
    pub(super) fn part(&mut self, line: Vec<u8>) {
        // See `say`.
        let _ = self.questions.take().map(|questions| questions.send(line));
    }
}

/// Returns the next line without its end; `None` where there is none.
fn next_line(reader: &mut impl BufRead, heard: &AtomicBool) -> io::Result<Option<Vec<u8>>> {
    let is_over = reader.fill_buf()?.is_empty();
    heard.fetch_or(!is_over, Ordering::Relaxed);
    let mut line = Vec::new();
    reader.take(MOST_LINE as u64).read_until(b'\n', &mut line)?;
    match line.pop() {
        Some(b'\n') => Ok(Some(line)),
        _ if line.len() + 1 >= MOST_LINE => {
            Err(io::Error::other(format!("its line has more than {MOST_LINE} bytes")))
        }
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use std::process::{Child, Command, Stdio};
    use std::time::Instant;

    use super::*;

    fn shell(script: &str) -> (Child, Pipes) {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let pipes = Pipes::new(child.stdin.take().unwrap(), child.stdout.take().unwrap()).unwrap();
        (child, pipes)
    }

    const LIMIT: Duration = Duration::from_secs(20);

    #[test]
    fn lines_of_any_length_go_both_ways() {
        let (mut child, mut pipes) = shell("exec cat");
        assert_eq!(pipes.ask(b"one\ntwo\n".to_vec(), LIMIT).unwrap(), b"one");
        assert_eq!(pipes.ask(b"three\n".to_vec(), LIMIT).unwrap(), b"two", "in their order");
        assert_eq!(pipes.ask(Vec::new(), LIMIT).unwrap(), b"three");
        // More than both pipes hold: whoever only said and then listened would wait for good.
        let mut long = vec![b'x'; MOST_LINE - 1];
        long.push(b'\n');
        assert_eq!(pipes.ask(long.clone(), LIMIT).unwrap().len(), MOST_LINE - 1);
        long.insert(0, b'x');
        assert!(matches!(pipes.ask(long, LIMIT), Err(Silence::Unreadable(_))));
        drop(pipes);
        child.wait().unwrap();
    }

    #[test]
    fn what_comes_without_a_question_is_seen_before_the_next_one() {
        let (mut child, mut pipes) = shell("read x; echo one; read x; printf 'two\\nmore'; read x");
        assert_eq!(pipes.ask(b"x\n".to_vec(), LIMIT).unwrap(), b"one");
        assert_eq!(pipes.unasked().unwrap(), b"");
        assert_eq!(pipes.ask(b"x\n".to_vec(), LIMIT).unwrap(), b"two");
        assert_eq!(pipes.unasked().unwrap(), b"more");
        pipes.part(Vec::new());
        child.wait().unwrap();
    }

    #[test]
    fn one_that_neither_reads_nor_answers_is_not_waited_for() {
        let (mut child, mut pipes) = shell("exec sleep 20");
        let begin = Instant::now();
        let long = vec![b'x'; 1 << 20];
        let limit = Duration::from_millis(50);
        assert!(matches!(pipes.ask(long.clone(), limit), Err(Silence::Late)));
        pipes.part(long);
        assert!(begin.elapsed() < Duration::from_secs(10));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(matches!(pipes.ask(Vec::new(), LIMIT), Err(Silence::Closed)));
    }

    #[test]
    fn one_that_answers_without_reading_is_heard() {
        let (mut child, mut pipes) = shell("exec <&-; echo here");
        child.wait().unwrap();
        assert_eq!(pipes.ask(vec![b'x'; 1 << 20], LIMIT).unwrap(), b"here");
        assert!(matches!(pipes.ask(b"x\n".to_vec(), LIMIT), Err(Silence::Closed)));
    }
}
