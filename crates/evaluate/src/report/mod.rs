//! The pages of evaluations and comparisons, made with [`b2b_page`], and charts for all reports, written as plotly's
//! JSON.

mod chart;
mod comparison;
mod deviation_chart;
mod evaluation;
mod evaluation_charts;
mod histogram;
mod hourly_chart;
mod reward_chart;
mod series;
mod trade_off;

pub use chart::{
    Chart, color, has_several_tasks, horizontal_line, label_logarithmic, make_logarithmic, mean_diamond,
    range,
};
pub use comparison::{Compared, write as write_comparison};
pub use deviation_chart::{StepDeviations, step_deviations};
pub use evaluation::write;
pub use reward_chart::step_rewards;
pub use series::{Series, labels, rms_deviations};
pub use trade_off::trade_offs;
