//! What a watch found, schema `terra-gap-watch/1`.

use serde_json::{Value, json};

use super::event::WatchEvent;
use super::{BaselineSpan, Watch};
use crate::verdict::Provenance;

/// The result of a finished watch and its events as JSON.
pub fn watch_json(watch: &Watch, events: &[WatchEvent], provenance: &Provenance) -> Value {
    let (windows, dropped) = watch.windows();
    let settings = watch.settings();
    let verdict = match (watch.refused(), events.is_empty()) {
        (Some(_), _) => "unidentifiable",
        (None, true) => "quiet",
        (None, false) => "gap",
    };
    json!({
        "schema": "terra-gap-watch/1",
        "verdict": verdict,
        "reason": watch.refused(),
        "false_alarms_per_log": settings.false_alarms,
        "spans_s": watch.spans_s(),
        "baseline_span": match &settings.baseline {
            BaselineSpan::Seconds(s) => json!({ "seconds": s }),
            BaselineSpan::Segment(name) => json!({ "segment": name }),
        },
        "baseline": watch.baseline(),
        "events": events,
        "data": { "windows": windows, "watched": watch.watched(), "dropped": dropped },
        "provenance": {
            "terra": env!("CARGO_PKG_VERSION"),
            "log_sha256": provenance.log_sha256,
            "rover_sha256": provenance.rover_sha256,
        },
    })
}
