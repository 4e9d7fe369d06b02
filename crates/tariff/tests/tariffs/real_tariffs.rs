//! Bills of real tariffs, worked out by hand from the utility's figures.

use crate::common::{YEAR, assert_cost, day, electricity, part, prices, run};
use b2b_tariff::{Bill, Carrier, Event, Moment};

#[test]
fn ten_kilowatts_in_january_under_rate_m() {
    let prices = prices("hq-m", &[], None);
    let (bill, _) = run(&prices, 1, 31, |_| 10.0);
    // 7440 kWh, below the 210,000 of the first block; months of 30 days: 31/30 of 18.242 $/kW.
    assert_cost(part(&bill, &prices, "energy"), 7440.0 * 0.06292);
    assert_cost(part(&bill, &prices, "demand"), 10.0 * 18.242 * 31.0 / 30.0);
    assert_cost(bill.total(&prices), 468.1248 + 188.500_666_667);
}

#[test]
fn thousand_kilowatts_reach_the_second_block_of_rate_m_in_the_month() {
    let prices = prices("hq-m", &[], None);
    let (bill, _) = run(&prices, day(4, 1), day(4, 30), |_| 1000.0);
    // April has 30 days: 720,000 kWh, of which 210,000 in the first block.
    assert_cost(part(&bill, &prices, "energy"), 210_000.0 * 0.06292 + 510_000.0 * 0.04666);
    assert_cost(part(&bill, &prices, "demand"), 18_242.0);
}

#[test]
fn a_block_of_a_month_shrinks_with_the_days_of_the_episode() {
    let prices = prices("hq-m", &[], None);
    // 14 of 30 days: 98,000 kWh in the first block, and 14/30 of the peak's charge.
    let (bill, _) = run(&prices, day(4, 5), day(4, 18), |_| 1000.0);
    assert_cost(part(&bill, &prices, "energy"), 98_000.0 * 0.06292 + 238_000.0 * 0.04666);
    assert_cost(part(&bill, &prices, "demand"), 18_242.0 * 14.0 / 30.0);
}

#[test]
fn two_kilowatts_under_rate_d_pay_40_kilowatt_hours_a_day_at_the_first_price() {
    let prices = prices("hq-d", &[], None);
    let (bill, _) = run(&prices, day(6, 1), day(6, 10), |_| 2.0);
    // 48 kWh a day: 40 at 7.065 ¢ and 8 at 11.142 ¢, over the ten days together.
    assert_cost(bill.total(&prices), 10.0 * (40.0 * 0.07065 + 8.0 * 0.11142));
    // Absent for five days, then twice the power: the same kWh of the month in the first block.
    let (bill, _) = run(&prices, day(6, 1), day(6, 10), |at| if at.day > day(6, 5) { 4.0 } else { 0.0 });
    assert_cost(bill.total(&prices), 10.0 * (40.0 * 0.07065 + 8.0 * 0.11142));
}

#[test]
fn an_event_of_rate_flex_d_costs_46_463_cents_beside_the_block() {
    let event = Event { day: day(1, 10), from: 6.0, to: 10.0 };
    let prices = prices("hq-flex-d", &[event], None);
    let (bill, _) = run(&prices, day(1, 10), day(1, 10), |_| 5.0);
    // 20 kWh in the event, 100 outside: 40 in the block of one day.
    assert_cost(part(&bill, &prices, "event"), 20.0 * 0.46463);
    assert_cost(part(&bill, &prices, "winter"), 40.0 * 0.04886 + 60.0 * 0.09103);
    let events: Vec<_> =
        (0..24).filter(|hour| prices.is_event(Moment { day: day(1, 10), hour: f64::from(*hour) })).collect();
    assert_eq!(events, [6, 7, 8, 9]);
}

#[test]
fn rate_dt_costs_six_times_as_much_below_minus_12_degrees() {
    let outdoor: Vec<f64> = (0..8760).map(|hour| if hour < 12 { -12.1 } else { -12.0 }).collect();
    let prices = prices("hq-dt", &[], Some(&outdoor));
    let (bill, _) = run(&prices, 1, 1, |_| 10.0);
    assert_cost(part(&bill, &prices, "cold"), 120.0 * 0.30001);
    assert_cost(part(&bill, &prices, "mild"), 120.0 * 0.05131);
}

#[test]
fn a_july_day_under_gsdt_1_is_on_peak_from_noon_to_nine_in_daylight_time() {
    let prices = prices("fpl-gsdt-1", &[], None);
    // Wednesday, 12 July 2017; the building's clock is an hour behind: on-peak from 11 to 20 of standard time.
    let wednesday = day(7, 12);
    let (bill, _) = run(&prices, wednesday, wednesday, |_| 10.0);
    assert_cost(part(&bill, &prices, "on-peak"), 90.0 * (0.07742 + 0.00093));
    assert_cost(part(&bill, &prices, "off-peak"), 150.0 * (0.03465 + 0.00093));
    assert_cost(part(&bill, &prices, "on-peak demand"), 10.0 * (9.91 + 1.33) / 31.0);
    let at = |hour| prices.electricity(Moment { day: wednesday, hour }, 0);
    assert_eq!([10.99, 11.0, 19.99, 20.0].map(at), [0.03558, 0.07835, 0.07835, 0.03558]);
    // Independence Day, a Tuesday, and Saturdays are off-peak.
    for day in [day(7, 4), day(7, 8)] {
        assert_eq!(prices.electricity(Moment { day, hour: 15.0 }, 0), 0.03558);
    }
}

