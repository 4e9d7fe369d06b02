//! The arguments in the body of a request: a JSON object or a form, as clients of BOPTEST send them.

use b2b_base::suggestion::nearest;
use serde_json::{Map, Value};

use super::answer::Refusal;

/// Maximum number of characters of a body, a name or a value that a message quotes.
const SHOWN: usize = 60;

/// The arguments of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Arguments(Map<String, Value>);

impl Arguments {
    /// Reads a body. An empty one has no arguments.
    ///
    /// # Errors
    /// The error for a body that is neither a JSON object nor a form.
    pub fn read(content_type: Option<&str>, body: &[u8]) -> Result<Self, Refusal> {
        let text = String::from_utf8_lossy(body);
        let is_form = content_type.is_some_and(|kind| kind.contains("application/x-www-form-urlencoded"));
        // `curl -d '{}'` calls any body a form.
        if is_form && !text.trim_start().starts_with('{') {
            return Ok(Self::of_form(body));
        }
        if text.trim().is_empty() {
            return Ok(Self::default());
        }
        let expected = "expected a JSON object such as {\"step\": 3600}";
        match serde_json::from_str(&with_quoted_numbers(&text)) {
            Ok(Value::Object(arguments)) => Ok(Self(arguments)),
            Ok(Value::Null) => Ok(Self::default()),
            Ok(_) => Err(Refusal::bad(format!("the body is `{}`; {expected}", shortened(&text)))),
            Err(why) => {
                Err(Refusal::bad(format!("the body `{}` is not JSON ({why}); {expected}", shortened(&text))))
            }
        }
    }

    /// A name that is given several times has a list of values.
    fn of_form(body: &[u8]) -> Self {
        let mut arguments = Map::new();
        for (name, value) in form_urlencoded::parse(body) {
            let value = Value::from(value.into_owned());
            match arguments.entry(name.into_owned()) {
                serde_json::map::Entry::Vacant(entry) => {
                    entry.insert(value);
                }
                serde_json::map::Entry::Occupied(mut entry) => match entry.get_mut() {
                    Value::Array(values) => values.push(value),
                    first => *first = Value::Array(vec![first.take(), value]),
                },
            }
        }
        Self(arguments)
    }

    /// Checks that every argument is known.
    ///
    /// # Errors
    /// A refusal with the nearest name.
    pub fn expect(&self, known: &[&str]) -> Result<(), Refusal> {
        match self.0.keys().find(|name| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => {
                let known = known.join(", ");
                Err(unknown("argument", name, known.split(", "), &format!("expected {known}")))
            }
        }
    }

    /// Returns every argument that is not null.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().filter(|(_, value)| !value.is_null()).map(|(name, value)| (name.as_str(), value))
    }

    /// Returns an argument that is not null.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name).filter(|value| !value.is_null())
    }

    /// Returns a finite number.
    ///
    /// # Errors
    /// A refusal if it is missing or not a finite number.
    pub fn number(&self, name: &str, remedy: &str) -> Result<f64, Refusal> {
        let value = self.any_number(name, remedy)?;
        match value.is_finite() {
            true => Ok(value),
            false => Err(Refusal::bad(format!("`{name}` is {value}; {remedy}"))),
        }
    }

    /// Returns a number that may be infinite.
    ///
    /// # Errors
    /// A refusal if it is missing or not a number.
    pub fn any_number(&self, name: &str, remedy: &str) -> Result<f64, Refusal> {
        let value = self.get(name).ok_or_else(|| Refusal::bad(format!("`{name}` is missing; {remedy}")))?;
        let number = to_number(value).filter(|number| !number.is_nan());
        number.ok_or_else(|| Refusal::bad(format!("`{name}` is `{}`; {remedy}", shown(value))))
    }

    /// Returns a text, if there is one.
    ///
    /// # Errors
    /// A refusal of a value that is not text.
    pub fn text(&self, name: &str, remedy: &str) -> Result<Option<&str>, Refusal> {
        match self.get(name) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(value) => Err(Refusal::bad(format!("`{name}` is `{}`; {remedy}", shown(value)))),
        }
    }

    /// Returns a list of names; one name counts as a list.
    ///
    /// # Errors
    /// A refusal if it is missing or not a list of texts.
    pub fn names(&self, name: &str) -> Result<Vec<String>, Refusal> {
        let refused = |what: String| Refusal::bad(format!("`{name}` {what}; expected a list of point names"));
        match self.get(name) {
            None => Err(refused("is missing".to_owned())),
            Some(Value::String(one)) => Ok(vec![one.clone()]),
            Some(Value::Array(values)) => {
                let texts = values.iter().map(|value| value.as_str().map(str::to_owned));
                let all: Option<Vec<_>> = texts.collect();
                all.ok_or_else(|| refused(format!("is `{}`", shown(&Value::from(values.clone())))))
            }
            Some(value) => Err(refused(format!("is `{}`", shown(value)))),
        }
    }
}

