//! Settings, each declared once: from a line per setting follow the struct that files are read into, its
//! defaults, the ranges that values are checked against, and the table that documentation shows.

/// A setting of a section: what a scenario's file and `--set` can give.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Its name in the section.
    pub name: &'static str,
    /// The lines of its documentation.
    pub lines: &'static [&'static str],
    /// Its unit; empty for shares, factors, switches and names.
    pub unit: &'static str,
    /// Returns its default, as a file has it.
    pub default: fn() -> String,
    /// What a number may be; `None` for switches and names.
    pub limits: Option<Limits>,
    /// Where the default comes from.
    pub source: &'static str,
}

/// What a number may be, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
    /// Another setting of the section that it may not exceed either.
    pub at_most: Option<&'static str>,
}

impl Setting {
    /// Returns what it is, in a sentence or a few.
    pub fn summary(&self) -> String {
        joined(self.lines)
    }

    /// Returns what it is in a sentence, with default, unit and range.
    pub fn headline(&self) -> String {
        let summary = self.summary();
        let first = summary.split_once(". ").map_or(summary.as_str(), |(first, _)| first);
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let range = self.limits.map_or(String::new(), |limits| format!("; {limits}"));
        format!("{} (default {}{unit}{range})", first.trim_end_matches('.'), (self.default)())
    }
}

impl std::fmt::Display for Limits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to {}", self.low, self.high)?;
        self.at_most.map_or(Ok(()), |other| write!(f, ", at most {other}"))
    }
}

/// Returns lines of documentation as one.
pub fn joined(lines: &[&str]) -> String {
    lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

/// The value of a number among the settings, and what it may be with the others as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranged {
    /// Name of the setting.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
}

/// A section of settings.
pub trait Section {
    /// Returns what it is about.
    fn about(&self) -> String {
        String::new()
    }

    /// Returns where the defaults come from, but for settings that say otherwise.
    fn source(&self) -> &'static str {
        ""
    }

    /// Returns its settings, in the order of the section.
    fn table(&self) -> &'static [Setting] {
        &[]
    }

    /// Returns the numbers among them.
    fn ranges(&self) -> Vec<Ranged> {
        Vec::new()
    }
}

/// Returns a setting by its dotted name; `None` for what stands outside of sections or deeper in them.
pub fn find(sections: &[(&str, &dyn Section)], name: &str) -> Option<&'static Setting> {
    let (section, name) = name.split_once('.')?;
    let (_, section) = sections.iter().find(|(own, _)| *own == section)?;
    section.table().iter().find(|s| s.name == name)
}

/// The section of a method that has no settings: neither read nor written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoSettings;

impl NoSettings {
    /// The empty table.
    pub const SETTINGS: &'static [Setting] = &[];
}

impl Section for NoSettings {}

/// What can have a range.
pub trait Number {
    /// Returns it in double precision; `None` where there is none.
    fn number(&self) -> Option<f64>;
}

macro_rules! numbers {
    ($($type:ty)*) => {
        $(impl Number for $type {
            fn number(&self) -> Option<f64> {
                Some(*self as f64)
            }
        })*
    };
}
numbers!(f32 f64 u32 u64 usize);

impl<T: Number> Number for Option<T> {
    fn number(&self) -> Option<f64> {
        self.as_ref().and_then(Number::number)
    }
}

