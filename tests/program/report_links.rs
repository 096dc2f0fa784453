use std::fs;
use std::path::{Path, PathBuf};

fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|ending| ending == "html") {
            found.push(path);
        }
    }
    found
}

/// Checks that every file exists that a page of a report names, and returns how many pages there are.
pub(crate) fn lead_somewhere(report: &Path) -> usize {
    let pages = pages(report);
    for page in &pages {
        let text = fs::read_to_string(page).unwrap();
        let links = ["href=\"", "src=\""].into_iter().flat_map(|name| text.split(name).skip(1));
        for link in links.filter_map(|rest| rest.split('"').next()) {
            let link = link.replace("&#x2f;", "/").replace("&amp;", "&");
            let file = link.split(['#', '?']).next().unwrap_or_default();
            if file.is_empty() || link.contains("://") || link.starts_with("data:") {
                continue;
            }
            let to = page.parent().unwrap().join(file);
            assert!(to.exists(), "{}: {link} leads nowhere", page.display());
        }
    }
    pages.len()
}
