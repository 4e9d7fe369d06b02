//! Writes the model of a house for the place of a weather file.
//!
//! `cargo run -p b2b-building --example house -- WEATHER.epw HOUSE.epJSON [slab] [crawlspace] [garage] [furnace] [two-storey]`

use std::error::Error;
use std::path::Path;

use b2b_building::climate::Site;
use b2b_building::house::{Capacities, Foundation, Heater, Heating, House, house};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [weather, output, options @ ..] = arguments.as_slice() else {
        return Err(
            "usage: house WEATHER.epw HOUSE.epJSON [slab] [crawlspace] [garage] [furnace] [two-storey]"
                .into(),
        );
    };
    let site = Site::read(Path::new(weather))?;
    let mut parameters = House::default();
    for option in options {
        match option.as_str() {
            "slab" => parameters.foundation = Foundation::Slab,
            "crawlspace" => parameters.foundation = Foundation::Crawlspace,
            "garage" => parameters.garage = true,
            "furnace" => parameters.heating = Heating::Furnace(Heater::Fuel { efficiency: 0.8 }),
            "two-storey" => parameters.storeys = 2,
            other => return Err(format!("unknown option `{other}`").into()),
        }
    }
    println!("{:?}", Capacities::for_design_days(&parameters, &site));
    std::fs::write(output, house(&parameters, &site)?.to_epjson())?;
    Ok(())
}
