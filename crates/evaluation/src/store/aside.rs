//! The episodes of records in a file without a name, for whoever needs all of them a second time.
//!
//! Records are checked when they are read, which takes far longer than to write these numbers and to read them back. Where
//! no such file can be made or written there is none, and records are read again.

use std::fs::File;
use std::io::{BufWriter, Error, ErrorKind, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::metrics::{Metrics, Names};
use super::record::{Row, RowKind};
use basics::files::FileError;

/// Bytes that are written at once.
const BUFFER: usize = 1 << 20;

/// The episodes of one record.
#[derive(Debug, Default)]
pub(super) struct Packed {
    /// The names of the metrics that they have, every set once.
    names: Vec<Names>,
    /// Per episode its number, its seed, its kind, the position of its names, and its values.
    bytes: Vec<u8>,
}

impl Packed {
    /// Packs episodes.
    pub(super) fn of(rows: &[Row]) -> Self {
        let mut packed = Self::default();
        for Row { kind, episode, seed, metrics } in rows {
            let own = metrics.names();
            let is_own = |names: &Names| Arc::ptr_eq(names, own) || names == own;
            let at = packed.names.iter().position(is_own).unwrap_or_else(|| {
                packed.names.push(own.clone());
                packed.names.len() - 1
            });
            packed.bytes.extend(episode.to_le_bytes());
            packed.bytes.extend(seed.to_le_bytes());
            packed.bytes.push(*kind as u8);
            packed.bytes.extend((at as u32).to_le_bytes());
            metrics.values().for_each(|value| packed.bytes.extend(value.to_le_bytes()));
        }
        packed
    }
}

/// Returns the episodes that such bytes are.
fn unpacked(names: &[&Names], mut bytes: &[u8]) -> Option<Vec<Row>> {
    let mut rows = Vec::new();
    while !bytes.is_empty() {
        let episode = u32::from_le_bytes(*next(&mut bytes)?);
        let seed = u64::from_le_bytes(*next(&mut bytes)?);
        let [kind] = *next(&mut bytes)?;
        let kind = *RowKind::ALL.get(usize::from(kind))?;
        let names = *names.get(u32::from_le_bytes(*next(&mut bytes)?) as usize)?;
        let value = |_: &String| Some(f64::from_le_bytes(*next(&mut bytes)?));
        let values = names.iter().map(value).collect::<Option<Arc<[f64]>>>()?;
        rows.push(Row { kind, episode, seed, metrics: Metrics::of(names.clone(), values) });
    }
    Some(rows)
}

/// Takes so many bytes.
fn next<'a, const N: usize>(bytes: &mut &'a [u8]) -> Option<&'a [u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(first)
}

/// Episodes that are being set aside, one record after the other.
#[derive(Debug)]
pub(super) struct Setting {
    file: BufWriter<File>,
    aside: Aside,
}

/// The episodes of all records of a run.
#[derive(Debug)]
pub(super) struct Aside {
    file: File,
    /// Where it is, for messages.
    folder: PathBuf,
    /// All sets of names that were met.
    names: Vec<Names>,
    /// Where the episodes of every task begin, and where the last ones end.
    begin: Vec<u64>,
}

impl Setting {
    /// Begins a file in a folder; `None` where it cannot be made.
    pub(super) fn new(folder: &Path) -> Option<Self> {
        let file = tempfile::tempfile_in(folder).ok()?;
        let writer = BufWriter::with_capacity(BUFFER, file.try_clone().ok()?);
        let folder = folder.to_path_buf();
        let aside = Aside { file, folder, names: Vec::new(), begin: vec![0] };
        Some(Self { file: writer, aside })
    }

    /// Adds the episodes of the next task; `None` where that cannot be written.
    pub(super) fn add(mut self, packed: Option<Packed>) -> Option<Self> {
        let Packed { names, bytes } = packed.unwrap_or_default();
        let mut head = vec![names.len() as u32];
        for own in names {
            let all = &mut self.aside.names;
            let is_own = |names: &Names| Arc::ptr_eq(names, &own) || *names == own;
            let at = all.iter().position(is_own).unwrap_or_else(|| {
                all.push(own.clone());
                all.len() - 1
            });
            head.push(at as u32);
        }
        for number in &head {
            self.file.write_all(&number.to_le_bytes()).ok()?;
        }
        self.file.write_all(&bytes).ok()?;
        let begin = self.aside.begin.last().copied().unwrap_or_default();
        self.aside.begin.push(begin + (4 * head.len() + bytes.len()) as u64);
        Some(self)
    }

    /// Returns the episodes of all tasks; `None` where they cannot be written.
    pub(super) fn finish(mut self) -> Option<Aside> {
        self.file.flush().ok()?;
        Some(self.aside)
    }
}

impl Aside {
    /// Returns the episodes of a task; none, where it has no record.
    ///
    /// # Errors
    ///
    /// [`FileError`] when they cannot be read back.
    pub(super) fn rows(&self, task: usize) -> Result<Vec<Row>, FileError> {
        let failed =
            |reason: Error| FileError::at("read back what was set aside in", &self.folder)(reason);
        let other = || failed(ErrorKind::UnexpectedEof.into());
        let [begin, end] =
            self.begin.get(task..task + 2).and_then(|own| own.try_into().ok()).ok_or_else(other)?;
        let mut bytes = vec![0; usize::try_from(end - begin).map_err(|_| other())?];
        self.file.read_exact_at(&mut bytes, begin).map_err(failed)?;
        let rows = || {
            let mut rest = &bytes[..];
            let count = u32::from_le_bytes(*next(&mut rest)?);
            let name = |_| self.names.get(u32::from_le_bytes(*next(&mut rest)?) as usize);
            let names: Vec<&Names> = (0..count).map(name).collect::<Option<_>>()?;
            unpacked(&names, rest)
        };
        rows().ok_or_else(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(kind: RowKind, episode: u32, metrics: &[(&str, f64)]) -> Row {
        let metrics = metrics.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect();
        Row { kind, episode, seed: u64::MAX - u64::from(episode), metrics }
    }

    #[test]
    fn episodes_come_back_as_they_were_whatever_they_have() {
        let records = [
            vec![
                row(RowKind::Training, 0, &[("delay_s", 0.1), ("loss", -0.0)]),
                row(RowKind::Training, 1, &[]),
                row(RowKind::Evaluation, 0, &[("delay_s", 1e-300), ("queue_veh", 3.0)]),
            ],
            Vec::new(),
            vec![row(RowKind::Evaluation, 7, &[("queue_veh", f64::MIN_POSITIVE)])],
        ];
        let folder = tempfile::tempdir().unwrap();
        let mut setting = Setting::new(folder.path()).unwrap();
        for rows in &records {
            setting = setting.add(Some(Packed::of(rows))).unwrap();
        }
        let aside = setting.add(None).unwrap().finish().unwrap();
        for (task, rows) in records.iter().enumerate() {
            assert_eq!(aside.rows(task).unwrap(), *rows);
        }
        assert!(aside.rows(3).unwrap().is_empty());
        let e = aside.rows(4).unwrap_err().to_string();
        assert!(e.starts_with("cannot read back what was set aside in"), "{e}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "it has no name");
    }

    #[test]
    fn without_a_folder_nothing_is_set_aside() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Setting::new(&folder.path().join("missing")).is_none());
    }
}
