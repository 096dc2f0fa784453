//! What a domain adds to a report that is otherwise the same for every task. Everything has a default that adds
//! nothing, or says what follows from the names in the records.

use std::path::{Path, PathBuf};

use super::format;
use super::svg::Figure;
use super::words::Words;
use crate::analysis::{Analysis, Measures, PointResult, TaskScore};
use crate::stats::Limit;
use crate::store::manifest::PointRow;
use basics::files::FileError;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file of the report cannot be written.
    #[error(transparent)]
    Io(#[from] FileError),
    /// The page's template does not fit its data, which is a mistake in this program.
    #[error("the report's page cannot be rendered: {0}; please report this")]
    Template(String),
}

/// Where a domain may add a sentence or a paragraph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// End of the headline.
    Headline,
    /// Under which conditions the results hold: end of what they rest on, on the first page.
    Conditions,
    /// What the best method gains in units that people in the field count in: first page.
    Gain,
    /// How the regimes of the baseline share the family: within a caption.
    Regimes,
    /// What few point MDPs may hold most of: first paragraph of the further summaries.
    Summaries,
    /// Heading of the table of evaluation episodes.
    Episodes,
    /// Paragraph above that table.
    BeforeEpisodes,
    /// How its shares are defined: paragraph below that table.
    AfterEpisodes,
    /// What is usually reported of training: within the paragraph below the tables of trainings.
    Training,
    /// How point MDPs came to be: end of the notes on them.
    Points,
    /// For who applies the results: below the ranking.
    ApplyRanking,
    /// The same, below the further summaries.
    ApplySummaries,
    /// The same, below the spread over point MDPs.
    ApplySpread,
    /// The same, below the learning curves.
    ApplyTraining,
    /// What even the best method cannot help: below the table of everything.
    Worst,
    /// What no interval covers.
    NotCovered,
    /// Where else results may be otherwise.
    Elsewhere,
}

/// Tables with columns for metrics beside the objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// `scores.csv`.
    Scores,
    /// `summary.csv`.
    Summary,
    /// `episodes.csv`.
    Episodes,
    /// The ranking on the page.
    Ranking,
}

/// A metric with a column of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Metric {
    /// Its name in records.
    pub name: String,
    /// Heading of its column on the page.
    pub heading: String,
    /// Its unit below that; empty where it has none.
    pub unit: String,
}

/// Where a part of the page stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// First, before the ranking.
    First,
    /// Among the sections, before the table of everything.
    Body,
    /// Among the notes.
    Notes,
}

/// A part of the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Where it stands.
    pub slot: Slot,
    /// Id of its element.
    pub id: &'static str,
    /// What it is called among the links; sections only.
    pub title: &'static str,
    /// The element, with its id.
    pub html: String,
}

/// A row of the table of everything: a place, or a point MDP.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spot {
    /// What it is called.
    pub name: String,
    /// What stands below that, such as its point MDP.
    pub detail: String,
    /// Position of the point MDP in [`Analysis::points`] whose results it has; `None` without.
    pub point: Option<usize>,
    /// Number of its dot on a map: the id of the dot is `dot-` and the number; `None` without a map.
    pub dot: Option<usize>,
    /// Why the probability that its best method is the best is not given; `None` where it is.
    pub withheld: Option<&'static str>,
}

/// Files that a domain wrote.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Written {
    /// The files.
    pub files: Vec<PathBuf>,
    /// What people should know of them, such as why one is missing.
    pub notes: Vec<String>,
}

/// How lines and bars of a method look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Colour, `#rrggbb`.
    pub color: &'static str,
    /// Pattern of dashes as in SVG; empty for a solid line.
    pub dash: &'static str,
}

