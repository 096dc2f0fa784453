//! The intersections of a city one by one: where they are, how much is known of them, and what is worth a look.

use osm_signals::streets::Source;
use osm_signals::traffic::InflowSource;
use serde::Serialize;

use super::flag::Flag;
use super::sites::{City, Site};

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
    /// Number of its arms.
    pub arms: usize,
    /// What the inflow of each approach rests on, clockwise from north.
    pub inflow_sources: Vec<InflowSource>,
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
    Spot {
        id: i.id.clone(),
        streets: i.streets().into_iter().map(str::to_owned).collect(),
        latitude: i.centre.latitude(),
        longitude: i.centre.longitude(),
        arms: i.arms.len(),
        inflow_sources: approaches().map(|(_, traffic)| traffic.source).collect(),
        signals: i.signals.len(),
        known: known as f64 / (3 * approaches().count().max(1)) as f64,
        list_distance_m: i.list_distance_m,
        count_distance_m: (!distances.is_empty()).then_some(mean),
        flags: site.flags(),
    }
}
