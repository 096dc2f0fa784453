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
    /// SUMO does not get it either, and its user is told: what it would have done.
    Dropped(&'static str),
    /// It stands in the way until its user accepts what is done instead: what is wrong, and what to accept.
    Refused(&'static str, Accept),
}

/// Short names of options, each before its long one.
const SHORT: &str = "n net-file net net-file r route-files routes route-files a additional-files \
    additional additional-files w weight-files weights weight-files b begin e end s route-steps \
    x weight-attribute measure weight-attribute";

/// Options that are lists of files.
const FILES: [&str; 4] = ["net-file", "route-files", "additional-files", "weight-files"];

/// Options that shape traffic.
const USED: &str = include_str!("options/used.txt");

/// Options that write, print or show, or that are decided by whoever starts SUMO.
const LEFT_OUT: &str = include_str!("options/left_out.txt");

/// What writes a file that is named like this, with its own options behind a point.
const OUTPUT: &str = "-output";

/// Options that are left out with a warning, by how they begin, and what they would have done.
const DROPPED: [(&str, &str); 4] = [
    (
        "remote-port num-clients pedestrian.remote",
        "nothing connects, and SUMO waits for nobody; what another program would steer stays as it is",
    ),
    ("pedestrian.jupedsim.wkt pedestrian.jupedsim.py", "it would write a file"),
    (
        "configuration-file astar phemlight selection-file",
        "one configuration is read, this one, and no emissions; tables and selections change no result",
    ),
    ("device.tripinfo", "the delay of every vehicle counts"),
];

/// Options that stand in the way, by how they begin, why, and what to accept.
const REFUSED: [(&str, &str, Accept); 2] = [
    (
        "load-state",
        "a saved state is read by no controller and hashed by no run, so the streets would be empty at the start",
        Accept::EmptyStart,
    ),
    (
        "device.fcd-replay.files alternative-net-file",
        "vehicles that follow a record take no notice of signals, and only the first network is read, so it would be left \
         out",
        Accept::UnknownOptions,
    ),
];

/// What is said of an option that nobody has looked at.
const UNKNOWN: &str = "it is none that is known to be safe and to shape traffic (is it spelt right?), so it would be left out";

/// Values that are false for SUMO.
///
/// Source: SUMO 1.15, `StringUtils::toBool`.
const FALSE: [&str; 6] = ["0", "no", "false", "off", "-", "f"];

/// Returns the value that an option that is [used](Kind::Used) has in place of its own, and why; `None` where it keeps
/// its own.
pub fn replaced(name: &str, value: &str) -> Option<(&'static str, &'static str)> {
    let value = value.trim().to_lowercase();
    let number = value.parse::<f64>().ok();
    let is_negative = number.is_some_and(|value| value < 0.0);
    let is_false = FALSE.contains(&value.as_str());
    let (applies, other, why) = match name {
        "max-depart-delay" => {
            (!is_negative, "-1", "it leaves vehicles that wait to enter out of the delay")
        }
        "max-num-teleports" => (!is_negative, "-1", "it ends a simulation early"),
        "time-to-teleport.remove" => {
            (!is_false, "false", "it ends the delay of vehicles that stand")
        }
        "time-to-teleport.highways" => {
            (number.is_none_or(|value| value > 0.0), "0", "it moves vehicles that stand")
        }
        "time-to-teleport.disconnected" => (!is_negative, "-1", "it moves vehicles that stand"),
        "collision.action" | "intermodal-collision.action" => {
            (value == "remove", "warn", "it ends the delay of vehicles that collide")
        }
        "pedestrian.model" => {
            (value == "remote", "striping", "it would connect to another program")
        }
        "mesosim" => (!is_false, "false", "the mesoscopic model has no lanes and no queues to see"),
        "tls.all-off" => (!is_false, "false", "it switches all signals off"),
        _ => return None,
    };
    applies.then_some((other, why))
}

/// Returns what has to be accepted before an option gets its [other value](replaced); `None` where a warning is enough.
pub fn to_accept(name: &str) -> Option<Accept> {
    match name {
        "mesosim" => Some(Accept::Microscopic),
        "tls.all-off" => Some(Accept::SignalsOn),
        _ => None,
    }
}

/// Whether a value of the validation of XML is another than the one that counts.
pub fn validates(name: &str, value: &str) -> bool {
    let is_validation = name == "X" || name.starts_with("xml-validation");
    is_validation && !["never", "auto", "local"].contains(&value.trim().to_lowercase().as_str())
}

/// Returns the long name of an option, where it has a short one that counts here.
pub fn long(name: &str) -> &str {
    let mut words = SHORT.split_whitespace();
    while let (Some(short), Some(long)) = (words.next(), words.next()) {
        if short == name {
            return long;
        }
    }
    name
}

/// Returns what is done with an option, given its long name.
pub fn kind(name: &str) -> Kind {
    let among = |list: &str| list.split_whitespace().any(|known| known == name);
    if FILES.contains(&name) {
        return Kind::Files;
    }
    if among(USED) {
        return Kind::Used;
    }
    let is_output =
        name.split_once(OUTPUT).is_some_and(|(_, own)| own.is_empty() || own.starts_with('.'));
    if is_output || among(LEFT_OUT) {
        return Kind::LeftOut;
    }
    let begins = |starts: &str| starts.split_whitespace().any(|start| name.starts_with(start));
    if let Some((_, why)) = DROPPED.iter().find(|(starts, _)| begins(starts)) {
        return Kind::Dropped(why);
    }
    let known = REFUSED.iter().find(|(starts, ..)| begins(starts));
    let (_, why, accept) = known.unwrap_or(&("", UNKNOWN, Accept::UnknownOptions));
    Kind::Refused(why, *accept)
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
            assert!(matches!(kind(dropped), Kind::Dropped(_)), "{dropped}");
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
            ("max-num-teleports", "-1", &["0", "9"], &["-1"]),
            ("time-to-teleport.remove", "false", &["true", "1", "x"], &["false", "OFF", "0"]),
            ("time-to-teleport.highways", "0", &["60"], &["0", "-1"]),
            ("collision.action", "warn", &["remove"], &["teleport", "warn", "none"]),
            ("intermodal-collision.action", "warn", &["remove"], &["warn"]),
            ("pedestrian.model", "striping", &["remote"], &["nonInteracting"]),
            ("max-num-vehicles", "", &[], &["20"]),
        ] {
            assert_eq!(kind(name), Kind::Used);
            for value in replaced_ones {
                assert_eq!(replaced(name, value).map(|r| r.0), Some(other), "{name}={value}");
                // What comes in its place is fine.
                assert_eq!(replaced(name, other), None, "{name}={other}");
            }
            assert!(fine.iter().all(|value| replaced(name, value).is_none()), "{name}");
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
