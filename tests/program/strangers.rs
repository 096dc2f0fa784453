//! Results directories and networks from strangers, whose manifests and indices have the hashes of whatever lies beside
//! them: nothing outside is read, written or removed. What SECURITY.md promises, beside `links.rs`, `terminal.rs`,
//! `strange_files.rs`, `imported_files.rs` and `numbers.rs`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{run, stderr, stdout, succeed};
use serde_json::{Value, json};
use tsc_family::hash::sha256;
use tsc_family::store::manifest::Manifest;
use tsc_family::store::plan::plan_text;
use tsc_family::store::record::Record;

const SMOKE: &str = "run smoke --methods max-pressure,actuated --eval-seeds 1 --set demand.horizon_s=120 --quiet --out out";

/// A folder with results, and what somebody else keeps beside them.
fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), SMOKE);
    let victim = folder.path().join("victim");
    fs::create_dir(&victim).unwrap();
    fs::write(victim.join("thesis.tex"), "years").unwrap();
    (folder, victim)
}

/// The same, from such a folder.
fn again(place: &Path) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let copied = Command::new("cp").arg("-a").arg(place.join(".")).arg(folder.path()).status();
    assert!(copied.unwrap().success());
    let victim = folder.path().join("victim");
    (folder, victim)
}

fn is_whole(victim: &Path) {
    let entries: Vec<_> = fs::read_dir(victim).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(entries, ["thesis.tex"]);
    assert_eq!(fs::read_to_string(victim.join("thesis.tex")).unwrap(), "years");
}

/// Changes the manifest as its author would: records and all fit it afterwards.
fn forge(folder: &Path, change: impl Fn(&mut Value)) {
    let path = folder.join("out/manifest.json");
    let mut value: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let before = value.clone();
    change(&mut value);
    assert_ne!(value, before, "nothing was forged");
    fs::write(&path, value.to_string()).unwrap();
    // A manifest that does not parse is refused before any record is read.
    let Ok(manifest) = serde_json::from_value::<Manifest>(value) else { return };
    let mut forged = 0;
    fs::write(folder.join("out/plan.jsonl"), plan_text(&manifest.identity.tasks())).unwrap();
    for task in manifest.identity.tasks() {
        let path = folder.join(format!("out/done/000/{}.jsonl", task.task));
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let Record { summary, rows } = Record::parse(&text).unwrap();
        let result = tsc_family::store::record::TaskResult {
            rows,
            programs: summary.programs,
            ..Default::default()
        };
        let record = Record::finished(&task, &manifest.sha256(), result);
        fs::write(&path, record.to_text()).unwrap();
        forged += 1;
    }
    assert!(forged > 0, "no record was forged");
}

/// The first lines of all records, where it stands why they failed.
fn reasons(folder: &Path) -> String {
    let records = fs::read_dir(folder.join("out/done/000")).unwrap();
    let text = records.map(|record| fs::read_to_string(record.unwrap().path()).unwrap());
    text.map(|text| text.lines().next().unwrap_or_default().to_owned() + "\n").collect()
}

fn check(folder: &Path, args: &str) -> String {
    let output = run(folder, &format!("check out {args}"));
    format!("{}{}", stdout(&output), stderr(&output))
}

#[test]
fn repair_removes_no_folder_but_those_of_networks() {
    let (made, _) = place();
    for at in ["../../../../victim/thesis.tex", "/"] {
        let (folder, victim) = again(made.path());
        // Seen from the folder of the network, or as it lies on the disk.
        let absolute = victim.join("thesis.tex").display().to_string();
        let name = if at == "/" { absolute } else { at.to_owned() };
        let old = fs::canonicalize(folder.path().join("networks/smoke/busy")).unwrap();
        forge(folder.path(), |manifest| {
            let points = manifest["identity"]["points"].as_array_mut().unwrap();
            let point = points.iter_mut().find(|p| p["point"] == "busy").unwrap();
            let files = point["sha256"].as_object_mut().unwrap();
            files.insert(name.clone(), json!("0".repeat(64)));
            moved(&old, point);
        });
        fs::write(folder.path().join("out/done/000/0.jsonl"), "").unwrap();
        check(folder.path(), "--repair --networks networks/smoke");
        is_whole(&victim);
    }
}

