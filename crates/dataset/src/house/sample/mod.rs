//! Samples of the ducted detached houses of Québec.
//!
//! A house is a function of a point of the unit cube, so that any design of experiments (a Latin hypercube, a grid,
//! random numbers) can draw houses. Each coordinate is transformed by an inverse cumulative distribution, from the
//! stock table where it has the variable, conditional on the vintage where the table distinguishes vintages.

use b2b_building::Parameter;
use b2b_climate::{Location, Region};

use self::stock::{number, numbers, pick, share, shares};
use super::parameters::{Foundation, Heater, Heating, House, IMPERIAL_R, IMPERIAL_U};

use crate::Result;

/// Number of coordinates of a house in the unit cube.
pub const DIMENSIONS: usize = 18;

/// Floor area by its rank in the stock, m²: quartiles 137 and 204, median 161, mean 188 (stock table's summary; the
/// ends are engineering judgment, and close the mean). The table's size classes, in ft², rank the houses of a
/// vintage among all.
const FLOOR_AREA: [(f64, f64); 6] =
    [(0.0, 60.0), (0.25, 137.0), (0.5, 161.0), (0.75, 204.0), (0.9, 310.0), (1.0, 528.0)];
/// Length over width, uniform around the stock's 1.8 (engineering judgment).
const ASPECT: [f64; 2] = [1.2, 2.4];
/// Half the width of a class of air changes (the table has whole numbers), 1/h.
const HALF_AIR_CHANGE: f64 = 0.5;
/// Half the width of a class of window-to-wall ratio (the table has multiples of 3 %).
const HALF_WINDOW_CLASS: f64 = 0.015;
/// U-factor (Btu/h·ft²·°F) and solar heat gain coefficient by window type: the summary of the stock table, and for
/// the single panes ResStock's options of the same names.
const WINDOWS: [(&str, f64, f64); 8] = [
    ("Double, Clear, Non-metal, Air", 0.49, 0.56),
    ("Double, Low-E, Non-metal, Air, L-Gain", 0.37, 0.30),
    ("Double, Clear, Metal, Air", 0.76, 0.67),
    ("Triple, Low-E, Non-metal, Air, L-Gain", 0.29, 0.26),
    ("Double, Low-E, Non-metal, Air, M-Gain", 0.38, 0.44),
    ("Single, Clear, Non-metal", 0.84, 0.63),
    ("Double, Low-E, L-Gain", 0.37, 0.30),
    ("Single, Clear, Metal", 1.16, 0.76),
];
/// Lighting and appliances over standard operating conditions, uniform (engineering judgment).
const APPLIANCE_USE: [f64; 2] = [0.7, 1.3];
/// Mean ventilation of a house with bathroom fans and windows, and of one with a central ventilator, L/s, uniform
/// (engineering judgment; NBC 9.32 asks 16 to 30 L/s of a principal fan, by bedrooms).
const FANS: [f64; 2] = [10.0, 30.0];
const VENTILATOR: [f64; 2] = [20.0, 40.0];
/// Sensible recovery of a heat-recovery ventilator, uniform (HVI directory, CSA F439 at 0 °C: 0.55 to 0.75).
const RECOVERY: [f64; 2] = [0.55, 0.75];
/// Heat over design heat loss, and cooling over design heat gain, uniform. CSA F280 accepts 1.4 and 1.25; installed
/// equipment exceeds it (engineering judgment).
const HEATING_OVERSIZING: [f64; 2] = [1.1, 1.7];
const COOLING_OVERSIZING: [f64; 2] = [1.0, 1.5];
/// Outdoor temperature under which a single-speed compressor stops, °C (a house of the original data set).
pub(crate) const CUTOFF: f64 = -12.0;
/// Efficiency of a fuel furnace (stock table: 80 % AFUE).
pub(crate) const FUEL: Heater = Heater::Fuel { efficiency: 0.8 };
/// SEER of cooling in a house with a furnace: the stock's usual heat pump (engineering judgment: the table has central
/// cooling but not its efficiency).
const FURNACE_SEER: f64 = 13.0;
/// SEER and HSPF of a heat pump.
type Ratings = (f64, f64);

