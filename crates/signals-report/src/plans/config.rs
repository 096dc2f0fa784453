//! A SUMO configuration that shows what the best method of a point MDP does: the scenario's own, seen
//! from another folder, with a program more.

use std::fs;
use std::path::{Component, Path, PathBuf};

use quick_xml::escape::escape;

use super::program_xml::comment;
use basics::files::FileError;
use evaluation::store::manifest::Identity;
use signals::sim::sumocfg::{file_names, options};

/// Options that are files, besides those whose names end like one; SUMO's short names are among them.
const FILES: [&str; 8] = ["n", "net", "r", "routes", "a", "additional", "g", "configuration-file"];

/// Names of the option of additional files.
const ADDITIONAL: [&str; 3] = ["additional-files", "additional", "a"];

/// Short names of options that may be replaced.
const SHORT: [(&str, &str); 4] =
    [("r", "route-files"), ("routes", "route-files"), ("b", "begin"), ("e", "end")];

/// Options that are decided here, or that would write where the scenario lies.
const DROPPED: [&str; 9] = [
    "seed", "random", "time-to-teleport", "xml-validation", "output-prefix", "log", "l",
    "message-log", "error-log",
];

/// What a configuration is made of.
pub(super) struct Show<'a> {
    /// Text of the scenario's own configuration.
    pub(super) text: &'a str,
    /// The way from the new configuration's folder to the scenario's.
    pub(super) way: &'a Path,
    /// Name of an additional file beside the new configuration.
    pub(super) additional: Option<&'a str>,
    /// Options that take the place of the scenario's own, by their long names.
    pub(super) replaced: &'a [(&'static str, String)],
    /// Seed of the episode.
    pub(super) seed: u64,
    /// Time after which SUMO teleports a vehicle, seconds.
    pub(super) time_to_teleport_s: f64,
    /// Lines that say what it is.
    pub(super) comment: &'a [String],
}

/// Returns the text of a configuration.
///
/// # Errors
///
/// What is wrong with the scenario's own.
pub(super) fn configuration(show: &Show<'_>) -> Result<String, String> {
    let mut lines = Vec::new();
    let mut additional: Vec<String> = Vec::new();
    for (option, value) in options(show.text)? {
        let is_output = option.ends_with("-output") || option.contains("-output.");
        let short = SHORT.iter().find(|(short, _)| *short == option).map(|(_, long)| *long);
        let long = short.unwrap_or(&option);
        let is_replaced = show.replaced.iter().any(|(name, _)| *name == long);
        if DROPPED.contains(&option.as_str()) || is_output || is_replaced {
            continue;
        }
        let is_file = FILES.contains(&option.as_str())
            || option.ends_with("-file")
            || option.ends_with("-files");
        let value = if is_file { rebased(&value, show.way)? } else { value };
        if ADDITIONAL.contains(&option.as_str()) {
            additional.push(value);
        } else {
            lines.push((option, value));
        }
    }
    additional.extend(show.additional.map(str::to_owned));
    lines.extend(show.replaced.iter().map(|(name, value)| ((*name).to_owned(), value.clone())));
    if !additional.is_empty() {
        lines.push(("additional-files".to_owned(), additional.join(",")));
    }
    lines.push(("seed".to_owned(), show.seed.to_string()));
    lines.push(("time-to-teleport".to_owned(), show.time_to_teleport_s.to_string()));
    lines.push(("xml-validation".to_owned(), "never".to_owned()));
    let mut text = comment(show.comment) + "<configuration>\n";
    for (option, value) in lines {
        text += &format!("    <{option} value=\"{}\"/>\n", escape(value.as_str()));
    }
    Ok(text + "</configuration>\n")
}

/// Returns a list of files, each seen from another folder.
fn rebased(files: &str, way: &Path) -> Result<String, String> {
    let file = |f: &String| way.join(f).display().to_string();
    Ok(file_names(files)?.iter().map(file).collect::<Vec<_>>().join(","))
}

/// Returns the way from a folder to the folder of a configuration.
///
/// # Errors
///
/// [`FileError`] when one of the two is not there.
pub(super) fn way_to(config: &Path, folder: &Path) -> Result<PathBuf, FileError> {
    let absolute = |path: &Path| fs::canonicalize(path).map_err(FileError::at("find", path));
    let parent = config.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(way(&absolute(folder)?, &absolute(parent)?))
}

/// Returns the time after which the vehicles of a run are teleported, seconds.
pub(super) fn time_to_teleport_s(identity: &Identity) -> f64 {
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
    fn a_configuration_is_the_scenario_s_own_with_a_program_more() {
        let text = "<configuration><n v='a.net.xml'/><r>a.rou.xml, /abs/b.rou.xml</r>\
            <a v='c.add.xml'/><begin value='0:10:00'/><tripinfo-output value='t.xml'/>\
            <seed value='3'/><step-length value='0.5'/></configuration>";
        let show = Show {
            text,
            way: Path::new("../../net"),
            additional: Some("p.add.xml"),
            replaced: &[],
            seed: 42,
            time_to_teleport_s: -1.0,
            comment: &["one".to_owned()],
        };
        insta::assert_snapshot!(configuration(&show).unwrap(), @r#"
        <!--
            one
        -->
        <configuration>
            <n value="../../net/a.net.xml"/>
            <r value="../../net/a.rou.xml,/abs/b.rou.xml"/>
            <begin value="0:10:00"/>
            <step-length value="0.5"/>
            <additional-files value="../../net/c.add.xml,p.add.xml"/>
            <seed value="42"/>
            <time-to-teleport value="-1"/>
            <xml-validation value="never"/>
        </configuration>
        "#);
        let replaced = [("route-files", "v.rou.xml".to_owned()), ("end", "900".to_owned())];
        let other = configuration(&Show { replaced: &replaced, ..show }).unwrap();
        assert!(other.contains("<route-files value=\"v.rou.xml\"/>"), "{other}");
        assert!(!other.contains("a.rou.xml") && other.contains("<end value=\"900\"/>"), "{other}");
        assert!(configuration(&Show { text: "<c", ..show }).is_err());
    }

    #[test]
    fn the_way_leads_up_and_down() {
        let to = |to: &str| way(Path::new("/a/b/c"), Path::new(to));
        assert_eq!(to("/a/x/y"), Path::new("../../x/y"));
        assert_eq!(to("/a/b/c"), Path::new(""));
    }
}
