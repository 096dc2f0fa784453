//! Named tensors and a card in one file: models and checkpoints.
//!
//! The file is a [safetensors](https://github.com/huggingface/safetensors) file, which every machine
//! learning framework reads. The card is JSON under one key of its metadata: a single key, because
//! the format's metadata is a map without an order, and equal content must give equal bytes.
//!
//! The card has a sha256 over the file as it is without it, so that a file that was damaged is refused: a flipped bit in a
//! weight is a number like any other.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde_json::{Map, Value};

use basics::files::{self, FileError, limits, write_atomically};
use basics::hash::sha256;

const CARD_KEY: &str = "tsc-family";

const CHECKSUM: &str = "sha256";

/// Why a model or a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// Not such a file at all.
    #[error("{}: {reason}; give a file that tsc-family has written", .path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A tensor is not there, or holds numbers of another type.
    #[error("it has no tensor {0:?}")]
    Missing(String),
    /// A tensor has another shape than what it is for.
    #[error("tensor {name:?} has shape {found:?}, but {wanted:?} is needed")]
    Shape {
        /// The tensor.
        name: String,
        /// Shape in the file.
        found: Vec<usize>,
        /// Shape that is needed.
        wanted: Vec<usize>,
    },
    /// A model of something else than what it is for.
    #[error("{0}")]
    Unfit(String),
    /// A tensor with infinities or what is no number.
    #[error("tensor {0:?} holds infinities or NaN; the training that wrote it diverged")]
    NotFinite(String),
    /// The card lacks a value or has a wrong one.
    #[error("its card has no valid {0:?}")]
    Card(String),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Type and shape of numbers, row-major, and the numbers as bytes of the file.
type Tensor = (Dtype, Vec<usize>, Vec<u8>);

/// Named tensors and a card.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Archive {
    /// What the tensors are and everything that is no tensor: an object.
    pub card: Map<String, Value>,
    tensors: BTreeMap<String, Tensor>,
}

impl Archive {
    /// Adds real numbers.
    pub fn put_f32(&mut self, name: impl Into<String>, shape: &[usize], values: &[f32]) {
        let data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensors.insert(name.into(), (Dtype::F32, shape.into(), data));
    }

    /// Adds whole numbers.
    pub fn put_u32(&mut self, name: impl Into<String>, shape: &[usize], values: &[u32]) {
        let data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensors.insert(name.into(), (Dtype::U32, shape.into(), data));
    }

    /// Adds a value to the card.
    pub fn put(&mut self, name: &str, value: impl serde::Serialize) {
        let value = serde_json::to_value(value).expect("a card holds plain data");
        self.card.insert(name.to_owned(), value);
    }

    /// Returns a value of the card.
    pub fn get<T: serde::de::DeserializeOwned>(&self, name: &str) -> Result<T, ArchiveError> {
        let value = self.card.get(name).cloned().ok_or_else(|| ArchiveError::Card(name.into()))?;
        serde_json::from_value(value).map_err(|_| ArchiveError::Card(name.into()))
    }

