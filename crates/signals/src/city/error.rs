//! Why no city can be derived from what was given.

use std::path::PathBuf;

use geo::{Coord, Intersects, Rect};
use osm_signals::OsmError;

use super::reason::Reason;
use crate::network::error::NetworkError;
use basics::files::FileError;
use evaluation::family::error::FamilyError;

/// Why no city can be derived from what was given.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CityError {
    /// The extract, or a file that says more of its city, cannot be used.
    #[error(transparent)]
    Input(#[from] OsmError),
    /// Settings that are wrong at a place.
    #[error("{}, {place}: {reason}", .path.display())]
    Settings {
        /// The file.
        path: PathBuf,
        /// Line or field.
        place: String,
        /// What is wrong.
        reason: String,
    },
    /// A file in the folder to write into that is not as it was written.
    #[error(
        "{}: not as this command wrote it; give another --out, or --force to replace it",
        .path.display()
    )]
    Edited {
        /// The file.
        path: PathBuf,
    },
    /// An extract of a region where traffic may keep to the left.
    #[error(
        "{}: in this part of the world traffic may keep to the left; give --driving-side left or right",
        .path.display()
    )]
    DrivingSide {
        /// The extract.
        path: PathBuf,
    },
    /// No signal that is an intersection.
    #[error("{}: {}", .path.display(), none(.reasons, .covered.as_ref()))]
    NoIntersection {
        /// The file that is to blame.
        path: PathBuf,
        /// Why the signals are none, most frequent reason first, with numbers of signals.
        reasons: Vec<(Reason, usize)>,
        /// The smallest box around the streets of the extract, degrees.
        covered: Option<Rect<f64>>,
    },
    /// A signal list that names no intersection of the extract.
    #[error(
        "{}: none of its {signals} signals is at an intersection of the extract; they cover {}{}; {}give \
         the list of this city, or leave out --signals",
        .path.display(), extent(*.bounds), beside(.covered.as_ref()), exchanged(*.bounds, .covered.as_ref())
    )]
    ListElsewhere {
        /// The list.
        path: PathBuf,
        /// How many signals it has.
        signals: usize,
        /// The smallest box around them, degrees.
        bounds: Rect<f64>,
        /// The smallest box around the streets of the extract, degrees.
        covered: Option<Rect<f64>>,
    },
    /// Counts of which none lies along a street of an intersection.
    #[error(
        "{}: none of its {counts} counts lies along a street of an intersection; they cover {}{}; {}give \
         counts of this city, or leave out --aadt",
        .path.display(), extent(*.bounds), beside(.covered.as_ref()),
        exchanged(*.bounds, .covered.as_ref())
    )]
    CountsElsewhere {
        /// The file.
        path: PathBuf,
        /// How many counts it has.
        counts: usize,
        /// The smallest box around all counts, degrees.
        bounds: Rect<f64>,
        /// The smallest box around the streets of the extract, degrees.
        covered: Option<Rect<f64>>,
    },
    /// A file of a city's folder that is not the GeoJSON that was written.
    #[error("{}: {reason}; build the city's networks again", .path.display())]
    Folder {
        /// The file.
        path: PathBuf,
        /// The parser's message.
        reason: geojson::Error,
    },
    /// The family that was derived is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A network cannot be built.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Says why no signal became an intersection.
fn none(reasons: &[(Reason, usize)], covered: Option<&Rect<f64>>) -> String {
    let Some((most, _)) = reasons.first() else {
        return "no signal (highway=traffic_signals) on a drivable street; give a larger extract, or \
                list the signals with --signals"
            .to_owned();
    };
    let counts: Vec<String> = reasons.iter().map(|(r, n)| format!("{n} {}", r.words())).collect();
    let way_out = most.way_out(covered.map(|bounds| extent(*bounds)));
    format!("no signalised intersection; signals: {}; {way_out}", counts.join(", "))
}

/// Says where a box lies whose x is the longitude and y the latitude, degrees.
fn extent(bounds: Rect<f64>) -> String {
    let (low, high) = (bounds.min(), bounds.max());
    format!("longitudes {:.3} to {:.3} and latitudes {:.3} to {:.3}", low.x, high.x, low.y, high.y)
}

/// Says where the extract lies, after where something else does.
fn beside(covered: Option<&Rect<f64>>) -> String {
    covered.map_or_else(String::new, |bounds| format!(", the extract {}", extent(*bounds)))
}

/// Says that latitude and longitude are exchanged, if the box lies at the extract then.
fn exchanged(bounds: Rect<f64>, covered: Option<&Rect<f64>>) -> &'static str {
    let flipped = |c: Coord<f64>| Coord { x: c.y, y: c.x };
    let other = Rect::new(flipped(bounds.min()), flipped(bounds.max()));
    match covered.is_some_and(|covered| covered.intersects(&other)) {
        true => "exchange latitude and longitude, with which they lie at the extract, ",
        false => "",
    }
}
