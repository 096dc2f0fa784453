//! Named tensors and a card in one file: models and checkpoints.
//!
//! The file is a [safetensors](https://github.com/huggingface/safetensors) file, which every machine
//! learning framework reads. The card is JSON under one key of its metadata: a single key, because
//! the format's metadata is a map without an order, and equal content must give equal bytes.
//!
//! The card begins with a sha256 over the file as it is without it, so that a file that was damaged is refused: a flipped
//! bit in a weight is a number like any other. Models of the first version have none, and are read all the same.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use safetensors::tensor::{Dtype, SafeTensors, View, serialize};
use serde_json::Value;

use basics::files::{self, FileError, limits, write_atomically};
use basics::hash::sha256;

/// Key of the card in the file's metadata.
const CARD_KEY: &str = "tsc-family";

/// What a card begins with in the file; the digits of the checksum and [`AFTER_CHECKSUM`] follow.
const BEFORE_CHECKSUM: &str = "{\"sha256\":\"";

/// What follows the digits of the checksum.
const AFTER_CHECKSUM: &str = "\",";

/// What follows them where the card is empty.
const AFTER_ALL: &str = "\"}";

/// Where a model's card says of which version it is.
const VERSION_KEY: &str = "format_version";

/// The version of models that had no checksum.
const WITHOUT_CHECKSUM: u32 = 1;

/// Digits of a checksum.
const DIGITS: usize = 64;

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
    /// A tensor is not there.
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
    /// A tensor holds other numbers than what it is for.
    #[error("tensor {0:?} holds numbers of another type")]
    Type(String),
    /// A model of other signals than those it is for.
    #[error("it is for signals of {found}, these have {wanted}")]
    Signals {
        /// Shape of its signals.
        found: String,
        /// Shape of these signals.
        wanted: String,
    },
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

/// Numbers with a shape, row-major.
#[derive(Debug, Clone, PartialEq)]
pub enum Tensor {
    /// Real numbers.
    F32(Vec<usize>, Vec<f32>),
    /// Whole numbers.
    U32(Vec<usize>, Vec<u32>),
}

impl Tensor {
    fn shape(&self) -> &[usize] {
        match self {
            Self::F32(shape, _) | Self::U32(shape, _) => shape,
        }
    }
}

impl View for &Tensor {
    fn dtype(&self) -> Dtype {
        match self {
            Tensor::F32(..) => Dtype::F32,
            Tensor::U32(..) => Dtype::U32,
        }
    }

    fn shape(&self) -> &[usize] {
        Tensor::shape(self)
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Owned(match self {
            Tensor::F32(_, values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Tensor::U32(_, values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        })
    }

    fn data_len(&self) -> usize {
        4 * Tensor::shape(self).iter().product::<usize>()
    }
}

/// Named tensors and a card.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Archive {
    /// What the tensors are and everything that is no tensor: an object.
    pub card: serde_json::Map<String, Value>,
    tensors: BTreeMap<String, Tensor>,
}

impl Archive {
    /// Adds real numbers.
    pub fn put_f32(&mut self, name: impl Into<String>, shape: &[usize], values: &[f32]) {
        debug_assert_eq!(shape.iter().product::<usize>(), values.len());
        self.tensors.insert(name.into(), Tensor::F32(shape.to_vec(), values.to_vec()));
    }

    /// Adds whole numbers.
    pub fn put_u32(&mut self, name: impl Into<String>, shape: &[usize], values: &[u32]) {
        debug_assert_eq!(shape.iter().product::<usize>(), values.len());
        self.tensors.insert(name.into(), Tensor::U32(shape.to_vec(), values.to_vec()));
    }

    /// Adds a value to the card.
    pub fn put(&mut self, name: &str, value: impl serde::Serialize) {
        let value = serde_json::to_value(value).expect("a card holds plain data");
        self.card.insert(name.to_owned(), value);
    }

