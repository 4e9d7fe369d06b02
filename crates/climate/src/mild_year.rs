//! Weather for runs whose results do not depend on it.

use std::fmt::Write;

use b2b_base::calendar::Calendar;

const HEADER: &str = "LOCATION,Nowhere,,,,0,0.0,0.0,0.0,0.0
DESIGN CONDITIONS,0
TYPICAL/EXTREME PERIODS,0
GROUND TEMPERATURES,0
HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0
COMMENTS 1
COMMENTS 2
DATA PERIODS,1,1,Data,Sunday,1/1,12/31
";
/// The columns after the minute: 20 °C, 9 °C dew point, 50 %, without sun, wind and rain.
const CONDITIONS: &str = "?,20,9,50,101325,0,0,330,0,0,0,0,0,0,0,0,0,5,5,20,77777,9,999999999,0,0,0,88,0,0,0";

/// Returns the text of an EPW file with a year in which every hour is the same. A leap year has a 29 February.
pub fn mild_year(is_leap: bool) -> String {
    let calendar = Calendar::new(0, is_leap);
    let mut text = HEADER.to_owned();
    if is_leap {
        text = text.replace("SAVINGS,No", "SAVINGS,Yes");
    }
    for (day, hour) in (1..=calendar.days()).flat_map(|day| (1..=24).map(move |hour| (day, hour))) {
        let [month, day] = calendar.date(day);
        // Writing to a string never fails.
        let _ = writeln!(text, "2017,{month},{day},{hour},60,{CONDITIONS}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::epw::Record;

    #[test]
    fn every_hour_is_the_same() {
        let record = Record::of(&mild_year(false), std::path::Path::new("a.epw")).unwrap();
        assert!(record.is_whole_year() && record.dry_bulbs().iter().all(|hour| *hour == 20.0));
    }
}
