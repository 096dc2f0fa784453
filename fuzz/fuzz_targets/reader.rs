//! Gives any bytes to the reader that the target is called after.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (_, reader) = readers::READERS.iter().find(|(name, _)| *name == env!("CARGO_BIN_NAME")).expect("it is listed");
    reader(bytes);
});
