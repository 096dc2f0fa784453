//! Reads files of demand, which may be a stranger's: how many vehicles one may ask for is checked before they are
//! drawn, and names before they are written into what SUMO reads.

use std::io::{Error, ErrorKind};
use std::path::Path;

use super::demand::{DemandSpec, Stream};
use crate::family::approaches::Arrivals;
use crate::settings::MIN_PEAK_HOUR_FACTOR;
use basics::files::{self, FileError, limits};
use basics::units::SECONDS_PER_HOUR;

/// Most vehicles of an episode on average: what the settings allow on the largest intersection, and far more than
/// fit on its roads.
const MOST_VEHICLES: f64 = 5e7;

/// How far the shares of a stream may be from 1 together: they may be written with two digits.
const SHARES_SLACK: f64 = 0.02;

/// Longest episode, seconds.
const LONGEST_S: f64 = 86_400.0;

impl DemandSpec {
    /// Reads a `.demand.json`.
    ///
    /// # Errors
    ///
    /// [`FileError`] if it cannot be read or is not a demand.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(&files::read(path, limits::NETWORK)?, path)
    }

    /// Returns what a `.demand.json` holds; the path is for messages.
    ///
    /// # Errors
    ///
    /// [`FileError`] if it is not a demand, or one that no intersection has.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, FileError> {
        let demand: Self =
            serde_json::from_slice(bytes).map_err(|e| FileError::at("parse", path)(e.into()))?;
        check_extent(path, demand.horizon_s, demand.streams.iter().map(|s| s.inflow_vph))?;
        demand.check().map_err(|reason| {
            FileError::at("use", path)(Error::new(ErrorKind::InvalidInput, reason))
        })?;
        Ok(demand)
    }

    /// Checks what is written into the files that SUMO reads, and what is drawn from.
    fn check(&self) -> Result<(), String> {
        if !(MIN_PEAK_HOUR_FACTOR..=1.0).contains(&self.peak_hour_factor) {
            return Err(format!("a peak hour factor of {}", self.peak_hour_factor));
        }
        if !(0.0..=1.0).contains(&self.heavy_vehicles) || !(0.0..=1.0).contains(&self.impatience) {
            let (heavy, impatience) = (self.heavy_vehicles, self.impatience);
            return Err(format!(
                "a share of {heavy} of heavy vehicles and an impatience of {impatience}"
            ));
        }
        if !(0.0..=1.0).contains(&self.sigma) {
            return Err(format!("drivers with a sigma of {}", self.sigma));
        }
        for stream in &self.streams {
            let Stream { from, inflow_vph, depart_lane, depart_speed, routes, .. } = stream;
            let manner = match stream.arrivals {
                None => true,
                Some(Arrivals::PeakHourFactor(f)) => (MIN_PEAK_HOUR_FACTOR..=1.0).contains(&f),
                Some(Arrivals::QuarterHours(quarters)) => {
                    let sum: f64 = quarters.iter().sum();
                    quarters.iter().all(|q| *q >= 0.0) && sum > 0.0 && sum.is_finite()
                }
            };
            if !manner || !(0.0..=1.0).contains(&stream.heavy_vehicles.unwrap_or_default()) {
                return Err(format!(
                    "the stream from {from} arrives in quarters that no hour has, or its share of heavy vehicles is no \
                     share"
                ));
            }
            let names = routes.iter().map(|route| &route.to);
            let plain = |c: char| c.is_ascii_alphanumeric() || "_-.#:".contains(c);
            for name in names.chain(&stream.upstream).chain([from, depart_lane, depart_speed]) {
                if name.is_empty() || !name.chars().all(plain) {
                    return Err(format!("{name:?} is no name of an edge, a lane or a speed"));
                }
            }
            let shares = || routes.iter().map(|route| route.share);
            let is_share = |share: f64| (0.0..=1.0).contains(&share);
            if *inflow_vph < 0.0 || routes.is_empty() || !shares().all(is_share) {
                return Err(format!("the stream from {from} has no inflow or no shares"));
            }
            let sum: f64 = shares().sum();
            if (sum - 1.0).abs() > SHARES_SLACK {
                return Err(format!(
                    "the shares of the stream from {from} are {sum} together; correct them so that they are 1"
                ));
            }
        }
        Ok(())
    }
}

/// Checks of a file how long an episode is and how many vehicles arrive, per hour and stream.
///
/// # Errors
///
/// [`FileError`] with how many they are, and how many are taken.
fn check_extent(
    path: &Path,
    horizon_s: f64,
    inflows_vph: impl Iterator<Item = f64>,
) -> Result<(), FileError> {
    let vehicles = inflows_vph.map(|q| q.max(0.0)).sum::<f64>() * horizon_s / SECONDS_PER_HOUR;
    if (0.0..=LONGEST_S).contains(&horizon_s) && vehicles <= MOST_VEHICLES {
        return Ok(());
    }
    let reason = format!(
        "{vehicles:e} vehicles within {horizon_s:e} s: expected at most {MOST_VEHICLES} within at most {LONGEST_S} s"
    );
    Err(FileError::at("use", path)(Error::new(ErrorKind::InvalidInput, reason)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_be_more_than_names_and_shares_that_are_none_are_refused() {
        let text = r#"{"horizon_s":60.0,"peak_hour_factor":1.0,"streams":[{"from":"in0","inflow_vph":60.0,
            "depart_lane":"best","depart_speed":"max","routes":[{"to":"out1","share":1.0}]}]}"#;
        let parse = |text: &str| DemandSpec::parse(text.as_bytes(), Path::new("d.json"));
        assert!(parse(text).unwrap().vehicles(1).len() < 10);
        for (from, to, expected) in [
            ("out1", r#"x\"/><include href=\"y.xml"#, "is no name of an edge, a lane or a speed"),
            ("best", "", "\"\" is no name"),
            (r#"{"to":"out1","share":1.0}"#, "", "the stream from in0 has no inflow or no shares"),
            (r#""share":1.0"#, r#""share":-1.0"#, "no inflow or no shares"),
            (r#""share":1.0"#, r#""share":0.4"#, "from in0 are 0.4 together; correct them"),
            ("_vph\":60.0", "_vph\":-1.0", "no inflow or no shares"),
            ("factor\":1.0", "factor\":0.0", "a peak hour factor of 0"),
            ("factor\":1.0", "factor\":1.0,\"heavy_vehicles\":2.0", "a share of 2 of heavy"),
            ("factor\":1.0", "factor\":1.0,\"sigma\":-1.0", "drivers with a sigma of -1"),
        ] {
            let e = parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(e.starts_with("cannot use d.json: ") && e.contains(expected), "{e}");
        }
    }

    #[test]
    fn more_vehicles_than_anybody_simulates_are_refused() {
        check_extent(Path::new("d"), 86_400.0, [50_000.0; 4].into_iter()).unwrap();
        for (horizon_s, inflow_vph) in
            [(3600.0, 1e308), (1e308, 1.0), (-1.0, 1.0), (3600.0, f64::NAN)]
        {
            let result = check_extent(Path::new("d"), horizon_s, [inflow_vph, 1e308].into_iter());
            assert!(
                result
                    .unwrap_err()
                    .to_string()
                    .contains("expected at most 50000000 within at most 86400 s")
            );
        }
    }
}
