//! The shim as something that the system's loader can open: memory that has a name while this process lives.
//!
//! A file in the folder for temporary files would stay behind when the process is killed, could be exchanged by
//! whoever may write there, and cannot be loaded where that folder is mounted `noexec`. It is used only where the
//! system has no such memory, or refuses to load from it.

use std::fs::File;
use std::io::{self, Write};
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};

use tempfile::TempPath;

/// A library that can be loaded for as long as this is there.
#[derive(Debug)]
enum Unpacked {
    /// In memory, by a name that holds while the file is open.
    Memory { path: PathBuf, _memory: File },
    /// In a file, which is deleted when this goes.
    File(TempPath),
}

/// How the system's loader says that it may not load from somewhere.
const REFUSALS: [&str; 3] = ["failed to map", "not permitted", "denied"];

/// Makes a library loadable and loads it.
/// * `load` — from a path; in an error, why not.
///
/// The error is the system's, with the way out where it may not load from the folder for temporary files.
pub(super) fn unpacked<T>(
    library: &[u8],
    load: impl Fn(&Path) -> Result<T, String>,
) -> io::Result<T> {
    if let Ok(memory) = in_memory(library) {
        match load(memory.path()) {
            Err(reason) if is_refusal(&reason) => {}
            result => return result.map_err(io::Error::other),
        }
    }
    let file = in_file(library)?;
    load(file.path()).map_err(|reason| io::Error::other(file.explained(reason)))
}

fn is_refusal(reason: &str) -> bool {
    REFUSALS.iter().any(|words| reason.contains(words))
}

#[cfg(target_os = "linux")]
fn in_memory(library: &[u8]) -> io::Result<Unpacked> {
    use rustix::fs::{MemfdFlags, memfd_create};

    // Systems that refuse programs in memory unless they are told of them know the second flag, others do not.
    let memory = memfd_create("libtscsumo.so", MemfdFlags::CLOEXEC | MemfdFlags::EXEC)
        .or_else(|_| memfd_create("libtscsumo.so", MemfdFlags::CLOEXEC))?;
    let mut memory = File::from(memory);
    memory.write_all(library)?;
    let path = PathBuf::from(format!("/proc/self/fd/{}", memory.as_raw_fd()));
    // Where /proc is missing, and where memory may not be run, the loader could not open it either.
    rustix::fs::access(&path, rustix::fs::Access::EXEC_OK)?;
    Ok(Unpacked::Memory { path, _memory: memory })
}

#[cfg(not(target_os = "linux"))]
fn in_memory(_: &[u8]) -> io::Result<Unpacked> {
    Err(io::ErrorKind::Unsupported.into())
}

fn in_file(library: &[u8]) -> io::Result<Unpacked> {
    let mut file = tempfile::Builder::new().prefix("libtscsumo-").suffix(".so").tempfile()?;
    file.write_all(library)?;
    Ok(Unpacked::File(file.into_temp_path()))
}

impl Unpacked {
    /// What to load.
    fn path(&self) -> &Path {
        match self {
            Self::Memory { path, .. } => path,
            Self::File(path) => path,
        }
    }

    /// Returns why it could not be loaded, with the way out where the folder may be the reason.
    fn explained(&self, reason: String) -> String {
        match self {
            Self::File(path) if is_refusal(&reason) => {
                let folder = path.parent().unwrap_or(path).display();
                format!(
                    "{reason}; {folder} may be mounted noexec: set TMPDIR to a folder from which programs may be \
                     run"
                )
            }
            _ => reason,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_library_in_memory_leaves_no_file() {
        let unpacked = in_memory(b"library").unwrap();
        assert_eq!(std::fs::read(unpacked.path()).unwrap(), b"library");
        let to = std::fs::read_link(unpacked.path()).unwrap();
        assert_eq!(to.to_string_lossy(), "/memfd:libtscsumo.so (deleted)");
    }

    #[test]
    fn what_memory_refuses_is_loaded_from_a_file_and_other_reasons_are_told() {
        let tried = std::cell::RefCell::new(Vec::new());
        let load = |path: &Path| {
            tried.borrow_mut().push(path.to_path_buf());
            match tried.borrow().len() {
                1 => Err("memfd: failed to map segment".to_owned()),
                _ => Ok(()),
            }
        };
        unpacked(b"library", load).unwrap();
        let missing = |_: &Path| Err::<(), _>("libsumocpp.so: cannot open".to_owned());
        assert_eq!(unpacked(b"x", missing).unwrap_err().to_string(), "libsumocpp.so: cannot open");
    }

    #[test]
    fn a_library_in_a_file_goes_with_it_and_says_what_to_do_on_noexec() {
        let unpacked = in_file(b"library").unwrap();
        let path = unpacked.path().to_path_buf();
        assert_eq!(std::fs::read(&path).unwrap(), b"library");
        let e = unpacked.explained("x.so: failed to map segment from shared object".into());
        assert!(e.contains("may be mounted noexec: set TMPDIR"), "{e}");
        assert_eq!(
            unpacked.explained("libproj.so.25: cannot open".into()),
            "libproj.so.25: cannot open"
        );
        drop(unpacked);
        assert!(!path.exists());
    }
}
