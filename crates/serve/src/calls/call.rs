//! The calls of BOPTEST that concern one test.

use axum::http::Method;

/// A call that concerns one test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// Name of the test case.
    Name,
    /// Inputs with metadata.
    Inputs,
    /// Measurements with metadata.
    Measurements,
    /// Forecast points with metadata.
    ForecastPoints,
    /// Step of an advance.
    Step,
    /// Sets the step.
    SetStep,
    /// The scenario.
    Scenario,
    /// Sets the scenario.
    SetScenario,
    /// Begins a run.
    Initialize,
    /// Advances a step.
    Advance,
    /// Values of points in the past.
    Results,
    /// Values of forecast points ahead.
    Forecast,
    /// Key performance indicators.
    Kpi,
    /// Publishes results on BOPTEST's dashboard; always refused.
    Submit,
}

/// Name, method and call.
const CALLS: [(&str, Method, Call); 15] = [
    ("name", Method::GET, Call::Name),
    ("inputs", Method::GET, Call::Inputs),
    ("measurements", Method::GET, Call::Measurements),
    ("forecast_points", Method::GET, Call::ForecastPoints),
    ("step", Method::GET, Call::Step),
    ("step", Method::PUT, Call::SetStep),
    ("scenario", Method::GET, Call::Scenario),
    ("scenario", Method::PUT, Call::SetScenario),
    ("initialize", Method::PUT, Call::Initialize),
    ("advance", Method::POST, Call::Advance),
    ("results", Method::PUT, Call::Results),
    ("forecast", Method::PUT, Call::Forecast),
    ("kpi", Method::GET, Call::Kpi),
    ("submit", Method::GET, Call::Submit),
    ("submit", Method::POST, Call::Submit),
];

impl Call {
    /// Returns the call of a name and a method.
    ///
    /// # Errors
    /// The methods of the name; none if there is no such call.
    pub fn find(name: &str, method: &Method) -> Result<Self, Vec<&'static str>> {
        let named = || CALLS.iter().filter(|(known, ..)| *known == name);
        let found = named().find(|(_, known, _)| known == method).map(|(.., call)| *call);
        found.ok_or_else(|| named().map(|(_, method, _)| method.as_str()).collect())
    }

    /// Returns the names of all calls, each once.
    pub fn names() -> Vec<&'static str> {
        let mut names: Vec<_> = CALLS.iter().map(|(name, ..)| *name).collect();
        names.dedup();
        names
    }
}
