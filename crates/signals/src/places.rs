//! Where a family's intersections are, all of them, and the streets around them: what maps and tables
//! of a report show beside the records. It decides no record.

use std::collections::BTreeMap;
use std::path::Path;

use osm_signals::angle::turn_degrees;
use osm_signals::{DrivingSide, Turn};
use serde::{Deserialize, Serialize};

use crate::city::surroundings::{Named, read_names, read_streets};
use crate::existing::{ExistingPlan, PlanPhase};
use crate::family::load::LoadedScenario;
use crate::junction::incoming_edge;
use crate::network::error::NetworkError;
use crate::network::intersection::{IntersectionSpec, intersections};
use crate::network::lanes::layout;
use crate::placed::Placed;
use crate::settings::{Detail, SignalSettings};
use crate::timing::{Approach, Timing, Way};
use crate::vocabulary::{DEFAULT_LANE_WIDTH_M, Heading};
use basics::files::write_atomically;
use basics::hash::sha256;
use basics::units::MPS_PER_MPH;
use evaluation::run::fault::Cause;
use evaluation::store::error::StoreError;
use evaluation::store::manifest::PointRow;
use evaluation::store::{Layout, Remedy};

/// Name of the file in a results directory.
pub const FILE: &str = "places.json";

/// An intersection of the family.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MappedIntersection {
    /// Its id in the table of approaches; empty when that is not known.
    #[serde(default)]
    pub id: String,
    /// Names of its streets; empty when the map has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub streets: Vec<String>,
    /// Degrees.
    pub latitude: f64,
    /// Degrees.
    pub longitude: f64,
    /// Its point MDP, simulated or not.
    pub point: String,
    /// The simulated point MDP that stands for it: its own, or with k-means that of its cluster; `None`
    /// where none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stands: Option<String>,
}

/// Streets of one rank, to be drawn under the intersections.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StreetsOfRank {
    /// 0 for minor ones to 3 for primary ones.
    pub rank: usize,
    /// Lines of longitude and latitude, degrees, as in GeoJSON.
    pub lines: Vec<Vec<[f64; 2]>>,
}

/// A simulated intersection, as it is drawn: on the ground.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnIntersection {
    /// Its point MDP.
    pub point: String,
    /// Its id in the table of approaches.
    pub intersection: String,
    /// Period of the day; empty where there is one only.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub period: String,
    /// Whether traffic keeps to the left.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_left_hand: bool,
    /// Its arms.
    pub arms: Vec<DrawnArm>,
}

/// An arm of an intersection, as it is drawn.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnArm {
    /// Its name.
    pub name: String,
    /// SUMO's id of the edge that leads to the signal.
    pub edge: String,
    /// Direction from the centre, degrees clockwise from north.
    pub bearing_deg: f64,
    /// Turns of each lane to the signal, such as `sr`, from the kerb to the middle of the street: left, straight, right.
    pub lanes: Vec<String>,
    /// Lanes away from the signal.
    pub lanes_out: u32,
    /// Speed limit, miles per hour.
    pub speed_mph: f64,
    /// Length of the left-turn lanes, metres; absent: that of the street.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_storage_m: Option<f64>,
    /// Length of the right-turn lanes, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right_storage_m: Option<f64>,
}

impl DrawnIntersection {
    /// Returns the side that traffic keeps to.
    pub fn side(&self) -> DrivingSide {
        if self.is_left_hand { DrivingSide::Left } else { DrivingSide::Right }
    }

    /// Returns the arms that lead to the signal: its approaches.
    pub fn incoming(&self) -> impl Iterator<Item = &DrawnArm> {
        self.arms.iter().filter(|arm| !arm.lanes.is_empty())
    }

    /// Returns the turns that the lanes of each approach allow, with the position of the approach.
    fn turns(&self) -> impl Iterator<Item = (usize, &DrawnArm, Turn)> {
        let all = [(Turn::Left, 'l'), (Turn::Through, 's'), (Turn::Right, 'r')];
        self.incoming().enumerate().flat_map(move |(approach, arm)| {
            let has = |letter: char| arm.lanes.iter().any(|lane| lane.contains(letter));
            let own = all.into_iter().filter(move |(_, letter)| has(*letter));
            own.map(move |(turn, _)| (approach, arm, turn))
        })
    }

