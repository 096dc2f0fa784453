//! A leaderboard: all methods of many results directories on one page.

use std::path::Path;

use super::compare::CompareArgs;
use super::folder::check_file;
use super::found::found;
use super::output::{line, note};
use crate::analysis::joined::{Known, Source};
use crate::analysis::leaderboard::leaderboard;
use crate::cli::exit;
use crate::domains;
use crate::files::write_atomically;
use crate::report::leaderboard::{json, markdown};
use crate::store::Layout;
use crate::store::results::Results;

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<u8> {
    if let Some(path) = &args.out {
        check_file(path, "--out", &[b"# Leaderboard"], "leaderboard")?;
    }
    let mut runs = Vec::new();
    for path in found(&args.results)? {
        let layout = Layout::new(&path);
        let results = Results::load(&layout)?;
        let analysis = domains::analysis(&layout, &results)?;
        let path = path.display().to_string();
        runs.push((Source { name: path.clone(), path, results }, analysis));
    }
    let domains: Vec<_> = (domains::domains().into_iter())
        .map(|domain| (domain, domain.methods().iter().map(|m| m.name).collect::<Vec<&str>>()))
        .collect();
    let known = |name: &str| match domains.iter().find(|(domain, _)| domain.name() == name) {
        None => Known { methods: &[], episodes: &[] },
        Some((domain, methods)) => Known { methods, episodes: domain.episode_sections() },
    };
    let tables = leaderboard(runs, &known);
    if args.json {
        json(&tables).into_iter().try_for_each(line)?;
        return Ok(exit::DONE);
    }
    let folder = args.out.as_deref().and_then(Path::parent);
    let folder = folder.filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let page = markdown(&tables, &|path| from(folder, Path::new(path)));
    match &args.out {
        None => line(page.trim_end())?,
        Some(path) => {
            write_atomically(path, page.as_bytes())?;
            note(format!("leaderboard: {}", path.display()));
        }
    }
    Ok(exit::DONE)
}

/// Returns a path as seen from a folder: without what both begin with.
fn from(folder: &Path, path: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (folder, whole) = (absolute(folder), absolute(path));
    whole.strip_prefix(&folder).unwrap_or(path).display().to_string()
}
