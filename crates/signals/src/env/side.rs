//! Scenarios of left-hand traffic, seen as right-hand traffic sees its own.
//!
//! A network says in its first element (`lefthand="true"`, netconvert's `--lefthand`) that traffic keeps to
//! the left. SUMO's directions of links and headings of lanes are those on the ground there, and lane 0
//! is the leftmost one, beside the kerb as everywhere. So that a turn across opposing traffic is a left
//! turn for whoever derives movements, phases and limits, the scene is mirrored where it comes from
//! the simulator: movements have the numbers and turns of the mirror image.

use std::io::{BufRead, Read};
use std::path::Path;

use osm_signals::DrivingSide;
use osm_signals::angle::mirrored_deg;
use quick_xml::events::Event;
use quick_xml::{Reader, XmlVersion};

use crate::sim::sources::open;
use crate::sim::sumocfg::SumoConfig;
use crate::sim::{Direction, Scene};

/// Values of an attribute that are true for SUMO.
///
/// Source: SUMO 1.15, `StringUtils::toBool`.
const TRUE: [&str; 6] = ["1", "yes", "true", "on", "x", "t"];

/// Most bytes that are read in search of the first element: the comments before it, and it. A file of nothing else would
/// fill the memory.
const BEFORE_FIRST_ELEMENT: u64 = 1 << 24;

/// Returns the side of the street that traffic keeps to in the networks of a configuration; right where
/// none can be read, which SUMO will say.
pub fn driving_side(config: &SumoConfig) -> DrivingSide {
    let left = config.networks().any(|path| is_left_hand(path).unwrap_or(false));
    if left { DrivingSide::Left } else { DrivingSide::Right }
}

/// Returns whether a network says so in its first element; `None` if it cannot be read.
fn is_left_hand(network: &Path) -> Option<bool> {
    first_element_says(&mut Reader::from_reader(open(network).ok()?.take(BEFORE_FIRST_ELEMENT)))
}

fn first_element_says<R: BufRead>(reader: &mut Reader<R>) -> Option<bool> {
    let mut buffer = Vec::new();
    loop {
        match reader.read_event_into(&mut buffer).ok()? {
            Event::Start(element) | Event::Empty(element) => {
                let attribute = element.try_get_attribute("lefthand").ok()?;
                let value = attribute.map(|a| a.normalized_value(XmlVersion::Implicit1_0));
                let value = value.and_then(Result::ok).unwrap_or_default();
                return Some(TRUE.contains(&value.to_lowercase().as_str()));
            }
            Event::Eof => return None,
            _ => buffer.clear(),
        }
    }
}

/// Returns a scene as right-hand traffic would have it: of left-hand traffic the mirror image.
pub fn as_right_hand(mut scene: Scene, side: DrivingSide) -> Scene {
    if side.is_right() {
        return scene;
    }
    for lane in &mut scene.lanes {
        lane.heading_deg = mirrored_deg(lane.heading_deg);
    }
    for link in scene.signals.iter_mut().flat_map(|s| s.links.iter_mut().flatten()) {
        link.direction = mirrored(link.direction);
    }
    scene
}

fn mirrored(direction: Direction) -> Direction {
    match direction {
        Direction::Left => Direction::Right,
        Direction::PartLeft => Direction::PartRight,
        Direction::Right => Direction::Left,
        Direction::PartRight => Direction::PartLeft,
        same @ (Direction::Straight | Direction::Turn) => same,
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::env::derive::derive;
    use crate::env::testing::crossing;
    use crate::settings::SignalSettings;

    fn side_of(net: &[u8]) -> DrivingSide {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.net.xml"), net).unwrap();
        let config = folder.path().join("a.sumocfg");
        fs::write(&config, "<c><net-file value='a.net.xml'/><end value='9'/></c>").unwrap();
        driving_side(&SumoConfig::read(&config).unwrap())
    }

    #[test]
    fn the_first_element_of_a_network_says_which_side() {
        let left = "<?xml version=\"1.0\"?>\n<!-- lefthand=\"false\" -->\n\
                    <net version=\"1.9\" lefthand=\"true\"><edge/></net>";
        assert_eq!(side_of(left.as_bytes()), DrivingSide::Left);
        for right in ["<net version=\"1.9\"><x lefthand=\"1\"/></net>", "<net lefthand='0'/>", ""] {
            assert_eq!(side_of(right.as_bytes()), DrivingSide::Right, "{right}");
        }
    }

    #[test]
    fn a_left_hand_signal_is_derived_as_the_mirror_image_of_a_right_hand_one() {
        let of = |lanes: &[(&str, f64, &str)], side| {
            let scene = as_right_hand(crossing(lanes, &["GGgGGg", "rrGrrG"]), side);
            derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap()
        };
        let right =
            [("n_0", 10.0, "rs"), ("n_1", 10.0, "l"), ("s_0", 170.0, "rs"), ("s_1", 170.0, "l")];
        let left =
            [("n_0", 350.0, "ls"), ("n_1", 350.0, "r"), ("s_0", 190.0, "ls"), ("s_1", 190.0, "r")];
        assert_eq!(of(&right, DrivingSide::Right), of(&left, DrivingSide::Left));
        assert_ne!(of(&right, DrivingSide::Right), of(&left, DrivingSide::Right));
    }
}
