//! Tags as they stand in a file.

/// Tags of a way or node, in the order of the file.
pub type Tags<'a> = [(&'a str, &'a str)];

/// Returns the value of a tag.
pub fn tag<'a>(tags: &Tags<'a>, key: &str) -> Option<&'a str> {
    tags.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
}