/// Returns a refusal of an unknown name, with the nearest known one.
pub(crate) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    remedy: &str,
) -> Refusal {
    let shown = shortened(name);
    Refusal::bad(match nearest(name, known).as_str() {
        "" => format!("unknown {what} `{shown}`; {remedy}"),
        near => format!("unknown {what} `{shown}`; did you mean {near}? {remedy}"),
    })
}

/// Returns a number, or the number that a text spells.
pub(crate) fn to_number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => number.as_f64(),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    }
}

/// Returns a value as it is quoted in a message.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => shortened(text),
        other => shortened(&other.to_string()),
    }
}

fn shortened(text: &str) -> String {
    let end = text.char_indices().nth(SHOWN).map(|(end, _)| end);
    end.map_or_else(|| text.to_owned(), |end| format!("{}…", &text[..end]))
}

/// Puts quotes around the words that Python's JSON uses for non-finite numbers.
fn with_quoted_numbers(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len());
    let (mut rest, mut in_text) = (text, false);
    while let Some(letter) = rest.chars().next() {
        let word = ["-Infinity", "Infinity", "NaN"].into_iter().find(|word| rest.starts_with(word));
        let part = match word {
            Some(word) if !in_text => {
                quoted.extend(["\"", word, "\""]);
                rest = &rest[word.len()..];
                continue;
            }
            _ if in_text && letter == '\\' => rest.chars().take(2).map(char::len_utf8).sum(),
            _ => letter.len_utf8(),
        };
        in_text ^= letter == '"';
        quoted.push_str(&rest[..part]);
        rest = &rest[part..];
    }
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(body: &str) -> Arguments {
        Arguments::read(None, body.as_bytes()).unwrap()
    }

    fn said(refused: Result<impl std::fmt::Debug, Refusal>) -> String {
        super::super::answer::Answer::from(refused.unwrap_err()).message
    }

    #[test]
    fn a_form_and_an_object_have_the_same_arguments() {
        let form = Arguments::read(
            Some("application/x-www-form-urlencoded"),
            b"point_names=a_y&point_names=b_y&start_time=0",
        );
        let (form, object) = (form.unwrap(), read(r#"{"point_names": ["a_y", "b_y"], "start_time": 0}"#));
        for arguments in [&form, &object] {
            assert_eq!(arguments.names("point_names").unwrap(), ["a_y", "b_y"]);
            assert_eq!(arguments.number("start_time", "").unwrap(), 0.0);
        }
        assert_eq!(read(" "), Arguments::default());
        let curl = Arguments::read(Some("application/x-www-form-urlencoded"), br#"{"step": 300}"#).unwrap();
        assert_eq!(curl.number("step", "").unwrap(), 300.0);
    }

    #[test]
    fn a_body_that_is_not_an_object_is_refused_with_its_text() {
        let refused = |body: &str| said(Arguments::read(None, body.as_bytes()));
        for body in ["{\"step\": ", "[1, 2]", "step=3", "\u{fffd}"] {
            assert!(refused(body).contains("expected a JSON object"), "{}", refused(body));
            assert!(refused(body).contains(body), "{}", refused(body));
        }
    }

    #[test]
    fn a_non_finite_number_is_refused_where_it_is_not_allowed() {
        let arguments =
            read(r#"{"step": NaN, "final_time": Infinity, "name": "NaN\" Infinity", "a": -Infinity}"#);
        assert!(
            said(arguments.number("step", "expected seconds")).contains("`step` is `NaN`; expected seconds")
        );
        assert_eq!(arguments.any_number("final_time", "").unwrap(), f64::INFINITY);
        assert!(said(arguments.number("a", "expected")).contains("`a` is -inf"));
        assert_eq!(arguments.text("name", "").unwrap(), Some("NaN\" Infinity"));
        assert!(said(arguments.number("horizon", "expected")).contains("`horizon` is missing"));
    }

    #[test]
    fn an_unknown_argument_gets_the_nearest_name() {
        let refused = said(read(r#"{"start_tme": 0}"#).expect(&["start_time", "warmup_period"]));
        assert!(refused.contains("`start_tme`; did you mean `start_time`?"), "{refused}");
    }
}
