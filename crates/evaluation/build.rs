//! Tells the program which revision and which compiler it was built from.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // Only files that exist: a missing one would make every build run this script again.
    for file in ["../../.git/HEAD", "../../.git/logs/HEAD"] {
        if Path::new(file).exists() {
            println!("cargo:rerun-if-changed={file}");
        }
    }
    // Whatever lies there comes with the program.
    let root = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let folder = Path::new(&root).join("../../data/published");
    println!("cargo:rerun-if-changed={}", folder.display());
    let files = std::fs::read_dir(folder).expect("data/published is a folder");
    let mut files: Vec<_> = files.map(|file| file.expect("it can be listed").path()).collect();
    files.sort();
    let texts: String = files.iter().map(|file| format!("include_str!({file:?}),")).collect();
    let out = std::env::var("OUT_DIR").expect("cargo sets it");
    std::fs::write(format!("{out}/published.rs"), format!("&[{texts}]"))
        .expect("it can be written");
    let git = output("git", &["describe", "--always", "--dirty", "--exclude=*"]);
    println!("cargo:rustc-env=TSC_FAMILY_GIT={git}");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    println!("cargo:rustc-env=TSC_FAMILY_RUSTC={}", output(&rustc, &["--version"]));
}

fn output(program: &str, args: &[&str]) -> String {
    Command::new(program)
        .args(args)
        .output()
        .ok()
        .filter(|o| o.status.success())
        .and_then(|o| String::from_utf8(o.stdout).ok())
        .map_or_else(|| "unknown".to_owned(), |text| text.trim().to_owned())
}
