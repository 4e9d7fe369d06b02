//! Properties of every bill: its steps sum up to it, and it equals the bill of the whole trajectory.

use std::collections::BTreeMap;

use crate::common::{STEP, YEAR, assert_cost, day, electricity, part, prices, run};
use b2b_tariff::{Bill, Calendar, Carrier, Event, Moment, PREVIEW, Prices, Tariff};

/// A load that changes every step, with peaks at changing hours.
fn wavy(at: Moment) -> f64 {
    let hours = f64::from(at.day) * 24.0 + at.hour;
    70.0 + 40.0 * (hours * 0.7).sin() + 25.0 * (hours * 3.3).cos()
}

fn outdoor() -> Vec<f64> {
    (0..8760).map(|hour| -10.0 + 8.0 * (f64::from(hour) * 0.05).sin()).collect()
}

fn in_2017(name: &str) -> Prices {
    let event = Event { day: day(1, 20), from: 16.0, to: 20.0 };
    prices(name, &[event], Some(&outdoor()))
}

#[test]
fn the_steps_of_every_shipped_tariff_sum_up_to_the_bill_and_its_parts() {
    for name in Tariff::names() {
        let prices = in_2017(name);
        let (bill, costs) = run(&prices, day(1, 18), day(3, 14), wavy);
        let total = bill.total(&prices);
        assert!(total > 0.0 && total.is_finite(), "{name}");
        assert_cost(costs.iter().map(|cost| cost.total()).sum(), total);
        assert_cost(bill.parts(&prices).iter().map(|part| part.cost).sum(), total);
        assert!(costs.iter().all(|cost| cost.energy > 0.0), "{name}");
        let has_demand = costs.iter().any(|cost| cost.demand > 0.0);
        assert_eq!(has_demand, prices.tariff().has_demand_charge(), "{name}");
    }
}

/// Rate G from its definition: 15,090 kWh a month at the first price; the largest 15-minute mean above 50 kW, but at
/// least 65 % of the winter's largest until then.
#[test]
fn rate_g_of_a_trajectory_equals_the_sum_of_the_steps() {
    let prices = prices("hq-g", &[], None);
    let (first, last) = (day(3, 10), day(5, 12));
    let load = |at: Moment| if at.day <= day(3, 31) { 2.0 * wavy(at) } else { wavy(at) };
    let (bill, _) = run(&prices, first, last, load);
    let mut months: BTreeMap<usize, (f64, f64, f64)> = BTreeMap::new();
    for day in first..=last {
        let month = [day >= crate::common::day(4, 1), day >= crate::common::day(5, 1)]
            .into_iter()
            .filter(|after| *after)
            .count();
        for quarter in 0..96 {
            let at = |step: u32| Moment { day, hour: f64::from(quarter * 3 + step) * STEP };
            let mean = (0..3).map(|step| load(at(step))).sum::<f64>() / 3.0;
            let entry = months.entry(month).or_default();
            *entry = (entry.0 + mean / 4.0, entry.1.max(mean), entry.2 + 1.0 / 96.0);
        }
    }
    let (mut energy, mut demand, mut winter) = (0.0, 0.0, 0.0_f64);
    for (month, (kwh, peak, days)) in months {
        let block = 15_090.0 * days / 30.0;
        energy += kwh.min(block) * 0.12388 + (kwh - block).max(0.0) * 0.09534;
        winter = if month == 0 { peak } else { winter };
        demand += (peak.max(0.65 * winter) - 50.0).max(0.0) * 22.071 * days / 30.0;
    }
    assert_cost(part(&bill, &prices, "energy"), energy);
    assert_cost(part(&bill, &prices, "demand"), demand);
}

