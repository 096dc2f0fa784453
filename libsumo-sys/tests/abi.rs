//! The embedded shim loads, and it, the headers and the library are of the same version.
#![expect(unsafe_code, reason = "this is about the C functions themselves")]

use std::ffi::CStr;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::ptr;

use libsumo_sys::{
    INCLUDE_DIR, LIBRARY, SHIM, SUMO_NOT_RUNNING, SUMO_OK, Shim, SumoCounts, TRACI_VERSION,
    TRAFFICLIGHT_TYPE_ACTUATED, TRAFFICLIGHT_TYPE_STATIC,
};

fn shim() -> Shim {
    let mut file = tempfile::NamedTempFile::new().expect("a temporary folder");
    file.write_all(SHIM).expect("a writable file");
    // SAFETY: the declarations were generated from this library's header.
    unsafe { Shim::new(file.path()) }.expect("SUMO is installed")
}

#[test]
fn the_library_speaks_the_traci_version_of_the_headers() {
    let (mut api, mut text) = (0, ptr::null());
    // SAFETY: both point to writable variables.
    let code = unsafe { shim().sumo_version(&raw mut api, &raw mut text) };
    assert_eq!((code, api), (SUMO_OK, TRACI_VERSION));
    assert!(Path::new(LIBRARY).is_file());
}

#[test]
fn the_constants_are_those_of_the_header() {
    let header = Path::new(INCLUDE_DIR).join("libsumo/TraCIConstants.h");
    let header = fs::read_to_string(header).unwrap();
    for (name, value) in [
        ("TRAFFICLIGHT_TYPE_STATIC", TRAFFICLIGHT_TYPE_STATIC),
        ("TRAFFICLIGHT_TYPE_ACTUATED", TRAFFICLIGHT_TYPE_ACTUATED),
    ] {
        assert!(header.contains(&format!("{name} = {value:#04x};")), "{name} = {value}");
    }
}

#[test]
fn a_call_without_a_simulation_returns_a_code_and_a_text() {
    let shim = shim();
    let mut counts = SumoCounts::default();
    // SAFETY: `counts` is writable.
    let code = unsafe { shim.sumo_step(1, &raw mut counts) };
    assert_eq!(code, SUMO_NOT_RUNNING);
    // SAFETY: has no conditions.
    let text = unsafe { shim.sumo_last_error() };
    // SAFETY: the shim's texts end with a null byte.
    let text = unsafe { CStr::from_ptr(text) };
    assert_eq!(text.to_str(), Ok("no simulation is running"));
}
