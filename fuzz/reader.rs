//! Gives any bytes to the reader that the environment variable `READER` names.
#![no_main]

mod readers;

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use readers::{READERS, Reader};

/// The reader. One program for all of them, because linking it takes longer than what it finds first.
static READER: LazyLock<Reader> = LazyLock::new(|| {
    let named = std::env::var("READER").unwrap_or_default();
    let names = READERS.map(|(name, _)| name).join(", ");
    let reader = READERS.iter().find(|(name, _)| *name == named);
    reader.unwrap_or_else(|| panic!("READER={named:?}: give one of {names}")).1
});

fuzz_target!(|bytes: &[u8]| READER(bytes));
