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
    /// Heavy vehicles of an approach, which its turns contain.
    HeavyCount(Heading),
    /// Heavy vehicles of an approach: a number or percent, which cannot be told.
    HeavyUnclear(Heading),
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
    /// A date or time in universal time.
    UniversalTime,
    /// The zone of the times.
    Zone,
    /// The end of an interval.
    End,
}

impl Holds {
    /// Returns the direction of travel of what it counts; `None` for what has none.
    pub(super) fn heading(self) -> Option<Heading> {
        match self {
            Self::Vehicles(heading, _)
            | Self::HeavyVehicles(heading, _)
            | Self::HeavyPercent(heading)
            | Self::HeavyCount(heading)
            | Self::HeavyUnclear(heading)
            | Self::Total(heading)
            | Self::Shared(heading) => Some(heading),
            Self::Pedestrians(heading) => heading,
            Self::Intersection
            | Self::Date
            | Self::Time
            | Self::UniversalTime
            | Self::Zone
            | Self::End => None,
        }
    }
}

/// Directions with their letters, diagonal ones first, so that none is taken for the start of another.
const DIRECTIONS: [(&str, &str, Heading); 8] = [
    ("NORTHEAST", "NE", Heading::NorthEast),
    ("NORTHWEST", "NW", Heading::NorthWest),
    ("SOUTHEAST", "SE", Heading::SouthEast),
    ("SOUTHWEST", "SW", Heading::SouthWest),
    ("NORTH", "N", Heading::North),
    ("SOUTH", "S", Heading::South),
    ("EAST", "E", Heading::East),
    ("WEST", "W", Heading::West),
];

/// Names of turns. A second left or right, such as `NBL2`, is one of several exits on that side.
const TURNS: [(Towards, &str); 4] = [
    (Towards::Left, "L L2 LT LEFT LEFTS LEFTTURN LEFTTURNS BEARLEFT HARDLEFT"),
    (Towards::Through, "T STRAIGHTTHROUGH GOINGSTRAIGHT TH THR THRU THROUGH STRAIGHT"),
    (Towards::Right, "R R2 RT RIGHT RIGHTS RIGHTTURN RIGHTTURNS BEARRIGHT HARDRIGHT"),
    (Towards::UTurn, "U UT UTURN UTURNS UTRN"),
];

/// Names of several turns in one column.
const SHARED: &str = "TR THRURIGHT THROUGHRIGHT LTR THRULEFT THROUGHLEFT LEFTTHRU LR";

/// Names of percentages of heavy vehicles.
const HEAVY: &str = "PHV HVPCT HVPERCENT HEAVYVEHICLESPERCENT";

/// The same where the name has a percent sign; a number where it ends with a word such as `count`.
const HEAVY_WITH_SIGN: &str = "HV HEAVY HEAVYVEHICLES TRUCK TRUCKS HEAVYTRUCKS";

/// Those of them that are unclear without either.
const HEAVY_UNCLEAR: &str = "HV HEAVY HEAVYVEHICLES";

/// Names of columns of pedestrians, of an approach or of any.
const PEDESTRIANS: &str = "PED PEDS PEDESTRIAN PEDESTRIANS";

/// Names of columns of an approach's pedestrians. Those of both directions (clockwise and counterclockwise) are added.
const CROSSING: &str = "PEDTOTAL PEDSTOTAL PEDSCW PEDSCCW PEDCW PEDCCW PEDCROSSING PEDCROSSINGS PEDSCROSSWALK CROSSWALK";

/// What columns count that are no vehicles of a turn.
const OTHERS: &str =
    "PED BIKE BICYC CROSS XWALK WALK CW TOTAL PHF SPEED LANE STREET NAME PERCENT PCT";

/// Names of columns with the end of an interval.
const ENDS: &str = "END ENDTIME TIMEEND PERIODEND PERIODENDING INTERVALEND ENDING COUNTTIME";

