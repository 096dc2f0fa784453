//! Paths in commands: those that people copy from what is printed, and those of scripts.

use std::borrow::Cow;
use std::path::Path;

/// Returns a path as a shell takes it, whatever is in it. Bytes that are no text are shown as well as can be.
pub fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    // No path has a NUL.
    shlex::try_quote(&text).map_or_else(|_| text.to_string(), Cow::into_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_shell_would_act_on_is_quoted() {
        assert_eq!(quoted(Path::new("/a/b c; rm $HOME")), "'/a/b c; rm $HOME'");
        assert_eq!(quoted(Path::new("networks/a-b")), "networks/a-b");
        assert_eq!(quoted(Path::new("my city's")), "\"my city's\"");
    }
}
