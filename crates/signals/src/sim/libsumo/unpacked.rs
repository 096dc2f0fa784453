//! The shim as something that the system's loader can open: memory that has a name while this process lives.
//!
//! A file in the folder for temporary files would stay behind when the process is killed, could be exchanged by
//! whoever may write there, and cannot be loaded where that folder is mounted `noexec`. It is used only where the
//! system has no such memory, or refuses to load from it.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Makes a library loadable and loads it from there; the error is the system's.
pub(super) fn unpacked<T>(
    library: &[u8],
    load: impl Fn(&Path) -> Result<T, String>,
) -> io::Result<T> {
    if let Ok((_memory, path)) = in_memory(library)
        && let Ok(loaded) = load(&path)
    {
        return Ok(loaded);
    }
    // What else is wrong is wrong with a file, too.
    let mut file = tempfile::Builder::new().prefix("libtscsumo-").suffix(".so").tempfile()?;
    file.write_all(library)?;
    let file = file.into_temp_path();
    load(&file).map_err(|reason| {
        let folder = std::env::temp_dir();
        let hint =
            "where it may not be mapped, set TMPDIR to a folder from which programs may be run";
        io::Error::other(match reason.contains("failed to map") {
            true => format!("{reason}; {}: {hint}", folder.display()),
            false => reason,
        })
    })
}

/// Returns memory with a library, and a name that holds while it is open.
#[cfg(target_os = "linux")]
fn in_memory(library: &[u8]) -> io::Result<(File, PathBuf)> {
    use std::os::fd::AsRawFd;

    use rustix::fs::{MemfdFlags, memfd_create};

    // Systems that refuse programs in memory unless they are told of them know the second flag, others do not.
    let memory = memfd_create("libtscsumo.so", MemfdFlags::CLOEXEC | MemfdFlags::EXEC)
        .or_else(|_| memfd_create("libtscsumo.so", MemfdFlags::CLOEXEC))?;
    let mut memory = File::from(memory);
    memory.write_all(library)?;
    let path = PathBuf::from(format!("/proc/self/fd/{}", memory.as_raw_fd()));
    Ok((memory, path))
}

#[cfg(not(target_os = "linux"))]
fn in_memory(_: &[u8]) -> io::Result<(File, PathBuf)> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_memory_refuses_is_loaded_from_a_file_that_goes_with_it() {
        let tried = std::cell::RefCell::new(Vec::new());
        let load = |path: &Path| {
            assert_eq!(std::fs::read(path).unwrap(), b"library");
            tried.borrow_mut().push(path.to_path_buf());
            Err::<(), _>("it failed to map a segment".to_owned())
        };
        let e = unpacked(b"library", load).unwrap_err().to_string();
        assert!(e.contains("set TMPDIR"), "{e}");
        let tried = tried.take();
        assert!(tried.len() == 2 && !tried[1].exists(), "{tried:?}");
    }
}