/// What a domain adds to a report.
pub trait Sections: std::fmt::Debug + Sync {
    /// Returns the method that does what is done today, which the first page compares with; `None` where that is not known.
    fn today(&self, _data: &Analysis) -> Option<&'static str> {
        None
    }

    /// Returns what it measures beside the objective.
    fn measures(&self) -> &dyn Measures {
        &()
    }

    /// Returns what it calls the objective of this name.
    fn words(&self, objective: &str) -> Words {
        Words::of_metric(objective)
    }

    /// Returns what people call a point MDP.
    fn title(&self, point: &PointRow) -> String {
        point.name().to_owned()
    }

    /// Returns what it counts as a failure of a method on a point MDP.
    fn failure(&self) -> Option<Limit> {
        None
    }

    /// Returns the look of a method, the same in every report; `None` for one that it does not know.
    fn look(&self, method: &str) -> Option<Look> {
        let _ = method;
        None
    }

    /// Returns what happened in the evaluation that a reader of the ranking should know, in plain text.
    fn happened(&self, data: &Analysis) -> Vec<String> {
        let _ = data;
        Vec::new()
    }

    /// Returns a text; `None` where there is nothing to say. All but those of the first page, from
    /// [`About::Headline`] to [`About::Gain`], are HTML, in which names are to be escaped.
    fn says(&self, about: About, data: &Analysis) -> Option<String> {
        let _ = (about, data);
        None
    }

    /// Returns who the paragraphs are for that [`About`] calls those for who applies the results.
    fn audience(&self) -> &'static str {
        "In practice"
    }

    /// Returns what columns of regimes and shares mean, for terminals, a line each.
    fn legend(&self, data: &Analysis) -> Vec<String> {
        let _ = data;
        Vec::new()
    }

    /// Returns the names of the two columns of `training.csv` for the best episode of a training and for its last
    /// ones, and what they are called on the page.
    fn training_columns(&self) -> [[&'static str; 2]; 2] {
        [["best_episode", "last_episodes"], ["Best", "Last"]]
    }

    /// Returns the metrics that have a column in a table; by default all that records have, and in the ranking
    /// none.
    fn metrics(&self, table: Table, data: &Analysis) -> Vec<Metric> {
        match table {
            Table::Ranking => Vec::new(),
            Table::Scores | Table::Summary => data.metrics().into_iter().map(Metric::of).collect(),
            Table::Episodes => data.episode_metrics().into_iter().map(Metric::of).collect(),
        }
    }

    /// Returns the names of further columns of `scores.csv`.
    fn score_columns(&self) -> &'static [&'static str] {
        &[]
    }

    /// Returns the cells of a task in those columns; `objective` is there when the task has a result.
    fn score_cells(
        &self,
        data: &Analysis,
        task: &TaskScore,
        objective: Option<f64>,
    ) -> Vec<String> {
        let _ = (data, task, objective);
        Vec::new()
    }

    /// Returns further columns of `summary.csv`, which are the same for all methods: names and cells.
    fn summary_columns(&self, data: &Analysis) -> Vec<(&'static str, String)> {
        let _ = data;
        Vec::new()
    }

    /// Returns the places that have a row each in the table of everything, in the order of their rows; `None` where
    /// none is known, so that point MDPs have.
    fn spots(&self, data: &Analysis) -> Option<Vec<Spot>> {
        let _ = data;
        None
    }

    /// Returns what a point MDP stands for.
    fn stands_for(&self, point: &PointRow) -> String {
        format::count(point.instances as usize, "instance")
    }

    /// Returns what [`Sections::point_cells`] are.
    fn point_columns(&self, data: &Analysis) -> Vec<&'static str> {
        let _ = data;
        Vec::new()
    }

    /// Returns what stands beside the objective of a method on a point MDP.
    fn point_cells(&self, data: &Analysis, result: &PointResult) -> Vec<String> {
        let _ = (data, result);
        Vec::new()
    }

    /// Returns further figures, which [`Sections::parts`] shows.
    fn figures(&self, data: &Analysis) -> Vec<Figure> {
        let _ = data;
        Vec::new()
    }

    /// Returns further parts of the page.
    ///
    /// # Errors
    ///
    /// [`ReportError::Template`].
    fn parts(&self, data: &Analysis, figures: &[Figure]) -> Result<Vec<Part>, ReportError> {
        let _ = (data, figures);
        Ok(Vec::new())
    }

    /// Returns the names of the tables that [`Sections::write`] adds.
    fn tables(&self, data: &Analysis) -> Vec<&'static str> {
        let _ = data;
        Vec::new()
    }

    /// Writes further files into the report's folder, and removes those that an earlier report left there.
    ///
    /// # Errors
    ///
    /// [`ReportError::Io`].
    fn write(&self, folder: &Path, data: &Analysis) -> Result<Written, ReportError> {
        let _ = (folder, data);
        Ok(Written::default())
    }
}

impl Metric {
    /// Returns a metric with heading and unit from its name.
    fn of(name: String) -> Self {
        let words = Words::of_metric(&name);
        Self { heading: words.heading(), unit: words.unit, name }
    }
}

/// A domain that adds nothing but names and colours.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plain {
    /// What the objective is called, and its unit; from the name of the metric when there is none.
    pub objective: Option<(String, String)>,
    /// What a row of training is called, and what it is where it is no single episode; an episode when there is none.
    pub row: Option<(String, String)>,
    /// How methods look, by name.
    pub looks: Vec<(String, Look)>,
    /// The most that the objective can be.
    pub most: Option<f64>,
    /// What counts as a failure; `None` where nothing does.
    pub failure: Option<Limit>,
}

impl Measures for Plain {
    fn most(&self, _objective: &str) -> Option<f64> {
        self.most
    }
}

impl Sections for Plain {
    fn measures(&self) -> &dyn Measures {
        self
    }

    fn words(&self, objective: &str) -> Words {
        let mut words = Words::of_metric(objective);
        if let Some((row, row_is)) = &self.row {
            (words.row, words.row_is) = (row.clone(), row_is.clone());
        }
        match &self.objective {
            None => words,
            Some((noun, unit)) => Words {
                noun: noun.clone(),
                amount: noun.clone(),
                unit: unit.clone(),
                unit_in_full: unit.clone(),
                ..words
            },
        }
    }

    fn failure(&self) -> Option<Limit> {
        self.failure.clone()
    }

    fn look(&self, method: &str) -> Option<Look> {
        self.looks.iter().find(|(name, _)| name == method).map(|(_, look)| *look)
    }
}