/// Moves the files of a network to where a point MDP of a manifest has them.
fn moved(old: &Path, point: &Value) {
    let hashes = serde_json::from_value(point["sha256"].clone()).unwrap();
    let address = tsc_family::traffic::network_files::address(&hashes);
    fs::rename(old, old.with_file_name(address)).unwrap();
}

#[test]
fn a_point_mdp_that_is_called_like_a_path_is_refused() {
    let (folder, victim) = place();
    for name in ["../../../../victim/thesis", "/etc/passwd", "..", ""] {
        forge(folder.path(), |manifest| manifest["identity"]["points"][0]["point"] = json!(name));
        let said = check(folder.path(), "--repair --networks networks/smoke");
        assert!(said.contains(&format!("a point MDP cannot be called {name:?}")), "{said}");
        is_whole(&victim);
    }
}

#[test]
fn networks_that_link_elsewhere_are_not_removed() {
    let (folder, victim) = place();
    let networks = folder.path().join("networks/smoke");
    fs::rename(networks.join("by-hash"), victim.join("by-hash")).unwrap();
    std::os::unix::fs::symlink(victim.join("by-hash"), networks.join("by-hash")).unwrap();
    let net = fs::canonicalize(networks.join("busy/busy.net.xml")).unwrap();
    fs::write(&net, "<net/>").unwrap();
    fs::write(folder.path().join("out/done/000/0.jsonl"), "").unwrap();
    let said = check(folder.path(), "--repair --networks networks/smoke");
    assert!(said.contains("by-hash: it is a link"), "{said}");
    assert!(net.exists());
}

/// Results of somebody's own scenario, whose manifest is made for what is in it now.
fn imported(folder: &Path, additional: &str) {
    fs::create_dir(folder.join("city")).unwrap();
    for ending in ["net.xml", "rou.xml"] {
        let from = folder.join(format!("networks/smoke/busy/busy.{ending}"));
        fs::copy(from, folder.join(format!("city/busy.{ending}"))).unwrap();
    }
    let config = "<c><n v='busy.net.xml'/><r v='busy.rou.xml'/><a v='a.add.xml'/><e v='60'/></c>";
    fs::write(folder.join("city/busy.sumocfg"), config).unwrap();
    fs::write(folder.join("city/a.add.xml"), "<additional/>").unwrap();
    fs::remove_dir_all(folder.join("out")).unwrap();
    succeed(
        folder,
        "run --sumocfg city/busy.sumocfg --methods program --eval-seeds 1 --quiet --out out",
    );
    fs::write(folder.join("city/a.add.xml"), additional).unwrap();
    forge(folder, |manifest| {
        manifest["identity"]["points"][0]["sha256"]["a.add.xml"] =
            json!(sha256(additional.as_bytes()));
    });
    fs::write(folder.join("out/done/000/0.jsonl"), "").unwrap();
}

#[test]
fn what_a_stranger_s_scenario_would_write_goes_nowhere_and_what_it_would_draw_in_is_refused() {
    let (made, _) = place();
    for (additional, expected) in [
        (
            "<additional><inductionLoop id='d' lane='in0_0' pos='1' period='1' file='../victim/thesis.tex'/></additional>",
            "2 of 2 records are sound",
        ),
        (
            "<!DOCTYPE a [<!ENTITY x SYSTEM '../victim/thesis.tex'>]><additional>&x;</additional>",
            "a <!DOCTYPE> can draw other files in",
        ),
        (
            "<additional><include href='../victim/thesis.tex'/></additional>",
            "thesis.tex, which lies outside the scenario; pass --accept outside-files",
        ),
    ] {
        let (folder, victim) = again(made.path());
        imported(folder.path(), additional);
        let said = check(folder.path(), "--repair") + reasons(folder.path()).as_str();
        assert!(said.contains(expected), "{said}");
        is_whole(&victim);
    }
}

