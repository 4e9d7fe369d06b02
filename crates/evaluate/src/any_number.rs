//! Numbers in JSON that may be infinite or NaN, which are written as text: `"inf"`, `"-inf"` or `"NaN"`.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Text(String),
}

/// Writes a number, which may be infinite or NaN.
///
/// # Errors
/// Errors of the serializer.
pub fn serialize<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    match number.is_finite() {
        true => number.serialize(serializer),
        false => number.to_string().serialize(serializer),
    }
}

/// Reads a number that [`serialize`] wrote.
///
/// # Errors
/// Errors of the deserializer.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    match Written::deserialize(deserializer)? {
        Written::Number(number) => Ok(number),
        Written::Text(text) => text.parse().map_err(serde::de::Error::custom),
    }
}

#[cfg(test)]
mod tests {
    use crate::statistics::Interval;

    #[test]
    fn infinite_numbers_are_read_as_they_were_written() {
        let interval = Interval { value: 1.5, low: f64::NEG_INFINITY, high: f64::INFINITY };
        let text = serde_json::to_string(&interval).unwrap();
        assert_eq!(text, r#"{"value":1.5,"low":"-inf","high":"inf"}"#);
        assert_eq!(serde_json::from_str::<Interval>(&text).unwrap(), interval);
    }
}
