//! A process that stands still is noticed; in a file of its own, because the pulse is the process's.

use std::sync::mpsc::channel;
use std::time::Duration;

use tsc_family::heartbeat;
use tsc_family::run::watchdog::Watchdog;

#[test]
fn a_process_that_simulates_no_step_is_noticed_with_the_steps_that_it_did() {
    heartbeat::beat(7);
    let (say, said) = channel();
    let limit = Duration::from_millis(200);
    let _dog = Watchdog::start(limit, |_| {}, move |steps| say.send(steps).unwrap()).unwrap();
    assert_eq!(said.recv_timeout(Duration::from_secs(20)), Ok(7));
}
