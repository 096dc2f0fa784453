//! The intersections of a city one by one: where they are, how each arm was read, what it rests on, and
//! what is worth a look.

use osm_signals::Arm;
use osm_signals::streets::Source;
use osm_signals::traffic::{ArmTraffic, InflowSource};
use serde::Serialize;

use super::flag::Flag;
use super::sites::{City, Site};
use super::table::arm_name;

/// One arm as it was read.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpotArm {
    /// Its name in the table of approaches.
    pub arm: String,
    /// Name of its street.
    pub street: Option<String>,
    /// Class of its street.
    pub class: &'static str,
    /// Direction from the centre, degrees clockwise from north.
    pub bearing_deg: f64,
    /// Lanes towards the signal.
    pub lanes_in: u32,
    /// Lanes away from it.
    pub lanes_out: u32,
    /// Left-only lanes among `lanes_in`.
    pub left_turn_lanes: u32,
    /// Right-only lanes among `lanes_in`.
    pub right_turn_lanes: u32,
    /// Speed limit, miles per hour.
    pub speed_mph: f64,
    /// What the lanes rest on.
    pub lanes_source: Source,
    /// What the speed limit rests on.
    pub speed_source: Source,
    /// What the inflow rests on; nothing for an arm that only leads away.
    pub inflow_source: Option<InflowSource>,
    /// Id of the count that it has.
    pub count: Option<String>,
    /// Distance of the counted line; of a spread count of the counted block along the street, metres.
    pub count_distance_m: Option<f64>,
}

/// One intersection on the map, in the table of the page and in `intersections.geojson`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spot {
    /// Id of the intersection.
    pub id: String,
    /// Names of its streets.
    pub streets: Vec<String>,
    /// Latitude, degrees.
    pub latitude: f64,
    /// Longitude, degrees.
    pub longitude: f64,
    /// Its arms, clockwise from north.
    pub arms: Vec<SpotArm>,
    /// Number of signal nodes.
    pub signals: usize,
    /// Share of its lanes, speeds and inflows that are tagged or counted.
    pub known: f64,
    /// Distance to its place in the signal list, metres.
    pub list_distance_m: Option<f64>,
    /// Mean distance of the matched counts, metres.
    pub count_distance_m: Option<f64>,
    /// What is worth a look.
    pub flags: Vec<Flag>,
}

/// Returns the intersections of a city one by one.
pub(super) fn spots(city: &City) -> Vec<Spot> {
    city.sites().map(|site| spot(&site)).collect()
}

fn spot(site: &Site<'_>) -> Spot {
    let (i, traffic) = (site.found, site.traffic);
    let approaches = || i.arms.iter().zip(traffic).filter(|(arm, _)| arm.lanes_in > 0);
    let known: usize = approaches()
        .map(|(arm, traffic)| {
            let tagged = [arm.lanes_source, arm.speed_source].map(|s| s == Source::Tagged);
            let counted = traffic.source == InflowSource::Counted;
            tagged.into_iter().chain([counted]).filter(|known| *known).count()
        })
        .sum();
    let counted = traffic.iter().filter(|t| t.source == InflowSource::Counted);
    let distances: Vec<f64> =
        counted.filter_map(|t| t.count.as_ref().map(|count| count.distance_m)).collect();
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let arms = i.arms.iter().zip(traffic).enumerate();
    Spot {
        id: i.id.clone(),
        streets: i.streets().into_iter().map(str::to_owned).collect(),
        latitude: i.centre.latitude(),
        longitude: i.centre.longitude(),
        arms: arms.map(|(index, (arm, traffic))| spot_arm(index, arm, traffic)).collect(),
        signals: i.signals.len(),
        known: known as f64 / (3 * approaches().count().max(1)) as f64,
        list_distance_m: i.list_distance_m,
        count_distance_m: (!distances.is_empty()).then_some(mean),
        flags: site.flags(),
    }
}

fn spot_arm(index: usize, arm: &Arm, traffic: &ArmTraffic) -> SpotArm {
    SpotArm {
        arm: arm_name(index),
        street: arm.name.clone(),
        class: arm.highway.name(),
        bearing_deg: arm.bearing_deg,
        lanes_in: arm.lanes_in,
        lanes_out: arm.lanes_out,
        left_turn_lanes: arm.left_turn_lanes,
        right_turn_lanes: arm.right_turn_lanes,
        speed_mph: arm.speed_mph,
        lanes_source: arm.lanes_source,
        speed_source: arm.speed_source,
        inflow_source: (arm.lanes_in > 0).then_some(traffic.source),
        count: traffic.count.as_ref().map(|count| count.id.clone()),
        count_distance_m: traffic.count.as_ref().map(|count| count.distance_m),
    }
}
