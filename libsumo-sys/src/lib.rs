//! Declarations of libsumo through a C shim of batched calls, and the shim itself.
//!
//! The build script compiles `csrc/shim.cpp` to a shared object and embeds it as [`SHIM`]; a user
//! writes it to a file and loads it with [`Shim::new`]. A program that depends on this crate
//! therefore starts on a machine without SUMO. This crate has no logic of its own.

/// The shared object to load: `csrc/shim.cpp`, linked to [`LIBRARY`].
pub const SHIM: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/libtscsumo.so"));

/// Where libsumo came from at build time: `eclipse-sumo`, `debian` or `custom`.
pub const KIND: &str = env!("LIBSUMO_KIND");

/// The libsumo that the shim loads, as found at build time.
pub const LIBRARY: &str = env!("LIBSUMO_LIBRARY");

/// The folder of the headers that the shim was compiled with.
pub const INCLUDE_DIR: &str = env!("LIBSUMO_INCLUDE");

/// Returns what [`LIBRARY`] says of its version, such as `SUMO 1.15.0`, without loading it, which takes a tenth of a second
/// of the processor; `None` where it is not the file of the build any more.
pub fn version() -> Option<&'static str> {
    let (version, built) = (env!("LIBSUMO_VERSION"), env!("LIBSUMO_STAMP"));
    let is_same = stamp(LIBRARY.as_ref()).is_some_and(|stamp| stamp == built);
    (is_same && !version.is_empty()).then_some(version)
}

include!("stamp.rs");

#[expect(
    missing_docs,
    unsafe_code,
    clippy::missing_safety_doc,
    clippy::undocumented_unsafe_blocks,
    reason = "generated; csrc/shim.h documents it"
)]
mod shim {
    include!(concat!(env!("OUT_DIR"), "/shim.rs"));
}

#[expect(missing_docs, reason = "generated from libsumo/TraCIConstants.h")]
mod constants {
    include!(concat!(env!("OUT_DIR"), "/constants.rs"));
}

pub use constants::*;
/// Loads a shared object, as [`Shim::new`] loads the shim.
pub use libloading::Library;
pub use shim::*;