    /// Returns the limits of its signal, with a link for each turn of an approach.
    pub fn timing(&self, settings: &SignalSettings) -> Timing {
        let side = self.side();
        let approach = |arm: &DrawnArm| {
            let plain_lanes = arm.lanes.len() as u32 + arm.lanes_out;
            Approach {
                heading_deg: side.bearing_deg(arm.bearing_deg) + 180.0,
                width_m: DEFAULT_LANE_WIDTH_M * f64::from(plain_lanes),
                plain_lanes,
                speed_mps: arm.speed_mph * MPS_PER_MPH,
            }
        };
        let way = |(approach, _, turn): (usize, &DrawnArm, Turn)| {
            let (left, right) = side.swapped((Turn::Left, Turn::Right));
            let turn = match turn {
                Turn::Left => left,
                Turn::Right => right,
                through => through,
            };
            vec![Way { approach, turn }]
        };
        let links = self.turns().map(way).collect();
        Timing::new(settings, self.incoming().map(approach).collect(), links)
    }

    /// Returns per phase of a plan that was placed the state in which its links are green, and no other.
    pub fn states(&self, plan: &ExistingPlan) -> Vec<String> {
        let is_green = |phase: &PlanPhase, arm: &DrawnArm, turn: Turn| {
            phase.all_movements().any(|name| {
                let comes = |(from, _): &(String, String)| *from == arm.edge;
                let way = Heading::of_movement(name, self.side());
                way.is_some_and(|way| way.1 == turn)
                    && plan.ways.get(name).is_some_and(|ways| ways.iter().any(comes))
            })
        };
        let state = |phase: &PlanPhase| {
            let letters = self.turns().map(|(_, arm, turn)| is_green(phase, arm, turn));
            letters.map(|is_green| if is_green { 'G' } else { 'r' }).collect()
        };
        plan.phases.iter().map(state).collect()
    }
}

impl DrawnArm {
    /// Returns the length of a lane that only a turn uses and that is shorter than the street, metres.
    pub fn bay_m(&self, lane: usize) -> Option<f64> {
        match self.lanes.get(lane)?.as_str() {
            "l" => self.left_storage_m,
            "r" => self.right_storage_m,
            _ => None,
        }
    }
}

/// Where a family's intersections are.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Places {
    /// All intersections, in the order of the table of approaches.
    pub intersections: Vec<MappedIntersection>,
    /// Streets, minor ones first; empty when there is no map.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub streets: Vec<StreetsOfRank>,
    /// The simulated intersections with arms of their own, as they are drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawings: Vec<DrawnIntersection>,
}

impl Places {
    /// Returns what a manifest says of places, for results from before they were kept: those of the
    /// simulated point MDPs, without names.
    pub fn of_points(points: &[PointRow]) -> Self {
        let place = |point: &PointRow, [latitude, longitude]: [f64; 2]| MappedIntersection {
            latitude,
            longitude,
            point: point.point.clone(),
            stands: Some(point.point.clone()),
            ..MappedIntersection::default()
        };
        let mut intersections = Vec::new();
        for point in points {
            let known =
                point.places.iter().filter(|at| at.iter().all(|degrees| degrees.is_finite()));
            intersections.extend(known.map(|at| place(point, *at)));
        }
        Self { intersections, ..Self::default() }
    }

    /// Reads the places of a results directory; `None` when there are none.
    /// Fails with [`StoreError`] when it cannot be read or is no such file.
    pub fn read(layout: &Layout) -> Result<Option<Self>, StoreError> {
        let Some(bytes) = layout.document(FILE)? else { return Ok(None) };
        Self::parse(&bytes, &layout.root().join(FILE)).map(Some)
    }

    /// Returns the places that bytes are; the path is for messages.
    /// Fails with [`StoreError::Damaged`] when they are damaged.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, StoreError> {
        let malformed = |reason: String| StoreError::damaged(path, reason, Remedy::Renew);
        let mut kept: serde_json::Value =
            serde_json::from_slice(bytes).map_err(|e| malformed(e.to_string()))?;
        // Versions before had no checksum.
        let expected = kept.as_object_mut().and_then(|fields| fields.remove("sha256"));
        let places: Self = serde_json::from_value(kept).map_err(|e| malformed(e.to_string()))?;
        if expected.is_some_and(|expected| expected != sha256(places.content().as_bytes())) {
            return Err(malformed("altered: the checksum does not match".to_owned()));
        }
        let lines = places.streets.iter().flat_map(|streets| &streets.lines).flatten().copied();
        let mut all = lines.chain(places.intersections.iter().map(|p| [p.longitude, p.latitude]));
        match all.all(|[longitude, latitude]| longitude.abs() <= 180.0 && latitude.abs() <= 90.0) {
            true => Ok(places),
            false => Err(malformed("something in it lies nowhere on earth".to_owned())),
        }
    }

    /// Returns the text of a file of places, an intersection per line, with its checksum at the end.
    pub fn to_json(&self) -> String {
        let content = self.content();
        format!("{content},\n\"sha256\":\"{}\"}}\n", sha256(content.as_bytes()))
    }

    /// Returns the text of a file of places, but its end.
    fn content(&self) -> String {
        // Files without drawings have the checksum of the versions before.
        let drawings = match self.drawings.is_empty() {
            true => String::new(),
            false => format!(",{}", rows("drawings", &self.drawings)),
        };
        let (intersections, streets) =
            (rows("intersections", &self.intersections), rows("streets", &self.streets));
        format!("{{{intersections},{streets}{drawings}")
    }
}

