//! Where places and elements of the map can be looked at.

/// Where elements of the map can be looked at.
pub(super) const OPENSTREETMAP: &str = "https://www.openstreetmap.org";

/// Returns where a place can be looked at on the map.
pub(super) fn map_link(latitude: f64, longitude: f64) -> String {
    format!(
        "{OPENSTREETMAP}/?mlat={latitude:.6}&mlon={longitude:.6}#map=19/{latitude:.6}/{longitude:.6}"
    )
}
