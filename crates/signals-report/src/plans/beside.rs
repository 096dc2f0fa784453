//! What a configuration that is handed out needs beside it: copies of a scenario's files that write nothing and in which
//! every vehicle counts, and a copy of the network with the programs where SUMO refuses them in an additional file.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::config::way_to;
use super::files::remove_earlier;
use basics::files::{FileError, write_atomically};
use evaluation::store::manifest::PointRow;
use signals::environment::given;
use signals::error::TrafficError;
use signals::program::SignalProgram;
use signals::sim::SimError;
use signals::sim::intake::Intake;
use signals::sim::net_file::{Mutual, refused};
use signals::sim::sources::{copy, open};

/// Name of the copy of the network that has the programs.
const NETWORK: &str = "programs.net.xml";

/// Option of the network.
const NET_FILE: &str = "net-file";

/// Where a program ends in a network.
const PROGRAM_END: &[u8] = b"</tlLogic>";

/// How a program begins in any file.
const PROGRAM_BEGIN: &[u8] = b"<tlLogic";

/// Files for a configuration of a scenario that somebody brought.
pub(super) struct Beside<'a> {
    /// The scenario's own configuration.
    pub(super) own: &'a Path,
    /// Its point MDP.
    pub(super) point: &'a PointRow,
    /// The folder of the new configuration.
    pub(super) folder: &'a Path,
    /// Name of the folder with copies within it.
    pub(super) copies: &'a str,
}

/// What was written.
pub(super) struct Handed {
    /// Options that take the place of the scenario's own: long name, value.
    pub(super) replaced: Vec<(String, String)>,
    /// Whether the network has the programs, so that no additional file is needed.
    pub(super) is_inside: bool,
}

impl Beside<'_> {
    /// Writes the files.
    ///
    /// # Arguments
    ///
    /// * `refused` — the text of an additional file whose programs SUMO refuses there; see [`is_refused`].
    pub(super) fn write(&self, refused: Option<&str>) -> Result<Handed, TrafficError> {
        let Self { own, point, folder, copies } = *self;
        let copies = folder.join(copies);
        remove_earlier(&copies)?;
        let intake = Intake::read(own, &given(point)?)?;
        let mut lists = copy(&intake.config, &intake.sources, &copies, false)?;
        let network = match refused {
            Some(programs) => self.network(&intake, &lists, programs, &copies)?,
            None => None,
        };
        let is_inside = network.is_some();
        if let Some(network) = network {
            lists.retain(|(option, _)| option != NET_FILE);
            lists.push((NET_FILE.to_owned(), network.display().to_string()));
        }
        if !lists.is_empty() && copies.display().to_string().contains(',') {
            let reason =
                "SUMO reads a comma in the name of a folder as two files; give --out without one";
            return Err(self.wrong(reason.to_owned()));
        }
        let (way, beside) = (way_to(own, folder)?, own.parent().unwrap_or(Path::new("")));
        let seen = |file: &str| {
            let file = Path::new(file);
            let copied = file.strip_prefix(folder).map(Path::to_path_buf);
            let found = copied.or_else(|_| file.strip_prefix(beside).map(|f| way.join(f)));
            found.unwrap_or_else(|_| file.to_path_buf()).display().to_string()
        };
        let replaced = lists.into_iter().map(|(option, files)| {
            (option, files.split(',').map(seen).collect::<Vec<_>>().join(","))
        });
        Ok(Handed { replaced: replaced.collect(), is_inside })
    }

    /// Writes a copy of the network with the programs of an additional file; returns its path, `None` where the scenario has
    /// no network for them.
    fn network(
        &self,
        intake: &Intake,
        lists: &[(String, String)],
        programs: &str,
        copies: &Path,
    ) -> Result<Option<PathBuf>, TrafficError> {
        let copied = lists.iter().find(|(option, _)| option == NET_FILE);
        let copied = copied.map(|(_, path)| Path::new(path));
        let Some(network) = copied.or_else(|| intake.config.networks().next()) else {
            return Ok(None);
        };
        // Programs of additional files are read later, and the last one that is read runs.
        for file in &intake.sources.files {
            let is_network = intake.config.networks().any(|network| network == file.path);
            let may_have = !is_network && !intake.config.has_routes(&file.path);
            if may_have && position(&read(&file.path)?, PROGRAM_BEGIN).is_some() {
                return Err(self.wrong(format!(
                    "SUMO refuses the programs in an additional file, and in the network those of {} would run instead; \
                     move these into the network",
                    file.path.display()
                )));
            }
        }
        let bytes = read(network)?;
        let Some(with) = inside(&bytes, programs) else { return Ok(None) };
        fs::create_dir_all(copies).map_err(FileError::at("create", copies))?;
        let path = copies.join(NETWORK);
        write_atomically(&path, &with)?;
        Ok(Some(path))
    }

    fn wrong(&self, reason: String) -> TrafficError {
        SimError::Config { path: self.own.to_path_buf(), reason }.into()
    }
}

/// Whether SUMO refuses programs in an additional file.
pub(super) fn is_refused(mutual: &Mutual, programs: &[SignalProgram]) -> bool {
    programs.iter().any(|program| {
        let states = program.phases.iter().map(|phase| phase.state.as_str());
        !program.own && refused(mutual, &program.signal, states).is_some()
    })
}

/// Returns a network with the programs of an additional file behind its own; the last one of a signal runs.
fn inside(network: &[u8], additional: &str) -> Option<Vec<u8>> {
    let (_, programs) = additional.rsplit_once("<additional>\n")?;
    let programs = programs.strip_suffix("</additional>\n")?;
    let mut windows = network.windows(PROGRAM_END.len());
    let end = windows.rposition(|window| window == PROGRAM_END)? + PROGRAM_END.len();
    Some([&network[..end], &b"\n"[..], programs.as_bytes(), &network[end..]].concat())
}

fn position(text: &[u8], part: &[u8]) -> Option<usize> {
    text.windows(part.len()).position(|window| window == part)
}

/// Returns the bytes of a file, which may be compressed.
fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes).map_err(FileError::at("read", path))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_come_behind_those_of_the_network() {
        let network = b"<net><tlLogic id='a'></tlLogic><tlLogic id='b'></tlLogic><junction/></net>";
        let additional =
            "<!--\n    <additional>\n-->\n<additional>\n    <tlLogic id=\"a\"/>\n</additional>\n";
        let with = String::from_utf8(inside(network, additional).unwrap()).unwrap();
        let expected = "<net><tlLogic id='a'></tlLogic><tlLogic id='b'></tlLogic>\n    <tlLogic id=\"a\"/>\n<junction/></net>";
        assert_eq!(with, expected);
        assert_eq!(inside(b"<net/>", additional), None);
    }
}
