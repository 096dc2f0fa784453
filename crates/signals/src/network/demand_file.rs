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
        let wrong = |what: String| {
            let reason = format!("{what}, which no intersection has; build its network again");
            FileError::at("use", path)(Error::new(ErrorKind::InvalidInput, reason))
        };
        if !demand.is_possible() {
            return Err(wrong("a duration, a number of vehicles or a share".to_owned()));
        }
        let stream = demand.streams.iter().find(|stream| !stream.is_possible());
        stream.map_or(Ok(()), |s| Err(wrong(format!("a stream from {:?}", s.from))))?;
        Ok(demand)
    }

    fn is_possible(&self) -> bool {
        let vehicles_vph: f64 = self.streams.iter().map(|stream| stream.inflow_vph.max(0.0)).sum();
        (0.0..=LONGEST_S).contains(&self.horizon_s)
            && vehicles_vph * self.horizon_s / SECONDS_PER_HOUR <= MOST_VEHICLES
            && is_factor(self.peak_hour_factor)
            && [self.heavy_vehicles, self.impatience, self.sigma].into_iter().all(is_share)
    }
}

impl Stream {
    fn is_possible(&self) -> bool {
        let comes = match self.arrivals {
            None => true,
            Some(Arrivals::PeakHourFactor(factor)) => is_factor(factor),
            Some(Arrivals::QuarterHours(quarters)) => {
                let sum: f64 = quarters.iter().sum();
                quarters.iter().all(|quarter| *quarter >= 0.0) && sum > 0.0 && sum.is_finite()
            }
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-.#:".contains(c);
        let is_name = |name: &String| !name.is_empty() && name.chars().all(plain);
        let names = self.routes.iter().map(|route| &route.to).chain(&self.upstream);
        let sum: f64 = self.routes.iter().map(|route| route.share).sum();
        comes
            && self.inflow_vph >= 0.0
            && is_share(self.heavy_vehicles.unwrap_or_default())
            && names.chain([&self.from, &self.depart_lane, &self.depart_speed]).all(is_name)
            && self.routes.iter().all(|route| is_share(route.share))
            && (sum - 1.0).abs() <= SHARES_SLACK
    }
}

fn is_share(value: f64) -> bool {
    (0.0..=1.0).contains(&value)
}

fn is_factor(value: f64) -> bool {
    (MIN_PEAK_HOUR_FACTOR..=1.0).contains(&value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_intersection_has_is_refused() {
        let text = r#"{"horizon_s":60.0,"peak_hour_factor":1.0,"streams":[{"from":"in0","inflow_vph":60.0,
            "depart_lane":"best","depart_speed":"max","routes":[{"to":"out1","share":1.0}]}]}"#;
        let parse = |text: &str| DemandSpec::parse(text.as_bytes(), Path::new("d.json"));
        assert!(parse(text).unwrap().vehicles(1).len() < 10);
        for (from, to) in [
            ("out1", r#"x\"/><include href=\"y.xml"#),
            ("best", ""),
            (r#"{"to":"out1","share":1.0}"#, ""),
            (r#""share":1.0"#, r#""share":-1.0"#),
            (r#""share":1.0"#, r#""share":0.4"#),
            ("_vph\":60.0", "_vph\":-1.0"),
            ("_vph\":60.0", "_vph\":1e300"),
            ("_s\":60.0", "_s\":1e9"),
            ("_s\":60.0", "_s\":-1.0"),
            ("factor\":1.0", "factor\":0.0"),
            ("factor\":1.0", "factor\":1.0,\"heavy_vehicles\":2.0"),
            ("factor\":1.0", "factor\":1.0,\"sigma\":-1.0"),
        ] {
            let e = parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(e.starts_with("cannot use d.json: "), "{e}");
        }
    }
}
