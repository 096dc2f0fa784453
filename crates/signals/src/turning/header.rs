//! What the columns of a count table hold, by their names.

pub use crate::vocabulary::Heading;

/// Where vehicles go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Towards {
    /// To the left.
    Left,
    /// Straight on.
    Through,
    /// To the right.
    Right,
    /// Back.
    UTurn,
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// Vehicles of a movement.
    Vehicles(Heading, Towards),
    /// Heavy vehicles of a movement, beside a column of its cars.
    HeavyVehicles(Heading, Towards),
    /// Heavy vehicles of an approach, percent.
    HeavyPercent(Heading),
    /// The sum of an approach.
    Total(Heading),
    /// People who cross the approach from which vehicles travel so; `None`: any approach of the intersection.
    Pedestrians(Option<Heading>),
    /// Vehicles of several turns of an approach, which cannot be told apart.
    Shared(Heading),
    /// The intersection.
    Intersection,
    /// A date.
    Date,
    /// A time, or date and time.
    Time,
    /// The end of an interval.
    End,
}

/// Names of headings, longest first, so that none is taken for the start of another. A single letter is none: `N` is
/// northbound for some and the northern leg for others.
const HEADINGS: [(&str, Heading); 28] = [
    ("NORTHEASTBOUND", Heading::NorthEast),
    ("NORTHWESTBOUND", Heading::NorthWest),
    ("SOUTHEASTBOUND", Heading::SouthEast),
    ("SOUTHWESTBOUND", Heading::SouthWest),
    ("NORTHBOUND", Heading::North),
    ("SOUTHBOUND", Heading::South),
    ("EASTBOUND", Heading::East),
    ("WESTBOUND", Heading::West),
    ("NEBOUND", Heading::NorthEast),
    ("NWBOUND", Heading::NorthWest),
    ("SEBOUND", Heading::SouthEast),
    ("SWBOUND", Heading::SouthWest),
    ("NBOUND", Heading::North),
    ("SBOUND", Heading::South),
    ("EBOUND", Heading::East),
    ("WBOUND", Heading::West),
    ("NEB", Heading::NorthEast),
    ("NWB", Heading::NorthWest),
    ("SEB", Heading::SouthEast),
    ("SWB", Heading::SouthWest),
    ("NB", Heading::North),
    ("SB", Heading::South),
    ("EB", Heading::East),
    ("WB", Heading::West),
    ("NE", Heading::NorthEast),
    ("NW", Heading::NorthWest),
    ("SE", Heading::SouthEast),
    ("SW", Heading::SouthWest),
];

/// Legs of an intersection with the heading of the traffic that comes from them.
const LEGS: [(&str, Heading); 8] = [
    ("NORTHEAST", Heading::SouthWest),
    ("NORTHWEST", Heading::SouthEast),
    ("SOUTHEAST", Heading::NorthWest),
    ("SOUTHWEST", Heading::NorthEast),
    ("NORTH", Heading::South),
    ("SOUTH", Heading::North),
    ("EAST", Heading::West),
    ("WEST", Heading::East),
];

/// Names of turns. A second left or right, such as `NBL2`, is one of several exits on that side.
const TURNS: [(&str, Towards); 31] = [
    ("L", Towards::Left),
    ("L2", Towards::Left),
    ("LT", Towards::Left),
    ("LEFT", Towards::Left),
    ("LEFTS", Towards::Left),
    ("LEFTTURN", Towards::Left),
    ("LEFTTURNS", Towards::Left),
    ("BEARLEFT", Towards::Left),
    ("HARDLEFT", Towards::Left),
    ("T", Towards::Through),
    ("STRAIGHTTHROUGH", Towards::Through),
    ("GOINGSTRAIGHT", Towards::Through),
    ("TH", Towards::Through),
    ("THR", Towards::Through),
    ("THRU", Towards::Through),
    ("THROUGH", Towards::Through),
    ("STRAIGHT", Towards::Through),
    ("R", Towards::Right),
    ("R2", Towards::Right),
    ("RT", Towards::Right),
    ("RIGHT", Towards::Right),
    ("RIGHTS", Towards::Right),
    ("RIGHTTURN", Towards::Right),
    ("RIGHTTURNS", Towards::Right),
    ("BEARRIGHT", Towards::Right),
    ("HARDRIGHT", Towards::Right),
    ("U", Towards::UTurn),
    ("UT", Towards::UTurn),
    ("UTURN", Towards::UTurn),
    ("UTURNS", Towards::UTurn),
    ("UTRN", Towards::UTurn),
];

/// Names of several turns in one column.
const SHARED: [&str; 8] =
    ["TR", "THRURIGHT", "THROUGHRIGHT", "LTR", "THRULEFT", "THROUGHLEFT", "LEFTTHRU", "LR"];

/// Names of percentages of heavy vehicles.
const HEAVY: [&str; 5] = ["HV", "PHV", "HVPCT", "HVPERCENT", "HEAVYVEHICLESPERCENT"];

