//! Invalid requests are refused with the name, the value and the remedy, and the server keeps running.

use serde_json::json;

use crate::client::Client;
use crate::server::Office;

fn assert_refused(client: &Client, method: &str, call: &str, body: &str, words: &[&str]) {
    let envelope = client.envelope(method, call, body);
    let message = envelope["message"].as_str().unwrap();
    assert_eq!(envelope["status"], 400, "{method} {call} {body}: {envelope}");
    assert!(envelope["payload"].is_null());
    assert!(words.iter().all(|word| message.contains(word)), "{method} {call} {body}: {message}");
}

#[test]
fn invalid_requests_are_refused_and_the_server_keeps_running() {
    let office = Office::new();
    let mut server = office.serve(1);
    let client = server.client();
    for (method, call, body) in [
        ("POST", "advance", "{}"),
        ("GET", "kpi", ""),
        ("PUT", "results", r#"{"point_names": [], "start_time": 0, "final_time": 1}"#),
        ("PUT", "forecast", r#"{"point_names": ["TDryBul"], "horizon": 0, "interval": 300}"#),
    ] {
        assert_refused(&client, method, call, body, &["no run has begun", "PUT /initialize"]);
    }
    for (call, body, words) in [
        ("initialize", "{\"start_time\": 0", &["not JSON", "start_time"][..]),
        ("initialize", "[]", &["[]", "expected a JSON object"]),
        ("initialize", r#"{"start_time": NaN, "warmup_period": 0}"#, &["start_time", "NaN", "31535"]),
        ("initialize", r#"{"start_time": -1, "warmup_period": 0}"#, &["start_time", "-1", "0 to"]),
        ("initialize", r#"{"start_time": 4e7, "warmup_period": 0}"#, &["start_time", "40000000"]),
        ("initialize", r#"{"start_time": "noon", "warmup_period": 0}"#, &["start_time", "noon"]),
        ("initialize", r#"{"start_time": 0}"#, &["warmup_period", "missing"]),
        ("initialize", r#"{"start_time": 0, "warmup_period": -3600}"#, &["warmup_period", "-3600"]),
        ("initialize", r#"{"start": 0, "warmup_period": 0}"#, &["`start`", "start_time"]),
        ("step", r#"{"step": -300}"#, &["step", "-300", "multiple of the control step of 300 s"]),
        ("step", r#"{"step": 100}"#, &["step", "100", "multiple"]),
        ("step", r#"{"step": 172800}"#, &["step", "172800", "86400"]),
        ("scenario", r#"{"time_period": "winter"}"#, &["time_period", "winter", "peak_heat_day"]),
    ] {
        assert_refused(&client, "PUT", call, body, words);
    }
    client.put("initialize", json!({"start_time": 0, "warmup_period": 0}));
    let inputs = client.get("inputs");
    let input = inputs.as_object().unwrap().keys().find(|name| name.ends_with("_u")).unwrap();
    let activation = input.replace("_u", "_activate");
    for (body, words) in [
        (format!(r#"{{"{input}": NaN, "{activation}": 1}}"#), [input.as_str(), "NaN", "expected a number"]),
        (format!(r#"{{"{input}": "warm"}}"#), [input, "warm", "expected a number"]),
        (format!(r#"{{"{activation}": 2}}"#), [&activation, "`2`", "1 or 0"]),
        (format!(r#"{{"{activation}": 1}}"#), [&activation, input, "missing"]),
        (r#"{"valve_u": 1}"#.to_owned(), ["unknown input", "valve_u", "GET /inputs"]),
    ] {
        assert_refused(&client, "POST", "advance", &body, &words);
    }
    let advanced = client.envelope("POST", "advance", &format!(r#"{{"{input}": 1}}"#));
    let said = advanced["message"].as_str().unwrap();
    assert!(said.contains(&format!("`{input}` has no effect unless `{activation}` is 1")), "{said}");
    for (call, body, words) in [
        (
            "forecast",
            r#"{"point_names": ["TDryBulb"], "horizon": 0, "interval": 1}"#,
            &["TDryBulb", "`TDryBul`"][..],
        ),
        (
            "forecast",
            r#"{"point_names": ["TDryBul"], "horizon": 1e12, "interval": 60}"#,
            &["horizon", "31536000"],
        ),
        (
            "forecast",
            r#"{"point_names": ["TDryBul"], "horizon": 1e7, "interval": 0.01}"#,
            &["interval", "longer"],
        ),
        (
            "forecast",
            r#"{"point_names": ["TDryBul"], "horizon": 10, "interval": 0}"#,
            &["interval", "more than 0"],
        ),
        ("forecast", r#"{"point_names": 3, "horizon": 10, "interval": 1}"#, &["point_names", "`3`", "list"]),
        (
            "results",
            r#"{"point_names": ["x_y"], "start_time": 0, "final_time": 1}"#,
            &["x_y", "GET /measurements"],
        ),
        (
            "results",
            r#"{"point_names": ["time"], "start_time": 5, "final_time": 1}"#,
            &["start_time", "final_time"],
        ),
    ] {
        assert_refused(&client, "PUT", call, body, words);
    }
    let huge = format!(r#"{{"point_names": ["{}"]}}"#, "x".repeat(2 << 20));
    assert_eq!(client.envelope("PUT", "results", &huge)["status"], 413);
    assert_eq!(client.envelope("GET", "submit", "")["status"], 501);
    assert_eq!(client.envelope("GET", "advance", "")["status"], 405);
    assert_eq!(client.envelope("GET", "advanc", "")["status"], 404);
    assert_eq!(client.send("POST", "/testcases/Castle/select", "").status, 404);
    assert_eq!(client.send("POST", "/testcases/OfficeSmall/select", "").status, 503, "one test at a time");
    assert_eq!(client.send("PUT", "/advance/a/b/c", "").status, 404);

    let beyond = client.envelope("POST", "advance", &format!(r#"{{"{input}": 1e9, "{activation}": true}}"#));
    assert!(beyond["message"].as_str().unwrap().contains("is used"), "{beyond}");
    assert_eq!(beyond["payload"]["time"], 7200.0, "the second step, after the one without activation");
    assert_eq!(client.send("PUT", "/stop", "").status, 200, "the test without an id");
    assert_eq!(client.send("POST", "/testcases/OfficeSmall/select", "").status, 200, "its slot is free");
    server.stop();
}