    /// Returns a value of the card.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Card`] when it is missing or of another type.
    pub fn get<T: serde::de::DeserializeOwned>(&self, name: &str) -> Result<T, ArchiveError> {
        let value = self.card.get(name).cloned().ok_or_else(|| ArchiveError::Card(name.into()))?;
        serde_json::from_value(value).map_err(|_| ArchiveError::Card(name.into()))
    }

    /// Returns the real numbers of a tensor of this shape.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when there is no such tensor, or of another shape or type.
    pub fn f32(&self, name: &str, shape: &[usize]) -> Result<&[f32], ArchiveError> {
        match self.tensor(name, shape)? {
            Tensor::F32(_, values) => Ok(values),
            Tensor::U32(..) => Err(ArchiveError::Type(name.into())),
        }
    }

    /// Returns the whole numbers of a tensor of this shape.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] when there is no such tensor, or of another shape or type.
    pub fn u32(&self, name: &str, shape: &[usize]) -> Result<&[u32], ArchiveError> {
        match self.tensor(name, shape)? {
            Tensor::U32(_, values) => Ok(values),
            Tensor::F32(..) => Err(ArchiveError::Type(name.into())),
        }
    }

    fn tensor(&self, name: &str, shape: &[usize]) -> Result<&Tensor, ArchiveError> {
        let tensor =
            self.tensors.get(name).ok_or_else(|| ArchiveError::Missing(name.to_owned()))?;
        if tensor.shape() != shape {
            return Err(ArchiveError::Shape {
                name: name.to_owned(),
                found: tensor.shape().to_vec(),
                wanted: shape.to_vec(),
            });
        }
        Ok(tensor)
    }

    /// Moves all tensors of another archive into this one, their names behind a prefix, and its card under the
    /// prefix.
    pub fn nest(&mut self, prefix: &str, other: Self) {
        self.put(prefix, other.card);
        let named = other.tensors.into_iter().map(|(name, t)| (format!("{prefix}{name}"), t));
        self.tensors.extend(named);
    }

    /// Takes out what [`Self::nest`] moved in under a prefix that no other tensor's name begins with.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Card`] when there is none.
    pub fn take_nested(&mut self, prefix: &str) -> Result<Self, ArchiveError> {
        let card = self.get(prefix)?;
        self.card.remove(prefix);
        let inside = |name: &String| name.starts_with(prefix);
        let names: Vec<String> = self.tensors.keys().filter(|name| inside(name)).cloned().collect();
        let take = |name: String| {
            let tensor = self.tensors.remove(&name).expect("its name was listed");
            (name[prefix.len()..].to_owned(), tensor)
        };
        Ok(Self { card, tensors: names.into_iter().map(take).collect() })
    }

    /// Returns the bytes of the file; equal archives give equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (card, checksum) = (self.card_as_json(), self.checksum());
        let rest = match card.strip_prefix('{') {
            Some(rest) if !self.card.is_empty() => format!("{AFTER_CHECKSUM}{rest}"),
            _ => AFTER_ALL.to_owned(),
        };
        self.with_card(format!("{BEFORE_CHECKSUM}{checksum}{rest}"))
    }

    /// Returns the sha256 of the file as it is without its checksum.
    pub fn checksum(&self) -> String {
        sha256(&self.with_card(self.card_as_json()))
    }

    fn card_as_json(&self) -> String {
        serde_json::to_string(&self.card).expect("a card is plain data")
    }

    fn with_card(&self, card: String) -> Vec<u8> {
        let metadata = HashMap::from([(CARD_KEY.to_owned(), card)]);
        serialize(&self.tensors, Some(metadata)).expect("shapes fit their numbers")
    }