/// Names of the column with the sum of an approach.
const TOTAL: &str = "TOTAL APP APPTOTAL APPROACHTOTAL";

/// Classes of vehicles before a turn: light and heavy ones.
const LIGHT_CLASSES: &str = "CARS CAR LIGHTS";
const HEAVY_CLASSES: &str = "TRUCKS TRUCK BUSES BUS HEAVY HV";

/// Classes of heavy vehicles after a turn; `NBL HV` may be a number or percent.
const HEAVY_CLASSES_AFTER: &str = "TRUCKS TRUCK BUSES BUS";

/// What long words contain that begin with a direction and may count vehicles, such as `NBRTOR`.
const COUNTED: &str = "RTOR ONRED TRUCK CARS BUS HEAVY";

/// Names of the column with the intersection.
///
/// Of several such columns the first of these counts.
const INTERSECTION: &str = "INTID INT INTERSECTION INTERSECTIONID INTERSECTIONNAME NODE NODEID SIGNAL SIGNALID LOCATION \
                            LOCATIONID SITE ID";

/// Names of the column with the date.
const DATE: &str = "DATE DAY COUNTDATE STARTDATE";

/// Names of the column with the time at which an interval begins.
const TIME: &str = "TIME STARTTIME TIMESTART BEGIN BEGINTIME START HOUR INTERVAL INTERVALSTART TIMEPERIOD TIMESTAMP \
                    DATETIME DATETIMEBIN";

/// Names of the column with the zone of the times. A column `Zone` may as well name a part of the city.
const ZONE: &str = "TIMEZONE TZ UTCOFFSET GMTOFFSET TIMEOFFSET TIMEZONEOFFSET";

/// What the name of a column with local times may end with, longer ones before those that they end with.
const LOCAL: [&str; 21] = [
    "LOCAL", "CEST", "EEST", "AEST", "AEDT", "AKST", "AKDT", "NZST", "EST", "EDT", "CST", "CDT",
    "MST", "MDT", "PST", "PDT", "HST", "BST", "WET", "CET", "EET",
];

/// Whether a word is one of several with a space between.
fn is_one(words: &str, word: &str) -> bool {
    words.split(' ').any(|known| known == word)
}

/// Returns what a column of this name holds; `None` for one that is not used.
pub fn holds(name: &str) -> Option<Holds> {
    let percent = name.contains('%');
    let mut plain: String =
        name.to_uppercase().chars().filter(char::is_ascii_alphanumeric).collect();
    if is_one(INTERSECTION, &plain) {
        return Some(Holds::Intersection);
    }
    if is_one(ZONE, &plain) {
        return Some(Holds::Zone);
    }
    let (timed, is_universal) = without_zone(&plain);
    if is_one(ENDS, timed) {
        return Some(Holds::End);
    }
    for (names, holds) in [(TIME, Holds::Time), (DATE, Holds::Date)] {
        if is_one(names, timed) {
            return Some(if is_universal { Holds::UniversalTime } else { holds });
        }
    }
    let mut is_number = false;
    for word in ["VOLUME", "VOL", "COUNT"] {
        if let Some(rest) = plain.strip_suffix(word) {
            plain = rest.to_owned();
            is_number = true;
        }
    }
    if is_one(PEDESTRIANS, &plain) {
        return Some(Holds::Pedestrians(None));
    }
    let (heading, rest) = direction(&plain)?;
    if (is_one(PEDESTRIANS, rest) || is_one(CROSSING, rest)) && !percent {
        return Some(Holds::Pedestrians(Some(heading)));
    }
    if is_one(HEAVY, rest) || percent && is_one(HEAVY_WITH_SIGN, rest) {
        return Some(Holds::HeavyPercent(heading));
    }
    if percent {
        return None;
    }
    if is_number && is_one(HEAVY_WITH_SIGN, rest) {
        return Some(Holds::HeavyCount(heading));
    }
    if is_one(HEAVY_UNCLEAR, rest) {
        return Some(Holds::HeavyUnclear(heading));
    }
    if is_one(TOTAL, rest) {
        return Some(Holds::Total(heading));
    }
    if is_one(SHARED, rest) {
        return Some(Holds::Shared(heading));
    }
    let turn =
        |rest: &str| TURNS.iter().find(|(_, names)| is_one(names, rest)).map(|(turn, _)| *turn);
    if let Some(towards) = turn(rest) {
        return Some(Holds::Vehicles(heading, towards));
    }
    let of = |classes: &str| classes.split(' ').find_map(|class| turn(rest.strip_prefix(class)?));
    let after =
        |classes: &str| classes.split(' ').find_map(|class| turn(rest.strip_suffix(class)?));
    let light = of(LIGHT_CLASSES).or_else(|| after(LIGHT_CLASSES));
    if let Some(towards) = light {
        return Some(Holds::Vehicles(heading, towards));
    }
    let towards = of(HEAVY_CLASSES).or_else(|| after(HEAVY_CLASSES_AFTER))?;
    Some(Holds::HeavyVehicles(heading, towards))
}

