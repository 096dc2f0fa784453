//! `--model`: what is refused, word by word.

use std::fs;

use crate::folder::Folder;
use serde_json::{Value, json};
use tsc_family::nn::archive::Archive;
use tsc_family::run::checkpoint::FORMAT_VERSION;

fn model(method: &str) -> Archive {
    let card = json!({
        "kind": "model",
        "format_version": FORMAT_VERSION,
        "method": method,
        "point": "quiet",
        "replicate": 0,
        "seed": 1,
        "training_episodes": 2,
        "settings": {},
        "signal": {"delta_time_s": 10, "yellow_time_s": 3, "detection_m": 200.0},
        "tsc_family": "0.1.0",
        "git": "unknown",
        "simulator": "SUMO 1.15.0",
        "evaluation": {"seeds": [1], "delay_s": 9.0},
        "learner": {},
    });
    let mut archive = Archive::default();
    archive.card = card.as_object().unwrap().clone();
    archive.put_f32("w", &[1], &[0.5]);
    archive
}

fn with(mut archive: Archive, key: &str, value: Value) -> Archive {
    archive.put(key, value);
    archive
}

fn refusal(bytes: &[u8]) -> String {
    let folder = Folder::new();
    fs::write(folder.join("m.safetensors"), bytes).unwrap();
    let said = folder.says(2, "run smoke --methods baseline --model m=m.safetensors --out out");
    assert!(!folder.has("networks"), "nothing is built for a model that cannot be used");
    said
}

#[test]
fn a_file_that_is_no_usable_model_is_refused_with_its_name() {
    let whole = model("max-pressure").to_bytes();
    // A safetensors file without metadata: eight bytes of length, then an empty header.
    let foreign = [&8_u64.to_le_bytes()[..], b"{}      "].concat();
    let cases = [
        ("truncated", whole[..whole.len() - 1].to_vec()),
        ("no_safetensors", b"hello".to_vec()),
        ("foreign", foreign),
        ("checkpoint", with(model("idqn"), "kind", json!("checkpoint")).to_bytes()),
        ("neither", with(model("idqn"), "kind", json!("report")).to_bytes()),
        ("version", with(model("idqn"), "format_version", json!(9)).to_bytes()),
        ("no_seed", with(model("idqn"), "seed", json!("x")).to_bytes()),
        ("no_learner", whole),
        ("method", model("idqn2").to_bytes()),
        ("setting", with(model("idqn"), "settings", json!({"colour": "red"})).to_bytes()),
        (
            "range",
            with(
                model("idqn"),
                "signal",
                json!({"delta_time_s": 0, "yellow_time_s": 3, "detection_m": 200.0}),
            )
            .to_bytes(),
        ),
    ];
    let text: String =
        cases.iter().map(|(name, bytes)| format!("{name}: {}", refusal(bytes))).collect();
    insta::with_settings!({filters => vec![("known are .*", "known are ...")]}, {
        insta::assert_snapshot!("refused_models", text);
    });
}