/// Exchanges text in a file of the network that the run has, with an index and a manifest that fit it.
fn network(folder: &Path, ending: &str, from: &str, to: &str) {
    let file = format!("busy.{ending}");
    let old = fs::canonicalize(folder.join("networks/smoke/busy")).unwrap();
    let text = fs::read_to_string(old.join(&file)).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(old.join(&file), text.replacen(from, to, 1)).unwrap();
    forge(folder, |manifest| {
        let points = manifest["identity"]["points"].as_array_mut().unwrap();
        let point = points.iter_mut().find(|p| p["point"] == "busy").unwrap();
        point["sha256"][&file] = json!(sha256(&fs::read(old.join(&file)).unwrap()));
        moved(&old, point);
    });
    let records = fs::read_dir(folder.join("out/done/000")).unwrap();
    records.for_each(|record| fs::write(record.unwrap().path(), "").unwrap());
}

#[test]
fn what_a_stranger_s_network_would_draw_in_or_write_is_not_simulated() {
    let (made, _) = place();
    let inject = r#""to": "out1\"/><include href=\"../../../../victim/thesis.tex"#;
    for (ending, from, to, expected) in [
        ("demand.json", "\"to\": \"out1", inject, "is no name of an edge, a lane or a speed"),
        (
            "net.xml",
            "<location",
            "<include href=\"../../../../victim/thesis.tex\"/><location",
            "thesis.tex, which lies outside the scenario",
        ),
        ("net.xml", "<net ", "<!DOCTYPE net SYSTEM \"x\"><net ", "a <!DOCTYPE> can draw"),
        (
            "rou.xml",
            "<routes",
            "<routes x=\"1\" file=\"../x\"",
            "it is not as networks are generated: outputs are not written: 1",
        ),
        (
            "sumocfg",
            "<net-file",
            "<additional-files value=\"../../../../victim/thesis.tex\"/><net-file",
            "thesis.tex",
        ),
        (
            "sumocfg",
            "<net-file",
            "<remote-port value=\"1\"/><net-file",
            "it is not as networks are generated: remote-port",
        ),
    ] {
        let (folder, victim) = again(made.path());
        network(folder.path(), ending, from, to);
        let said = check(folder.path(), "--repair --jobs 1") + reasons(folder.path()).as_str();
        assert!(said.contains(expected), "{ending}: {said}");
        is_whole(&victim);
        let simulated = "\"point\":\"busy\",\"replicate\":0,\"seed\":";
        let ok = |text: &&str| text.contains(simulated) && text.contains("\"outcome\":\"ok\"");
        assert_eq!(reasons(folder.path()).lines().find(ok), None);
    }
}

/// What runs where a page shows it as it is.
const MARKUP: &str = "<img src=x onerror=alert(1)>";

/// Puts markup into all text of a value, but where it says what the rest means.
fn mark(value: &mut Value, key: &str) {
    let plain = [
        "sha256", "method", "methods", "replicated", "baseline", "objective", "environment",
        "sampling",
    ];
    match value {
        _ if plain.contains(&key) => {}
        Value::Object(members) => members.iter_mut().for_each(|(key, value)| mark(value, key)),
        Value::Array(members) => members.iter_mut().for_each(|value| mark(value, key)),
        Value::String(text) if key == "unit" => *text = MARKUP.to_owned(),
        Value::String(text) => text.push_str(MARKUP),
        _ => {}
    }
}

#[test]
fn what_a_stranger_s_results_say_is_text_on_every_page() {
    let (folder, _) = place();
    forge(folder.path(), |manifest| {
        for part in ["points", "features", "scenario", "simulator"] {
            mark(&mut manifest["identity"][part], part);
        }
        // A sample names point MDPs too.
        mark(&mut manifest["identity"]["sample"]["draws"], "draws");
        mark(&mut manifest["provenance"], "provenance");
        manifest["identity"]["settings"]["title"] = json!(MARKUP);
    });
    succeed(folder.path(), "report out");
    succeed(folder.path(), "sensitivity out");
    let mut pages = 0;
    for part in ["report", "sensitivity"] {
        for entry in fs::read_dir(folder.path().join("out").join(part)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "html" || e == "svg") {
                let text = fs::read_to_string(&path).unwrap();
                assert!(!text.contains("<img src=x"), "{}", path.display());
                pages += usize::from(text.contains("&lt;img src=x"));
            }
        }
    }
    assert!(pages >= 2, "only {pages} pages have it");
}
