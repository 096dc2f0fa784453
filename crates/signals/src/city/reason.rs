//! Why a signal of the map is no intersection of the family: the map's reasons, and what building adds.

use std::cmp::Ordering;

use osm_signals::intersections::Skip;
use serde::Serialize;

/// Why a signal is no intersection of the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// No two streams need green at different times, so there is nothing to control.
    OneGreen,
    /// No sound network can be built for it.
    NoNetwork,
    /// It is none on the map, or not one that was asked for.
    #[serde(untagged)]
    Map(Skip),
}

impl Reason {
    /// Returns the reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Map(skip) => skip.reason(),
            Self::OneGreen => "a single green",
            Self::NoNetwork => "no sound network can be built",
        }
    }

    /// Says what to do where it leaves no intersection.
    ///
    /// # Arguments
    ///
    /// * `covered` — where the extract lies.
    pub(super) fn way_out(self, covered: Option<String>) -> String {
        let way_out = match self {
            Self::Map(Skip::Border) => {
                "give an extract that reaches some hundred metres beyond the signals"
            }
            Self::Map(Skip::OutsideBoundary) => match covered {
                Some(extent) => {
                    return format!("give another --boundary: the extract covers {extent}");
                }
                None => "give another --boundary",
            },
            Self::Map(Skip::NotListed) => "check the places in the signal list",
            Self::NoNetwork => "see the reasons above",
            Self::Map(Skip::ManyArms | Skip::ManyLanes | Skip::FewArms | Skip::FewApproaches) => {
                "look at them on the map, and correct the map or [intersections] in the settings"
            }
            Self::Map(_) | Self::OneGreen => "see which nodes have highway=traffic_signals",
        };
        way_out.to_owned()
    }

    /// Returns the place among the reasons: of the map's after which it comes, and whether it does.
    fn rank(self) -> (Skip, bool) {
        match self {
            Self::Map(skip) => (skip, false),
            Self::OneGreen => (Skip::Crossing, true),
            Self::NoNetwork => (Skip::NotListed, true),
        }
    }
}

impl Ord for Reason {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank().cmp(&other.rank())
    }
}

impl PartialOrd for Reason {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_of_building_have_their_place_among_those_of_the_map() {
        let mut reasons = [
            Reason::NoNetwork,
            Reason::Map(Skip::NotListed),
            Reason::Map(Skip::Roundabout),
            Reason::OneGreen,
            Reason::Map(Skip::Crossing),
        ];
        reasons.sort();
        let json = serde_json::to_string(&reasons).unwrap();
        assert_eq!(json, r#"["crossing","one_green","roundabout","not_listed","no_network"]"#);
    }
}
