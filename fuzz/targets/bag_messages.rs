//! Message definitions and messages inside a whole bag: the text of the definition, a line `---`, then messages, each behind
//! a byte that is its length.
#![no_main]

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use terra_data::{Rover, import_mcap};
use terra_fuzz::{Scratch, check_import, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static BAG: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("bag.mcap"));
static MAP: LazyLock<Scratch> = LazyLock::new(|| {
    let map = Scratch::new("topics.toml");
    map.with(include_bytes!("../fixed/speed.toml"));
    map
});

/// Where the definition ends.
const END: &[u8] = b"\n---\n";

fn bag(data: &[u8]) -> mcap::McapResult<Vec<u8>> {
    let cut = data.windows(END.len()).position(|w| w == END);
    let (definition, body) = match cut {
        Some(at) => (&data[..at], &data[at + END.len()..]),
        None => (data, &[][..]),
    };
    let mut bytes = Cursor::new(vec![]);
    let mut writer = WriteOptions::new().compression(None).create(&mut bytes)?;
    let schema = writer.add_schema("my/msg/M", "ros2msg", definition)?;
    let channel_id = writer.add_channel(schema, "/speed", "cdr", &BTreeMap::new())?;
    let mut rest = body;
    let mut log_time = 0;
    while let [length, after @ ..] = rest {
        let (message, behind) = after.split_at((*length as usize).min(after.len()));
        rest = behind;
        log_time += 10_000_000;
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, message)?;
    }
    writer.finish()?;
    drop(writer);
    Ok(bytes.into_inner())
}

fuzz_target!(|data: &[u8]| run(|| {
    let Ok(bytes) = bag(data) else { return };
    check_import(&import_mcap(BAG.with(&bytes), MAP.path()), &ROVERS[0]);
}));