    /// Writes the file; it is either as before or complete.
    ///
    /// # Errors
    ///
    /// [`FileError`] when the folder cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        write_atomically(path, &self.to_bytes())
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// [`ArchiveError::Foreign`] when it is truncated, altered or not one of ours.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        let bytes = files::read(path, limits::ARCHIVE)?;
        Self::from_bytes(&bytes)
            .map_err(|reason| ArchiveError::Foreign { path: path.into(), reason })
    }

    /// Returns what the bytes of a file hold.
    ///
    /// # Errors
    ///
    /// Why they are no file of ours, or not as it was written.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let broken = |e| format!("not a complete safetensors file ({e})");
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let file = SafeTensors::deserialize(bytes).map_err(broken)?;
        let card = header
            .metadata()
            .as_ref()
            .and_then(|m| m.get(CARD_KEY))
            .ok_or("a safetensors file without a tsc-family card")?;
        let (checksum, own) = match without_checksum(card) {
            Some((checksum, own)) => (Some(checksum), own),
            None => (None, card.clone()),
        };
        let card: serde_json::Map<String, Value> =
            serde_json::from_str(&own).map_err(|e| format!("its card is damaged: {e}"))?;
        if checksum.is_none() && card.get(VERSION_KEY) != Some(&WITHOUT_CHECKSUM.into()) {
            return Err("it has no checksum: it is damaged".to_owned());
        }
        let mut tensors = BTreeMap::new();
        for (name, view) in file.iter() {
            let words = || view.data().as_chunks::<4>().0.iter();
            let shape = view.shape().to_vec();
            let tensor = match view.dtype() {
                Dtype::F32 => Tensor::F32(shape, words().map(|w| f32::from_le_bytes(*w)).collect()),
                Dtype::U32 => Tensor::U32(shape, words().map(|w| u32::from_le_bytes(*w)).collect()),
                other => return Err(format!("tensor {name:?} holds {other:?}")),
            };
            tensors.insert(name.to_owned(), tensor);
        }
        let archive = Self { card, tensors };
        if checksum.is_some_and(|checksum| sha256(&archive.with_card(own)) != checksum) {
            return Err("it was altered or damaged: its checksum does not match".to_owned());
        }
        Ok(archive)
    }
}

/// Parts a card as it lies in the file into its checksum and the card without it.
fn without_checksum(card: &str) -> Option<(&str, String)> {
    let (checksum, rest) = card.strip_prefix(BEFORE_CHECKSUM)?.split_at_checked(DIGITS)?;
    let without = match rest.strip_prefix(AFTER_CHECKSUM) {
        Some(rest) => format!("{{{rest}"),
        None if rest == AFTER_ALL => "{}".to_owned(),
        None => return None,
    };
    Some((checksum, without))
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
    fn a_file_cut_anywhere_is_refused() {
        let bytes = archive().to_bytes();
        for length in 0..bytes.len() {
            let (_dir, path) = file(&bytes[..length]);
            let e = Archive::read(&path).unwrap_err().to_string();
            assert!(e.contains("m.safetensors: not a complete safetensors file"), "{length}: {e}");
        }
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
    fn an_archive_without_a_card_reads_back() {
        let mut archive = Archive::default();
        archive.put_f32("w", &[1], &[2.0]);
        assert_eq!(Archive::from_bytes(&archive.to_bytes()), Ok(archive));
    }

    #[test]
    fn a_file_without_a_checksum_is_refused() {
        let bytes = archive().with_card("{\"method\":\"idqn\"}".to_owned());
        let e = Archive::from_bytes(&bytes).unwrap_err();
        assert!(e.starts_with("it has no checksum"), "{e}");
        let card = |version| format!("{{\"format_version\":{version}}}");
        assert!(Archive::from_bytes(&archive().with_card(card(2))).is_err());
        let of_a_version_without = Archive::from_bytes(&archive().with_card(card(1))).unwrap();
        assert_eq!(of_a_version_without.tensors, archive().tensors);
    }

    #[test]
    fn a_model_of_another_program_is_refused() {
        let weights = Tensor::F32(vec![1], vec![0.0]);
        let bytes = serialize([("w", &weights)], None).unwrap();
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
