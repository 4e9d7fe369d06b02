//! The scenario of a test: its two weeks, prices, and errors of weather forecasts.

use b2b_climate::TwoWeeks;
use serde_json::{Value, json};

use crate::calls::{Arguments, Refusal, shown};
use crate::subject::{PriceScenario, Uncertainty, WeatherErrors};

const TIME_PERIOD: &str = "time_period";
const PRICE: &str = "electricity_price";
const TEMPERATURE: &str = "temperature_uncertainty";
const SOLAR: &str = "solar_uncertainty";
const SEED: &str = "seed";

/// The scenario of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Scenario {
    /// Two weeks; `None` in a test that was initialized at a time.
    pub time_period: Option<TwoWeeks>,
    /// Prices of electricity.
    pub price: PriceScenario,
    temperature: Option<Uncertainty>,
    solar: Option<Uncertainty>,
    seed: Option<u64>,
}

/// The values that a request sets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Change {
    /// Two weeks to begin.
    pub time_period: Option<TwoWeeks>,
    price: Option<PriceScenario>,
    temperature: Option<Uncertainty>,
    solar: Option<Uncertainty>,
    seed: Option<u64>,
}

impl Change {
    /// Reads a request.
    ///
    /// # Errors
    /// A refusal of an unknown argument or value.
    pub fn read(arguments: &Arguments) -> Result<Self, Refusal> {
        arguments.expect(&[TIME_PERIOD, PRICE, TEMPERATURE, SOLAR, SEED])?;
        Ok(Self {
            time_period: choice(
                arguments,
                TIME_PERIOD,
                &TwoWeeks::ALL.map(|weeks| (period_name(weeks), weeks)),
            )?,
            price: choice(arguments, PRICE, &PriceScenario::ALL.map(|price| (price.name(), price)))?,
            temperature: uncertainty(arguments, TEMPERATURE)?,
            solar: uncertainty(arguments, SOLAR)?,
            seed: seed(arguments)?,
        })
    }

    /// Returns the settings, with the measurements at the beginning of the two weeks.
    pub fn payload(&self, measurements: Value) -> Value {
        json!({
            PRICE: self.price.map(PriceScenario::name),
            TIME_PERIOD: measurements,
            TEMPERATURE: self.temperature.map(Uncertainty::name),
            SOLAR: self.solar.map(Uncertainty::name),
            SEED: self.seed,
        })
    }
}

impl Scenario {
    /// Applies a change. As in BOPTEST, prices and two weeks that are not named stay the same, and errors that are not
    /// named end.
    pub fn apply(&mut self, change: &Change) {
        let Change { time_period, price, temperature, solar, seed } = *change;
        self.time_period = time_period.or(self.time_period);
        self.price = price.unwrap_or(self.price);
        (self.temperature, self.solar, self.seed) = (temperature, solar, seed);
    }

    /// Returns the errors of forecasts.
    pub fn errors(&self) -> WeatherErrors {
        let Self { temperature, solar, seed, .. } = *self;
        WeatherErrors { temperature, solar, seed: seed.unwrap_or_default() }
    }

    /// Returns the scenario.
    pub fn payload(&self) -> Value {
        json!({
            PRICE: self.price.name(),
            TIME_PERIOD: self.time_period.map(period_name),
            TEMPERATURE: self.temperature.map(Uncertainty::name),
            SOLAR: self.solar.map(Uncertainty::name),
            SEED: self.seed,
        })
    }
}

/// Returns the name of two weeks in BOPTEST.
fn period_name(weeks: TwoWeeks) -> &'static str {
    match weeks {
        TwoWeeks::PeakHeating => "peak_heat_day",
        TwoWeeks::PeakCooling => "peak_cool_day",
        TwoWeeks::TypicalHeating => "typical_heat_day",
        TwoWeeks::TypicalCooling => "typical_cool_day",
        TwoWeeks::Mixed => "mix_day",
    }
}

fn uncertainty(arguments: &Arguments, name: &str) -> Result<Option<Uncertainty>, Refusal> {
    let [low, medium, high] = Uncertainty::ALL.map(|level| (level.name(), Some(level)));
    Ok(choice(arguments, name, &[("none", None), low, medium, high])?.flatten())
}

fn choice<T: Copy>(arguments: &Arguments, name: &str, choices: &[(&str, T)]) -> Result<Option<T>, Refusal> {
    let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
    let remedy = format!("expected {}", names.join(", "));
    let Some(text) = arguments.text(name, &remedy)? else { return Ok(None) };
    let chosen = choices.iter().find(|(known, _)| *known == text).map(|(_, choice)| *choice);
    chosen.map_or_else(
        || Err(Refusal::bad(format!("`{name}` is `{text}`; {remedy}"))),
        |choice| Ok(Some(choice)),
    )
}

fn seed(arguments: &Arguments) -> Result<Option<u64>, Refusal> {
    let Some(value) = arguments.get(SEED) else { return Ok(None) };
    let seed = value.as_u64().or_else(|| value.as_str()?.parse().ok());
    let refused =
        || Refusal::bad(format!("`{SEED}` is `{}`; expected a whole number, 0 or more", shown(value)));
    seed.ok_or_else(refused).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(body: &str) -> Result<Change, Refusal> {
        Change::read(&Arguments::read(None, body.as_bytes()).unwrap())
    }

    #[test]
    fn prices_stay_and_errors_end_unless_they_are_named() {
        let mut scenario = Scenario::default();
        let all = r#"{"electricity_price": "dynamic", "temperature_uncertainty": "low", "seed": 5}"#;
        scenario.apply(&read(all).unwrap());
        assert_eq!(scenario.payload()[PRICE], "dynamic");
        assert_eq!(scenario.errors().seed, 5);
        scenario.apply(&read(r#"{"solar_uncertainty": "none", "time_period": null}"#).unwrap());
        assert_eq!(scenario, Scenario { price: PriceScenario::Dynamic, ..Scenario::default() });
    }

    #[test]
    fn an_unknown_choice_is_refused_with_the_known_ones() {
        for (body, words) in [
            (r#"{"time_period": "peak_heat"}"#, ["peak_heat`", "typical_cool_day"]),
            (r#"{"electricity_price": 3}"#, ["`3`", "highly_dynamic"]),
            (r#"{"seed": -1}"#, ["`-1`", "whole number"]),
            (r#"{"prices": "dynamic"}"#, ["prices", "electricity_price"]),
        ] {
            let said = format!("{:?}", read(body).unwrap_err());
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        }
    }
}
