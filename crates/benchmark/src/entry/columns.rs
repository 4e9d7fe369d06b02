//! What tables show beside the statistics of a score.

use b2b_evaluate::statistics::ratio_text;
use b2b_evaluate::{EpisodeResult, OperationComfort, relative_energy, relative_resource, resource_heading};

use super::scores::mean_deviation;

/// The columns of a table of episodes, which depend on their tasks.
#[derive(Clone, Debug, PartialEq)]
pub enum Columns {
    /// Of targets: two scores, the RMS deviation and energy.
    Targets,
    /// Of operation: one score, the task's resource under this heading, discomfort and energy.
    Operation(String),
}

impl Columns {
    /// Returns the columns for the tasks of some rows.
    pub fn of(rows: &[EpisodeResult]) -> Self {
        match OperationComfort::of(rows.iter()) {
            None => Self::Targets,
            Some(_) => Self::Operation(resource_heading(rows.iter().map(|row| &row.info.task[..]))),
        }
    }

    /// Returns the names of the scores.
    pub fn scores(&self) -> &'static [&'static str] {
        match self {
            Self::Targets => &["resolved score", "score"],
            Self::Operation(_) => &["score at comfort"],
        }
    }

    /// Returns the cells of the scores: both are the same in operation.
    pub fn score_cells(&self, resolved: String, score: String) -> Vec<String> {
        match self {
            Self::Targets => vec![resolved, score],
            Self::Operation(_) => vec![score],
        }
    }

    /// Returns the names of the columns after the scores.
    pub fn others(&self) -> Vec<&str> {
        match self {
            Self::Targets => vec!["RMS deviation (K)", "energy / baseline"],
            Self::Operation(resource) => vec![
                resource,
                "discomfort (K·h per zone)",
                "baseline's",
                "too uncomfortable",
                "energy / baseline",
            ],
        }
    }

    /// Returns the cells after the scores.
    pub fn other_cells(&self, rows: &[&EpisodeResult]) -> Vec<String> {
        let all = || rows.iter().copied();
        let energy = ratio_text(relative_energy(all()));
        match self {
            Self::Targets => vec![format!("{:.2}", mean_deviation(all())), energy],
            Self::Operation(_) => {
                let comfort = OperationComfort::of(all());
                let comfort = comfort.as_ref();
                vec![
                    ratio_text(relative_resource(all())),
                    ratio_text(comfort.map(|comfort| comfort.discomfort_k_h)),
                    ratio_text(comfort.and_then(|comfort| comfort.baseline_discomfort_k_h)),
                    comfort.map_or_else(String::new, OperationComfort::mark),
                    energy,
                ]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use b2b_env::EpisodeMetrics;
    use b2b_evaluate::{BuiltIn, EpisodeInfo, EpisodePlan, Scored, Subject};

    use super::*;

    fn row(task: &str, tdis_tot: Option<f64>) -> EpisodeResult {
        let episode = EpisodePlan {
            subject: Subject::at_home("OfficeSmall-1".parse().unwrap()),
            task: task.parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 0,
            steps_per_hour: 12,
        };
        let metrics = EpisodeMetrics {
            rms_deviation: 0.5,
            steps: 576,
            tdis_tot,
            cost_tot: tdis_tot,
            ..EpisodeMetrics::default()
        };
        let scored = Scored {
            metrics,
            resource: Some(3.0),
            baseline_resource: Some(4.0),
            baseline_discomfort: tdis_tot.map(|_| 1.0),
            ..Scored::default()
        };
        EpisodeResult { info: EpisodeInfo::of(&episode, &BuiltIn::random()), outcome: Ok(scored) }
    }

    #[test]
    fn operation_shows_cost_and_discomfort_and_marks_what_is_uncomfortable() {
        let rows = [row("operate", Some(1.0)), row("operate", Some(3.0))];
        let columns = Columns::of(&rows);
        assert_eq!(columns, Columns::Operation("cost / baseline".into()));
        let cells = columns.other_cells(&rows.iter().collect::<Vec<_>>());
        assert_eq!(cells, ["0.75", "2.00", "1.00", "! 1", "–"]);
        assert_eq!(columns.others().len(), cells.len());
        assert_eq!(columns.score_cells("1.2".into(), "1.2".into()).len(), columns.scores().len());
    }

    #[test]
    fn targets_show_the_deviation() {
        let rows = [row("constant", None)];
        let columns = Columns::of(&rows);
        assert_eq!(columns, Columns::Targets);
        assert_eq!(columns.other_cells(&[&rows[0]]), ["0.50", "–"]);
    }
}