/// The ducted systems of the stock table: the heat pump, if there is one, and the heater. Two furnaces in one house
/// and ground-source heat pumps, 5 % of the ducted houses, are left out.
const SYSTEMS: [(&str, Option<Ratings>, Heater); 8] = [
    ("ASHP, SEER 10, 6.2 HSPF", Some((10.0, 6.2)), Heater::Electric),
    ("ASHP, SEER 13, 7.7 HSPF", Some((13.0, 7.7)), Heater::Electric),
    ("ASHP, SEER 15, 8.5 HSPF", Some((15.0, 8.5)), Heater::Electric),
    ("Fuel Furnace, 80% AFUE & ASHP, SEER 10, 6.2 HSPF", Some((10.0, 6.2)), FUEL),
    ("Fuel Furnace, 80% AFUE & ASHP, SEER 13, 7.7 HSPF", Some((13.0, 7.7)), FUEL),
    ("Fuel Furnace, 80% AFUE & ASHP, SEER 15, 8.5 HSPF", Some((15.0, 8.5)), FUEL),
    ("Electric Furnace, 100% AFUE", None, Heater::Electric),
    ("Fuel Furnace, 80% AFUE", None, FUEL),
];
/// Power of the fan per cooling or heating delivered at rated flow: 365 W per 1000 cfm, 400 cfm per ton (AHRI
/// 210/240). Ratings are net of it, models are not.
const RATED_FAN: f64 = 0.0415;

/// Construction periods of houses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Vintage {
    /// Before 1946.
    Before1946,
    /// 1946 to 1970.
    From1946,
    /// 1971 to 1985.
    From1971,
    /// 1986 to 2012.
    From1986,
    /// 2013 and after.
    From2013,
}

impl Vintage {
    /// Every vintage, oldest first.
    pub const ALL: [Self; 5] =
        [Self::Before1946, Self::From1946, Self::From1971, Self::From1986, Self::From2013];

    /// Its name in the stock table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Before1946 => "< 1946",
            Self::From1946 => "[1946 - 1971)",
            Self::From1971 => "[1971 - 1986)",
            Self::From1986 => "[1986 - 2013)",
            Self::From2013 => ">= 2013",
        }
    }

    /// First and last year of construction.
    pub const YEARS: [u32; 2] = [1900, 2023];

    /// The vintage of a year.
    pub fn of_year(year: u32) -> Self {
        let begun = |vintage: &&Self| vintage.years()[0] <= f64::from(year);
        *Self::ALL.iter().rev().find(begun).unwrap_or(&Self::Before1946)
    }

    /// First year, and the year after the last; the outer limits are engineering judgment.
    fn years(self) -> [f64; 2] {
        match self {
            Self::Before1946 => [1900.0, 1946.0],
            Self::From1946 => [1946.0, 1971.0],
            Self::From1971 => [1971.0, 1986.0],
            Self::From1986 => [1986.0, 2013.0],
            Self::From2013 => [2013.0, 2024.0],
        }
    }
}

/// A house drawn from the stock: location, year and every parameter of its model.
#[derive(Clone, Debug, PartialEq)]
pub struct HouseSample {
    /// Its location.
    pub location: Location,
    /// Its construction period.
    pub vintage: Vintage,
    /// Year of construction.
    pub year: u32,
    /// Its parameters.
    pub house: House,
}

/// Given properties of a house; all others are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FixedProperties {
    /// Year of construction, which determines the vintage.
    pub year: Option<u32>,
    /// Foundation.
    pub foundation: Option<Foundation>,
}

impl HouseSample {
    /// Returns the house at a point of the unit cube. Coordinates, in order: region, vintage, floor area, storeys,
    /// aspect, foundation, garage, insulation, airtightness, window-to-wall ratio, window type, orientation, occupants,
    /// appliances, ventilation, system, heating oversizing, cooling oversizing.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a coordinate outside 0 to 1.
    pub fn from_unit(point: &[f64; DIMENSIONS]) -> Result<Self> {
        Self::from_unit_with(point, &FixedProperties::default())
    }