    /// Returns the real numbers of a tensor; fails where there is none of this name, shape and type.
    pub fn f32(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, ArchiveError> {
        let words = self.words(name, shape, Dtype::F32)?;
        Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
    }

    /// As [`Self::f32`], and refuses infinities and NaN.
    pub fn finite(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, ArchiveError> {
        let numbers = self.f32(name, shape)?;
        match numbers.iter().all(|number| number.is_finite()) {
            true => Ok(numbers),
            false => Err(ArchiveError::NotFinite(name.to_owned())),
        }
    }

    /// Returns the whole numbers of a tensor; fails as [`Self::f32`].
    pub fn u32(&self, name: &str, shape: &[usize]) -> Result<Vec<u32>, ArchiveError> {
        let words = self.words(name, shape, Dtype::U32)?;
        Ok(words.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    fn words(
        &self,
        name: &str,
        wanted: &[usize],
        dtype: Dtype,
    ) -> Result<&[[u8; 4]], ArchiveError> {
        let tensor = self.tensors.get(name).filter(|tensor| tensor.0 == dtype);
        let (_, shape, data) = tensor.ok_or_else(|| ArchiveError::Missing(name.to_owned()))?;
        if shape != wanted {
            let (found, wanted) = (shape.clone(), wanted.to_vec());
            return Err(ArchiveError::Shape { name: name.to_owned(), found, wanted });
        }
        Ok(data.as_chunks().0)
    }

    /// Puts another archive into this one, under a name.
    pub fn nest(&mut self, name: &str, other: &Self) {
        let data = other.to_bytes();
        let shape = vec![data.len()];
        self.tensors.insert(name.to_owned(), (Dtype::U8, shape, data));
    }

    /// Takes out what [`Self::nest`] put in; [`ArchiveError::Missing`] when there is none.
    pub fn take_nested(&mut self, name: &str) -> Result<Self, ArchiveError> {
        let tensor = self.tensors.remove(name);
        let read = tensor.and_then(|tensor| Self::from_bytes(&tensor.2).ok());
        read.ok_or_else(|| ArchiveError::Missing(name.to_owned()))
    }

    /// Returns the bytes of the file; equal archives give equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut card = self.card.clone();
        card.insert(CHECKSUM.to_owned(), self.checksum().into());
        self.with_card(&card)
    }

    /// Returns the sha256 of the file as it is without its checksum.
    pub fn checksum(&self) -> String {
        sha256(&self.with_card(&self.card))
    }

    fn with_card(&self, card: &Map<String, Value>) -> Vec<u8> {
        let card = serde_json::to_string(card).expect("a card is plain data");
        let metadata = HashMap::from([(CARD_KEY.to_owned(), card)]);
        let views = self.tensors.iter().map(|(name, (dtype, shape, data))| {
            let view = TensorView::new(*dtype, shape.clone(), data);
            (name, view.expect("shapes fit their numbers"))
        });
        serialize(views, Some(metadata)).expect("shapes fit their numbers")
    }

    /// Writes the file; it is either as before or complete.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        write_atomically(path, &self.to_bytes())
    }

    /// Reads a file; [`ArchiveError::Foreign`] when it is truncated, altered or not one of ours.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        let bytes = files::read(path, limits::ARCHIVE)?;
        Self::from_bytes(&bytes)
            .map_err(|reason| ArchiveError::Foreign { path: path.into(), reason })
    }

    /// Returns what the bytes of a file hold, or why they are no file of ours, or not as it was written.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let broken = |e| format!("not a complete safetensors file ({e})");
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let file = SafeTensors::deserialize(bytes).map_err(broken)?;
        let card = header
            .metadata()
            .as_ref()
            .and_then(|m| m.get(CARD_KEY))
            .ok_or("a safetensors file without a tsc-family card")?;
        let mut card: Map<String, Value> =
            serde_json::from_str(card).map_err(|e| format!("its card is damaged: {e}"))?;
        let checksum = card.remove(CHECKSUM).ok_or("it has no checksum: it is damaged")?;
        let tensor = |(name, view): (&str, TensorView<'_>)| {
            let (dtype, shape) = (view.dtype(), view.shape().to_vec());
            (name.to_owned(), (dtype, shape, view.data().to_vec()))
        };
        let archive = Self { card, tensors: file.iter().map(tensor).collect() };
        if checksum != archive.checksum() {
            return Err("it was altered or damaged: its checksum does not match".to_owned());
        }
        Ok(archive)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn archive() -> Archive {
        let mut archive = Archive::default();
        archive.put("method", "idqn");
        archive.put_f32("weights", &[2, 2], &[1.0, -0.5, f32::MIN_POSITIVE, 3.25]);
        archive.put_u32("actions", &[3], &[0, 7, u32::MAX]);
        archive
    }

    fn file(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("m.safetensors");
        fs::write(&path, bytes).unwrap();
        (dir, path)
    }

    #[test]
    fn an_archive_reads_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("m.safetensors");
        archive().write(&path).unwrap();
        let read = Archive::read(&path).unwrap();
        assert_eq!(read, archive());
        assert_eq!(read.get::<String>("method").unwrap(), "idqn");
        assert_eq!(read.u32("actions", &[3]).unwrap(), [0, 7, u32::MAX]);
    }

    #[test]
    fn a_file_with_any_bit_flipped_is_refused_or_the_same() {
        let bytes = archive().to_bytes();
        let mut refused = 0;
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            match Archive::from_bytes(&damaged) {
                Ok(read) => assert_eq!(read, archive(), "bit {bit}"),
                Err(_) => refused += 1,
            }
        }
        // Blanks that fill up the header may be other ones.
        assert!(refused > 8 * bytes.len() * 9 / 10, "{refused} of {}", 8 * bytes.len());
    }

    #[test]
    fn a_model_of_another_program_is_refused() {
        let weights = TensorView::new(Dtype::F32, vec![1], &[0; 4]).unwrap();
        let bytes = serialize([("w", weights)], None).unwrap();
        let (_dir, path) = file(&bytes);
        let e = Archive::read(&path).unwrap_err().to_string();
        assert!(e.contains("without a tsc-family card; give a file that tsc-family has"), "{e}");
    }

    #[test]
    fn another_shape_or_type_is_named() {
        let e = archive().f32("weights", &[4]).unwrap_err().to_string();
        assert_eq!(e, "tensor \"weights\" has shape [2, 2], but [4] is needed");
        assert!(archive().f32("actions", &[3]).is_err());
        assert_eq!(archive().u32("x", &[3]).unwrap_err().to_string(), "it has no tensor \"x\"");
    }
}
