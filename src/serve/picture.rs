//! `/frame.png` and `/frame.jpg`: one freshly drawn picture of a view, for scripts and people.

use super::app::{App, Parameters};
use super::hub::Picture;
use super::world_task::Request;
use crate::encode::{self, Format};
use axum::extract::{Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Duration;

/// A request does not wait longer for its picture.
const PATIENCE: Duration = Duration::from_secs(30);

pub(super) async fn png(app: State<Arc<App>>, parameters: Parameters) -> Response {
    answer(app, parameters, Format::Png).await
}

pub(super) async fn jpeg(app: State<Arc<App>>, parameters: Parameters) -> Response {
    let quality = app.settings.jpeg_quality;
    answer(app, parameters, Format::Jpeg { quality }).await
}

async fn answer(State(app): State<Arc<App>>, Query(parameters): Parameters, format: Format) -> Response {
    match picture(&app, parameters.get("view").map(String::as_str), format).await {
        Ok(Picture { frame, bytes }) => {
            let headers = [
                (header::CONTENT_TYPE.as_str(), format.media_type().to_owned()),
                (header::CACHE_CONTROL.as_str(), "no-store".to_owned()),
                ("stormdeck-view", frame.view.clone()),
                ("stormdeck-frame", frame.number.to_string()),
                ("stormdeck-simulation-time", frame.simulation_time_s.to_string()),
            ];
            (headers, bytes).into_response()
        }
        Err((status, why)) => (status, format!("{why}\n")).into_response(),
    }
}

async fn picture(app: &App, view: Option<&str>, format: Format) -> Result<Picture, (StatusCode, String)> {
    let state = app
        .ask_world(|reply| Request::State { reply })
        .await
        .map_err(|refused| (StatusCode::SERVICE_UNAVAILABLE, refused.why))?;
    let views = &state.snapshot.views;
    let found = match view {
        None => views.first(),
        Some(name) => views.iter().find(|candidate| candidate.name == name),
    };
    let Some(found) = found else {
        let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
        return Err((StatusCode::NOT_FOUND, format!("there is no such view; there are: {}", names.join(", "))));
    };
    // In lockstep only steps draw, one frame for each view: the picture of the last step is the present one.
    if state.lockstep
        && let Some(frame) = app.hub.newest(&found.name)
    {
        let encoding = tokio::task::spawn_blocking(move || {
            let bytes = encode::encode(&frame, format).map_err(|error| error.to_string())?;
            Ok(Picture { frame, bytes: bytes.into() })
        });
        let result = encoding.await.unwrap_or_else(|error| Err(error.to_string()));
        return result.map_err(|why| (StatusCode::INTERNAL_SERVER_ERROR, why));
    }
    let waiting = app.hub.ask(&found.name, format);
    tokio::select! {
        () = app.stop.cancelled() => Err((StatusCode::SERVICE_UNAVAILABLE, "the server stops".to_owned())),
        answer = tokio::time::timeout(PATIENCE, waiting) => match answer {
            Ok(Ok(result)) => result.map_err(|why| (StatusCode::INTERNAL_SERVER_ERROR, why)),
            Ok(Err(_)) => Err((StatusCode::SERVICE_UNAVAILABLE, "the picture was lost: see the server's log".to_owned())),
            Err(_) => Err((
                StatusCode::GATEWAY_TIMEOUT,
                format!("no frame of this view was drawn within {} s", PATIENCE.as_secs()),
            )),
        },
    }
}
