//! Names of metrics, which end in their unit: `delay_s` is a delay in seconds.

/// Suffixes that are units, with how people write them.
const UNITS: [(&str, &str); 7] = [
    ("s", "s"),
    ("m", "m"),
    ("veh", "vehicles"),
    ("vph", "vehicles per hour"),
    ("mph", "mph"),
    ("kmh", "km/h"),
    ("rad", "rad"),
];

/// Returns what a metric is called in a sentence: its name as words, without the unit.
pub fn noun(metric: &str) -> String {
    let stem = split(metric).map_or(metric, |(stem, _)| stem);
    stem.replace('_', " ")
}

/// Returns the unit of a metric; empty where its name has none.
pub fn unit(metric: &str) -> &'static str {
    split(metric).map_or("", |(_, unit)| unit)
}

fn split(metric: &str) -> Option<(&str, &'static str)> {
    let (stem, suffix) = metric.rsplit_once('_')?;
    UNITS.iter().find(|(name, _)| *name == suffix).map(|(_, unit)| (stem, *unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_metric_is_its_suffix() {
        assert_eq!((noun("delay_s"), unit("delay_s")), ("delay".to_owned(), "s"));
        assert_eq!((noun("queue_veh"), unit("queue_veh")), ("queue".to_owned(), "vehicles"));
        assert_eq!((noun("score"), unit("score")), ("score".to_owned(), ""));
        assert_eq!((noun("episode_return"), unit("episode_return")), ("episode return".into(), ""));
    }
}