/// The same where the name has a percent sign.
const HEAVY_WITH_SIGN: [&str; 6] =
    ["HV", "HEAVY", "HEAVYVEHICLES", "TRUCK", "TRUCKS", "HEAVYTRUCKS"];

/// Names of columns of pedestrians. Those of both directions (clockwise and counterclockwise) are added.
const PEDESTRIANS: [&str; 14] = [
    "PED", "PEDS", "PEDESTRIAN", "PEDESTRIANS", "PEDTOTAL", "PEDSTOTAL", "PEDSCW", "PEDSCCW",
    "PEDCW", "PEDCCW", "PEDCROSSING", "PEDCROSSINGS", "PEDSCROSSWALK", "CROSSWALK",
];

/// What columns count that are no vehicles of a turn.
const OTHERS: [&str; 15] = [
    "PED", "BIKE", "BICYC", "CROSS", "XWALK", "WALK", "CW", "TOTAL", "PHF", "SPEED", "LANE",
    "STREET", "NAME", "PERCENT", "PCT",
];

/// Names of columns with the end of an interval.
const ENDS: [&str; 8] = [
    "END", "ENDTIME", "TIMEEND", "PERIODEND", "PERIODENDING", "INTERVALEND", "ENDING", "COUNTTIME",
];

/// Names of the column with the sum of an approach.
const TOTAL: [&str; 3] = ["TOTAL", "APPTOTAL", "APPROACHTOTAL"];

/// Classes of vehicles before a turn, and whether they are heavy.
const CLASSES: [(&str, bool); 9] = [
    ("CARS", false),
    ("CAR", false),
    ("LIGHTS", false),
    ("TRUCKS", true),
    ("TRUCK", true),
    ("BUSES", true),
    ("BUS", true),
    ("HEAVY", true),
    ("HV", true),
];

/// Names of the column with the intersection.
///
/// Of several such columns the first of these counts.
const INTERSECTION: [&str; 13] = [
    "INTID", "INT", "INTERSECTION", "INTERSECTIONID", "INTERSECTIONNAME", "NODE", "NODEID",
    "SIGNAL", "SIGNALID", "LOCATION", "LOCATIONID", "SITE", "ID",
];

/// Names of the column with the date.
const DATE: [&str; 4] = ["DATE", "DAY", "COUNTDATE", "STARTDATE"];

/// Names of the column with the time at which an interval begins.
const TIME: [&str; 13] = [
    "TIME", "STARTTIME", "TIMESTART", "BEGIN", "BEGINTIME", "START", "HOUR", "INTERVAL",
    "INTERVALSTART", "TIMEPERIOD", "TIMESTAMP", "DATETIME", "DATETIMEBIN",
];

/// Returns what a column of this name holds; `None` for one that is not used.
pub fn holds(name: &str) -> Option<Holds> {
    let percent = name.contains('%');
    let mut plain: String =
        name.to_uppercase().chars().filter(char::is_ascii_alphanumeric).collect();
    if INTERSECTION.contains(&&*plain) {
        return Some(Holds::Intersection);
    }
    if TIME.contains(&&*plain) {
        return Some(Holds::Time);
    }
    if ENDS.contains(&&*plain) {
        return Some(Holds::End);
    }
    if DATE.contains(&&*plain) {
        return Some(Holds::Date);
    }
    for word in ["VOLUME", "VOL", "COUNT"] {
        if let Some(rest) = plain.strip_suffix(word) {
            plain = rest.to_owned();
        }
    }
    if PEDESTRIANS[..4].contains(&&*plain) {
        return Some(Holds::Pedestrians(None));
    }
    let (heading, rest) = direction(&plain)?;
    if PEDESTRIANS.contains(&rest) && !percent {
        return Some(Holds::Pedestrians(Some(heading)));
    }
    if HEAVY.contains(&rest) || percent && HEAVY_WITH_SIGN.contains(&rest) {
        return Some(Holds::HeavyPercent(heading));
    }
    if percent {
        return None;
    }
    if TOTAL.contains(&rest) {
        return Some(Holds::Total(heading));
    }
    if SHARED.contains(&rest) {
        return Some(Holds::Shared(heading));
    }
    let turn = |rest: &str| TURNS.iter().find(|(name, _)| *name == rest).map(|(_, turn)| *turn);
    if let Some(towards) = turn(rest) {
        return Some(Holds::Vehicles(heading, towards));
    }
    CLASSES.iter().find_map(|(class, is_heavy)| {
        let towards = turn(rest.strip_prefix(class)?)?;
        Some(match is_heavy {
            true => Holds::HeavyVehicles(heading, towards),
            false => Holds::Vehicles(heading, towards),
        })
    })
}

