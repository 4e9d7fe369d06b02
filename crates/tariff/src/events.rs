//! Events: hours of a winter with a high price, announced the day before.

use b2b_base::calendar::Calendar;
use toml::Spanned;

use crate::calendar::Date;
use crate::energy::{Class, EnergyTable};
use crate::error::Fault;
use crate::file::EventsFile;
use crate::span::{Dates, Days, Hours};

/// When a utility may call events and what they cost.
#[derive(Clone, Debug)]
pub(crate) struct EventRule {
    /// Class of the price.
    pub(crate) class: u16,
    dates: Dates,
    days: Days,
    hours: Vec<Hours>,
    most_per_day: u32,
    most_hours: f64,
    /// Hour of the day before, on the local clock, from which an event is known.
    pub(crate) notice: f64,
    never: Vec<Date>,
}

/// An event of a year, on the local clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Day of the year, from 1.
    pub day: u32,
    /// First hour, 0 to 24.
    pub from: f64,
    /// Hour at which it ends.
    pub to: f64,
}

impl EventRule {
    /// Returns the rule of a file and adds its price.
    ///
    /// # Errors
    /// A fault at the table.
    pub(crate) fn of(file: &Spanned<EventsFile>, energy: &mut EnergyTable) -> Result<Self, Fault> {
        let place = file.span().start;
        let file = file.get_ref();
        let notice = file.notice.filter(|notice| (0.0..=24.0).contains(notice)).ok_or_else(|| {
            Fault::at(
                place,
                "[electricity.events] needs `notice`: the hour of the day before by which events are announced, 0 to 24, such as \
                 `notice = 15`",
            )
        })?;
        let given = file.most_hours;
        if file.hours.is_empty() || file.most_per_day == 0 || !given.is_finite() || given <= 0.0 {
            let why = "[electricity.events] allows no event; expected `hours`, `most_per_day` and `most_hours` above 0";
            return Err(Fault::at(place, why));
        }
        let mut hours = file.hours.clone();
        hours.sort_by_key(|hours| hours.from);
        if hours.iter().all(|hours| hours.length() > given)
            || hours.windows(2).any(|two| two[1].from < two[0].to)
        {
            let why = "[electricity.events] needs `hours` that do not overlap, one of them no longer than `most_hours`";
            return Err(Fault::at(place, why));
        }
        Ok(Self {
            class: energy.add("event", Class::flat(file.price, false), place)?,
            dates: file.dates.clone(),
            days: file.days,
            hours: file.hours.clone(),
            most_per_day: file.most_per_day,
            most_hours: file.most_hours,
            notice,
            never: file.never.clone(),
        })
    }

    /// Chooses the events of a year: see [`Tariff::events`](crate::Tariff::events). `is_weekend` takes a day of the
    /// year.
    pub(crate) fn choose(
        &self,
        calendar: Calendar,
        daily_means: &[f64],
        is_weekend: impl Fn(u32) -> bool,
    ) -> Vec<Event> {
        let mut candidates = Vec::new();
        for (day, mean) in (1..).zip(daily_means) {
            if self.permits(calendar.day_of_common_year(day), is_weekend(day)) {
                candidates.extend(self.hours.iter().map(|hours| (mean, day, *hours)));
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(b.0).then(a.1.cmp(&b.1)).then(a.2.from.cmp(&b.2.from)));
        let (mut chosen, mut used) = (Vec::<Event>::new(), 0.0);
        for (_, day, hours) in candidates {
            let same_day = chosen.iter().filter(|event| event.day == day).count();
            if same_day < self.most_per_day as usize && used + hours.length() <= self.most_hours {
                used += hours.length();
                let [from, to] = [hours.from, hours.to].map(|quarter| f64::from(quarter) / 4.0);
                chosen.push(Event { day, from, to });
            }
        }
        chosen.sort_by(|a, b| a.day.cmp(&b.day).then(a.from.total_cmp(&b.from)));
        chosen
    }

    fn permits(&self, day: u32, weekend: bool) -> bool {
        let excluded = self.never.iter().any(|never| never.day == day);
        self.dates.contain(day) && self.days.contain(weekend) && !excluded
    }
}
