//! How exactly episodes that ran again are compared.

use b2b_base::machine;
use b2b_env::EpisodeMetrics;

use super::{TOLERANCE, is_near};

/// How exactly episodes that ran again are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Accuracy {
    /// Bit for bit: this machine computes as that of the result does.
    Bits,
    /// Within [`TOLERANCE`]: libm or instruction set differ.
    Tolerance,
}

impl Accuracy {
    pub(super) fn on(machine_of_result: &str) -> Self {
        if machine_of_result == machine::fingerprint() { Self::Bits } else { Self::Tolerance }
    }

    fn same(self, there: f64, here: f64) -> bool {
        match self {
            Self::Bits => there == here,
            Self::Tolerance => is_near(there, here, TOLERANCE),
        }
    }
}

impl std::fmt::Display for Accuracy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bits => f.write_str("bit for bit"),
            Self::Tolerance => {
                write!(f, "within a relative {TOLERANCE:e} (the result is from a different kind of machine)")
            }
        }
    }
}

/// Returns the first metric that differs: of all of them bit for bit, or of those that are averages within the tolerance.
pub(super) fn different_metric(
    there: &EpisodeMetrics,
    here: &EpisodeMetrics,
    accuracy: Accuracy,
) -> Option<(&'static str, f64, f64)> {
    let averages = |metrics: &EpisodeMetrics| {
        [
            ("return", metrics.episode_return),
            ("temperature penalty", metrics.temperature_penalty),
            ("energy penalty", metrics.energy_penalty),
            ("energy", metrics.energy()),
            ("RMS deviation", metrics.rms_deviation),
            ("mean absolute deviation", metrics.mean_abs_deviation),
            ("discomfort", metrics.discomfort),
            ("cost", metrics.cost),
            ("emissions", metrics.emissions),
        ]
    };
    let pairs = averages(there).into_iter().zip(averages(here));
    let mut averages = pairs.map(|((name, there), (_, here))| (name, there, here));
    let mut all = EpisodeMetrics::COLUMNS
        .iter()
        .map(|column| (column.name, (column.get)(there).as_f64(), (column.get)(here).as_f64()));
    let differ = |(_, there, here): &(&str, f64, f64)| {
        !(accuracy.same(*there, *here) || there.is_nan() && here.is_nan())
    };
    match accuracy {
        Accuracy::Bits => all.find(differ),
        Accuracy::Tolerance => averages.find(differ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_compared_on_the_same_kind_of_machine_and_values_on_another() {
        assert_eq!(Accuracy::on(&machine::fingerprint()), Accuracy::Bits);
        assert_eq!(Accuracy::on("x86_64, glibc 2.17"), Accuracy::Tolerance);
        let there =
            EpisodeMetrics { episode_return: -100.0, temperature_penalty: 100.0, ..Default::default() };
        let near = EpisodeMetrics { episode_return: -100.0 * (1.0 + 4e-9), ..there.clone() };
        let far = EpisodeMetrics { episode_return: -100.01, ..there.clone() };
        let different = |here: &EpisodeMetrics, accuracy| different_metric(&there, here, accuracy);
        assert_eq!(different(&there, Accuracy::Bits), None);
        assert_eq!(different(&near, Accuracy::Bits).unwrap().0, "return");
        assert_eq!(different(&near, Accuracy::Tolerance), None);
        assert_eq!(different(&far, Accuracy::Tolerance).unwrap().0, "return");
        let other = EpisodeMetrics { rms_heating_only: 0.5, ..there.clone() };
        assert_eq!(different(&other, Accuracy::Bits), Some(("rms_heating_only_k", 0.0, 0.5)));
    }
}