fn rows(name: &str, rows: &[impl Serialize]) -> String {
    let row = |row| serde_json::to_string(row).expect("places are plain data");
    format!("\"{name}\":[\n{}\n]", rows.iter().map(row).collect::<Vec<_>>().join(",\n"))
}

/// Distance from which on a name on the map belongs to another intersection, degrees: the table was
/// edited since.
const ELSEWHERE_DEG: f64 = 1e-3;

/// Writes where the intersections of a run's family are, unless none is known.
/// * `stands` — per point MDP the one that stands for it, if any.
/// * `folder` — that of a city, which has names and streets beside the scenario.
///
/// The error is what cannot be read or written.
pub(super) fn write(
    layout: &Layout,
    loaded: &LoadedScenario,
    stands: &[Option<usize>],
    folder: Option<&Path>,
) -> Result<(), Cause> {
    if loaded.intersections.is_empty() {
        return Ok(());
    }
    let names = folder.map(read_names).transpose()?.unwrap_or_default();
    let streets = folder.map(read_streets).transpose()?.unwrap_or_default();
    let mut mapped: Vec<(usize, MappedIntersection)> = Vec::new();
    for (point, members) in loaded.members.iter().enumerate() {
        for member in members {
            let intersection = &loaded.intersections[*member];
            let at = (intersection.latitude, intersection.longitude);
            if !at.0.is_finite() || !at.1.is_finite() {
                continue;
            }
            let id = |point: usize| loaded.family.points[point].id.clone();
            let place = MappedIntersection {
                id: intersection.id.clone(),
                streets: streets_of(&names, &intersection.id, at),
                latitude: at.0,
                longitude: at.1,
                point: id(point),
                stands: stands[point].map(id),
            };
            mapped.push((*member, place));
        }
    }
    mapped.sort_by_key(|i| i.0);
    let places = Places {
        intersections: mapped.into_iter().map(|i| i.1).collect(),
        streets: streets.into_iter().map(|(rank, lines)| StreetsOfRank { rank, lines }).collect(),
        drawings: drawings(loaded, stands)?,
    };
    if !places.intersections.is_empty() || !places.drawings.is_empty() {
        write_atomically(&layout.root().join(FILE), places.to_json().as_bytes())?;
    }
    Ok(())
}

/// Returns plans as [`ExistingPlan::legal`] makes them.
pub(super) fn legal(loaded: &LoadedScenario, today: &Placed) -> Result<Placed, NetworkError> {
    let (limits, all) = (&loaded.scenario.signal, (0..loaded.members.len()).map(Some));
    let of = |drawn: DrawnIntersection| {
        let plan = today.of_point.get(&drawn.point)?;
        let legal = plan.legal(&drawn.timing(limits), &drawn.states(plan));
        Some((drawn.point, legal))
    };
    let drawings = drawings(loaded, &all.collect::<Vec<_>>())?;
    let of_point = drawings.into_iter().filter_map(of).collect();
    Ok(Placed { of_point, ..Placed::default() })
}

/// Returns how the simulated intersections are drawn; none where four equal arms stand for others.
fn drawings(
    loaded: &LoadedScenario,
    stands: &[Option<usize>],
) -> Result<Vec<DrawnIntersection>, NetworkError> {
    if loaded.scenario.family.detail != Detail::PerApproach {
        return Ok(Vec::new());
    }
    let specs = intersections(loaded)?;
    let points = specs.iter().zip(&loaded.members).zip(stands).enumerate();
    let simulated = points.filter(|(point, (_, stands))| **stands == Some(*point));
    let drawn = simulated.map(|(_, ((spec, members), _))| drawn(loaded, spec, members[0]));
    drawn.collect()
}

