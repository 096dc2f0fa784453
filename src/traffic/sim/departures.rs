//! The order of vehicles in a route file: SUMO reads it as time goes on, and leaves out whatever departs before what it
//! has read already, with a warning among others.
//!
//! Source: what `sumo` 1.15 leaves out, tried: vehicles, trips, flows and persons count alike; those of a public transport
//! line do not move the time on. In additional files any order is read.

use super::sumocfg::seconds;

/// What departs, with the attribute that says when.
const DEPARTING: [(&str, &str); 7] = [
    ("vehicle", "depart"),
    ("trip", "depart"),
    ("flow", "begin"),
    ("person", "depart"),
    ("personFlow", "begin"),
    ("container", "depart"),
    ("containerFlow", "begin"),
];

/// The latest departure in a route file so far, and of what it is.
#[derive(Debug, Default)]
pub(super) struct Departures {
    latest: Option<(String, f64)>,
}

impl Departures {
    /// Looks at the next element.
    ///
    /// # Errors
    ///
    /// That SUMO would leave it out.
    pub(super) fn next(
        &mut self,
        tag: &str,
        attributes: &[(String, String)],
    ) -> Result<(), String> {
        let Some((_, when)) = DEPARTING.iter().find(|(name, _)| *name == tag) else {
            return Ok(());
        };
        let of = |wanted: &str| attributes.iter().find(|(name, _)| name == wanted).map(|(_, v)| v);
        // What waits for something else has no time.
        let Some(depart_s) = of(when).and_then(|text| seconds(text).ok()) else { return Ok(()) };
        let name = format!("<{tag} id={:?}>", of("id").map_or("", |id| id));
        if let Some((before, latest_s)) = &self.latest
            && depart_s < *latest_s
        {
            return Err(format!(
                "{name} departs at {depart_s} s, after {before} at {latest_s} s in the file, and SUMO would leave it \
                 out; sort the file by departure (SUMO has tools/route/sort_routes.py)"
            ));
        }
        if of("line").is_none_or(String::is_empty) {
            self.latest = Some((name, depart_s));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looked(elements: &[(&str, &[(&str, &str)])]) -> Result<(), String> {
        let mut departures = Departures::default();
        elements.iter().try_for_each(|(tag, attributes)| {
            let owned = |(a, b): &(&str, &str)| ((*a).to_owned(), (*b).to_owned());
            departures.next(tag, &attributes.iter().map(owned).collect::<Vec<_>>())
        })
    }

    #[test]
    fn what_sumo_would_leave_out_is_named_and_nothing_else() {
        let first: (&str, &[(&str, &str)]) = ("vehicle", &[("id", "a"), ("depart", "0:01:40")]);
        for (second, fits) in [
            (("vehicle", &[("id", "b"), ("depart", "99.9")][..]), false),
            (("flow", &[("id", "b"), ("begin", "10")]), false),
            (("person", &[("id", "b"), ("depart", "10")]), false),
            (("trip", &[("id", "b"), ("depart", "10"), ("line", "7")]), false),
            (("trip", &[("id", "b"), ("depart", "100")]), true),
            (("trip", &[("id", "b"), ("depart", "triggered")]), true),
            (("flow", &[("id", "b"), ("end", "10")]), true),
            (("route", &[("id", "b"), ("edges", "x y")]), true),
        ] {
            let result = looked(&[first, second]);
            assert_eq!(result.is_ok(), fits, "{second:?}: {result:?}");
        }
        let said = looked(&[first, ("trip", &[("id", "b"), ("depart", "10")])]).unwrap_err();
        let expected =
            "<trip id=\"b\"> departs at 10 s, after <vehicle id=\"a\"> at 100 s in the file";
        assert!(said.starts_with(expected), "{said}");
        let of_line: (&str, &[(&str, &str)]) = ("vehicle", &[("depart", "100"), ("line", "7")]);
        assert!(looked(&[of_line, ("trip", &[("id", "b"), ("depart", "10")])]).is_ok());
    }
}
