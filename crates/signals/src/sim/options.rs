//! Which options of somebody's SUMO configuration are used, which are left out, and which stand in the way.
//!
//! SUMO is never given the configuration itself, only the options that are known here to shape traffic and
//! to touch no file but the ones that are hashed. What SUMO would only write is left out; what would open a
//! connection or read what nobody hashes is left out with a warning. An option that nobody has looked at stands in the
//! way until its user says that it may go.
//!
//! Methods are compared on the same vehicles. So an option that ends the trips of vehicles that wait, stand or
//! collide gets [another value](replaced), with a warning: how many those are depends on the method. One that only
//! delays vehicles (`max-num-vehicles`) is used, because their delay counts, and so is one that leaves the same
//! vehicles out for every method (`scale`).
//!
//! Source: `sumo --save-template` of SUMO 1.15 with its synonyms, and of SUMO 1.28.

use super::obstacle::Accept;

/// What is done with an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// SUMO gets it; it shapes traffic and names no file.
    Used,
    /// A list of files that are hashed.
    Files,
    /// SUMO does not get it: it writes, prints, shows, or is decided elsewhere.
    LeftOut,
    /// SUMO does not get it either, and its user is told.
    Dropped,
    /// It stands in the way until its user accepts what is done instead: what is wrong, and what to accept.
    Refused(&'static str, Accept),
}

/// Short names of options.
const SHORT: [(&str, &str); 13] = [
    ("n", "net-file"),
    ("net", "net-file"),
    ("r", "route-files"),
    ("routes", "route-files"),
    ("a", "additional-files"),
    ("additional", "additional-files"),
    ("w", "weight-files"),
    ("weights", "weight-files"),
    ("b", "begin"),
    ("e", "end"),
    ("s", "route-steps"),
    ("x", "weight-attribute"),
    ("measure", "weight-attribute"),
];

/// Options that are lists of files.
const FILES: [&str; 4] = ["net-file", "route-files", "additional-files", "weight-files"];

/// Options that shape traffic.
const USED: &str = include_str!("options/used.txt");

/// Options that write, print or show, or that are decided by whoever starts SUMO.
const LEFT_OUT: &str = include_str!("options/left_out.txt");

/// What writes a file that is named like this, with its own options behind a point.
const OUTPUT: &str = "-output";

/// How options begin that would connect to another program, read what nobody hashes, or leave vehicles out of `tripinfo`.
const DROPPED: [&str; 10] = [
    "remote-port", "num-clients", "pedestrian.remote", "pedestrian.jupedsim.wkt",
    "pedestrian.jupedsim.py", "configuration-file", "astar", "phemlight", "selection-file",
    "device.tripinfo",
];

const SAVED_STATE: &str = "a saved state is read by no controller and hashed by no run, so the streets would be empty at the start";

/// What is said of an option that nobody has looked at.
const UNKNOWN: &str = "it is none that is known to be safe and to shape traffic (is it spelt right?), so it would be left out";

/// Values that are false for SUMO.
///
/// Source: SUMO 1.15, `StringUtils::toBool`.
const FALSE: [&str; 6] = ["0", "no", "false", "off", "-", "f"];

/// Another value that an option gets: its name, the one value that is replaced (empty: every number above the other one, or
/// whatever is not false), what counts instead, why, and what has to be accepted before; `None` where a warning is enough.
pub type Replaced = (&'static str, &'static str, &'static str, &'static str, Option<Accept>);

const REPLACED: [Replaced; 10] = [
    ("max-depart-delay", "", "-1", "it leaves vehicles that wait to enter out of the delay", None),
    ("max-num-teleports", "", "-1", "it ends a simulation early", None),
    ("time-to-teleport.remove", "", "false", "it ends the delay of vehicles that stand", None),
    ("time-to-teleport.highways", "", "0", MOVES, None),
    ("time-to-teleport.disconnected", "", "-1", MOVES, None),
    ("collision.action", "remove", "warn", COLLIDE, None),
    ("intermodal-collision.action", "remove", "warn", COLLIDE, None),
    ("pedestrian.model", "remote", "striping", "it would connect to another program", None),
    ("mesosim", "", "false", MESOSCOPIC, Some(Accept::Microscopic)),
    ("tls.all-off", "", "false", "it switches all signals off", Some(Accept::SignalsOn)),
];

