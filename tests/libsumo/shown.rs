//! Checks the lights that SUMO really showed, second by second, against limits in plain numbers.
//!
//! Knows nothing of how the limits were computed or of what a controller meant: only letters.

use std::fs;
use std::path::Path;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    pub(crate) yellow: usize,
    pub(crate) all_red: usize,
    /// Shortest green of a through link under two rings.
    pub(crate) min_through: usize,
    /// The same of other links.
    pub(crate) min_left: usize,
    /// Shortest green of a state in which some through link is green; of any other state it is that of other links.
    pub(crate) min_state: usize,
    /// Walk and clearance of every crosswalk; 0 where nobody walks.
    pub(crate) walk: usize,
    pub(crate) max_green: usize,
}

pub(crate) fn states(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let state = |line: &str| {
        let (_, rest) = line.split_once(" state=\"")?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    text.lines().filter(|line| line.contains("<tlsState ")).filter_map(state).collect()
}

/// Reads which links of a network of one junction meet: of every link, by SUMO's numbers, the letters from the last one.
pub(crate) fn foes(net: &Path) -> Vec<Vec<bool>> {
    let text = fs::read_to_string(net).unwrap();
    let row = |line: &str| {
        let (_, rest) = line.split_once(" foes=\"")?;
        Some(rest.split_once('"')?.0.bytes().rev().map(|b| b == b'1').collect())
    };
    text.lines().filter(|line| line.contains("<request ")).filter_map(row).collect()
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
        let least = if serves_through { limits.min_state } else { limits.min_left };
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

/// Returns which crosswalks people could not cross in time, in words: from the second in which one can be crossed to
/// that in which it cannot. Nobody crosses beside somebody who comes from there and does not turn right, who goes
/// there straight on, or who turns left there with right of way, until the end of their yellow. They cross beside
/// somebody who does not turn right. The first and the last time do not count, nor does what is no longer than an all-red: a change in
/// which somebody keeps his green.
pub(crate) fn hurried(states: &[String], ways: &[Way], limits: &Limits) -> Vec<String> {
    let mut wrong = Vec::new();
    // What links show, with the green before it for a yellow.
    let mut shown: Vec<Vec<u8>> = states.iter().map(|s| s.as_bytes().to_vec()).collect();
    for second in 1..shown.len() {
        let before = shown[second - 1].clone();
        for (letter, before) in shown[second].iter_mut().zip(before) {
            if *letter == b'y' {
                *letter = before;
            }
        }
    }
    let is_right = |way: Way| !way.is_through() && !way.is_left();
    for arm in 0..4 {
        let blocks = |(link, letter): (usize, &u8)| {
            let way = ways[link];
            match letter {
                b'r' => false,
                _ if way.from == arm => !is_right(way),
                _ if way.to == arm && way.is_through() => true,
                _ => way.to == arm && way.is_left() && *letter == b'G',
            }
        };
        let serves = |state: &String| {
            state.bytes().enumerate().any(|(i, c)| is_green(c) && !is_right(ways[i]))
        };
        let open: Vec<bool> = (states.iter().zip(&shown))
            .map(|(state, shown)| serves(state) && !shown.iter().enumerate().any(blocks))
            .collect();
        let mut second = open.iter().position(|open| !open).unwrap_or(open.len());
        while second < open.len() {
            let begin = (second..open.len()).find(|s| open[*s]).unwrap_or(open.len());
            let end = (begin..open.len()).find(|s| !open[*s]).unwrap_or(open.len());
            if end < open.len() && (limits.all_red + 1..limits.walk).contains(&(end - begin)) {
                let (lasts, walk) = (end - begin, limits.walk);
                wrong
                    .push(format!("{begin} s: arm {arm} can be crossed for {lasts} s, not {walk}"));
            }
            second = end;
        }
    }
    wrong
}

/// A way through four arms, numbered clockwise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    pub(crate) from: usize,
    pub(crate) to: usize,
}

impl Way {
    fn is_through(self) -> bool {
        (self.from + 2) % 4 == self.to
    }

    fn is_left(self) -> bool {
        (self.from + 1) % 4 == self.to
    }

    /// Whether two ways meet: they end in the same arm, or cross. Around the circle every arm has its way in before
    /// its way out.
    fn meets(self, other: Self) -> bool {
        let (a, b) = (2 * self.from, 2 * self.to + 1);
        let inside = |point: usize| (a.min(b)..a.max(b)).contains(&point);
        let crosses = inside(2 * other.from) != inside(2 * other.to + 1);
        self.from != other.from && (self.to == other.to || crosses)
    }
}

/// Returns what is wrong with states of which every link keeps to the limits by itself: those of two rings, where a
/// green of one ring lasts while those of the other change.
///
/// `may_meet` says of two links whether the network has vehicles of theirs meet.
pub(crate) fn violations_by_link(
    states: &[String],
    ways: &[Way],
    may_meet: &dyn Fn(usize, usize) -> bool,
    limits: &Limits,
) -> Vec<String> {
    let at = |second: usize, link: usize| states[second].as_bytes()[link];
    let (end, links) = (states.len(), 0..ways.len());
    let mut wrong = Vec::new();
    for link in links.clone() {
        let way = ways[link];
        let meets = |other: &usize| way.meets(ways[*other]) && may_meet(link, *other);
        let foes: Vec<usize> = links.clone().filter(meets).collect();
        let mut began = None;
        for second in 1..end {
            let (before, now) = (at(second - 1, link), at(second, link));
            for &foe in &foes {
                let other = at(second, foe);
                if now == b'G' && other == b'G' {
                    wrong.push(format!("{second} s: links {link} and {foe} have right of way"));
                }
                if now == b'g' && is_green(other) && way.is_through() {
                    wrong.push(format!("{second} s: link {link} is green beside {foe}"));
                }
                if now == b'y' && is_green(other) && way.is_left() && ways[foe].is_through() {
                    wrong.push(format!("{second} s: yellow of {link} beside the green of {foe}"));
                }
                if is_green(now) && !is_green(before) && other == b'r' {
                    let dark = (0..second).rev().take_while(|s| at(*s, foe) == b'r').count();
                    if dark < limits.all_red {
                        wrong.push(format!("{second} s: link {link} begins {dark} s after {foe}"));
                    }
                }
                if is_green(now) && !is_green(before) && other == b'y' {
                    wrong.push(format!("{second} s: link {link} begins in the yellow of {foe}"));
                }
            }
            // Without all-red the next phase may let a left turn yield at once.
            let yields_at_once = now == b'g' && limits.all_red == 0;
            if before == b'y' && is_green(now) && !yields_at_once {
                wrong.push(format!("{second} s: link {link} goes from yellow to green"));
            }
            if is_green(now) && !is_green(before) {
                began = Some(second);
            }
            if is_green(before) && !is_green(now) {
                let yellow = (second..end).take_while(|s| at(*s, link) == b'y').count();
                if yellow < limits.yellow && second + yellow < end {
                    wrong.push(format!("{second} s: link {link} has {yellow} s of yellow"));
                }
                let least = if way.is_through() { limits.min_through } else { limits.min_left };
                let length = second - began.unwrap_or(0);
                // The first green of an episode began before it.
                if began.is_some() && length < least {
                    wrong.push(format!(
                        "{second} s: link {link} was green for {length} s, not {least}"
                    ));
                }
                if way.is_through() && length > limits.max_green {
                    wrong.push(format!("{second} s: link {link} was green for {length} s"));
                }
            }
        }
    }
    wrong
}