/// Returns whether the name of a column of vehicles says that they are light ones, such as `NBT Cars`.
pub(super) fn says_light(name: &str) -> bool {
    let name = name.to_uppercase();
    LIGHT_CLASSES.split(' ').any(|class| name.contains(class))
}

/// Returns the name of a column without the zone of its times, and whether that is universal time: `Time (UTC)`, but not
/// `Local Time` or `Time (UTC-7)`.
fn without_zone(plain: &str) -> (&str, bool) {
    let local = LOCAL.iter().find_map(|zone| plain.strip_suffix(zone));
    if let Some(rest) = local.or_else(|| plain.strip_prefix("LOCAL")) {
        return (rest, false);
    }
    for (before, after) in ["UTC", "GMT"].into_iter().filter_map(|zone| plain.split_once(zone)) {
        if before.is_empty() {
            return (after, true);
        }
        if after.chars().all(|c| c.is_ascii_digit()) {
            return (before, after.chars().all(|c| c == '0'));
        }
    }
    (plain, false)
}

/// Returns whether the name of a column says that its times are local.
pub(super) fn says_local(name: &str) -> bool {
    name.to_uppercase().contains("LOCAL")
}

/// Returns the place of a column's name among those of the intersection; the least counts.
pub(super) fn rank_of_id(name: &str) -> usize {
    let plain: String = name.to_uppercase().chars().filter(char::is_ascii_alphanumeric).collect();
    let mut names = INTERSECTION.split(' ');
    names.position(|known| known == plain).unwrap_or(usize::MAX)
}

/// Returns whether the name of a movement may be another word: `Net` is a sum, or northeastbound through traffic.
pub(super) fn may_be_word(name: &str) -> bool {
    let mut words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let first = words.find(|word| !word.is_empty()).unwrap_or_default();
    ["NET", "SET"].iter().any(|word| first.eq_ignore_ascii_case(word))
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
    if name.contains('%') || OTHERS.split(' ').any(|other| plain.contains(other)) {
        return false;
    }
    // Two letters alone begin many words.
    let is_direction = |word: &str| {
        let mut headings = DIRECTIONS.iter().flat_map(|(name, letters, _)| headings(name, letters));
        headings.any(|heading| heading == word && (word.len() > 2 || word.ends_with('B')))
    };
    let is_counted = |word: &str| COUNTED.split(' ').any(|counted| word.contains(counted));
    let short = words.first().is_some_and(|word| {
        (word.len() <= 5 || is_counted(word))
            && ["NB", "SB", "EB", "WB"].iter().any(|direction| word.starts_with(direction))
    });
    words.len() > 1 && words.iter().any(|word| is_direction(word)) || short && plain.len() > 2
}