/// Declares a section of settings, one line and its documentation per setting:
///
/// ```text
/// settings! {
///     /// Hyper-parameters of `idqn`.
///     pub struct Config, source "RESCO, config/agent_config.py" {
///         /// Transitions per update.
///         batch_size: usize = 32, in 1.0..=4096.0, at most buffer_size, unit "transitions";
///         /// Whether the online network chooses the action.
///         double_dqn: bool = false, source "Van Hasselt et al., 2016";
///     }
/// }
/// ```
///
/// - `= 32` is the default;
/// - `in LOW..=HIGH` the range of a number, both ends included, and `at most OTHER` a setting before it
///   that it may not exceed;
/// - a setting that is optional has a range where it is given;
/// - `unit` is left out of pure numbers, `source` where it is the section's.
///
/// It makes the struct, read and written by serde (a setting that does not exist is an error, one that is
/// missing has its default), `Default`, [`Section`] and the constant `SETTINGS`.
///
/// `pub struct Config extends Base, source ... { ... } and { ... }` also makes a `Base` from the settings
/// of the first braces, which must be those of `Base`.
#[doc(hidden)]
#[macro_export]
macro_rules! __settings {
    (
        $(#[doc = $about:literal])*
        $vis:vis struct $name:ident, source $section:literal {
            $(
                $(#[doc = $doc:literal])*
                $(#[serde $serde:tt])*
                $field:ident : $type:ty = $default:expr
                $(, in $range:expr)? $(, at most $other:ident)?
                $(, unit $unit:literal)? $(, source $source:literal)?;
            )*
        }
    ) => {
        $(#[doc = $about])*
        ///
        #[doc = concat!("Source: ", $section, ".")]
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        $vis struct $name {
            $(
                $(#[doc = $doc])*
                ///
                #[doc = concat!(
                    "By default `", stringify!($default), "`"
                    $(, " ", $unit)? $(, ", in `", stringify!($range), "`")?
                    $(, ", at most `", stringify!($other), "`")? $(, " (", $source, ")")?, "."
                )]
                $(#[serde $serde])*
                $vis $field: $type,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            /// Its settings, in the order of the section.
            $vis const SETTINGS: &'static [$crate::setting::Setting] = &[$(
                $crate::setting::Setting {
                    name: stringify!($field),
                    lines: &[$($doc,)*],
                    unit: $crate::setting::settings!(@or "" $($unit)?),
                    default: || {
                        serde_json::to_string(&$name::default().$field)
                            .expect("a setting is plain data")
                    },
                    limits: $crate::setting::settings!(@limits $($range)?; $($other)?),
                    source: $crate::setting::settings!(@or $section $($source)?),
                },
            )*];
        }

        impl $crate::setting::Section for $name {
            fn about(&self) -> String {
                $crate::setting::joined(&[$($about,)*])
            }

            fn source(&self) -> &'static str {
                $section
            }

            fn table(&self) -> &'static [$crate::setting::Setting] {
                Self::SETTINGS
            }

            fn ranges(&self) -> Vec<$crate::setting::Ranged> {
                let mut ranges = Vec::new();
                $($crate::setting::settings!(
                    @range ranges self $field $($range)?; $($other)?
                );)*
                ranges
            }
        }
    };
    (
        $(#[doc = $about:literal])*
        $vis:vis struct $name:ident extends $base:path, source $section:literal {
            $($common:tt)*
        } and {
            $($own:tt)*
        }
    ) => {
        $crate::setting::settings! {
            $(#[doc = $about])*
            $vis struct $name, source $section { $($common)* $($own)* }
        }
        $crate::setting::settings! { @from $name $base { $($common)* } }
    };
    (@from $name:ident $base:path {
        $(
            $(#[doc = $doc:literal])*
            $(#[serde $serde:tt])*
            $field:ident : $type:ty = $default:expr
            $(, in $range:expr)? $(, at most $other:ident)?
            $(, unit $unit:literal)? $(, source $source:literal)?;
        )*
    }) => {
        impl From<&$name> for $base {
            fn from(all: &$name) -> Self {
                Self { $($field: Clone::clone(&all.$field),)* }
            }
        }
    };
    (@or $usual:literal) => { $usual };
    (@or $usual:literal $own:literal) => { $own };
    (@limits ;) => { None };
    (@limits $range:expr; $($other:ident)?) => {
        Some($crate::setting::Limits {
            low: *($range).start(),
            high: *($range).end(),
            at_most: $crate::setting::settings!(@some $($other)?),
        })
    };
    (@some) => { None };
    (@some $other:ident) => { Some(stringify!($other)) };
    (@range $ranges:ident $self:ident $field:ident ;) => {};
    (@range $ranges:ident $self:ident $field:ident $range:expr; $($other:ident)?) => {
        if let Some(value) = $crate::setting::Number::number(&$self.$field) {
            let (low, high): (f64, f64) = (*($range).start(), *($range).end());
            $(let other = $crate::setting::Number::number(&$self.$other);
            let high = other.map_or(high, |other| high.min(other));)?
            let name = stringify!($field);
            $ranges.push($crate::setting::Ranged { name, value, low, high });
        }
    };
}

pub use crate::__settings as settings;

#[cfg(test)]
mod tests;