#[test]
fn a_ratchet_bills_65_percent_of_the_winter_peak_in_summer() {
    let prices = prices("hq-m", &[], None);
    let load = |at: Moment| if at.day == day(3, 31) && at.hour < 0.25 { 200.0 } else { 10.0 };
    let (bill, costs) = run(&prices, day(3, 31), day(6, 30), load);
    let months = 200.0 / 30.0 + 0.65 * 200.0 * (30.0 + 31.0 + 30.0) / 30.0;
    assert_cost(part(&bill, &prices, "demand"), 18.242 * months);
    // It is due at the first step of a month.
    assert_cost(costs[288].demand, 18.242 * 130.0);
    assert_eq!(costs[289].demand, 0.0);
    // A peak in summer sets no floor.
    let summer = |at: Moment| if at.day == day(4, 30) && at.hour < 0.25 { 200.0 } else { 10.0 };
    let (bill, _) = run(&prices, day(4, 30), day(5, 31), summer);
    assert_cost(part(&bill, &prices, "demand"), 18.242 * (200.0 + 10.0 * 31.0) / 30.0);
}

#[test]
fn a_spike_of_five_minutes_counts_by_its_quarter_hour() {
    let prices = prices("minnesota-power-gs", &[], None);
    let load = |at: Moment| if at.day == 2 && (at.hour - 12.0).abs() < 0.01 { 90.0 } else { 30.0 };
    let (bill, costs) = run(&prices, 1, 31, load);
    assert_cost(part(&bill, &prices, "demand"), 50.0 * 6.5);
    let charged: Vec<usize> = (0..costs.len()).filter(|step| costs[*step].demand > 1e-9).collect();
    // The first quarter-hour builds up to 30 kW; the spike's quarter-hour exceeds it in each of its three steps.
    assert_eq!(charged, [0, 1, 2, 288 + 145, 288 + 146]);
}

#[test]
fn steps_of_an_hour_or_a_minute_are_billed_alike() {
    for name in ["fpl-gsdt-1", "hq-d", "hq-g", "tou"] {
        let prices = in_2017(name);
        let bill_of = |steps_an_hour: u32| {
            let mut bill = Bill::new(day(3, 9), day(3, 14));
            let hours = 1.0 / f64::from(steps_an_hour);
            for step in 0..6 * 24 * steps_an_hour {
                let hour = step / steps_an_hour;
                let at = Moment {
                    day: day(3, 9) + hour / 24,
                    hour: f64::from(hour % 24) + f64::from(step % steps_an_hour) * hours,
                };
                let power = if (8..20).contains(&(hour % 24)) { 90.0 } else { 20.0 };
                bill.step(&prices, at, &electricity(power * hours), hours);
            }
            bill.total(&prices)
        };
        assert_cost(bill_of(1), bill_of(60));
        assert_cost(bill_of(6), bill_of(12));
    }
}

#[test]
fn an_episode_that_passes_new_year_costs_as_much_as_its_parts_in_two_years() {
    let bill_of = |calendar: Calendar, days: &[u32]| {
        let prices = Prices::new(Tariff::named("fpl-gsdt-1").unwrap(), calendar, &[], None).unwrap();
        let mut bill = Bill::new(days[0], days[days.len() - 1]);
        for (day, hour) in days.iter().flat_map(|day| (0..24).map(move |hour| (*day, hour))) {
            let power = f64::from(20 + day % 7 + hour);
            bill.step(&prices, Moment { day, hour: f64::from(hour) }, &electricity(power), 1.0);
        }
        bill.total(&prices)
    };
    let (december, january): (Vec<u32>, Vec<u32>) = ((361..=365).collect(), (1..=9).collect());
    let both = [&december[..], &january].concat();
    let parts = bill_of(YEAR, &december) + bill_of(YEAR.following(), &january);
    assert_cost(bill_of(YEAR.passing_new_year(361), &both), parts);
}