/// Returns how an intersection is drawn; what the network has mirrored is as on the ground again.
fn drawn(
    loaded: &LoadedScenario,
    spec: &IntersectionSpec,
    member: usize,
) -> Result<DrawnIntersection, NetworkError> {
    let intersection = &loaded.intersections[member];
    let layout = layout(spec)?;
    let arm = |(i, arm): (usize, &crate::network::intersection::Arm)| {
        let bearing_deg = spec.side.bearing_deg(arm.bearing_deg);
        let off_deg = |row: &&crate::family::approaches::Approach| {
            turn_degrees(row.bearing_deg, bearing_deg).abs()
        };
        let own = intersection.arms.iter().min_by(|a, b| off_deg(a).total_cmp(&off_deg(b)));
        let turns = |lane: u32| -> String {
            let of_lane = |turn: Turn| {
                let mut own = layout.connections.iter();
                own.any(|c| (c.movement.from, c.movement.turn, c.from_lane) == (i, turn, lane))
            };
            let (left, right) = spec.side.swapped((Turn::Left, Turn::Right));
            let letters = [(left, 'l'), (Turn::Through, 's'), (right, 'r')];
            letters
                .into_iter()
                .filter(|(turn, _)| of_lane(*turn))
                .map(|(_, letter)| letter)
                .collect()
        };
        let (left_storage_m, right_storage_m) =
            spec.side.swapped((arm.left_storage_m, arm.right_storage_m));
        DrawnArm {
            name: own.map_or_else(String::new, |row| row.arm.clone()),
            edge: incoming_edge(i),
            bearing_deg,
            lanes: (0..arm.lanes_in).map(turns).collect(),
            lanes_out: layout.exit_lanes[i],
            speed_mph: arm.speed_mps / MPS_PER_MPH,
            left_storage_m,
            right_storage_m,
        }
    };
    Ok(DrawnIntersection {
        point: spec.point.clone(),
        intersection: intersection.id.clone(),
        period: intersection.period.clone(),
        is_left_hand: !spec.side.is_right(),
        arms: spec.arms.iter().enumerate().map(arm).collect(),
    })
}

fn streets_of(names: &BTreeMap<String, Named>, id: &str, at: (f64, f64)) -> Vec<String> {
    let near = |(_, (latitude, longitude)): &&Named| {
        (latitude - at.0).abs() < ELSEWHERE_DEG && (longitude - at.1).abs() < ELSEWHERE_DEG
    };
    names.get(id).filter(near).map(|(streets, _)| streets.clone()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn places_read_back() {
        let place = MappedIntersection {
            id: "n7".into(),
            streets: vec!["Main Street".into()],
            latitude: 40.5,
            longitude: -111.5,
            point: "p".into(),
            stands: None,
        };
        let streets =
            vec![StreetsOfRank { rank: 3, lines: vec![vec![[-111.5, 40.5], [-111.4, 40.5]]] }];
        let arm = DrawnArm {
            name: "NB Main".into(),
            edge: "in0".into(),
            bearing_deg: 180.0,
            lanes: vec!["sr".into(), "l".into()],
            lanes_out: 1,
            speed_mph: 30.0,
            left_storage_m: Some(45.7),
            right_storage_m: None,
        };
        assert_eq!([0, 1, 2].map(|lane| arm.bay_m(lane)), [None, Some(45.7), None]);
        let drawn = DrawnIntersection {
            point: "p".into(),
            intersection: "n7".into(),
            period: String::new(),
            is_left_hand: false,
            arms: vec![arm],
        };
        let places = Places { intersections: vec![place], streets, drawings: vec![drawn] };
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let path = dir.path().join(FILE);
        assert_eq!(Places::read(&layout).unwrap(), None);
        fs::write(&path, places.to_json()).unwrap();
        assert_eq!(Places::read(&layout).unwrap().as_ref(), Some(&places));
        fs::write(&path, "{").unwrap();
        let e = Places::read(&layout).unwrap_err().to_string();
        assert!(e.contains("places.json") && e.contains("delete it"), "{e}");
        // One digit of where it is, and of versions without checksum.
        let moved = places.to_json().replace("-111.5", "-111.4");
        fs::write(&path, &moved).unwrap();
        let e = Places::read(&layout).unwrap_err().to_string();
        assert!(e.contains("altered: the checksum does not match; delete it"), "{e}");
        fs::write(&path, format!("{}}}", moved.split_once(",\n\"sha256").unwrap().0)).unwrap();
        assert!(Places::read(&layout).unwrap().is_some());
    }

    #[test]
    fn a_name_from_elsewhere_is_not_taken() {
        let named = (vec!["Main Street".into()], (40.0, -111.0));
        let names = BTreeMap::from([("n1".to_owned(), named)]);
        assert_eq!(streets_of(&names, "n1", (40.0001, -111.0)), ["Main Street"]);
        assert!(streets_of(&names, "n1", (40.1, -111.0)).is_empty());
        assert!(streets_of(&names, "n2", (40.0, -111.0)).is_empty());
    }
}
