//! A SUMO configuration that shows what a run simulated: the scenario's own, seen from another folder, with the programs of
//! a method.
//!
//! It has the options that a run gives SUMO ([`signals::sim::options`]) and those that a run sets itself, so plain `sumo`
//! simulates the same.

use std::fs;
use std::path::{Component, Path, PathBuf};

use quick_xml::escape::escape;

use super::program_xml::comment;
use basics::files::FileError;
use evaluation::store::manifest::{Identity, PointRow};
use signals::environment::given;
use signals::network_files::GENERATED;
use signals::sim::SimError;
use signals::sim::sumocfg::SumoConfig;

/// Option of the files that programs are added to.
const ADDITIONAL: &str = "additional-files";

/// What a configuration is made of.
pub(super) struct Show<'a> {
    /// Text of the scenario's own configuration.
    pub(super) text: &'a str,
    /// The way from the new configuration's folder to the scenario's.
    pub(super) way: &'a Path,
    /// Name of an additional file beside the new configuration.
    pub(super) additional: Option<&'a str>,
    /// Options that take the place of the scenario's own: long name, value.
    pub(super) replaced: &'a [(String, String)],
    /// Lines that say what it is.
    pub(super) comment: &'a [String],
}

/// Returns the text of a configuration.
pub(super) fn configuration(show: &Show<'_>) -> Result<String, String> {
    // Read as if it lay where the new one does, so that its files are seen from there.
    let own = SumoConfig::parse(show.text, &show.way.join("own.sumocfg"))?;
    if let Some(other) = own.obstacles.iter().find(|o| o.way.is_none()) {
        return Err(other.reason.clone());
    }
    let is_kept =
        |option: &&(String, String)| !show.replaced.iter().any(|(name, _)| *name == option.0);
    let mut lines: Vec<(String, String)> =
        own.options().iter().filter(is_kept).chain(show.replaced).cloned().collect();
    if let Some(file) = show.additional {
        match lines.iter_mut().find(|(option, _)| option == ADDITIONAL) {
            Some((_, files)) => *files = format!("{files},{file}"),
            None => lines.push((ADDITIONAL.to_owned(), file.to_owned())),
        }
    }
    let mut text = comment(show.comment) + "<configuration>\n";
    for (option, value) in lines {
        text += &format!("    <{option} value=\"{}\"/>\n", escape(value.as_str()));
    }
    Ok(text + "</configuration>\n")
}

/// Returns the options that a run sets itself in an episode: long name, value.
pub(super) fn set_by_run(
    identity: &Identity,
    point: &PointRow,
    seed: u64,
) -> Result<Vec<(String, String)>, SimError> {
    let mut options = Vec::new();
    if point.environment != GENERATED {
        let given = given(point)?;
        let times =
            [("begin", given.begin_s), ("end", given.end_s), ("step-length", given.step_length_s)];
        options.extend(times.into_iter().filter_map(|(name, s)| Some((name, s?.to_string()))));
    }
    options.extend([
        ("seed", seed.to_string()),
        ("time-to-teleport", time_to_teleport_s(identity).to_string()),
        ("xml-validation", "never".to_owned()),
        // Vehicles with a device for safety measures would each write a file.
        ("device.ssm.file", "NUL".to_owned()),
    ]);
    Ok(options.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
}

pub(super) fn way_to(config: &Path, folder: &Path) -> Result<PathBuf, FileError> {
    let absolute = |path: &Path| fs::canonicalize(path).map_err(FileError::at("find", path));
    let parent = config.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(way(&absolute(folder)?, &absolute(parent)?))
}

/// Returns the time after which the vehicles of a run are teleported, seconds.
fn time_to_teleport_s(identity: &Identity) -> f64 {
    let set = identity.settings.pointer("/simulation/time_to_teleport_s");
    set.and_then(serde_json::Value::as_f64).unwrap_or(-1.0)
}

/// Returns the way from one folder to another; both are absolute.
fn way(from: &Path, to: &Path) -> PathBuf {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (from.components().collect(), to.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let mut way: PathBuf = from[common..].iter().map(|_| Component::ParentDir).collect();
    way.extend(&to[common..]);
    way
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_is_what_the_run_gave_sumo_with_a_program_more() {
        let text = "<configuration><n v='a.net.xml'/><r>a.rou.xml, /abs/b.rou.xml</r>\
            <a v='c.add.xml'/><begin value='0:10:00'/><tripinfo-output value='t.xml'/>\
            <seed value='3'/><step-length value='0.5'/><max-depart-delay value='30'/>\
            <time-to-teleport value='50'/><time-to-teleport.highways value='20'/>\
            <collision.action value='remove'/><mesosim value='1'/><tls.all-off value='true'/>\
            <remote-port value='8899'/><tripinfo v='t.xml'/><netstate-dump v='d.xml'/></configuration>";
        let replaced = [("seed", "42"), ("time-to-teleport", "-1")]
            .map(|(name, value)| (name.to_owned(), value.to_owned()));
        let show = Show {
            text,
            way: Path::new("../../net"),
            additional: Some("p.add.xml"),
            replaced: &replaced,
            comment: &["one".to_owned()],
        };
        insta::assert_snapshot!(configuration(&show).unwrap(), @r#"
        <!--
            one
        -->
        <configuration>
            <net-file value="../../net/a.net.xml"/>
            <route-files value="../../net/a.rou.xml,/abs/b.rou.xml"/>
            <additional-files value="../../net/c.add.xml,p.add.xml"/>
            <begin value="0:10:00"/>
            <step-length value="0.5"/>
            <max-depart-delay value="-1"/>
            <time-to-teleport.highways value="0"/>
            <collision.action value="warn"/>
            <mesosim value="false"/>
            <tls.all-off value="false"/>
            <seed value="42"/>
            <time-to-teleport value="-1"/>
        </configuration>
        "#);
        let replaced = [("route-files", "v.rou.xml"), ("end", "900")]
            .map(|(name, value)| (name.to_owned(), value.to_owned()));
        let other = configuration(&Show { replaced: &replaced, ..show }).unwrap();
        assert!(other.contains("<route-files value=\"v.rou.xml\"/>"), "{other}");
        assert!(!other.contains("a.rou.xml") && other.contains("<end value=\"900\"/>"), "{other}");
        assert!(configuration(&Show { text: "<c", ..show }).is_err());
        let comma = configuration(&Show { way: Path::new("../a,b"), ..show }).unwrap_err();
        assert!(comma.contains("SUMO reads a comma"), "{comma}");
    }

    #[test]
    fn the_way_leads_up_and_down() {
        let to = |to: &str| way(Path::new("/a/b/c"), Path::new(to));
        assert_eq!(to("/a/x/y"), Path::new("../../x/y"));
        assert_eq!(to("/a/b/c"), Path::new(""));
    }
}
