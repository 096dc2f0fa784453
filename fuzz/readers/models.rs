//! Readers of models and checkpoints.

use std::path::Path;

use tsc_family::nn::archive::Archive;
use tsc_family::run::model::SavedModel;
use tsc_family::traffic::control::registry::METHODS;
use tsc_family::traffic::controllers::create;
use tsc_family::traffic::family::load::load;
use tsc_family::traffic::model::SignalModel;

/// A safetensors file: it reads back, and as a model it makes a controller or is refused.
///
/// Seeds of the first format have no checksum, which would keep the fuzzer out.
pub(crate) fn archive(bytes: &[u8]) {
    let Ok(archive) = Archive::from_bytes(bytes) else { return };
    let written = archive.to_bytes();
    let read = Archive::from_bytes(&written).expect("it was written");
    // Not the archives: NaN is not equal to itself.
    assert_eq!(read.to_bytes(), written);
    let path = Path::new("fuzz.safetensors");
    let signals = |saved| SignalModel::new(saved, METHODS);
    let Ok(model) = SavedModel::of(path, archive).and_then(signals) else { return };
    let scenario = load("smoke").expect("it is embedded").scenario;
    if model.check(&scenario).is_ok() {
        let _ = model.controller("fuzz", &scenario, |scenario, seed| {
            create(&model.saved.card.method, scenario, false, seed)
        });
    }
}
