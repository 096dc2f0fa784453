//! When the vehicles of a file depart, if it has any.

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

/// The departures in a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Departures {
    /// Whether there is a vehicle, or something that SUMO makes one of.
    pub has_vehicles: bool,
    /// Whether there are people or containers.
    pub has_others: bool,
    /// The first flow whose vehicles are drawn from the seed.
    pub first_drawn: Option<String>,
    /// Earliest departure of a vehicle, seconds.
    pub first_s: Option<f64>,
    /// Latest departure of a vehicle or end of a flow, seconds.
    pub last_s: Option<f64>,
}

impl Departures {
    /// Looks at the next element, given its attributes by name.
    pub(super) fn next<'a>(&mut self, tag: &str, of: &dyn Fn(&str) -> Option<&'a str>) {
        if tag == "personTrip" {
            let modes = of("modes").unwrap_or_default();
            self.has_vehicles |= OWN_VEHICLES.iter().any(|mode| modes.contains(mode));
            self.has_vehicles |= of("vTypes").is_some();
        }
        let Some((_, when)) = DEPARTING.iter().find(|(name, _)| *name == tag) else { return };
        if !VEHICLES.contains(&tag) {
            self.has_others = true;
            return;
        }
        self.has_vehicles = true;
        if tag == "flow" && is_drawn(of) {
            let id = of("id").unwrap_or_default();
            self.first_drawn.get_or_insert_with(|| format!("<flow id={id:?}>"));
        }
        let time = |name: &str| of(name).and_then(|text| seconds(text).ok());
        // What waits for something else has no time.
        let Some(depart_s) = time(when) else { return };
        let last_s = time("end").map_or(depart_s, |end_s| end_s.max(depart_s));
        self.first_s = Some(self.first_s.map_or(depart_s, |known| known.min(depart_s)));
        self.last_s = Some(self.last_s.map_or(last_s, |known| known.max(last_s)));
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
        let mut departures = Departures::default();
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
