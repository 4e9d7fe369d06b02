//! The accuracy of comparing reruns with a result.

use b2b_base::machine;
use b2b_env::{EpisodeMetrics, MetricValue, Resource, Term};

use super::{TOLERANCE, is_near};

/// The accuracy of comparing reruns with a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Accuracy {
    /// Bit for bit, because this machine rounds like the one that produced the result.
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

/// Returns the first metric that differs: comparing all bit for bit, or only sums and means within the tolerance.
pub(super) fn different_metric(
    there: &EpisodeMetrics,
    here: &EpisodeMetrics,
    accuracy: Accuracy,
) -> Option<(&'static str, f64, f64)> {
    let values = |metrics: &EpisodeMetrics| {
        [
            ("return", Some(metrics.episode_return)),
            ("temperature penalty", Some(metrics.temperature_penalty)),
            ("energy penalty", Some(metrics.energy_penalty)),
            ("energy", metrics.used(Resource::ENERGY)),
            ("RMS deviation", Some(metrics.rms_deviation)),
            ("mean absolute deviation", Some(metrics.mean_abs_deviation)),
            ("discomfort", Some(metrics.discomfort)),
            ("thermal discomfort", metrics.tdis_tot),
            ("cost", metrics.terms.get(Term::Cost)),
            ("emissions", metrics.terms.get(Term::Emissions)),
        ]
    };
    let mut pairs = values(there).into_iter().zip(values(here));
    let found = pairs.find_map(|((name, there), (_, here))| {
        different(name, there, here, |there, here| accuracy.same(there, here))
    });
    let other = || {
        EpisodeMetrics::columns().find_map(|column| {
            let [there, here] = [there, here].map(|metrics| column.get(metrics).map(MetricValue::as_f64));
            different(column.name, there, here, |there, here| there == here)
        })
    };
    found.or_else(|| (accuracy == Accuracy::Bits).then(other).flatten())
}

/// Returns a metric with its values if they differ. A result may be older than a metric.
fn different(
    name: &'static str,
    there: Option<f64>,
    here: Option<f64>,
    is_same: impl Fn(f64, f64) -> bool,
) -> Option<(&'static str, f64, f64)> {
    let (there, here) = (there?, here.unwrap_or(f64::NAN));
    (!is_same(there, here)).then_some((name, there, here))
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
        let [cold, colder] = [9.0, 9.1].map(|k_h| EpisodeMetrics { tdis_tot: Some(k_h), ..there.clone() });
        let found = different_metric(&colder, &cold, Accuracy::Tolerance);
        assert_eq!(found, Some(("thermal discomfort", 9.1, 9.0)));
        let travels = EpisodeMetrics { daily_travel: 1.0, ..there.clone() };
        assert_eq!(different(&travels, Accuracy::Bits), Some(("daily_travel", 0.0, 1.0)));
        let mut younger = EpisodeMetrics { occupied_too_cold: Some(0.5), ..there.clone() };
        younger.terms.set(Term::Heating, 2.0);
        assert_eq!(different(&younger, Accuracy::Bits), None, "the result is older than these metrics");
        assert_eq!(different_metric(&younger, &there, Accuracy::Bits).unwrap().0, "heating_wh_m2");
    }
}
