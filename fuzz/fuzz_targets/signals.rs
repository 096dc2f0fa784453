//! Any bytes as a signal list.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use osm_signals::signals::{SignalColumns, SignalList};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(list) =
        SignalList::from_bytes(bytes, Path::new("fuzz.csv"), &SignalColumns::default())
    {
        assert!(!list.signals.is_empty(), "a list without signals is an error");
    }
});