/// Returns the direction of travel that a name begins with, and the rest of the name.
fn direction(plain: &str) -> Option<(Heading, &str)> {
    // Before it may be the name of the street.
    let leg = plain.rfind("FROM").map(|at| &plain[at + "FROM".len()..]);
    for (name, _, heading) in DIRECTIONS {
        // Traffic comes from a leg.
        let onward = Heading::ALL[(heading as usize + 4) % 8];
        if let Some(rest) = leg.and_then(|leg| leg.strip_prefix(name)) {
            return Some((onward, rest));
        }
        let rest = plain.strip_prefix(name);
        let of_leg = rest
            .and_then(|rest| ["APPROACH", "LEG"].iter().find_map(|word| rest.strip_prefix(word)));
        if let Some(rest) = of_leg {
            return Some((onward, rest));
        }
    }
    DIRECTIONS.iter().find_map(|(name, letters, heading)| {
        let rest = headings(name, letters).find_map(|prefix| plain.strip_prefix(&*prefix))?;
        Some((*heading, rest))
    })
}

/// Returns the names of a heading, longest first. A single letter is none: `N` is northbound for some and the northern leg
/// for others.
fn headings(name: &str, letters: &str) -> impl Iterator<Item = String> {
    let alone = (letters.len() > 1).then(|| letters.to_owned());
    let bound = [format!("{name}BOUND"), format!("{letters}BOUND"), format!("{letters}B")];
    bound.into_iter().chain(alone)
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
            ("NB Left Cars", North, Left),
            ("SBT Lights", South, Through),
        ] {
            assert_eq!(holds(name), Some(Holds::Vehicles(heading, towards)), "{name}");
        }
        assert_eq!(holds("NB HV %"), Some(Holds::HeavyPercent(North)));
        assert_eq!(
            (holds("NB Trucks"), holds("NB Trucks %")),
            (None, Some(Holds::HeavyPercent(North)))
        );
        assert_eq!(holds("Main St From North Left"), Some(Holds::Vehicles(South, Left)));
        assert_eq!(holds("WBHV"), Some(Holds::HeavyUnclear(West)));
        assert_eq!(holds("WB HV count"), Some(Holds::HeavyCount(West)));
        for name in ["nb_bus_l", "NBL Trucks"] {
            assert_eq!(holds(name), Some(Holds::HeavyVehicles(North, Left)), "{name}");
        }
        for name in ["Westbound App. Total", "WB App"] {
            assert_eq!(holds(name), Some(Holds::Total(West)), "{name}");
        }
        assert_eq!(holds("SBTR"), Some(Holds::Shared(South)));
        for name in ["NBPED", "NB Peds", "Northbound Pedestrians", "South Leg Peds CW"] {
            assert_eq!(holds(name), Some(Holds::Pedestrians(Some(North))), "{name}");
        }
        assert_eq!(holds("PED"), Some(Holds::Pedestrians(None)));
        assert_eq!(holds("Signal ID"), Some(Holds::Intersection));
        assert_eq!(holds("Start Time"), Some(Holds::Time));
    }

    #[test]
    fn names_of_times_may_have_a_zone() {
        for name in [
            "Local Time", "Time (Local)", "start_time_local", "Time (MST)", "Time (CEST)",
            "Time (UTC-7)",
        ] {
            assert_eq!(holds(name), Some(Holds::Time), "{name}");
        }
        assert_eq!(holds("Local Date"), Some(Holds::Date));
        for name in ["Time (UTC)", "UTC Time", "Date (UTC)", "timestamp_gmt", "Time (UTC+00:00)"] {
            assert_eq!(holds(name), Some(Holds::UniversalTime), "{name}");
        }
        assert_eq!(holds("End Time (UTC)"), Some(Holds::End));
        for name in ["Time Zone", "TZ", "UTC Offset"] {
            assert_eq!(holds(name), Some(Holds::Zone), "{name}");
        }
    }

    #[test]
    fn columns_that_may_count_vehicles_are_told_from_others() {
        for name in [
            "Thru NB", "NBL1", "NB Trucks", "NBR RTOR", "NBRTOR", "NBL HV",
            "Northbound Lefts on red",
        ] {
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
