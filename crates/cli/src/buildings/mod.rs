//! Commands about buildings and models.

pub(crate) mod check;
pub(crate) mod edit;
pub(crate) mod facts;
pub(crate) mod list;
pub(crate) mod show;
