//! The three price scenarios of BOPTEST.

use b2b_tariff::{Calendar, Carrier, Moment, Prices, Tariff};

use crate::Result;

/// A price scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum PriceScenario {
    /// The same price all year.
    #[default]
    Constant,
    /// By season and hour.
    Dynamic,
    /// By hour, as on a market.
    HighlyDynamic,
}

impl PriceScenario {
    /// All scenarios.
    pub const ALL: [Self; 3] = [Self::Constant, Self::Dynamic, Self::HighlyDynamic];

    /// Returns the name in requests.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Dynamic => "dynamic",
            Self::HighlyDynamic => "highly_dynamic",
        }
    }

    /// Returns the name of its forecast point.
    pub fn point(self) -> &'static str {
        match self {
            Self::Constant => "PriceElectricPowerConstant",
            Self::Dynamic => "PriceElectricPowerDynamic",
            Self::HighlyDynamic => "PriceElectricPowerHighlyDynamic",
        }
    }

    /// Returns the name of its tariff.
    pub fn tariff(self) -> &'static str {
        match self {
            Self::Constant => "flat",
            Self::Dynamic => "tou",
            Self::HighlyDynamic => "dynamic",
        }
    }
}

/// The prices of all scenarios, in their order.
#[derive(Clone, Debug)]
pub(crate) struct AllPrices([Prices; 3]);

impl AllPrices {
    /// Lays out the tariffs of the scenarios in a calendar.
    ///
    /// # Errors
    /// [`crate::Error::Tariff`].
    pub fn new(calendar: Calendar) -> Result<Self> {
        let of = |scenario: PriceScenario| {
            let tariff = Tariff::named(scenario.tariff())?;
            Prices::new(tariff, calendar, &[], None)
        };
        let [constant, dynamic, highly_dynamic] = PriceScenario::ALL.map(of);
        Ok(Self([constant?, dynamic?, highly_dynamic?]))
    }

    /// Returns the prices of a scenario.
    pub fn of(&self, scenario: PriceScenario) -> &Prices {
        &self.0[scenario as usize]
    }

    /// Returns the price of gas at a moment, currency/kWh.
    pub fn gas(&self, at: Moment) -> f64 {
        self.of(PriceScenario::Constant).price(Carrier::Gas, at)
    }
}
