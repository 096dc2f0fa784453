//! Keeps the documentation together: no dead link or anchor in any page, every page within reach of the README,
//! every code block true.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod blocks;
mod circles;
#[path = "../common/nightly.rs"]
mod nightly;
mod pages;
mod play;
mod settings_page;
mod snippets;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use pages::{Page, markdown, normal};

fn dead(page: &Page, target: &str, pages: &BTreeMap<PathBuf, Page>) -> Option<String> {
    if let Some((scheme, _)) = target.split_once(':') {
        let known = ["http", "https", "mailto"].contains(&scheme);
        return (!known).then(|| format!("unknown scheme {scheme}"));
    }
    let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
    let file = if path.is_empty() {
        page.path.clone()
    } else {
        normal(&page.path.parent().unwrap().join(path))
    };
    if !file.exists() && !pages.contains_key(&file) {
        return Some("no such file".to_owned());
    }
    if anchor.is_empty() {
        return None;
    }
    match pages.get(&file) {
        None => Some("only pages have anchors".to_owned()),
        Some(page) if page.anchors.contains(anchor) => None,
        Some(_) => Some("no such heading".to_owned()),
    }
}

#[test]
fn every_relative_link_and_anchor_exists() {
    let pages = markdown();
    let mut wrong = Vec::new();
    let mut count = 0;
    for page in pages.values() {
        for target in &page.links {
            count += 1;
            if let Some(reason) = dead(page, target, &pages) {
                wrong.push(format!("{}: {target}: {reason}", page.path.display()));
            }
        }
    }
    assert!(count > 50, "only {count} links found: are the pages still read?");
    assert!(wrong.is_empty(), "dead links:\n{}", wrong.join("\n"));
}

#[test]
fn every_page_is_within_reach_of_the_readme() {
    let pages = markdown();
    let mut reached = BTreeSet::new();
    let mut next = vec![PathBuf::from("README.md")];
    while let Some(path) = next.pop() {
        let Some(page) = pages.get(&path) else { continue };
        if !reached.insert(path.clone()) {
            continue;
        }
        let folder = page.path.parent().unwrap();
        for target in page.links.iter().filter(|t| !t.contains(':')) {
            let file = target.split('#').next().unwrap_or_default();
            next.push(normal(&folder.join(file)));
        }
    }
    let lost: Vec<_> = pages.keys().filter(|path| !reached.contains(*path)).collect();
    assert!(lost.is_empty(), "no way from the README to {lost:?}");
}