#[test]
fn a_year_from_the_middle_of_a_month_is_billed_for_twelve_months() {
    // Half a month at the beginning and half at the end.
    let days: Vec<u32> = (day(7, 15)..=365).chain(1..day(7, 15)).collect();
    let bill_of = |days: &[u32]| {
        let prices = prices("minnesota-power-gs", &[], None);
        let mut bill = Bill::new(days[0], days[days.len() - 1]);
        for (day, hour) in days.iter().flat_map(|day| (0..24).map(move |hour| (*day, hour))) {
            bill.step(&prices, Moment { day, hour: f64::from(hour) }, &electricity(30.0), 1.0);
        }
        bill.total(&prices)
    };
    assert_cost(bill_of(&days), bill_of(&(1..=365).collect::<Vec<_>>()));
}

#[test]
fn free_power_is_what_may_be_used_without_a_higher_bill() {
    let prices = prices("hq-g", &[], None);
    let at = |day, hour| Moment { day, hour };
    let mut bill = Bill::new(day(3, 31), day(4, 30));
    assert_eq!(bill.free_power(&prices, at(day(3, 31), 0.0)), 50.0, "the first 50 kW are free");
    bill.step(&prices, at(day(3, 31), 0.0), &electricity(100.0), 1.0);
    assert_eq!(bill.free_power(&prices, at(day(3, 31), 1.0)), 100.0);
    // April bills 65 % of the winter's peak anyway.
    let first = bill.step(&prices, at(day(4, 1), 0.0), &electricity(10.0), 1.0);
    assert_cost(first.demand, 15.0 * 22.071);
    let free = bill.free_power(&prices, at(day(4, 1), 1.0));
    assert_eq!(free, 65.0);
    assert_eq!(bill.step(&prices, at(day(4, 1), 1.0), &electricity(free), 1.0).demand, 0.0);
    assert!(bill.step(&prices, at(day(4, 1), 2.0), &electricity(free + 1.0), 1.0).demand > 20.0);
    let fpl = crate::common::prices("fpl-gsdt-1", &[], None);
    assert_eq!(Bill::new(1, 5).free_power(&fpl, at(1, 3.0)), f64::INFINITY, "off-peak");
}

#[test]
fn a_daily_block_restarts_at_midnight() {
    let text = "title = \"a\"\nplace = \"b\"\ncustomers = \"any\"\ncurrency = \"USD\"\n\
        source = { document = \"c\", date = \"d\" }\n[electricity]\ndaylight_time = false\n\
        blocks = { per = \"day\", up_to = [10, 20] }\nenergy = [{ name = \"e\", price = [0.1, 0.2, 0.4] }]\n";
    let tariff = Tariff::parse("test", "test.toml", text).unwrap();
    let prices = Prices::new(tariff, YEAR, &[], None).unwrap();
    let (bill, _) = run(&prices, 1, 2, |at| if at.day == 1 { 1.0 } else { 0.5 });
    assert_cost(bill.total(&prices), 10.0 * 0.1 + 10.0 * 0.2 + 4.0 * 0.4 + 10.0 * 0.1 + 2.0 * 0.2);
}

#[test]
fn electricity_and_a_fuel_of_one_name_add_up() {
    let text = "title = \"a\"\nplace = \"b\"\ncustomers = \"any\"\ncurrency = \"USD\"\n\
        source = { document = \"c\", date = \"d\" }\nfuels = { gas = 0.5 }\n[electricity]\n\
        daylight_time = false\nenergy = [{ name = \"natural gas\", price = 0.25 }]\n";
    let tariff = Tariff::parse("test", "test.toml", text).unwrap();
    let prices = Prices::new(tariff, YEAR, &[], None).unwrap();
    let mut bill = Bill::new(1, 1);
    let mut energy = electricity(3.0);
    energy[Carrier::Gas as usize] = 2.0;
    bill.step(&prices, Moment { day: 1, hour: 0.0 }, &energy, 1.0);
    let parts = bill.parts(&prices);
    assert_eq!(parts.len(), 1, "{parts:?}");
    assert_cost(parts[0].quantity, 5.0);
    assert_cost(parts[0].cost, 3.0 * 0.25 + 2.0 * 0.5);
}

