//! What is worth a look at an intersection, and why a signal is none.

use serde::Serialize;

/// What is worth a look at an intersection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Flag {
    /// No node is a signal for vehicles: pedestrians cross all of its streets at signals.
    CrossingsOnly,
    /// All of its signals are crossings of pedestrians, too.
    AllCrossings,
    /// The map leaves an approach no way across.
    NoWayAcross,
    /// Two ways of the map are drawn over each other, and the lanes of one of them are counted.
    DrawnTwice,
    /// Its signals are those of one controller by the signal list, though they are far apart.
    OneController,
    /// Ramps along one street that are joined because they are near: they may have several controllers.
    JoinedRamps,
    /// Another signalised intersection is near: both may have one controller.
    NearSignal,
    /// Two neighbouring arms are at a small angle.
    CloseArms,
    /// Five or six arms.
    ManyArms,
    /// An approach of seven or more lanes.
    ManyLanes,
    /// An approach of two or more lanes for right turns only.
    ManyRight,
    /// The map has no signal there, only the list.
    NotOnMap,
    /// Its row in the signal list is far away.
    FarFromList,
    /// The extract ends before the next junction of an approach.
    Cut,
    /// An approach is shorter or longer than the settings allow and was given another length.
    OtherLength,
}

impl Flag {
    /// Returns the flag in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::CrossingsOnly => "known by its crossings only",
            Self::AllCrossings => "all signals are at crossings",
            Self::NoWayAcross => "an approach without a way across",
            Self::DrawnTwice => "two ways over each other, counted once",
            Self::OneController => "joined by the controller in the list",
            Self::JoinedRamps => "ramps joined by distance, perhaps of several controllers",
            Self::NearSignal => {
                "another signal less than 60 m away, perhaps of the same controller"
            }
            Self::CloseArms => "two arms less than 25 degrees apart",
            Self::ManyArms => "five or more arms",
            Self::ManyLanes => "an approach of seven or more lanes",
            Self::ManyRight => "two or more right-only lanes",
            Self::Cut => "cut by the extract",
            Self::OtherLength => "an approach was given another length",
            Self::NotOnMap => "no signal on the map",
            Self::FarFromList => "more than 25 m from its row in the list",
        }
    }
}

/// Why a signal is no intersection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Skip {
    /// It is on no drivable street.
    NotOnStreet,
    /// No junction of streets is within reach, such as at a crossing in mid-block.
    NoJunction,
    /// The extract ends before or at the junction.
    Border,
    /// Its street ends at it, probably because the extract was cut out there.
    EndOfStreet,
    /// It is a pedestrian crossing on one street of a junction, whose other streets have no signal.
    Crossing,
    /// It controls a roundabout.
    Roundabout,
    /// It meters a ramp: only motorways and their ramps meet, and they merge.
    RampMeter,
    /// It stops traffic for trains.
    LevelCrossing,
    /// It stops traffic for vehicles that leave a fire station.
    Emergency,
    /// It stops traffic before a bridge that opens.
    Bridge,
    /// It lets traffic of either direction onto a single lane.
    SingleLane,
    /// It always blinks.
    Beacon,
    /// Fewer than three arms.
    FewArms,
    /// Fewer than two arms lead to the signal.
    FewApproaches,
    /// More than [`MAX_ARMS`](crate::intersections::MAX_ARMS) arms.
    ManyArms,
    /// More than [`MAX_LANES`](crate::intersections::MAX_LANES) lanes in one direction.
    ManyLanes,
    /// Outside the boundary.
    OutsideBoundary,
    /// Not in the signal list.
    NotListed,
}

impl Skip {
    /// Returns the reason in words.
    pub fn reason(self) -> &'static str {
        match self {
            Self::NotOnStreet => "not on a drivable street",
            Self::NoJunction => "no junction within reach",
            Self::Border => "at the border of the extract",
            Self::EndOfStreet => "at the end of a street",
            Self::Crossing => "pedestrian crossing on one street",
            Self::Roundabout => "roundabout",
            Self::RampMeter => "ramp meter",
            Self::LevelCrossing => "level crossing",
            Self::Emergency => "emergency signal",
            Self::Bridge => "movable bridge",
            Self::SingleLane => "single-lane section",
            Self::Beacon => "flashing beacon",
            Self::FewArms => "fewer than three arms",
            Self::FewApproaches => "fewer than two approaches",
            Self::ManyArms => "more than six arms",
            Self::ManyLanes => "more than twelve lanes in one direction",
            Self::OutsideBoundary => "outside the boundary",
            Self::NotListed => "not in the signal list",
        }
    }
}