    /// [`HouseSample::from_unit`] with given properties; dependent ones are drawn accordingly.
    ///
    /// # Errors
    /// Same as [`HouseSample::from_unit`].
    pub fn from_unit_with(point: &[f64; DIMENSIONS], given: &FixedProperties) -> Result<Self> {
        check(point)?;
        #[rustfmt::skip]
        let [
            region, vintage, area, storeys, aspect, ground, garage, insulation, tightness, glass, window, orientation,
            people, usage, air, system, heat, cool,
        ] = *point;
        let (drawn_vintage, within) = pick_vintage(vintage);
        let vintage = given.year.map_or(drawn_vintage, Vintage::of_year);
        let foundation = given.foundation.unwrap_or_else(|| foundation(ground));
        let [wall_resistance, attic_resistance, foundation_resistance] = resistances(vintage, insulation);
        let (window_u, window_shgc) = window_type(vintage, window);
        let (ventilation, heat_recovery) = ventilation(air);
        let (heating, cooling_cop) = heating_system(system);
        let house = House {
            floor_area: floor_area(vintage, area),
            storeys: storeys_on(foundation, storeys),
            aspect: between(ASPECT, aspect),
            orientation: 360.0 * orientation,
            foundation,
            garage: garage < share("Presence_Garage", "Garage non chauffé"),
            wall_resistance,
            attic_resistance,
            foundation_resistance,
            air_changes_50: air_changes(vintage, tightness),
            window_to_wall: window_to_wall(glass),
            window_u,
            window_shgc,
            occupants: pick(&numbers("Nombre_Personnes", ""), people).0,
            household: 0,
            appliance_use: between(APPLIANCE_USE, usage),
            ventilation,
            heat_recovery,
            heating,
            cooling_cop,
            heating_oversizing: between(HEATING_OVERSIZING, heat),
            cooling_oversizing: between(COOLING_OVERSIZING, cool),
            capacities: None,
        };
        let year = given.year.unwrap_or_else(|| between(vintage.years(), within.min(0.999)) as u32);
        Ok(Self { location: Location::Region(pick_region(region)), vintage, year, house })
    }
}

fn check(point: &[f64; DIMENSIONS]) -> Result<()> {
    const COORDINATE: Parameter = Parameter::new("coordinate of the unit cube", "1", 0.0, 1.0);
    Ok(point.iter().try_for_each(|value| COORDINATE.check(*value))?)
}

fn between([low, high]: [f64; 2], u: f64) -> f64 {
    low + (high - low) * u
}

fn pick_region(u: f64) -> &'static Region {
    let weighted: Vec<_> =
        Region::all().iter().map(|region| (region, share("Region_Administrative", region.name))).collect();
    pick(&weighted, u).0
}

fn pick_vintage(u: f64) -> (Vintage, f64) {
    pick(&Vintage::ALL.map(|vintage| (vintage, share("An_ConstructionCode", vintage.name()))), u)
}

fn floor_area(vintage: Vintage, u: f64) -> f64 {
    const CLASSES: &str = "Superficie_Totale";
    let (class, within) = pick(&numbers(CLASSES, vintage.name()), u);
    let all = numbers(CLASSES, "");
    let smaller: f64 = all.iter().filter(|(c, _)| *c < class).map(|(_, share)| share).sum();
    let own: f64 = all.iter().filter(|(c, _)| *c == class).map(|(_, share)| share).sum();
    interpolate(&FLOOR_AREA, smaller + within * own)
}

fn interpolate(knots: &[(f64, f64)], x: f64) -> f64 {
    let last = knots[knots.len() - 1].1;
    knots.windows(2).find(|pair| x < pair[1].0).map_or(last, |pair| {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    })
}

/// A basement next to a crawlspace counts as a basement.
fn foundation(u: f64) -> Foundation {
    let share = |value| share("Presence_SousSol", value);
    let basement = share("Sous sol 6 pied") + share("Sous-sol et vide sanitaire");
    let weighted = [
        (Foundation::Basement, basement),
        (Foundation::Slab, share("Aucun Sous-sol ou vide sanitaire")),
        (Foundation::Crawlspace, share("Vide sanitaire moins 6 pieds")),
    ];
    pick(&weighted, u).0
}

