//! Code blocks of a page, and what the HTML comment before each says about it.
//!
//! A marker is a comment of its own directly before a block; GitHub does not show it:
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
//! - `doctest: WHERE`: Rust that the tests of a crate's documentation compile;
//! - `text: REASON`: no command and no file.
//!
//! `before` is a shell command that puts files in place, `instead` a part of the commands that is replaced to
//! make them small. Both can be repeated.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

use super::Page;

/// What is done with a block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    Run,
    Parse,
    File(String),
    Text,
}

/// A code block with its marker.
#[derive(Debug, Clone)]
#[cfg_attr(
    not(feature = "libsumo"),
    expect(dead_code, reason = "without a simulator nothing is executed")
)]
pub(crate) struct Block {
    pub(crate) language: String,
    pub(crate) text: String,
    pub(crate) kind: Kind,
    pub(crate) before: Vec<String>,
    pub(crate) instead: Vec<(String, String)>,
    /// Page and line, for messages.
    pub(crate) place: String,
}

/// Returns the code blocks of a page, or what is wrong with one.
pub(crate) fn blocks(page: &Page) -> Result<Vec<Block>, String> {
    let mut found = Vec::new();
    let mut marker = String::new();
    let mut current: Option<(String, String, String)> = None;
    for (event, range) in Parser::new_ext(&page.text, Options::ENABLE_TABLES).into_offset_iter() {
        match event {
            Event::Start(Tag::HtmlBlock) => marker.clear(),
            Event::Html(part) => marker.push_str(&part),
            Event::End(TagEnd::HtmlBlock) => {}
            Event::Start(Tag::CodeBlock(kind)) => {
                let line = 1 + page.text[..range.start].matches('\n').count();
                let place = format!("{}:{line}", page.path.display());
                let CodeBlockKind::Fenced(info) = kind else {
                    return Err(format!("{place}: an indented block; use a fence and a language"));
                };
                current = Some((info.to_string(), String::new(), place));
            }
            Event::Text(part) if current.is_some() => {
                if let Some((_, text, _)) = &mut current {
                    text.push_str(&part);
                }
            }
            Event::End(TagEnd::CodeBlock) => {
                let (language, text, place) = current.take().expect("the block has begun");
                found.push(block(language, text, place, &marker)?);
                marker.clear();
            }
            _ => marker.clear(),
        }
    }
    Ok(found)
}

/// Reads the marker of a block.
fn block(language: String, text: String, place: String, marker: &str) -> Result<Block, String> {
    let wrong = |reason: &str| Err(format!("{place}: {reason}"));
    let Some(marker) = marker.trim().strip_prefix("<!-- snippet:") else {
        return wrong("no marker before the block; see tests/docs/pages/blocks.rs");
    };
    let mut lines = marker.trim_end_matches("-->").lines();
    let head = lines.next().unwrap_or_default().trim();
    let (word, rest) = head.split_once([' ', ':']).unwrap_or((head, ""));
    let rest = rest.trim();
    let languages: &[&str] = match word {
        "run" | "parse" => &["sh", "console"],
        "file" => &["toml", "csv"],
        "doctest" => &["rust", "rust,no_run"],
        _ => &["text", "python", "sh"],
    };
    if !languages.contains(&&*language) {
        return wrong(&format!("the language is `{language}`, with `{word}` one of {languages:?}"));
    }
    let kind = match word {
        "run" if rest.is_empty() => Kind::Run,
        "parse" if !rest.is_empty() => Kind::Parse,
        "file" if !rest.is_empty() => Kind::File(rest.to_owned()),
        "text" | "doctest" if !rest.is_empty() => Kind::Text,
        _ => return wrong(&format!("unknown marker or no reason: {head}")),
    };
    let (mut before, mut instead) = (Vec::new(), Vec::new());
    for line in lines.map(str::trim).filter(|l| !l.is_empty()) {
        match (line.split_once(':'), line.split_once(" => ")) {
            (Some(("before", command)), _) => before.push(command.trim().to_owned()),
            (Some(("instead", _)), Some((old, new))) => {
                let old = old.trim_start_matches("instead:").trim();
                instead.push((old.to_owned(), new.trim().to_owned()));
            }
            _ => return wrong(&format!("unknown line of the marker: {line}")),
        }
    }
    Ok(Block { language, text, kind, before, instead, place })
}

impl Block {
    /// Returns the commands of the block: without prompts and comments, one per line.
    pub(crate) fn commands(&self) -> Vec<String> {
        let joined = self.text.replace("\\\n", " ");
        let lines = joined.lines().filter_map(|line| {
            let line = line.trim();
            let line = if self.language == "console" { line.strip_prefix("$ ")? } else { line };
            let line = line.split(" #").next().unwrap_or_default().trim();
            (!line.is_empty() && !line.starts_with('#')).then(|| line.to_owned())
        });
        lines.collect()
    }

    /// Returns the arguments of every call of the program.
    pub(crate) fn calls(&self) -> Vec<Vec<String>> {
        let commands = self.commands();
        let parts = commands.iter().flat_map(|c| c.split(['|', ';', '&']));
        let words = parts.map(words);
        words.filter(|w| w.first().is_some_and(|w| w == "tsc-family")).collect()
    }
}

/// Returns the words of a command as a shell has them: what stands in quotes is one, without them.
fn words(command: &str) -> Vec<String> {
    let (mut words, mut quote) = (vec![String::new()], None);
    for c in command.chars() {
        match quote {
            Some(q) if c == q => quote = None,
            None if c == '"' || c == '\'' => quote = Some(c),
            None if c.is_whitespace() => words.push(String::new()),
            _ => words.last_mut().expect("there is one").push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}
