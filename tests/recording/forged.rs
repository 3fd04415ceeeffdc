//! Malicious files: refused quickly and in little memory.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};
use gelpad::session::{Reader, TOPICS};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};

use crate::{config_setup, said};

/// Address space of a process that reads a forged file, kB: gelpad, its table, and little more.
const MOST_MEMORY_KB: u64 = 600_000;
/// Processor time of such a process, s.
const MOST_SECONDS: u64 = 20;

/// The beginning of a valid recording.
fn begun() -> Result<Writer<Cursor<Vec<u8>>>> {
    let options = WriteOptions::new()
        .profile("gelpad")
        .compression(Some(Compression::Zstd))
        .chunk_size(None);
    let mut file = options.create(Cursor::new(Vec::new()))?;
    file.write_metadata(&Metadata {
        name: "gelpad".to_owned(),
        metadata: BTreeMap::from([("version".to_owned(), "1".to_owned())]),
    })?;
    let setup = config_setup();
    let profile = serde_json::to_vec(&setup.profile)?;
    let parts: [(&str, &[u8]); 4] = [
        ("pad.toml", setup.pad.as_bytes()),
        ("profile.json", &profile),
        ("sensing.bin", &setup.sensing),
        (
            "responses.bin",
            setup.responses.as_deref().unwrap_or_default(),
        ),
    ];
    for (name, bytes) in parts {
        file.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: String::new(),
            data: Cow::Borrowed(bytes),
        })?;
    }
    for topic in TOPICS {
        file.add_channel(0, topic, "json", &BTreeMap::new())?;
    }
    Ok(file)
}

