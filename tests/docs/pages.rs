//! The markdown pages of the repository: their links, the anchors of their headings, their code blocks.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// Folders without pages of ours.
const OTHERS: [&str; 4] = ["target", ".git", "node_modules", "corpus"];

#[derive(Debug, Clone)]
pub(crate) struct Page {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    pub(crate) links: Vec<String>,
    /// Code in the running text.
    pub(crate) codes: Vec<String>,
    pub(crate) anchors: BTreeSet<String>,
}

impl Page {
    pub(crate) fn read(path: PathBuf, text: String) -> Self {
        let mut links = Vec::new();
        let mut codes = Vec::new();
        let mut titles: Vec<String> = Vec::new();
        let mut heading = false;
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    links.push(dest_url.to_string());
                }
                Event::Start(Tag::Heading { .. }) => {
                    heading = true;
                    titles.push(String::new());
                }
                Event::End(TagEnd::Heading(_)) => heading = false,
                Event::Text(part) | Event::Code(part) if heading => {
                    titles.last_mut().expect("a heading has begun").push_str(&part);
                }
                Event::Code(part) => codes.push(part.to_string()),
                _ => {}
            }
        }
        Self { path, anchors: anchors(&titles), text, links, codes }
    }
}

/// Anchors as GitHub makes them: lower case, blanks as hyphens, other punctuation dropped, repeated ones numbered.
fn anchors(titles: &[String]) -> BTreeSet<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut all = BTreeSet::new();
    for title in titles {
        let keep = |c: &char| c.is_alphanumeric() || [' ', '-', '_'].contains(c);
        let slug: String = title.to_lowercase().chars().filter(keep).collect();
        let slug = slug.replace(' ', "-");
        let times = seen.entry(slug.clone()).or_default();
        all.insert(if *times == 0 { slug } else { format!("{slug}-{times}") });
        *times += 1;
    }
    all
}

pub(crate) fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => assert!(out.pop(), "{} leaves the repository", path.display()),
            part => out.push(part),
        }
    }
    out
}

pub(crate) fn markdown() -> BTreeMap<PathBuf, Page> {
    let mut pages = BTreeMap::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(Path::new(".").join(&folder)).expect("a folder can be read") {
            let entry = entry.expect("an entry can be read");
            let path = folder.join(entry.file_name());
            let name = entry.file_name().to_string_lossy().into_owned();
            if entry.file_type().expect("an entry has a type").is_dir() {
                if !OTHERS.contains(&name.as_str()) {
                    folders.push(path);
                }
            } else if name.ends_with(".md") {
                let text = fs::read_to_string(&path).expect("a page can be read");
                pages.insert(path.clone(), Page::read(path, text));
            }
        }
    }
    pages
}