const MOVES: &str = "it moves vehicles that stand";
const COLLIDE: &str = "it ends the delay of vehicles that collide";
const MESOSCOPIC: &str = "the mesoscopic model has no lanes and no queues to see";

/// Returns what an option that is [used](Kind::Used) has in place of its own value; `None` where it keeps that.
pub fn replaced(name: &str, value: &str) -> Option<&'static Replaced> {
    let value = value.trim().to_lowercase();
    let other = REPLACED.iter().find(|other| other.0 == name)?;
    let keeps = match (other.1, other.2.parse::<f64>()) {
        ("", Ok(to)) => value.parse::<f64>().is_ok_and(|value| value <= to),
        ("", Err(_)) => FALSE.contains(&value.as_str()),
        (from, _) => value != from,
    };
    (!keeps).then_some(other)
}

/// Returns the long name of an option, where it has a short one that counts here.
pub fn long(name: &str) -> &str {
    SHORT.iter().find(|(short, _)| *short == name).map_or(name, |(_, long)| long)
}

/// Returns what is done with an option, given its long name.
pub fn kind(name: &str) -> Kind {
    let among = |list: &str| list.split_whitespace().any(|known| known == name);
    let is_output =
        name.split_once(OUTPUT).is_some_and(|(_, own)| own.is_empty() || own.starts_with('.'));
    match name {
        _ if FILES.contains(&name) => Kind::Files,
        _ if among(USED) => Kind::Used,
        _ if is_output || among(LEFT_OUT) => Kind::LeftOut,
        _ if DROPPED.iter().any(|start| name.starts_with(start)) => Kind::Dropped,
        _ if name.starts_with("load-state") => Kind::Refused(SAVED_STATE, Accept::EmptyStart),
        _ => Kind::Refused(UNKNOWN, Accept::UnknownOptions),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_is_used_left_out_or_refused_by_its_name() {
        let kinds =
            ["scale", "route-files", "fcd-output", "fcd-output.geo", "edgedata-output", "seed"];
        assert_eq!(
            kinds.map(kind),
            [Kind::Used, Kind::Files, Kind::LeftOut, Kind::LeftOut, Kind::LeftOut, Kind::LeftOut]
        );
        for dropped in ["remote-port", "astar.all-distances", "device.tripinfo.probability"] {
            assert_eq!(kind(dropped), Kind::Dropped, "{dropped}");
        }
        for refused in ["load-state.offset", "python-script", "include", "new-outputs"] {
            assert!(matches!(kind(refused), Kind::Refused(..)), "{refused}");
        }
        assert_eq!(
            ["n", "routes", "b", "scale"].map(long),
            ["net-file", "route-files", "begin", "scale"]
        );
    }

    #[test]
    fn what_ends_trips_depending_on_the_method_gets_another_value() {
        for (name, other, replaced_ones, fine) in [
            ("max-depart-delay", "-1", &["20", "0", "0:10:00"][..], &["-1", " -1.0 "][..]),
            ("mesosim", "false", &["true", "1"], &["false"]),
            ("time-to-teleport.remove", "false", &["true", "1", "x"], &["false", "OFF", "0"]),
            ("time-to-teleport.highways", "0", &["60"], &["0", "-1"]),
            ("collision.action", "warn", &["remove"], &["teleport", "warn", "none"]),
            ("pedestrian.model", "striping", &["remote"], &["nonInteracting"]),
            ("max-num-vehicles", "", &[], &["20"]),
        ] {
            for value in replaced_ones {
                assert_eq!(replaced(name, value).map(|r| r.2), Some(other), "{name}={value}");
            }
            assert!(fine.iter().all(|value| replaced(name, value).is_none()), "{name}");
        }
        for (name, _, other, ..) in &REPLACED {
            assert_eq!((kind(name), replaced(name, other)), (Kind::Used, None), "{name}");
        }
    }

    #[test]
    fn no_option_is_in_two_lists() {
        let all: Vec<&str> = USED.split_whitespace().chain(LEFT_OUT.split_whitespace()).collect();
        let mut once = all.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), all.len());
        assert!(all.iter().all(|name| long(name) == *name && !FILES.contains(name)));
    }
}
