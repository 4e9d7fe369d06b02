//! Answers to requests.

use serde_json::{Value, json};

/// An answer in BOPTEST's envelope.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Answer {
    /// HTTP status.
    pub status: u16,
    /// What was done, or the error.
    pub message: String,
    /// Result; null with an error.
    pub payload: Value,
}

/// The reason why a request has no result.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    status: u16,
    message: String,
}

impl Answer {
    /// Returns the answer to a request that succeeded.
    pub fn new(message: impl Into<String>, payload: Value) -> Self {
        Self { status: 200, message: message.into(), payload }
    }

    /// Returns the text of the envelope.
    pub fn to_json(&self) -> String {
        json!({"status": self.status, "message": self.message, "payload": self.payload}).to_string()
    }
}

impl Refusal {
    /// Returns a refusal of bad input.
    pub fn bad(message: impl Into<String>) -> Self {
        Self::with_status(400, message)
    }

    /// Returns a refusal with a status.
    pub fn with_status(status: u16, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }
}

impl From<Refusal> for Answer {
    fn from(Refusal { status, message }: Refusal) -> Self {
        Self { status, message, payload: Value::Null }
    }
}