#[test]
fn a_copy_continues_as_the_original() {
    let prices = in_2017("hq-g");
    let (bill, _) = run(&prices, 15, 40, wavy);
    let (mut one, mut two) = (bill, bill);
    let at = Moment { day: 41, hour: 0.0 };
    assert_eq!(
        one.step(&prices, at, &electricity(9.0), STEP),
        two.step(&prices, at, &electricity(9.0), STEP)
    );
    assert_eq!(one, two);
}

#[test]
fn the_block_of_a_bill_gives_the_price_of_the_next_kilowatt_hour() {
    let prices = prices("hq-d", &[], None);
    let mut bill = Bill::new(1, 2);
    let at = |hour| Moment { day: 1, hour };
    assert_eq!(bill.block(&prices, at(0.0)), 0);
    bill.step(&prices, at(0.0), &electricity(79.0), 1.0);
    assert_eq!(bill.block(&prices, at(1.0)), 0);
    bill.step(&prices, at(1.0), &electricity(1.5), 1.0);
    assert_eq!(bill.block(&prices, at(2.0)), 1);
    assert_eq!(prices.electricity(at(2.0), bill.block(&prices, at(2.0))), 0.11142);
}

#[test]
fn daylight_time_moves_the_windows_on_its_two_days() {
    let prices = prices("teco-gst", &[], None);
    // Weekdays: summer windows 12-21 and winter windows 18-22 on the local clock.
    let first_on =
        |day| (0..24).find(|hour| prices.electricity(Moment { day, hour: f64::from(*hour) }, 0) > 0.1);
    assert_eq!(first_on(day(3, 10)), Some(6), "Friday before the second Sunday of March");
    assert_eq!(first_on(day(3, 13)), Some(5), "Monday after it");
    assert_eq!(first_on(day(11, 3)), Some(5), "Friday before the first Sunday of November");
    assert_eq!(first_on(day(11, 6)), Some(6), "Monday after it");
    assert_eq!(first_on(day(7, 12)), Some(11));
}

#[test]
fn an_event_is_in_the_preview_from_its_notice_on() {
    let event = Event { day: day(1, 20), from: 6.0, to: 10.0 };
    let prices = prices("hq-flex-d", &[event], None);
    let seen = |day, hour| {
        let mut ahead = [0.0; PREVIEW];
        prices.preview(Moment { day, hour }, 0, &mut ahead);
        ahead.iter().position(|price| *price == 0.46463)
    };
    assert_eq!(seen(day(1, 19), 14.99), None);
    assert_eq!(seen(day(1, 19), 15.0), Some(15));
    assert_eq!(seen(day(1, 20), 0.0), Some(6));
    assert_eq!(seen(day(1, 20), 9.0), Some(0));
    assert_eq!(seen(day(1, 20), 10.0), None);
}

#[test]
fn a_preview_at_the_end_of_the_year_shows_its_beginning() {
    let prices = prices("tou", &[], None);
    let mut ahead = [0.0; PREVIEW];
    prices.preview(Moment { day: 365, hour: 20.0 }, 0, &mut ahead);
    assert_eq!((ahead[0], ahead[2], ahead[18]), (0.06906, 0.05871, 0.1599));
}

#[test]
fn prices_need_the_temperatures_of_a_tariff_with_a_cold_price() {
    let new = |outdoor: Option<&[f64]>| Prices::new(Tariff::named("hq-dt").unwrap(), YEAR, &[], outdoor);
    let missing = new(None).err().unwrap().to_string();
    assert!(missing.contains("`hq-dt`") && missing.contains("outdoor temperatures"), "{missing}");
    let short = new(Some(&[0.0; 24])).err().unwrap().to_string();
    assert!(short.contains("got 24") && short.contains("8760"), "{short}");
}
