//! How many signals a configuration's networks have, without SUMO.

use std::collections::BTreeSet;
use std::path::Path;

use quick_xml::events::Event;
use quick_xml::{Reader, XmlVersion};

use super::sources::open;
use super::sumocfg::SumoConfig;

/// Returns the number of signals that have a program in the networks of a configuration, at least one, and one
/// where they cannot be read, which whoever simulates them will say. Those of foot paths count too, level
/// crossings have no program.
pub fn signals_in(config: &Path) -> u32 {
    count(config).unwrap_or(1).max(1)
}

fn count(config: &Path) -> Option<u32> {
    let mut ids = BTreeSet::new();
    for network in SumoConfig::read(config).ok()?.networks() {
        let mut reader = Reader::from_reader(open(network).ok()?);
        let mut buffer = Vec::new();
        loop {
            match reader.read_event_into(&mut buffer).ok()? {
                Event::Start(element) | Event::Empty(element)
                    if element.name().as_ref() == "tlLogic" =>
                {
                    let id = element.try_get_attribute("id").ok()??;
                    ids.insert(id.normalized_value(XmlVersion::Implicit1_0).ok()?.into_owned());
                }
                Event::Eof => break,
                _ => {}
            }
            buffer.clear();
        }
    }
    u32::try_from(ids.len()).ok()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_signal_counts_once_however_many_programs_it_has() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("a.sumocfg");
        fs::write(&config, "<c><net-file value='n.xml'/></c>").unwrap();
        assert_eq!(signals_in(&config), 1);
        let logic =
            |id: &str| format!("<tlLogic id='{id}'><phase duration='9' state='G'/></tlLogic>");
        let net = ["a", "b", "a"].map(logic).concat();
        fs::write(folder.path().join("n.xml"), format!("<net>{net}</net>")).unwrap();
        assert_eq!(signals_in(&config), 2);
    }
}
