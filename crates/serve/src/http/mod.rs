//! The server: BOPTEST's routes, in the classic form (`/advance`) and in the service's (`/advance/{testid}`).

mod sessions;

use std::future::IntoFuture;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{any, get, post, put};
use b2b_workers::WorkerOptions;
use serde_json::{Value, json};

use sessions::{CLASSIC, Sessions, no_test};

use crate::calls::{Answer, Arguments, Call, Refusal};
use crate::subject::Subject;
use crate::{Error, Result};

/// Maximum size of a body, bytes: enough for the names of thousands of points.
const LARGEST_BODY: usize = 1 << 20;
/// Interval of checks for a request to stop.
const LOOK: Duration = Duration::from_millis(50);
/// Time that requests in progress have left once the server stops.
const GRACE: Duration = Duration::from_secs(3);

/// Options of a server.
#[derive(Clone, Debug)]
pub struct Options {
    /// The worker processes of each test. `interrupted` also ends the server.
    pub workers: WorkerOptions,
    /// Maximum number of tests at a time.
    pub tests: usize,
}

/// State shared by all requests.
type Shared = State<Arc<Sessions>>;
/// The body of a request.
type Body = std::result::Result<Bytes, BytesRejection>;

/// Answers requests until [`WorkerOptions::interrupted`] returns true.
///
/// # Errors
/// [`Error::Io`] when the server cannot run on the socket.
pub fn serve(subject: Arc<Subject>, options: Options, listener: TcpListener) -> Result<()> {
    let io = |what| move |source| Error::Io { what, source };
    let interrupted = options.workers.interrupted;
    let name: Arc<str> = subject.name().into();
    let sessions = Arc::new(Sessions::new(subject, options.workers, options.tests));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
    let runtime = runtime.map_err(io("start the server"))?;
    let router = router(Arc::clone(&sessions), name);
    let served = runtime.block_on(async {
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let server = axum::serve(listener, router).with_graceful_shutdown(until(interrupted));
        tokio::select! {
            served = server.into_future() => served,
            () = async { until(interrupted).await; tokio::time::sleep(GRACE).await } => Ok(()),
        }
    });
    drop(runtime);
    sessions.stop_all();
    served.map_err(io("serve on this address"))
}

async fn until(interrupted: fn() -> bool) {
    while !interrupted() {
        tokio::time::sleep(LOOK).await;
    }
}

fn router(sessions: Arc<Sessions>, name: Arc<str>) -> Router {
    let test_cases = json!([{"testcaseid": &*name}]);
    Router::new()
        .route("/version", get(version))
        .route("/testcases", get(|| async move { json_response(200, test_cases.to_string()) }))
        .route(
            "/testcases/{name}/select",
            post(move |State(sessions): Shared, Path(asked): Path<String>| async move {
                select(&sessions, &name, &asked)
            }),
        )
        .route("/status/{testid}", get(status))
        .route("/stop", put(|State(sessions): Shared| async move { stop(&sessions, CLASSIC) }))
        .route(
            "/stop/{testid}",
            put(|State(sessions): Shared, Path(id): Path<String>| async move { stop(&sessions, &id) }),
        )
        .route("/{call}", any(classic))
        .route("/{call}/{testid}", any(of_test))
        .fallback(no_route)
        .method_not_allowed_fallback(no_route)
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        .with_state(sessions)
}

async fn version() -> Response {
    let version = json!({"version": concat!("building2building ", env!("CARGO_PKG_VERSION"))});
    envelope(&Answer::new("the version", version))
}

fn select(sessions: &Sessions, name: &str, asked: &str) -> Response {
    if asked != name {
        let message = format!("no test case `{asked}`; this server has `{name}`");
        return envelope(&Refusal::with_status(404, message).into());
    }
    match sessions.select() {
        Ok(id) => json_response(200, json!({"testid": id}).to_string()),
        Err(refusal) => envelope(&refusal.into()),
    }
}

async fn status(State(sessions): Shared, Path(id): Path<String>) -> Response {
    match sessions.has(&id) {
        true => json_response(200, Value::from("Running").to_string()),
        false => envelope(&no_test(&id).into()),
    }
}

fn stop(sessions: &Sessions, id: &str) -> Response {
    match sessions.stop(id) {
        true => "OK".into_response(),
        false => envelope(&no_test(id).into()),
    }
}

async fn classic(
    State(sessions): Shared,
    method: Method,
    Path(call): Path<String>,
    headers: HeaderMap,
    body: Body,
) -> Response {
    answer(&sessions, &method, &call, None, &headers, body).await
}

async fn of_test(
    State(sessions): Shared,
    method: Method,
    Path((call, id)): Path<(String, String)>,
    headers: HeaderMap,
    body: Body,
) -> Response {
    answer(&sessions, &method, &call, Some(&id), &headers, body).await
}

async fn no_route(method: Method, uri: Uri) -> Response {
    let message = format!("no call `{method} {}`; docs/serve.md lists the calls", uri.path());
    envelope(&Refusal::with_status(404, message).into())
}

/// Answers a call that concerns one test.
async fn answer(
    sessions: &Sessions,
    method: &Method,
    name: &str,
    id: Option<&str>,
    headers: &HeaderMap,
    body: Body,
) -> Response {
    let content_type = headers.get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    let request = Call::find(name, method).map_err(|methods| wrong_call(name, method, &methods));
    let request = request.and_then(|call| Ok((call, read(content_type, body)?)));
    match request {
        Ok((call, arguments)) => envelope(&sessions.ask(id, call, arguments).await),
        Err(refusal) => envelope(&refusal.into()),
    }
}

fn read(content_type: Option<&str>, body: Body) -> std::result::Result<Arguments, Refusal> {
    let body = body.map_err(|rejected| {
        let status = rejected.status().as_u16();
        let message = format!("{}; a body has at most {LARGEST_BODY} bytes", rejected.body_text());
        Refusal::with_status(status, message)
    })?;
    Arguments::read(content_type, &body)
}

fn wrong_call(name: &str, method: &Method, methods: &[&str]) -> Refusal {
    match methods {
        [] => {
            let known = Call::names().join(", ");
            Refusal::with_status(404, format!("no call `{name}`; expected one of {known}"))
        }
        methods => {
            let methods = methods.join(" or ");
            Refusal::with_status(405, format!("`{name}` does not answer {method}; use {methods}"))
        }
    }
}

fn envelope(answer: &Answer) -> Response {
    json_response(answer.status, answer.to_json())
}

fn json_response(status: u16, text: String) -> Response {
    let status = StatusCode::from_u16(status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    (status, [(header::CONTENT_TYPE, "application/json")], text).into_response()
}
