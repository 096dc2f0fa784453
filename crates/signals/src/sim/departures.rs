//! The order of vehicles in a route file: SUMO reads it as time goes on, and leaves out whatever departs before what it
//! has read already, with a warning among others. And when the vehicles of a file depart, if it has any.
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

/// What of them are vehicles.
const VEHICLES: [&str; 3] = ["vehicle", "trip", "flow"];

/// Ways to travel for which SUMO makes a vehicle of the person's own.
const OWN_VEHICLES: [&str; 2] = ["car", "bicycle"];

/// The departures in a file so far.
#[derive(Debug, Default)]
pub(super) struct Departures {
    in_order: bool,
    /// The latest one, and of what it is.
    latest: Option<(String, f64)>,
    /// Whether there is a vehicle, or something that SUMO makes one of.
    pub(super) has_vehicles: bool,
    /// Whether there are people or containers.
    pub(super) has_others: bool,
    /// The first flow whose vehicles are drawn from the seed.
    pub(super) first_drawn: Option<String>,
    /// The earliest one of a vehicle, and the latest one or end of a flow, seconds.
    pub(super) first_s: Option<f64>,
    pub(super) last_s: Option<f64>,
    /// How many SUMO leaves out.
    pub(super) left_out: u32,
    /// What is to be said of the first that SUMO leaves out.
    pub(super) first_left_out: Option<String>,
}

impl Departures {
    /// Returns those of a file, before anything is read.
    ///
    /// # Arguments
    ///
    /// * `in_order` — whether it is read as time goes on.
    pub(super) fn new(in_order: bool) -> Self {
        Self { in_order, ..Self::default() }
    }

    /// Looks at the next element, given its attributes by name; returns whether SUMO leaves it out.
    pub(super) fn next<'a>(&mut self, tag: &str, of: &dyn Fn(&str) -> Option<&'a str>) -> bool {
        if tag == "personTrip" {
            let modes = of("modes").unwrap_or_default();
            self.has_vehicles |= OWN_VEHICLES.iter().any(|mode| modes.contains(mode));
            self.has_vehicles |= of("vTypes").is_some();
        }
        let Some((_, when)) = DEPARTING.iter().find(|(name, _)| *name == tag) else {
            return false;
        };
        let is_vehicle = VEHICLES.contains(&tag);
        self.has_vehicles |= is_vehicle;
        self.has_others |= !is_vehicle;
        if tag == "flow" && is_drawn(of) {
            let id = of("id").unwrap_or_default();
            self.first_drawn.get_or_insert_with(|| format!("<flow id={id:?}>"));
        }
        let time = |name: &str| of(name).and_then(|text| seconds(text).ok());
        // What waits for something else has no time.
        let Some(depart_s) = time(when) else { return false };
        let name = format!("<{tag} id={:?}>", of("id").unwrap_or_default());
        if let Some((before, latest_s)) = self.latest.as_ref().filter(|_| self.in_order)
            && depart_s < *latest_s
        {
            self.left_out += 1;
            self.first_left_out.get_or_insert_with(|| {
                format!(
                    "{name}: it departs at {depart_s} s, after {before} at {latest_s} s in the file"
                )
            });
            return true;
        }
        if is_vehicle {
            let last_s = time("end").map_or(depart_s, |end_s| end_s.max(depart_s));
            self.first_s = Some(self.first_s.map_or(depart_s, |known| known.min(depart_s)));
            self.last_s = Some(self.last_s.map_or(last_s, |known| known.max(last_s)));
        }
        if of("line").is_none_or(str::is_empty) {
            self.latest = Some((name, depart_s));
        }
        false
    }
}

/// Whether SUMO draws from the seed when the vehicles of a flow depart.
fn is_drawn<'a>(of: &dyn Fn(&str) -> Option<&'a str>) -> bool {
    of("probability").is_some() || of("period").is_some_and(|period| period.starts_with("exp"))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Element<'a> = (&'a str, &'a [(&'a str, &'a str)]);

    fn looked(elements: &[Element<'_>]) -> Departures {
        let mut departures = Departures::new(true);
        for (tag, attributes) in elements {
            let of =
                |wanted: &str| attributes.iter().find(|(name, _)| *name == wanted).map(|a| a.1);
            departures.next(tag, &of);
        }
        departures
    }

    #[test]
    fn flows_whose_vehicles_follow_from_the_seed_are_named() {
        let flow = |how: (&'static str, &'static str)| {
            looked(&[("flow", &[("id", "f"), ("begin", "0"), ("end", "9"), how])]).first_drawn
        };
        let drawn = Some("<flow id=\"f\">".to_owned());
        assert_eq!(flow(("probability", "0.2")), drawn);
        assert_eq!(flow(("period", "exp(0.1)")), drawn);
        assert_eq!(flow(("period", "9")), None);
    }

    #[test]
    fn what_sumo_leaves_out_is_counted_and_named_and_nothing_else() {
        let first: Element<'_> = ("vehicle", &[("id", "a"), ("depart", "0:01:40")]);
        for (second, left_out) in [
            (("vehicle", &[("id", "b"), ("depart", "99.9")][..]), 1),
            (("flow", &[("id", "b"), ("begin", "10")]), 1),
            (("person", &[("id", "b"), ("depart", "10")]), 1),
            (("trip", &[("id", "b"), ("depart", "10"), ("line", "7")]), 1),
            (("trip", &[("id", "b"), ("depart", "100")]), 0),
            (("trip", &[("id", "b"), ("depart", "triggered")]), 0),
            (("flow", &[("id", "b"), ("end", "10")]), 0),
            (("route", &[("id", "b"), ("edges", "x y")]), 0),
        ] {
            assert_eq!(looked(&[first, second]).left_out, left_out, "{second:?}");
        }
        let said = looked(&[first, ("trip", &[("id", "b"), ("depart", "10")])]).first_left_out;
        let expected =
            "<trip id=\"b\">: it departs at 10 s, after <vehicle id=\"a\"> at 100 s in the file";
        assert_eq!(said.as_deref(), Some(expected));
        let of_line: Element<'_> = ("vehicle", &[("depart", "100"), ("line", "7")]);
        assert_eq!(looked(&[of_line, ("trip", &[("depart", "10")])]).left_out, 0);
    }

    #[test]
    fn a_flow_lasts_to_its_end() {
        let flow: Element<'_> = ("flow", &[("begin", "0"), ("end", "0:30:00")]);
        assert_eq!(looked(&[flow, ("trip", &[("depart", "9")])]).last_s, Some(1800.0));
        assert_eq!(looked(&[("trip", &[("depart", "9")])]).last_s, Some(9.0));
        assert_eq!(looked(&[]).last_s, None);
        assert_eq!(looked(&[("person", &[("depart", "9")])]).last_s, None);
    }

    #[test]
    fn people_are_no_vehicles_unless_they_drive() {
        let of = |elements: &[Element<'_>]| {
            let departures = looked(elements);
            (departures.has_vehicles, departures.has_others)
        };
        let person: Element<'_> = ("person", &[("depart", "9")]);
        assert_eq!(of(&[person, ("walk", &[("edges", "x y")])]), (false, true));
        assert_eq!(of(&[person, ("personTrip", &[("modes", "public")])]), (false, true));
        assert_eq!(of(&[person, ("personTrip", &[("modes", "public car")])]), (true, true));
        assert_eq!(of(&[("flow", &[("number", "9")])]), (true, false));
        assert_eq!(of(&[("route", &[("edges", "x y")])]), (false, false));
    }
}