/// Storeys above the foundation. The table's storeys are taken to include the basement: houses with one (12 %) are
/// about as many as houses without basement (14 %); three means two over a basement (engineering judgment).
fn storeys_on(foundation: Foundation, u: f64) -> u32 {
    let levels = |value| share("Nombre_Etages", value);
    let basement = share("Presence_SousSol", "Sous sol 6 pied")
        + share("Presence_SousSol", "Sous-sol et vide sanitaire");
    let single = match foundation {
        Foundation::Basement => 1.0 - levels("Trois étages et plus") / basement,
        Foundation::Slab | Foundation::Crawlspace => levels("Un étage") / (1.0 - basement),
    };
    if u < single { 1 } else { 2 }
}

/// Wall, attic and foundation, m²K/W. The table has the same classes, shares and order for each, because one code era,
/// or one renovation, determines all three.
fn resistances(vintage: Vintage, u: f64) -> [f64; 3] {
    let era = vintage.name();
    let classes: Vec<_> = shares("Insulation Wall", era)
        .iter()
        .enumerate()
        .map(|(class, (_, share))| (class, *share))
        .collect();
    let (class, _) = pick(&classes, u);
    ["Insulation Wall", "Insulation Ceiling", "Insulation Foundation Wall"]
        .map(|part| number(shares(part, era)[class].0) * IMPERIAL_R)
}

fn air_changes(vintage: Vintage, u: f64) -> f64 {
    let (class, within) = pick(&numbers("Infiltration", vintage.name()), u);
    class + HALF_AIR_CHANGE * (2.0 * within - 1.0)
}

fn window_to_wall(u: f64) -> f64 {
    let (class, within) = pick(&numbers("Window Areas", ""), u);
    class / 100.0 + HALF_WINDOW_CLASS * (2.0 * within - 1.0)
}

/// U (W/m²K) and solar heat gain coefficient.
fn window_type(vintage: Vintage, u: f64) -> (f64, f64) {
    let in_era = |kind: &str| {
        shares("Windows", vintage.name()).iter().filter(|(v, _)| *v == kind).map(|(_, share)| share).sum()
    };
    let ((u_factor, shgc), _) = pick(&WINDOWS.map(|(kind, u, shgc)| ((u, shgc), in_era(kind))), u);
    (u_factor * IMPERIAL_U, shgc)
}

/// Flow (L/s) and recovery. The table's codes mean: no ventilator; with heat recovery (VRC); without (VRS); unknown
/// (VRNsP), divided between the two (engineering judgment).
fn ventilation(u: f64) -> (f64, f64) {
    let share = |value| share("VRC", value);
    let (with, without) = (share("VRC"), share("VRS"));
    let known = 1.0 + share("VRNsP") / (with + without);
    let weighted = [(None, share("Aucun")), (Some(false), without * known), (Some(true), with * known)];
    match pick(&weighted, u) {
        (None, within) => (between(FANS, within), 0.0),
        (Some(false), within) => (between(VENTILATOR, within), 0.0),
        // More flow, more recovery: a larger core.
        (Some(true), within) => (between(VENTILATOR, within), between(RECOVERY, within)),
    }
}

/// The system and its gross cooling COP.
fn heating_system(u: f64) -> (Heating, f64) {
    let weighted =
        SYSTEMS.map(|(name, pump, heater)| ((pump, heater), share("HVAC Heating Efficiency", name)));
    let ((pump, heater), _) = pick(&weighted, u);
    match pump {
        None => (Heating::Furnace(heater), cooling_cop(FURNACE_SEER)),
        Some((seer, hspf)) => {
            let cop = heating_cop(hspf);
            (Heating::HeatPump { cop, cutoff: CUTOFF, backup: heater }, cooling_cop(seer))
        }
    }
}

/// Gross COP at 35 °C of a single-speed unit (SEER to EER: Wassmer 2003, as ResStock).
fn cooling_cop(seer: f64) -> f64 {
    let net = seer * (1.1088 - 0.0202 * seer) / 3.412;
    (1.0 + RATED_FAN) / (1.0 / net - RATED_FAN)
}

/// Gross COP at 8.3 °C of a single-speed unit (HSPF to COP: ResStock, single-speed).
fn heating_cop(hspf: f64) -> f64 {
    let net = hspf * (0.6239 - 0.0255 * hspf);
    (1.0 - RATED_FAN) / (1.0 / net - RATED_FAN)
}

pub(crate) mod stock;
#[cfg(test)]
mod tests;
