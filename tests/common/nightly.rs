//! What is tried before a release and not at every change.

pub(crate) fn is_nightly() -> bool {
    std::env::var_os("NIGHTLY").is_some_and(|value| value == "1")
}
