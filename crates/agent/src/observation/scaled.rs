//! The environment's observation, scaled by its bounds.

use b2b_env::RoleValue;
use b2b_workers::{Arranged, RowSlot};

use super::feature::{Feature, Source};

/// Returns one feature for each slot.
pub(super) fn features(arranged: &Arranged) -> Vec<Feature> {
    let slots = arranged.slots().into_iter().zip(arranged.values());
    slots.map(|(slot, value)| Feature::new(slot.name.clone(), scaled(&slot, value))).collect()
}

fn scaled(slot: &RowSlot, value: RoleValue) -> Source {
    let &RowSlot { low, high, .. } = slot;
    match value {
        RoleValue::Slot(slot) => Source::Bounded { slot, low, high },
        RoleValue::Constant(value) => Source::Constant(2.0 * (value - low) / (high - low) - 1.0),
    }
}
