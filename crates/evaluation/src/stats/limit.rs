//! A limit that a metric is beyond: `waiting_s>20`, `normalised_return<0.05`.

use std::fmt;
use std::str::FromStr;

/// On which side of a limit a value is beyond it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// A value above the limit is.
    Above,
    /// A value below the limit is.
    Below,
}

/// A limit that a metric is beyond, as `METRIC>VALUE` or `METRIC<VALUE`.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// Name of the metric.
    pub metric: String,
    /// On which side a value is beyond it.
    pub side: Side,
    /// The limit, in the metric's unit; finite.
    pub value: f64,
}

impl Limit {
    /// Whether a value of the metric is beyond the limit.
    pub fn is_beyond(&self, value: f64) -> bool {
        match self.side {
            Side::Above => value > self.value,
            Side::Below => value < self.value,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = if self.side == Side::Above { '>' } else { '<' };
        write!(f, "{}{side}{}", self.metric, self.value)
    }
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || "expected METRIC>VALUE or METRIC<VALUE in quotes, such as 'waiting_s>20'".to_owned();
        let at = text.find(['>', '<']).ok_or_else(expected)?;
        let side = if text[at..].starts_with('>') { Side::Above } else { Side::Below };
        let (metric, value) = (text[..at].trim(), text[at + 1..].trim());
        let value: f64 = value.parse().map_err(|_| expected())?;
        if metric.is_empty() || !value.is_finite() {
            return Err(expected());
        }
        Ok(Self { metric: metric.to_owned(), side, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_reads_back_as_it_is_written() {
        for text in ["waiting_s>20", "normalised_return<0.05", "queue_veh>-1"] {
            assert_eq!(text.parse::<Limit>().unwrap().to_string(), text);
        }
        let limit: Limit = " waiting_s > 20 ".parse().unwrap();
        assert!(limit.is_beyond(20.5) && !limit.is_beyond(20.0));
        assert!("a<1".parse::<Limit>().unwrap().is_beyond(0.5));
    }
}
