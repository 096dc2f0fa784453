//! Private copies of a scenario's files, for one simulation: without what SUMO would write, and where it is asked for
//! without programs that change by the clock. Of the other files SUMO reads the originals.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::Path;

use super::scan::Edit;
use super::sources::{Source, Sources, open};
use super::sumocfg::SumoConfig;
use basics::files::{FileError, make_folder};

/// Writes the copies that are needed into a folder, and returns the options that SUMO gets in place of the
/// configuration's: long name, value.
///
/// # Arguments
///
/// * `day_plan` — whether programs change by the clock as they do in the scenario.
///
/// # Errors
///
/// [`FileError`] when a file cannot be read or the folder cannot be written.
pub fn copy(
    config: &SumoConfig,
    sources: &Sources,
    folder: &Path,
    day_plan: bool,
) -> Result<Vec<(String, String)>, FileError> {
    let copied = needed(sources, day_plan);
    if !copied.contains(&true) {
        return Ok(Vec::new());
    }
    make_folder(folder)?;
    let of_copy = |file: usize| format!("{file}.xml");
    for (file, source) in sources.files.iter().enumerate().filter(|(file, _)| copied[*file]) {
        let path = folder.join(of_copy(file));
        write(source, &edits(source, day_plan, &of_copy), &path)?;
    }
    let shown = |file: usize| folder.join(of_copy(file)).display().to_string();
    let now = |path: &str| {
        let file = sources.files.iter().position(|source| source.path == Path::new(path));
        file.filter(|file| copied[*file]).map_or_else(|| path.to_owned(), shown)
    };
    let lists = config.options().iter().filter(|(name, _)| SumoConfig::is_list(name));
    let lists = lists.map(|(name, paths)| {
        (name.clone(), paths.split(',').map(now).collect::<Vec<_>>().join(","))
    });
    Ok(lists.collect())
}

/// Returns by file whether a copy of it is needed: of those that have something otherwise, of those that draw such a file
/// in, and of all that a copy draws in, so that they lie side by side.
fn needed(sources: &Sources, day_plan: bool) -> Vec<bool> {
    let files = &sources.files;
    let differs = |source: &Source| {
        let scanned = &source.scanned;
        !scanned.edits.is_empty() || !day_plan && !scanned.day_plan.is_empty()
    };
    let mut copied: Vec<bool> = files.iter().map(differs).collect();
    loop {
        let mut changed = false;
        for (file, source) in files.iter().enumerate() {
            for named in source.names.iter().flatten().copied() {
                if copied[file] != copied[named] {
                    (copied[file], copied[named], changed) = (true, true, true);
                }
            }
        }
        if !changed {
            return copied;
        }
    }
}

/// Returns what a copy has otherwise, in order.
fn edits(source: &Source, day_plan: bool, of_copy: &dyn Fn(usize) -> String) -> Vec<Edit> {
    let scanned = &source.scanned;
    let gone = scanned.day_plan.iter().filter(|_| !day_plan);
    let gone = gone.map(|at| Edit { at: at.clone(), with: String::new() });
    let names = scanned.named.iter().zip(&source.names);
    let names =
        names.filter_map(|((_, at), file)| Some(Edit { at: at.clone(), with: of_copy((*file)?) }));
    let mut edits: Vec<Edit> = scanned.edits.iter().cloned().chain(gone).chain(names).collect();
    edits.sort_by_key(|edit| (edit.at.start, std::cmp::Reverse(edit.at.end)));
    edits
}

