/// Returns what tells a file from one that replaced it: its size, bytes, and when it was changed, nanoseconds since 1970.
fn stamp(file: &std::path::Path) -> Option<String> {
    let about = std::fs::metadata(file).ok()?;
    let changed = about.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
    Some(format!("{} {}", about.len(), changed.as_nanos()))
}
