//! Why no city can be derived from what was given.

use std::path::PathBuf;

use geo::Rect;
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
    /// An extract of a region with traffic of both sides.
    #[error(
        "{}: there are countries of left-hand and of right-hand traffic in this region; give --driving-side left or right",
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
    /// A signal list, or counts, of another place.
    #[error(
        "{}: none of its {what}; they cover {}{}; give those of this city, or leave out {option}",
        .path.display(), extent(**.bounds), beside(.covered.as_ref())
    )]
    Elsewhere {
        /// The file.
        path: PathBuf,
        /// What of it is not where.
        what: String,
        /// The option that gave it.
        option: &'static str,
        /// The smallest box around what it has, degrees.
        bounds: Box<Rect<f64>>,
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