/// Writes a copy.
fn write(source: &Source, edits: &[Edit], path: &Path) -> Result<(), FileError> {
    let mut from = open(&source.path)?;
    let failed = |e: io::Error| FileError::at("copy", &source.path)(e);
    let file = File::create_new(path).map_err(FileError::at("create", path))?;
    let mut to = BufWriter::new(file);
    let mut pass = |count: u64, to: &mut dyn Write| match io::copy(&mut (&mut from).take(count), to)
    {
        Ok(passed) if passed < count && count < u64::MAX => {
            Err(failed(io::Error::new(ErrorKind::UnexpectedEof, "it became shorter meanwhile")))
        }
        Ok(_) => Ok(()),
        Err(e) => Err(failed(e)),
    };
    let mut at = 0;
    for Edit { at: bytes, with } in edits {
        // What lies in an element that is gone is gone with it.
        let Some(before) = bytes.start.checked_sub(at) else { continue };
        pass(before, &mut to)?;
        to.write_all(with.as_bytes()).map_err(FileError::at("write", path))?;
        pass(bytes.end - bytes.start, &mut io::sink())?;
        at = bytes.end;
    }
    pass(u64::MAX, &mut to)?;
    to.flush().map_err(FileError::at("write", path))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    use super::*;

    /// A scenario of a network and these additional files, the first of which is named.
    fn scenario(folder: &Path, files: &[(&str, &str)]) -> (SumoConfig, Sources) {
        for (name, text) in files.iter().chain(&[("n.xml", "<net/>")]) {
            fs::write(folder.join(name), text).unwrap();
        }
        let text = format!("<c><n v='n.xml'/><a v='{}'/></c>", files[0].0);
        fs::write(folder.join("a.sumocfg"), text).unwrap();
        let config = SumoConfig::read(&folder.join("a.sumocfg")).unwrap();
        let sources = Sources::of(&config, &BTreeSet::new());
        assert_eq!((&config.obstacles[..], &sources.obstacles[..]), (&[][..], &[][..]));
        (config, sources)
    }

    #[test]
    fn outputs_of_any_kind_go_nowhere_and_everything_else_stays_byte_for_byte() {
        let folder = tempfile::tempdir().unwrap();
        let text = "<a>\r\n<!-- Stra\u{df}e file='x' --><e1Detector id=\"d\" file=\"\u{fc} o.xml\"\n/>\
            <edgeData edgesFile='e' file=  'x&amp;.xml'/><timedEvent dest='t.xml' source=\"c\"/>\
            <vType emissionClass='PHEMlight/PC'><param key='device.ssm.file' value='s.xml'/>\
            <param value='false' key='has.tripinfo.device'/><param key='x-output' value=''/></vType>\
            <routeProbe file='NUL'/><vType imgFile='b.png'/></a> ";
        let (config, sources) = scenario(folder.path(), &[("a.xml", text)]);
        let options = copy(&config, &sources, &folder.path().join("copies"), true).unwrap();
        let copied = fs::read_to_string(folder.path().join("copies/1.xml")).unwrap();
        let expected = text
            .replace("\u{fc} o.xml", "NUL")
            .replace("edgesFile='e'", "             ")
            .replace("x&amp;.xml", "NUL")
            .replace("t.xml", "NUL")
            .replace("PHEMlight/PC", "HBEFA3/PC_G_EU4")
            .replace("s.xml", "NUL")
            .replace("value='false'", "value='true'");
        assert_eq!(copied, expected);
        let shown = |name: &str| folder.path().join(name).display().to_string();
        let expected = [
            ("net-file".to_owned(), shown("n.xml")),
            ("additional-files".to_owned(), shown("copies/1.xml")),
        ];
        assert_eq!(options, expected);
        assert_eq!(sources.files[1].scanned.outputs.as_ref().unwrap().0, 5);
        assert!(!folder.path().join("copies/0.xml").exists(), "the network has nothing otherwise");
    }

    #[test]
    fn a_day_plan_is_left_out_where_it_is_asked_for_with_what_draws_it_in() {
        let folder = tempfile::tempdir().unwrap();
        let plan = "<a><x/><WAUT id='w' startProg='p'><wautSwitch time='9' to='q'/></WAUT>\
            <wautJunction wautID='w' junctionID='c'/><include href='c.xml'/></a>";
        let files = [
            ("a.xml", "<a><include href='b.xml'/></a>"),
            ("b.xml", plan),
            ("c.xml", "<c><include href='a.xml'/></c>"),
        ];
        let (config, sources) = scenario(folder.path(), &files);
        let with = |day_plan: bool| {
            let copies = folder.path().join(format!("copies-{day_plan}"));
            copy(&config, &sources, &copies, day_plan).unwrap().len()
        };
        assert_eq!((with(true), with(false)), (0, 2));
        let read =
            |n: usize| fs::read_to_string(folder.path().join(format!("copies-false/{n}.xml")));
        assert_eq!(read(1).unwrap(), "<a><include href='2.xml'/></a>");
        assert_eq!(read(2).unwrap(), "<a><x/><include href='3.xml'/></a>");
        assert_eq!(read(3).unwrap(), "<c><include href='1.xml'/></c>");
    }
}
