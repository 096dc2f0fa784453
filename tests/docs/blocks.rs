//! Code blocks of a page, and what the HTML comment before each says about it:
//!
//! ```text
//! <!-- snippet: run
//! before: cp $REPO/osm-signals/tests/networks/four_arms/input.osm .
//! instead: --budget 20 => --budget 1 --eval-seeds 1
//! -->
//! ```
//!
//! - `run`: the commands are executed, one page in one folder, from top to bottom;
//! - `parse: REASON`: they are not, for a reason, but the program must accept their arguments;
//! - `file NAME`: the block is that file, which commands of the page use;
//! - `text: REASON` and `doctest: WHERE`: neither.
//!
//! `before` is a shell command that puts files in place, `instead` a part of the commands that is replaced to make them
//! small. Both can be repeated.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

use super::pages::Page;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    Run,
    Parse,
    File(String),
    Text,
}

#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub(crate) text: String,
    pub(crate) kind: Kind,
    pub(crate) before: Vec<String>,
    pub(crate) instead: Vec<(String, String)>,
    pub(crate) place: String,
    has_prompts: bool,
}

pub(crate) fn blocks(page: &Page) -> Vec<Block> {
    let (mut found, mut marker, mut block) = (Vec::new(), String::new(), None);
    for (event, range) in Parser::new_ext(&page.text, Options::ENABLE_TABLES).into_offset_iter() {
        match event {
            Event::Start(Tag::HtmlBlock) => marker.clear(),
            Event::Html(part) => marker.push_str(&part),
            Event::End(TagEnd::HtmlBlock) => {}
            Event::Start(Tag::CodeBlock(kind)) => {
                let line = 1 + page.text[..range.start].matches('\n').count();
                let place = format!("{}:{line}", page.path.display());
                let CodeBlockKind::Fenced(info) = kind else {
                    panic!("{place}: an indented block; use a fence and a language")
                };
                block = Some(marked(&marker, place, &*info == "console"));
            }
            Event::Text(part) => match &mut block {
                Some(block) => block.text.push_str(&part),
                None => marker.clear(),
            },
            Event::End(TagEnd::CodeBlock) => found.extend(block.take()),
            _ => marker.clear(),
        }
    }
    found
}

fn marked(marker: &str, place: String, has_prompts: bool) -> Block {
    let Some(marker) = marker.trim().strip_prefix("<!-- snippet:") else {
        panic!("{place}: no marker before the block; see tests/docs/blocks.rs")
    };
    let mut lines = marker.trim_end_matches("-->").lines();
    let head = lines.next().unwrap_or_default().trim();
    let (word, rest) = head.split_once([' ', ':']).unwrap_or((head, ""));
    let kind = match word {
        "run" => Kind::Run,
        "parse" => Kind::Parse,
        "file" => Kind::File(rest.trim().to_owned()),
        "text" | "doctest" => Kind::Text,
        _ => panic!("{place}: unknown marker: {head}"),
    };
    let (mut before, mut instead) = (Vec::new(), Vec::new());
    for line in lines.map(str::trim).filter(|l| !l.is_empty()) {
        match (line.split_once(':'), line.split_once(" => ")) {
            (Some(("before", command)), _) => before.push(command.trim().to_owned()),
            (Some(("instead", _)), Some((old, new))) => {
                let old = old.trim_start_matches("instead:").trim();
                instead.push((old.to_owned(), new.trim().to_owned()));
            }
            _ => panic!("{place}: unknown line of the marker: {line}"),
        }
    }
    Block { text: String::new(), kind, before, instead, place, has_prompts }
}

impl Block {
    /// Returns the commands of the block: without prompts and comments, one per line.
    pub(crate) fn commands(&self) -> Vec<String> {
        let joined = self.text.replace("\\\n", " ");
        let lines = joined.lines().filter_map(|line| {
            let line = line.trim();
            let line = if self.has_prompts { line.strip_prefix("$ ")? } else { line };
            let line = line.split(" #").next().unwrap_or_default().trim();
            (!line.is_empty() && !line.starts_with('#')).then(|| line.to_owned())
        });
        lines.collect()
    }

    pub(crate) fn calls(&self) -> Vec<Vec<String>> {
        let commands = self.commands();
        let parts = commands.iter().flat_map(|c| c.split(['|', ';', '&']));
        let words = parts.filter_map(shlex::split);
        words.filter(|w| w.first().is_some_and(|w| w == "tsc-family")).collect()
    }
}
