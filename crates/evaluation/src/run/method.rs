//! What evaluation, reports and the command line know of a method, whatever it controls: a description that
//! stands in the method's own file.

use crate::settings::setting::Setting;

use super::error::RunError;
use basics::suggest::did_you_mean;

/// What a method does before it is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Training {
    /// Nothing: its record follows from the evaluation seeds alone, so one task is enough.
    None,
    /// It searches for settings in simulation; another task seed may find others.
    Tuned {
        /// The setting, with its section, that says how many episodes it may use.
        episodes: &'static str,
    },
    /// It learns; another task seed learns something else.
    Learned,
}

/// End of the name of a method of which settings are tuned, after the name of the method.
pub const TUNED: &str = "-tuned";

/// A method as `tsc-family run --methods` knows it.
#[derive(Debug, Clone, Copy)]
pub struct Method {
    /// Stable name.
    pub name: &'static str,
    /// One sentence for people.
    pub summary: &'static str,
    /// What it does before it is evaluated; all but [`Training::None`] is replicated.
    pub training: Training,
    /// Whether it runs when `--methods` is not given.
    pub default: bool,
    /// Processor time per decision of training, updates included, seconds; 0 without a training that
    /// costs more than its episodes. A first guess: a run measures it.
    pub decision_s: f64,
    /// Colour of its lines and bars, `#rrggbb`.
    pub color: &'static str,
    /// Pattern of its lines' dashes as in SVG; empty for solid ones.
    pub dash: &'static str,
    /// Its settings; none for a method without a section.
    pub settings: &'static [Setting],
    /// Settings, with their sections, that may be tuned, each with the values that are tried.
    pub tunes: &'static [(&'static str, &'static [f64])],
    /// Sections that it reads beside its own.
    pub reads: &'static [&'static str],
}

impl Method {
    /// Returns the description of a method without settings and with a colour that no other has, to be
    /// changed where it is more than that.
    pub const fn new(name: &'static str, summary: &'static str, training: Training) -> Self {
        let (color, dash) = ("#444444", "6 2");
        Self {
            name,
            summary,
            training,
            default: false,
            decision_s: 0.0,
            color,
            dash,
            settings: &[],
            tunes: &[],
            reads: &[],
        }
    }

    /// Returns the description of a method of this program: solid lines, to which its summary is to be added.
    pub const fn built_in(name: &'static str, training: Training, color: &'static str) -> Self {
        Self { color, dash: "", ..Self::new(name, "", training) }
    }

    /// Whether it is another method but for its settings, which are tuned.
    pub fn is_tuned(&self) -> bool {
        !self.tunes.is_empty() && self.training != Training::None
    }

    /// Returns the name of its section of a scenario.
    pub fn section(&self) -> String {
        let name = self.name.strip_suffix(TUNED).filter(|_| self.is_tuned());
        name.unwrap_or(self.name).replace('-', "_")
    }
}

/// Returns a method by its name.
///
/// # Errors
///
/// [`RunError::Method`] for a name that none of them has.
pub fn find<'a>(methods: &'a [Method], name: &str) -> Result<&'a Method, RunError> {
    methods.iter().find(|m| m.name == name).ok_or_else(|| {
        let known: Vec<_> = methods.iter().map(|m| m.name).collect();
        let meant = did_you_mean(name, known.iter().copied());
        RunError::Method { name: name.to_owned(), known: known.join(", "), meant }
    })
}