#[test]
fn a_january_day_under_gsdt_1_is_on_peak_in_the_morning_and_the_evening() {
    let prices = prices("fpl-gsdt-1", &[], None);
    let on = |hour: u32| prices.electricity(Moment { day: day(1, 11), hour: f64::from(hour) }, 0) > 0.07;
    let hours: Vec<_> = (0..24).filter(|hour| on(*hour)).collect();
    assert_eq!(hours, [6, 7, 8, 9, 18, 19, 20, 21]);
}

#[test]
fn a_night_peak_in_rochester_pays_the_excess_over_the_day_alone() {
    let prices = prices("rpu-medium-gs-tou", &[], None);
    // February: 60 kW from 10:00 to 22:00 on all days, 100 kW at night.
    let (bill, _) =
        run(&prices, day(2, 1), day(2, 28), |at| if (10.0..22.0).contains(&at.hour) { 60.0 } else { 100.0 });
    assert_cost(part(&bill, &prices, "on-peak demand"), 60.0 * 15.52);
    assert_cost(part(&bill, &prices, "off-peak excess"), 40.0 * 1.896);
    assert_cost(part(&bill, &prices, "energy"), 28.0 * 12.0 * 160.0 * 0.0571);
}

#[test]
fn a_summer_day_under_b_10_has_three_prices_and_a_march_day_a_fourth() {
    let prices = prices("pge-b10", &[], None);
    let (bill, _) = run(&prices, day(7, 9), day(7, 9), |_| 1.0);
    assert_cost(part(&bill, &prices, "on-peak"), 5.0 * 0.33947);
    assert_cost(part(&bill, &prices, "part-peak"), 4.0 * 0.27778);
    assert_cost(part(&bill, &prices, "off-peak"), 15.0 * 0.24522);
    assert_cost(part(&bill, &prices, "demand"), 20.5 / 31.0);
    let (bill, _) = run(&prices, day(3, 20), day(3, 20), |_| 1.0);
    assert_cost(part(&bill, &prices, "super off-peak"), 5.0 * 0.19139);
    assert_eq!(prices.electricity(Moment { day: day(2, 20), hour: 10.0 }, 0), 0.22773);
}

#[test]
fn winter_in_georgia_is_cheaper_after_1500_kilowatt_hours() {
    let prices = prices("georgia-tou-eo-11", &[], None);
    let (bill, _) = run(&prices, day(1, 1), day(1, 31), |_| 10.0);
    assert_cost(bill.total(&prices), 1500.0 * 0.122533 + 5940.0 * 0.064571);
    // A quarter-hour of 60 kW: 10 kW at each of the record's prices of demand.
    let is_peak = |at: Moment| at.day == 9 && (9.0..9.25).contains(&at.hour);
    let (bill, _) = run(&prices, day(1, 1), day(1, 31), |at| if is_peak(at) { 60.0 } else { 10.0 });
    let demand = [30, 40, 50].map(|above| part(&bill, &prices, &format!("demand above {above} kW")));
    assert_cost(demand.iter().sum(), 10.0 * (4.71 + 1.29 + 9.22 + 2.53 + 28.13 + 7.71));
}

#[test]
fn gas_and_the_carriers_that_a_tariff_does_not_price_have_the_defaults() {
    let flat = prices("flat", &[], None);
    let at = Moment { day: 1, hour: 0.0 };
    assert_eq!(flat.price(Carrier::Electricity, at), 0.094);
    assert_eq!(flat.price(Carrier::Gas, at), 0.024);
    assert_eq!(flat.price(Carrier::DistrictHeating, at), 0.024 / 0.8);
    assert_eq!(flat.price(Carrier::DistrictCooling, at), 0.094 / 5.0);
    assert_eq!(prices("hq-m", &[], None).price(Carrier::Gas, at), 0.0365);
    let mut bill = Bill::new(1, 1);
    let mut energy = electricity(1.0);
    energy[Carrier::Propane as usize] = 3.0;
    let cost = bill.step(&flat, at, &energy, 1.0);
    assert_cost(cost.energy, 0.094 + 3.0 * 0.10);
    assert_cost(part(&bill, &flat, "propane"), 0.30);
}

#[test]
fn events_of_the_coldest_winter_days_use_up_the_hours_of_the_tariff() {
    let flex = b2b_tariff::Tariff::named("hq-flex-d").unwrap();
    // Each day is colder than the one before until the end of March; Christmas and 1 July are colder still.
    let mut means = [5.0; 365];
    (0..90).for_each(|day| means[day] = -10.0 - day as f64 / 10.0);
    means[day(12, 25) as usize - 1] = -40.0;
    means[day(7, 1) as usize - 1] = -50.0;
    let events = flex.events(YEAR, &means);
    assert_eq!(events.len(), 30, "120 hours of 4");
    let days: Vec<_> = events.iter().step_by(2).map(|event| event.day).collect();
    assert_eq!(days, (76..=90).collect::<Vec<_>>(), "the 15 coldest days, without Christmas and July");
    assert!(events.chunks(2).all(|two| two[0].day == two[1].day && two[1].from - two[0].to == 6.0));
}

#[test]
fn events_of_rate_flex_m_are_on_weekdays_and_take_at_most_100_hours() {
    let flex = b2b_tariff::Tariff::named("hq-flex-m").unwrap();
    let events = flex.events(YEAR, &[-20.0; 365]);
    assert!(events.iter().all(|event| YEAR.weekday(event.day) < 5));
    let hours: f64 = events.iter().map(|event| event.to - event.from).sum();
    assert!((97.0..=100.0).contains(&hours), "{hours}");
    assert!(b2b_tariff::Tariff::named("hq-m").unwrap().events(YEAR, &[-20.0; 365]).is_empty());
}
