//! Damage to inputs: bytes, texts and JSON documents.

use rand::{Rng, RngExt};
use serde_json::{Value, json};

/// Numbers that often cause errors.
const NUMBERS: [&str; 16] = [
    "0",
    "-0.0",
    "-1",
    "1",
    "0.1",
    "1e-300",
    "-1e-9",
    "1e19",
    "1e300",
    "1e999",
    "-273.16",
    "9007199254740993",
    "18446744073709551616",
    "NaN",
    "Infinity",
    "99999",
];
const TEXTS: [&str; 10] =
    ["", " ", "\u{0}", "\u{feff}", "autosize", "../../etc/passwd", "ünïcödé ☃", "null", "%s%n", "-"];

/// Returns a damaged copy; in a JSON document, mostly values are damaged rather than bytes.
pub fn mutate(bytes: &[u8], random: &mut impl Rng) -> Vec<u8> {
    let document = serde_json::from_slice::<Value>(bytes).ok().filter(|_| random.random_bool(0.8));
    let mut damaged = match document {
        Some(mut document) => {
            for _ in 0..random.random_range(1..4) {
                mutate_value(&mut document, random);
            }
            document.to_string().into_bytes()
        }
        None => bytes.to_vec(),
    };
    if damaged == bytes || random.random_bool(0.1) {
        for _ in 0..random.random_range(1..4) {
            mutate_bytes(&mut damaged, random);
        }
    }
    damaged
}

/// Damages one random value of a document.
pub fn mutate_value(document: &mut Value, random: &mut impl Rng) {
    let mut paths = Vec::new();
    collect(document, &mut String::new(), &mut paths);
    let path: String = pick(&paths, random).clone();
    match random.random_range(0..10) {
        0 => remove(document, &path),
        1 => {
            let other = document.pointer(pick(&paths, random).as_str()).cloned().unwrap_or_default();
            set(document, &path, other);
        }
        2 => set(document, &path, json!("x".repeat(random.random_range(1..100_000)))),
        3 => set(document, &path, pick(&[json!([]), json!({}), json!([[]]), Value::Null], random).clone()),
        4 => set(document, &path, json!(*pick(&TEXTS, random))),
        _ => {
            let value = document.pointer(&path).and_then(Value::as_f64);
            let scaled = value.map(|value| value * 10_f64.powi(random.random_range(-6..7)));
            let number = pick(&NUMBERS, random).parse::<f64>().unwrap_or(-1.0);
            let flipped = value.map(|value| -value);
            let value = *pick(&[scaled, Some(number), Some(number), flipped], random);
            set(document, &path, json!(value));
        }
    }
}

fn mutate_bytes(bytes: &mut Vec<u8>, random: &mut impl Rng) {
    let length = bytes.len();
    let start = random.random_range(0..=length);
    let end = (start + random.random_range(1..64)).min(length);
    match random.random_range(0..7) {
        0 => bytes.truncate(start),
        1 => drop(bytes.drain(start..end)),
        2 => drop(bytes.splice(start..start, pick(&TEXTS, random).bytes())),
        3 => {
            let copied = bytes[start..end].to_vec();
            drop(bytes.splice(start..start, copied));
        }
        4 => replace_number(bytes, start, random),
        _ => bytes[start..end].iter_mut().take(random.random_range(1..4)).for_each(|byte| {
            *byte ^= 1 << random.random_range(0..8);
        }),
    }
}

/// Replaces the first number at or after a position.
fn replace_number(bytes: &mut Vec<u8>, from: usize, random: &mut impl Rng) {
    let is_number = |byte: &u8| byte.is_ascii_digit() || b".-+eE".contains(byte);
    let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit).map(|found| from + found) else {
        return;
    };
    let length = bytes[start..].iter().take_while(|byte| is_number(byte)).count();
    drop(bytes.splice(start..start + length, pick(&NUMBERS, random).bytes()));
}

/// Collects the JSON pointers of a value and of all values in it.
fn collect(value: &Value, path: &mut String, paths: &mut Vec<String>) {
    paths.push(path.clone());
    let mut below = |name: &str, value: &Value| {
        let length = path.len();
        path.push('/');
        path.push_str(&name.replace('~', "~0").replace('/', "~1"));
        collect(value, path, paths);
        path.truncate(length);
    };
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| below(name, value)),
        Value::Array(items) => items.iter().enumerate().for_each(|(i, value)| below(&i.to_string(), value)),
        _ => {}
    }
}

fn set(document: &mut Value, path: &str, value: Value) {
    if let Some(place) = document.pointer_mut(path) {
        *place = value;
    }
}

fn remove(document: &mut Value, path: &str) {
    let Some((parent, name)) = path.rsplit_once('/') else { return };
    let name = name.replace("~1", "/").replace("~0", "~");
    match document.pointer_mut(parent) {
        Some(Value::Object(fields)) => drop(fields.remove(&name)),
        Some(Value::Array(items)) => drop(name.parse().map(|index: usize| items.remove(index))),
        _ => {}
    }
}

/// Returns a random value.
pub fn pick<'a, T>(values: &'a [T], random: &mut impl Rng) -> &'a T {
    &values[random.random_range(0..values.len())]
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn damage_differs_from_the_input_and_repeats_with_the_seed() {
        let damage =
            |seed| mutate(br#"{"a": [1, {"b": "c"}], "d": 2.5}"#, &mut ChaCha8Rng::seed_from_u64(seed));
        let all: std::collections::BTreeSet<_> = (0..200).map(damage).collect();
        assert!(all.len() > 100, "{}", all.len());
        assert_eq!(damage(7), damage(7));
    }

    #[test]
    fn every_value_of_a_document_is_reached() {
        let mut paths = Vec::new();
        collect(&json!({"a/b": [1, {"~": 2}]}), &mut String::new(), &mut paths);
        assert_eq!(paths, ["", "/a~1b", "/a~1b/0", "/a~1b/1", "/a~1b/1/~0"]);
        let mut document = json!({"a/b": [1, {"~": 2}]});
        remove(&mut document, "/a~1b/1/~0");
        assert_eq!(document, json!({"a/b": [1, {}]}));
    }
}