/// Returns the place of a column's name among those of the intersection; the least counts.
pub(super) fn rank_of_id(name: &str) -> usize {
    let plain: String = name.to_uppercase().chars().filter(char::is_ascii_alphanumeric).collect();
    INTERSECTION.iter().position(|known| *known == plain).unwrap_or(INTERSECTION.len())
}

/// Returns whether a column that nobody understands may count vehicles: it names a direction and nothing else that is
/// counted.
pub(super) fn may_be_movement(name: &str) -> bool {
    let words: Vec<String> = name
        .to_uppercase()
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_owned)
        .collect();
    let plain = words.concat();
    if name.contains('%') || OTHERS.iter().any(|other| plain.contains(other)) {
        return false;
    }
    // Two letters alone begin many words.
    let is_direction = |word: &str| {
        HEADINGS.iter().any(|(name, _)| *name == word && (name.len() > 2 || name.ends_with('B')))
    };
    let short = words.first().is_some_and(|word| {
        word.len() <= 5
            && ["NB", "SB", "EB", "WB"].iter().any(|direction| word.starts_with(direction))
    });
    words.len() > 1 && words.iter().any(|word| is_direction(word)) || short && plain.len() > 2
}

/// Returns the direction of travel that a name begins with, and the rest of the name.
fn direction(plain: &str) -> Option<(Heading, &str)> {
    // Before it may be the name of the street.
    let leg = plain.rfind("FROM").map(|at| &plain[at + "FROM".len()..]);
    for (name, heading) in LEGS {
        if let Some(rest) = leg.and_then(|leg| leg.strip_prefix(name)) {
            return Some((heading, rest));
        }
        let rest = plain.strip_prefix(name);
        let of_leg = rest
            .and_then(|rest| ["APPROACH", "LEG"].iter().find_map(|word| rest.strip_prefix(word)));
        if let Some(rest) = of_leg {
            return Some((heading, rest));
        }
    }
    HEADINGS.iter().find_map(|(prefix, heading)| Some((*heading, plain.strip_prefix(prefix)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_movements_are_understood_as_people_write_them() {
        use Heading::{East, North, NorthEast, South, West};
        use Towards::{Left, Right, Through, UTurn};
        for (name, heading, towards) in [
            ("NBL", North, Left),
            ("nbt", North, Through),
            ("SB Thru", South, Through),
            ("Eastbound Left", East, Left),
            ("EB_RT", East, Right),
            ("WBU", West, UTurn),
            ("WB U-Turn", West, UTurn),
            ("NBL2", North, Left),
            ("NEL", NorthEast, Left),
            ("SBL Vol", South, Left),
            ("Northbound-Through", North, Through),
            ("Northbound - Thru", North, Through),
            ("From North Left", South, Left),
            ("East Approach Right", West, Right),
            ("sb_cars_r", South, Right),
            ("SB Straight Through", South, Through),
        ] {
            assert_eq!(holds(name), Some(Holds::Vehicles(heading, towards)), "{name}");
        }
        assert_eq!(holds("NB HV %"), Some(Holds::HeavyPercent(North)));
        assert_eq!(
            (holds("NB Trucks"), holds("NB Trucks %")),
            (None, Some(Holds::HeavyPercent(North)))
        );
        assert_eq!(holds("Main St From North Left"), Some(Holds::Vehicles(South, Left)));
        assert_eq!(holds("WBHV"), Some(Holds::HeavyPercent(West)));
        assert_eq!(holds("nb_bus_l"), Some(Holds::HeavyVehicles(North, Left)));
        assert_eq!(holds("Westbound App. Total"), Some(Holds::Total(West)));
        assert_eq!(holds("SBTR"), Some(Holds::Shared(South)));
        for name in ["NBPED", "NB Peds", "Northbound Pedestrians", "South Leg Peds CW"] {
            assert_eq!(holds(name), Some(Holds::Pedestrians(Some(North))), "{name}");
        }
        assert_eq!(holds("PED"), Some(Holds::Pedestrians(None)));
        assert_eq!(holds("Signal ID"), Some(Holds::Intersection));
        assert_eq!(holds("Start Time"), Some(Holds::Time));
    }

    #[test]
    fn columns_that_may_count_vehicles_are_told_from_others() {
        for name in
            ["NB Left Cars", "Thru NB", "NBL1", "NB Trucks", "NBR RTOR", "Northbound Lefts on red"]
        {
            assert!(holds(name).is_none() && may_be_movement(name), "{name}");
        }
        for name in [
            "NB Peds", "SB Peds CW", "WB % App", "Notes", "News", "Weather", "EB App. Total",
            "Session",
        ] {
            assert!(!may_be_movement(name), "{name}");
        }
    }

    #[test]
    fn what_is_no_movement_is_not_taken_for_one() {
        for name in [
            "NB", "NBPED %", "Int. Total", "PED button", "NR", "N_CARS_R", "North", "Notes",
            "NBL %", "West Leg", "E",
        ] {
            assert_eq!(holds(name), None, "{name}");
        }
    }
}
