//! How many workers a machine lets start.
//!
//! A limit on processes (`ulimit -u`, the pids of a container or of a batch system) counts threads too. So
//! members of the crew are hired one after the other, each when the one before has its first worker
//! running. One that cannot start its first gives its task back and leaves: the run goes on with those
//! there are. One that cannot start a later worker waits until others have ended, and when none runs, for
//! some seconds: whatever else fills the machine may end too.

use std::io::{self, ErrorKind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::thread;
use std::time::{Duration, Instant};

use basics::machine::{lacks_files, with_way_out};

/// How long a crew of which nobody works waits for the machine.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time between two attempts to start a worker.
const AGAIN: Duration = Duration::from_millis(100);

/// Tasks by their position that nobody has taken yet.
#[derive(Debug)]
pub(super) struct Queue {
    next: AtomicUsize,
    len: usize,
    given_back: Mutex<Vec<usize>>,
}

impl Queue {
    /// Returns a queue of so many tasks.
    pub(super) fn new(len: usize) -> Self {
        Self { next: AtomicUsize::new(0), len, given_back: Mutex::new(Vec::new()) }
    }

    /// Returns the position of a task that is to be done.
    pub(super) fn take(&self) -> Option<usize> {
        let given_back = self.given_back.lock().ok().and_then(|mut tasks| tasks.pop());
        given_back.or_else(|| {
            let position = self.next.fetch_add(1, Ordering::Relaxed);
            (position < self.len).then_some(position)
        })
    }

    /// Takes a task back that was not done.
    pub(super) fn give_back(&self, position: usize) {
        if let Ok(mut tasks) = self.given_back.lock() {
            tasks.push(position);
        }
    }

    /// Whether all tasks were taken.
    pub(super) fn is_empty(&self) -> bool {
        let all_taken = self.next.load(Ordering::Relaxed) >= self.len;
        all_taken && self.given_back.lock().is_ok_and(|tasks| tasks.is_empty())
    }
}

/// Who has a worker running.
#[derive(Debug, Default)]
pub(super) struct Crew {
    at_work: AtomicUsize,
}

/// A running worker of the crew; dropped when it has ended.
#[derive(Debug)]
pub(super) struct AtWork<'a>(&'a Crew);

impl Drop for AtWork<'_> {
    fn drop(&mut self) {
        self.0.at_work.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Whoever does one task after the other.
#[derive(Debug)]
pub(super) struct Member<'a> {
    crew: &'a Crew,
    /// Hears whether the first worker could be started; gone after that.
    hired: Mutex<Option<Sender<io::Result<()>>>>,
}

impl<'a> Member<'a> {
    /// Returns a new member, who says whether a first worker could be started.
    pub(super) fn new(crew: &'a Crew, hired: Sender<io::Result<()>>) -> Self {
        Self { crew, hired: Mutex::new(Some(hired)) }
    }

    /// Starts a worker; `None` where the run is to stop or the member is to leave.
    ///
    /// # Errors
    ///
    /// The system's, with the way out, when no worker at all can be started.
    pub(super) fn start<T>(
        &self,
        halt: &dyn Fn() -> bool,
        start: &dyn Fn() -> io::Result<T>,
    ) -> io::Result<Option<(T, AtWork<'a>)>> {
        let mut alone = None;
        loop {
            self.crew.at_work.fetch_add(1, Ordering::Relaxed);
            let at_work = AtWork(self.crew);
            let reason = match start() {
                Ok(started) => {
                    self.say(Ok(()));
                    return Ok(Some((started, at_work)));
                }
                Err(reason) if lacks_files(&reason) => return Err(with_way_out(reason)),
                Err(reason) if !is_scarce(&reason) => return Err(reason),
                Err(reason) => reason,
            };
            drop(at_work);
            let others = self.crew.at_work.load(Ordering::Relaxed);
            if others > 0 && self.is_new() {
                self.say(Err(reason));
                return Ok(None);
            }
            if others > 0 {
                alone = None;
            } else if alone.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
                return Err(with_way_out(reason));
            }
            if halt() {
                return Ok(None);
            }
            thread::sleep(AGAIN);
        }
    }

    fn is_new(&self) -> bool {
        self.hired.lock().is_ok_and(|hired| hired.is_some())
    }

    fn say(&self, result: io::Result<()>) {
        let hired = self.hired.lock().ok().and_then(|mut hired| hired.take());
        // Whoever hired may have gone.
        hired.map(|hired| hired.send(result));
    }
}

/// Whether nothing more may be started for now.
fn is_scarce(reason: &io::Error) -> bool {
    matches!(reason.kind(), ErrorKind::WouldBlock | ErrorKind::OutOfMemory)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    fn scarce<T>() -> io::Result<T> {
        Err(ErrorKind::WouldBlock.into())
    }

    #[test]
    fn who_cannot_start_a_first_worker_leaves_and_the_task_is_taken_by_another() {
        let (crew, queue) = (Crew::default(), Queue::new(2));
        let (first_says, first_said) = channel();
        let first = Member::new(&crew, first_says);
        let _at_work = first.start(&|| false, &|| Ok(())).unwrap().unwrap();
        assert!(first_said.recv().unwrap().is_ok());
        assert_eq!(queue.take(), Some(0));
        let (second_says, second_said) = channel();
        let second = Member::new(&crew, second_says);
        let position = queue.take().unwrap();
        assert!(second.start(&|| false, &scarce::<()>).unwrap().is_none());
        queue.give_back(position);
        assert!(second_said.recv().unwrap().is_err());
        assert!(!queue.is_empty());
        assert_eq!((queue.take(), queue.take()), (Some(1), None));
        assert!(queue.is_empty());
    }

    #[test]
    fn who_has_worked_waits_until_there_is_room_again() {
        let crew = Crew::default();
        let (says, _said) = channel();
        let member = Member::new(&crew, says);
        drop(member.start(&|| false, &|| Ok(())).unwrap());
        let tries = AtomicUsize::new(0);
        let third = || match tries.fetch_add(1, Ordering::Relaxed) {
            0 | 1 => scarce(),
            n => Ok(n),
        };
        assert_eq!(member.start(&|| false, &third).unwrap().unwrap().0, 2);
        assert!(member.start(&|| true, &scarce::<()>).unwrap().is_none(), "the run is to stop");
        let missing = || Err::<(), _>(ErrorKind::NotFound.into());
        assert_eq!(member.start(&|| false, &missing).unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[test]
    fn the_only_one_gives_up_with_the_way_out() {
        let crew = Crew::default();
        let (says, _said) = channel();
        let e = Member::new(&crew, says).start(&|| false, &scarce::<()>).unwrap_err();
        assert!(e.to_string().contains("raise it (ulimit -u"), "{e}");
    }
}