fn say(file: &mut Writer<Cursor<Vec<u8>>>, topic: &str, payload: &[u8]) -> Result<()> {
    let channel = TOPICS
        .iter()
        .position(|known| *known == topic)
        .expect("known");
    let header = MessageHeader {
        // Channels are numbered from 1.
        channel_id: channel as u16 + 1,
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    Ok(file.write_to_known_channel(&header, payload)?)
}

fn finished(mut file: Writer<Cursor<Vec<u8>>>) -> Result<Vec<u8>> {
    file.finish()?;
    Ok(file.into_inner().into_inner())
}

/// A valid beginning, then a record with this op code, claimed length and body.
fn claiming(code: u8, length: u64, body: &[u8]) -> Result<Vec<u8>> {
    let mut file = begun()?;
    say(&mut file, "/tick", br#"{"t_ns":0}"#)?;
    file.flush()?;
    let mut bytes = file.into_inner().into_inner();
    bytes.push(code);
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(body);
    Ok(bytes)
}

/// Two megabytes of records of a kind, each with a length of half of what follows, and before each of them three short ones, so that
/// it looks like the next record of a file.
fn nested_claims(kind: u8) -> Vec<u8> {
    const LENGTH: usize = 2 << 20;
    let mut bytes = vec![0];
    while bytes.len() < LENGTH {
        for _ in 0..3 {
            bytes.extend_from_slice(&[3, 1, 0, 0, 0, 0, 0, 0, 0, 0]);
        }
        bytes.push(kind);
        let claimed = (LENGTH.saturating_sub(bytes.len()) / 2) as u64;
        bytes.extend_from_slice(&claimed.to_le_bytes());
    }
    bytes
}

/// The body of a chunk that claims these sizes.
fn chunk(claimed: u64, packed: &[u8]) -> Vec<u8> {
    let mut body = chunk_head(claimed, "zstd", packed.len() as u64);
    body.extend_from_slice(packed);
    body
}

fn chunk_head(claimed: u64, compression: &str, packed: u64) -> Vec<u8> {
    let mut head = vec![0; 16];
    head.extend_from_slice(&claimed.to_le_bytes());
    head.extend_from_slice(&0u32.to_le_bytes());
    head.extend_from_slice(&(compression.len() as u32).to_le_bytes());
    head.extend_from_slice(compression.as_bytes());
    head.extend_from_slice(&packed.to_le_bytes());
    head
}

pub fn refused() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut bomb = begun()?;
    say(&mut bomb, "/profile", &vec![b' '; 200_000_000])?;
    let mut bombs = begun()?;
    for _ in 0..40 {
        say(&mut bombs, "/profile", &vec![b' '; 7_000_000])?;
        bombs.flush()?;
    }
    let mut years = begun()?;
    say(&mut years, "/tick", br#"{"t_ns":0}"#)?;
    say(&mut years, "/tick", br#"{"t_ns":900000000000000000}"#)?;
    let mut nowhere = begun()?;
    say(
        &mut nowhere,
        "/matrix",
        br#"{"attachment":"sensing-1.bin"}"#,
    )?;
    let mut deep = begun()?;
    say(&mut deep, "/profile", &vec![b'['; 1_000_000])?;
    let mut circle = begun()?;
    let extends_itself = r#"{"t_ns":0,"chain":[{"name":"a","toml":"schema = 1\nname = \"a\"\nextends = \"a\"\n"}],"user":null}"#;
    say(&mut circle, "/profile", extends_itself.as_bytes())?;
    let nested = chunk(60, &[]);
    // A record of 40 bytes in a chunk of 12.
    let mut beyond = chunk_head(12, "", 12);
    beyond.push(5);
    beyond.extend_from_slice(&40u64.to_le_bytes());
    beyond.extend_from_slice(&[0; 40]);
    let files = [
        ("bomb", finished(bomb)?),
        ("many_bombs", finished(bombs)?),
        ("years_between_ticks", finished(years)?),
        ("a_matrix_that_is_not_there", finished(nowhere)?),
        ("deep_json", finished(deep)?),
        ("a_profile_that_extends_itself", finished(circle)?),
        ("longest_record", claiming(5, u64::MAX, b"")?),
        ("long_record", claiming(9, 120_000_000, b"x")?),
        (
            "chunk_of_a_terabyte",
            claiming(6, 60, &chunk(1 << 40, &[0; 20]))?,
        ),
        ("chunk_of_nothing", claiming(6, 40, &chunk(8 << 20, &[]))?),
        (
            "chunk_in_a_chunk",
            claiming(6, nested.len() as u64 + 40, &chunk(100, &nested))?,
        ),
        (
            "a_record_longer_than_its_chunk",
            claiming(6, beyond.len() as u64, &beyond)?,
        ),
        ("attachment_of_nothing", claiming(9, 5, b"12345")?),
        (
            "records_of_no_kind_in_each_other",
            claiming(3, 1, &nested_claims(0x50))?,
        ),
        ("messages_in_each_other", claiming(3, 1, &nested_claims(5))?),
    ];
    for (name, bytes) in files {
        let path = folder.path().join(format!("{name}.mcap"));
        fs::write(&path, &bytes)?;
        refuses(&path)?;
    }
    Ok(())
}

/// The file is refused with an error, within the limits; `recover` ends, too.
fn refuses(path: &Path) -> Result<()> {
    // The reader may accept what another part of the program refuses.
    let run = |what: &str| -> Result<_> {
        let limits = format!(
            "ulimit -v {MOST_MEMORY_KB} -t {MOST_SECONDS}; exec '{}' {what}",
            env!("CARGO_BIN_EXE_gelpad")
        );
        Ok(Command::new("bash").args(["-c", &limits]).output()?)
    };
    let file = path.display();
    let output = run(&format!("replay '{file}'"))?;
    let is_told = output.status.code() == Some(1) && said(&output).contains("error: ")
        || output.status.code() == Some(3);
    ensure!(is_told, "{file}: {:?}\n{}", output.status, said(&output));
    let output = run(&format!("recover '{file}' -o '{file}.saved'"))?;
    ensure!(
        matches!(output.status.code(), Some(0 | 1 | 3)),
        "{file}: {:?}\n{}",
        output.status,
        said(&output)
    );
    // The library's reader ends, too.
    if let Ok((mut reader, _)) = Reader::open(Cursor::new(fs::read(path)?)) {
        while let Ok(Some(_)) = reader.next() {}
    }
    Ok(())
}
