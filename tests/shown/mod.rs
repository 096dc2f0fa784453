//! Checks the lights that SUMO really showed, second by second, against limits in plain numbers.
//!
//! Knows nothing of how the limits were computed or of what a controller meant: only letters.

use std::fs;
use std::path::Path;

/// Limits of one signal, seconds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    pub(crate) yellow: usize,
    pub(crate) all_red: usize,
    /// Shortest green of a state in which some through link is green.
    pub(crate) min_through: usize,
    /// Shortest green of any other state.
    pub(crate) min_left: usize,
    pub(crate) max_green: usize,
}

/// Reads the states of a signal that SUMO saved, one per second.
pub(crate) fn states(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let state = |line: &str| {
        let (_, rest) = line.split_once(" state=\"")?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    text.lines().filter(|line| line.contains("<tlsState ")).filter_map(state).collect()
}

fn is_green(letter: u8) -> bool {
    letter == b'G' || letter == b'g'
}

/// Returns what is wrong with the states, in words; `through` are the indices of through links.
pub(crate) fn violations(states: &[String], through: &[usize], limits: &Limits) -> Vec<String> {
    let links = states[0].len();
    let at = |second: usize, link: usize| states[second].as_bytes()[link];
    let mut wrong = Vec::new();
    let end = states.len();
    // When a green of some link ended for good, after its yellow, and when one began.
    let (mut ended, mut began) = (Vec::new(), Vec::new());
    for link in 0..links {
        for second in 1..end {
            let (before, now) = (at(second - 1, link), at(second, link));
            if is_green(before) && !is_green(now) {
                let yellow = (second..end).take_while(|s| at(*s, link) == b'y').count();
                if second + yellow < end {
                    if yellow < limits.yellow {
                        wrong.push(format!("{second} s: link {link} has {yellow} s of yellow"));
                    }
                    ended.push(second + yellow);
                }
            }
            if before == b'y' && is_green(now) {
                wrong.push(format!("{second} s: link {link} goes from yellow to green"));
            }
            if !is_green(before) && is_green(now) {
                began.push(second);
            }
        }
    }
    for begin in &began {
        let last = ended.iter().filter(|e| *e <= begin).max();
        if let Some(last) = last.filter(|last| begin - **last < limits.all_red) {
            wrong.push(format!("{begin} s: green {} s after the last yellow", begin - last));
        }
    }
    // A green phase begins when some link turns green, or at the start, and ends at the next yellow.
    began.push(0);
    began.sort_unstable();
    began.dedup();
    for begin in began {
        let state = &states[begin];
        let length = (begin..end).take_while(|s| states[*s] == *state).count();
        if begin + length == end {
            continue;
        }
        let serves_through = through.iter().any(|link| is_green(state.as_bytes()[*link]));
        let least = if serves_through { limits.min_through } else { limits.min_left };
        // The first phase of an episode began before it.
        if length < least && begin > 0 {
            wrong.push(format!("{begin} s: {state} lasts {length} s, not {least}"));
        }
        if length > limits.max_green {
            wrong.push(format!("{begin} s: {state} lasts {length} s"));
        }
    }
    wrong
}
