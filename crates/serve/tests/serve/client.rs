//! A plain HTTP client.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};

use serde_json::{Value, json};

/// Sends requests, each on its own connection.
pub struct Client {
    address: SocketAddr,
    /// Added to the path of every call: `/TESTID`, or nothing.
    test: String,
}

/// Status and body of an answer.
pub struct Response {
    pub status: u16,
    pub body: String,
}

impl Client {
    pub fn new(address: SocketAddr) -> Self {
        Self { address, test: String::new() }
    }

    /// Begins a test and returns a client of it.
    pub fn select(&self, name: &str) -> Self {
        let response = self.send("POST", &format!("/testcases/{name}/select"), "{}");
        let id: Value = serde_json::from_str(&response.body).unwrap();
        Self { address: self.address, test: format!("/{}", id["testid"].as_str().unwrap()) }
    }

    pub fn test(&self) -> &str {
        &self.test
    }

    /// Sends a request and returns the payload of a success.
    pub fn call(&self, method: &str, call: &str, arguments: Value) -> Value {
        let envelope = self.envelope(method, call, &arguments.to_string());
        assert_eq!(envelope["status"], 200, "{method} {call} {arguments}: {envelope}");
        envelope["payload"].clone()
    }

    pub fn get(&self, call: &str) -> Value {
        self.call("GET", call, json!({}))
    }

    pub fn put(&self, call: &str, arguments: Value) -> Value {
        self.call("PUT", call, arguments)
    }

    pub fn advance(&self, inputs: Value) -> Value {
        self.call("POST", "advance", inputs)
    }

    /// Sends a request and returns its envelope, with the status of the response.
    pub fn envelope(&self, method: &str, call: &str, body: &str) -> Value {
        let response = self.send(method, &format!("/{call}{}", self.test), body);
        let envelope: Value = serde_json::from_str(&response.body).expect(&response.body);
        assert_eq!(envelope["status"], response.status, "{envelope}");
        envelope
    }

    pub fn send(&self, method: &str, path: &str, body: &str) -> Response {
        let mut stream = TcpStream::connect(self.address).unwrap();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n",
            self.address,
            body.len()
        );
        // The server may refuse a body before all of it was sent.
        let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(body.as_bytes()));
        let mut text = Vec::new();
        let _ = stream.read_to_end(&mut text);
        let text = String::from_utf8_lossy(&text).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").expect(&text);
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Response { status, body: body.to_owned() }
    }
}
