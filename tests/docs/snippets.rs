//! Every code block of the documentation does what it shows: commands run, files are read.

use std::collections::BTreeSet;
use std::path::Path;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use tsc_family::cli::Cli;
use tsc_family::settings::overrides::Override;
use tsc_family::traffic::family::load::load;

use crate::blocks::{Block, Kind, blocks};
use crate::pages::{Page, markdown};

pub(crate) const REPO: &str = env!("CARGO_MANIFEST_DIR");

pub(crate) fn all_blocks() -> Vec<(Page, Vec<Block>)> {
    let pages = markdown().into_values();
    pages.map(|page| (page.clone(), blocks(&page))).collect()
}

#[test]
fn the_program_accepts_the_arguments_of_every_call() {
    let mut count = 0;
    for (_, blocks) in all_blocks() {
        for block in blocks.iter().filter(|b| matches!(b.kind, Kind::Run | Kind::Parse)) {
            for call in block.calls() {
                count += 1;
                if let Err(e) = Cli::try_parse_from(&call) {
                    panic!("{}: {}\n{e}", block.place, call.join(" "));
                }
            }
        }
    }
    assert!(count > 20, "only {count} calls found");
}

#[test]
fn what_is_not_executed_names_files_that_exist() {
    let made = ["results/", "networks/", "fuzz/corpus", "target/"];
    for (page, blocks) in all_blocks() {
        for block in blocks.iter().filter(|b| b.kind == Kind::Parse) {
            // Paths that start with a folder of the repository.
            for word in block.commands().iter().flat_map(|c| c.split_whitespace()) {
                let top = word.split(['/', '=']).next().unwrap_or_default();
                let ours = word.contains('/') && Path::new(REPO).join(top).is_dir();
                let there =
                    made.iter().any(|m| word.starts_with(m)) || Path::new(REPO).join(word).exists();
                assert!(!ours || there, "{}: no {word}", page.path.display());
            }
        }
    }
}

#[test]
fn the_examples_of_the_help_are_accepted() {
    let mut count = 0;
    for command in std::iter::once(&Cli::command()).chain(Cli::command().get_subcommands()) {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        for line in help.lines().filter(|l| l.starts_with("  tsc-family ")) {
            let call = line.split(['|', '>']).next().unwrap_or_default();
            // What an example is for stands behind three blanks.
            let call = call.trim().split("   ").next().unwrap_or_default();
            count += 1;
            if let Err(e) = Cli::try_parse_from(call.split_whitespace()) {
                panic!("help of {}: {call}\n{e}", command.get_name());
            }
        }
    }
    assert!(count > 20, "only {count} examples found");
}

#[test]
fn the_wheel_of_the_docs_is_the_one_that_ci_builds_against() {
    let project = std::fs::read_to_string(Path::new(REPO).join("python/pyproject.toml")).unwrap();
    let version = project.split_once("eclipse-sumo==").unwrap().1.split(['"', ';']).next().unwrap();
    let page = &markdown()[Path::new("docs/install.md")].text;
    assert!(page.contains(&format!("eclipse-sumo=={version}\n")), "CI has {version}");
}

/// Options of other programs that our pages name.
const OTHERS_OPTIONS: [&str; 6] =
    ["--junctions.join", "--tls.join", "--tls.guess-signals", "--lefthand", "--end", "--locked"];

/// Pages for users, whose code in the running text is of today's program.
fn user_pages() -> impl Iterator<Item = Page> {
    let theirs =
        |p: &Path| p.starts_with("docs") || p.starts_with("results") || p.ends_with("README.md");
    markdown().into_values().filter(move |page| theirs(&page.path))
}

#[test]
fn calls_and_options_in_the_text_exist() {
    let mut root = Cli::command();
    root.build();
    let names: BTreeSet<_> = root.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let options: BTreeSet<_> = root
        .get_subcommands()
        .flat_map(clap::Command::get_arguments)
        .filter_map(|a| a.get_long().map(|long| format!("--{long}")))
        .collect();
    let mut count = 0;
    for page in user_pages() {
        for code in &page.codes {
            let place = format!("{}: `{code}`", page.path.display());
            let mut words: Vec<&str> = code.split_whitespace().collect();
            if words.first() == Some(&"tsc-family") {
                words.remove(0);
            }
            let Some(first) = words.first() else { continue };
            if first.starts_with("--") {
                let option = first.split('=').next().unwrap_or_default();
                let known = options.contains(option) || OTHERS_OPTIONS.contains(&option);
                assert!(known, "{place}: there is no option {option}");
                count += 1;
            } else if names.contains(*first) && words.len() > 1 {
                // Capitals stand for something: a number will do.
                let stands = |w: &str| w.len() == 1 && w.chars().all(char::is_uppercase);
                let args = words.iter().map(|w| if stands(w) { "1" } else { w });
                let parsed = Cli::try_parse_from(["tsc-family"].into_iter().chain(args));
                let unknown = [ErrorKind::UnknownArgument, ErrorKind::InvalidSubcommand];
                if let Err(e) = parsed {
                    assert!(!unknown.contains(&e.kind()), "{place}: {e}");
                }
                count += 1;
            }
        }
    }
    assert!(count > 30, "only {count} options found in the text");
}

#[test]
fn settings_in_the_text_exist() {
    let scenario = load("smoke").unwrap().scenario;
    let sections = toml::Table::try_from(&scenario).unwrap();
    let mut count = 0;
    for page in user_pages() {
        for code in &page.codes {
            let key =
                code.trim_start_matches("--set ").split('=').next().unwrap_or_default().trim();
            let Some((section, rest)) = key.split_once('.') else { continue };
            // A table of a report has a section's name.
            if ["csv", "tex"].contains(&rest) {
                continue;
            }
            if !sections.get(section).is_some_and(toml::Value::is_table) || key.contains(' ') {
                continue;
            }
            count += 1;
            let setting: Override = format!("{key}=1").parse().unwrap();
            let message = setting.apply(&scenario).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(!message.contains("unknown setting"), "{}: {message}", page.path.display());
        }
    }
    assert!(count > 5, "only {count} settings found in the text");
}
