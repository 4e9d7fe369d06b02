use super::*;

/// Shares of homes with everyone out, by hour: McKenna, Krawczynski and Thomson 2015 (UK Time Use Survey 2000), for one
/// to five residents, from the starting states and transition probabilities of the four-state model.
const WEEKDAY: [[f64; 24]; 5] = [
    [
        0.08, 0.07, 0.06, 0.06, 0.06, 0.06, 0.09, 0.16, 0.30, 0.45, 0.55, 0.58, 0.56, 0.55, 0.59, 0.57, 0.48,
        0.38, 0.29, 0.27, 0.26, 0.23, 0.17, 0.11,
    ],
    [
        0.02, 0.02, 0.01, 0.01, 0.01, 0.02, 0.03, 0.08, 0.24, 0.38, 0.48, 0.52, 0.48, 0.47, 0.48, 0.46, 0.37,
        0.24, 0.16, 0.15, 0.14, 0.11, 0.07, 0.04,
    ],
    [
        0.01, 0.01, 0.01, 0.00, 0.00, 0.00, 0.01, 0.03, 0.22, 0.37, 0.44, 0.48, 0.46, 0.44, 0.48, 0.43, 0.25,
        0.15, 0.10, 0.10, 0.09, 0.06, 0.03, 0.02,
    ],
    [
        0.00, 0.00, 0.00, 0.00, 0.00, 0.00, 0.00, 0.01, 0.21, 0.37, 0.44, 0.51, 0.51, 0.48, 0.46, 0.41, 0.20,
        0.12, 0.08, 0.07, 0.06, 0.03, 0.01, 0.01,
    ],
    [
        0.01, 0.01, 0.01, 0.01, 0.00, 0.00, 0.00, 0.00, 0.14, 0.28, 0.30, 0.35, 0.40, 0.37, 0.43, 0.33, 0.12,
        0.03, 0.03, 0.08, 0.08, 0.04, 0.04, 0.01,
    ],
];
const WEEKEND: [[f64; 24]; 5] = [
    [
        0.11, 0.09, 0.07, 0.07, 0.07, 0.07, 0.08, 0.11, 0.17, 0.27, 0.38, 0.43, 0.45, 0.46, 0.48, 0.47, 0.42,
        0.34, 0.30, 0.30, 0.29, 0.27, 0.21, 0.16,
    ],
    [
        0.06, 0.04, 0.03, 0.02, 0.02, 0.02, 0.03, 0.04, 0.07, 0.14, 0.25, 0.32, 0.32, 0.34, 0.37, 0.36, 0.30,
        0.24, 0.21, 0.20, 0.20, 0.18, 0.15, 0.10,
    ],
    [
        0.03, 0.02, 0.01, 0.01, 0.01, 0.01, 0.02, 0.02, 0.03, 0.08, 0.16, 0.23, 0.26, 0.25, 0.26, 0.26, 0.22,
        0.16, 0.13, 0.12, 0.12, 0.10, 0.07, 0.05,
    ],
    [
        0.01, 0.01, 0.01, 0.00, 0.00, 0.00, 0.01, 0.01, 0.03, 0.06, 0.12, 0.18, 0.18, 0.22, 0.24, 0.24, 0.17,
        0.14, 0.10, 0.12, 0.13, 0.11, 0.07, 0.02,
    ],
    [
        0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.02, 0.06, 0.10, 0.12, 0.14, 0.19, 0.17, 0.11,
        0.08, 0.04, 0.06, 0.06, 0.05, 0.03, 0.02,
    ],
];
/// Households drawn of each size.
const COUNT: u64 = 2000;

/// Share of drawn households with everyone out, by hour, over some days.
fn empty(people: u32, days: std::ops::Range<usize>) -> [f64; 24] {
    let mut shares = [0.0; 24];
    for household in (0..COUNT).map(|seed| Household::draw(people, seed)) {
        for day in days.clone() {
            for (quarter, count) in household.at_home(day).iter().enumerate() {
                shares[quarter / 4] += f64::from(*count == 0);
            }
        }
    }
    shares.map(|sum| sum / (4 * days.len()) as f64 / COUNT as f64)
}

#[test]
fn the_shares_of_empty_homes_by_hour_are_near_the_published_ones() {
    for (what, days, published) in [("weekday", 0..5, WEEKDAY), ("weekend", 5..7, WEEKEND)] {
        for (people, published) in (1..).zip(published) {
            let drawn = empty(people, days.clone());
            let differences = drawn.iter().zip(published).map(|(drawn, published)| (drawn - published).abs());
            let largest = differences.clone().fold(0.0, f64::max);
            let mean = differences.sum::<f64>() / 24.0;
            println!("{what} {people}: mean {mean:.3}, largest {largest:.3}; {drawn:.2?}");
            assert!(mean < 0.08 && largest < 0.18, "{what} {people}: {mean} {largest} {drawn:.2?}");
        }
    }
}

#[test]
fn people_are_counted_whole_and_everyone_is_at_home_at_night() {
    for people in 0..=12 {
        for household in (0..50).map(|seed| Household::draw(people, seed)) {
            assert_eq!(household.people(), people);
            for day in 0..DAYS {
                let counts = household.at_home(day);
                assert_eq!(counts.len(), QUARTERS);
                assert!(counts.iter().all(|count| *count <= people));
                assert!(counts[..20].iter().all(|count| *count == people), "day {day}: {counts:?}");
            }
        }
    }
}

#[test]
fn the_number_of_people_and_the_seed_determine_the_week() {
    assert_eq!(Household::draw(3, 7), Household::draw(3, 7));
    assert_ne!(Household::draw(3, 7), Household::draw(3, 8));
}

#[test]
fn most_households_are_out_at_some_hour_of_the_week_and_some_stay_home_all_day() {
    let is_out = |household: &Household, day| household.at_home(day).contains(&0);
    for (people, minimum) in [(1, 0.99), (2, 0.95), (3, 0.9), (4, 0.9), (5, 0.85)] {
        let households = (0..COUNT).map(|seed| Household::draw(people, seed));
        let out = households.filter(|household| (0..DAYS).any(|day| is_out(household, day))).count();
        let share = out as f64 / COUNT as f64;
        println!("{people}: {share}");
        assert!(share > minimum, "{people}: {share}");
    }
    // McKenna, Krawczynski and Thomson 2015: 14 % of the homes of two are occupied for all of a weekday.
    let stays = (0..COUNT).map(|seed| u32::from(!is_out(&Household::draw(2, seed), 1))).sum::<u32>();
    let share = f64::from(stays) / COUNT as f64;
    println!("{share}");
    assert!((0.08..0.25).contains(&share), "{share}");
}

#[test]
fn the_default_household_of_two_is_out_on_working_days() {
    let household = crate::house::House::default().draw_household();
    let hours = |day: usize| household.at_home(day).iter().filter(|count| **count == 0).count() as f64 / 4.0;
    assert!((0..5).all(|day| hours(day) > 4.0), "{:?}", [0, 1, 2, 3, 4].map(hours));
}
