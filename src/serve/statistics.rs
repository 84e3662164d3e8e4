//! The numbers of `/metrics` as messages: the statistics query, and telemetry about once a second.

use super::app::App;
use super::metrics::ViewCounts;
use crate::passes::relight::tables::Status;
use crate::wire::control;
use crate::wire::control::out::{
    DelayStatistics, EventMessage, Outbound, Statistics, TableStatistics, Telemetry, ViewStatistics,
};
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;
use tokio::time::MissedTickBehavior;

/// Between two telemetry messages.
const TELEMETRY_EVERY: Duration = Duration::from_secs(1);

/// Answers the statistics query.
pub(super) fn statistics(app: &App, seq: Option<u64>) -> Statistics {
    let metrics = &app.metrics;
    Statistics {
        seq,
        uptime_s: metrics.now_us() as f64 * 1e-6,
        executor: metrics.executor(),
        clients: metrics.clients.load(Relaxed).try_into().unwrap_or(u32::MAX),
        host: app.roles.host_id(),
        messages: metrics.messages.load(Relaxed),
        refused: metrics.refusals.load(Relaxed) + metrics.unsaid.load(Relaxed),
        faults: metrics.faults.load(Relaxed),
        views: view_statistics(app),
        subscriptions: app.hub.clients().iter().flat_map(|client| client.statistics()).collect(),
    }
}

/// Tells every client that subscribed to anything how its frames are doing, and everybody of new faults, until the server
/// stops.
pub(super) async fn telemetry(app: std::sync::Arc<App>) {
    let mut tick = tokio::time::interval(TELEMETRY_EVERY);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut told = 0;
    let mut baking = false;
    loop {
        tokio::select! {
            () = app.stop.cancelled() => return,
            _ = tick.tick() => {}
        }
        let faults = app.metrics.faults.load(Relaxed);
        if faults > told {
            let what = format!("{} faults of the server in the last second; its log names them", faults - told);
            app.hub.broadcast(&Outbound::Event(EventMessage::Fault { what }));
            told = faults;
        }
        let views = view_statistics(&app);
        let tables = app.metrics.tables();
        let status = tables.as_ref().map(|tables| tables.status()).unwrap_or_default();
        tables.iter().flat_map(|tables| tables.complaints()).for_each(|what| tracing::warn!("cache of tables: {what}"));
        if status.baking != baking {
            baking = status.baking;
            let what = if baking { "baking tables of virtual lights" } else { "tables of virtual lights are baked" };
            tracing::info!(lights = status.lights, of = status.of, "{what}");
        }
        for client in app.hub.clients() {
            let subscriptions = client.statistics();
            if subscriptions.is_empty() {
                continue;
            }
            let simulation_time_s = app.metrics.simulation_time_s();
            let message =
                Telemetry { simulation_time_s, views: views.clone(), subscriptions, tables: told_of(&status) };
            if !client.queue.push_event(control::encode(&Outbound::Telemetry(message))) {
                app.metrics.events_dropped.fetch_add(1, Relaxed);
            }
        }
    }
}

/// What clients are told of tables; nothing while there are none.
fn told_of(status: &Status) -> Option<TableStatistics> {
    let Status { lights, of, baking, read, .. } = *status;
    (of > 0).then_some(TableStatistics { lights, of, baking, read })
}

fn view_statistics(app: &App) -> Vec<ViewStatistics> {
    let now_us = app.metrics.now_us();
    let one = |(view, counts): (String, ViewCounts)| ViewStatistics {
        view,
        frames: counts.drawn + counts.repeated,
        repeated: counts.repeated,
        rate_hz: counts.rate_hz(now_us),
        delay: (counts.delay.kept() > 0).then(|| DelayStatistics {
            median_ms: counts.delay.quantile_s(0.5) * 1e3,
            p99_ms: counts.delay.quantile_s(0.99) * 1e3,
            frames: counts.delay.kept() as u32,
        }),
    };
    app.metrics.views().into_iter().map(one).collect()
}
