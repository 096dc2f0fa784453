//! The network's own signal program, untouched: what a city runs today, and RESCO's FIXED.
//!
//! On generated networks the own program is netconvert's default, so the method equals the
//! baseline there.

use super::{Controller, Drive, Setup, same};
use evaluation::run::method::{Method, Training};
use evaluation::settings::setting::NoSettings;

/// The method.
pub const METHOD: Method = Method {
    summary: "the network's own signal program, untouched",
    ..Method::built_in("program", Training::None, "#66002b")
};

/// Returns the own program.
pub fn create(_config: &NoSettings, _setup: &Setup) -> Box<dyn Controller> {
    same(METHOD.name, Drive::OwnProgram)
}
