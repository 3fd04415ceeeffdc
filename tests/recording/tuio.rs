//! Touches by UDP, read by a listener of our own and by python-tuio.

use std::collections::BTreeMap;
use std::net::UdpSocket;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use rosc::{OscPacket, OscType, decoder};

use crate::{gelpad_ends, printed, said};

const TOUCHES: &str =
    "t:400 down 1 80 50\nt:700 down 2 20 57\nt:1000 up 1\nt:1300 up 2\nt:1500 end\n";
/// The pad's size, mm.
const PAD_MM: f32 = 100.0;
/// Largest error of a touch, as a share of the pad.
const OFF: f32 = 0.02;

pub fn by_udp() -> Result<()> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("touches.txt"), TOUCHES)?;
    let socket = UdpSocket::bind("127.0.0.1:0")?;
    socket.set_read_timeout(Some(Duration::from_millis(200)))?;
    let address = socket.local_addr()?.to_string();
    gelpad_ends(
        folder.path(),
        &[
            "play",
            "--source",
            "simulated:touches.txt",
            "--output",
            "trace",
            "--headless",
            "--tuio",
            &address,
        ],
        0,
    )?;
    // All packets wait in the socket: less than a second of them.
    let mut places: BTreeMap<i32, Vec<[f32; 2]>> = BTreeMap::new();
    let mut alive_last = None;
    let mut frame_last = 0;
    let mut buffer = [0; 4096];
    while let Ok(count) = socket.recv(&mut buffer) {
        let (_, packet) = decoder::decode_udp(&buffer[..count])?;
        for args in messages(packet)? {
            match args.as_slice() {
                [OscType::String(word), ids @ ..] if word == "alive" => {
                    alive_last = Some(ids.len())
                }
                [
                    OscType::String(word),
                    OscType::Int(id),
                    OscType::Float(x),
                    OscType::Float(y),
                    ..,
                ] if word == "set" => {
                    places.entry(*id).or_default().push([*x, *y]);
                }
                [OscType::String(word), OscType::Int(frame)] if word == "fseq" => {
                    ensure!(*frame > frame_last, "frames count up");
                    frame_last = *frame;
                }
                _ => {}
            }
        }
    }
    ensure!(alive_last == Some(0), "at the end no touch is alive");
    check(
        &places
            .into_values()
            .filter_map(|seen| seen.last().copied())
            .collect::<Vec<_>>(),
    )
}

fn messages(packet: OscPacket) -> Result<Vec<Vec<OscType>>> {
    match packet {
        OscPacket::Message(message) => {
            ensure!(message.addr == "/tuio/2Dcur", "{}", message.addr);
            Ok(vec![message.args])
        }
        OscPacket::Bundle(bundle) => {
            let all: Result<Vec<_>> = bundle.content.into_iter().map(messages).collect();
            Ok(all?.concat())
        }
    }
}

/// Two touches, each where its finger was: from the left, and from the top.
fn check(places: &[[f32; 2]]) -> Result<()> {
    let expected =
        [[80.0, 50.0], [20.0, 57.0]].map(|[x, y]: [f32; 2]| [x / PAD_MM, 1.0 - y / PAD_MM]);
    let near = |a: &[f32; 2], b: &[f32; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < OFF;
    ensure!(
        places.len() == 2
            && expected
                .iter()
                .all(|place| places.iter().any(|seen| near(place, seen))),
        "saw {places:?}, expected {expected:?}"
    );
    Ok(())
}

pub fn python() -> Result<()> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("touches.txt"), TOUCHES)?;
    // A free port, closed just before the client opens it.
    let port = UdpSocket::bind("127.0.0.1:0")?.local_addr()?.port();
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/recording/tuio_client.py"
    );
    let mut client: Command = crate::python();
    client
        .arg(script)
        .arg(port.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut client = client.spawn()?;
    let address = format!("127.0.0.1:{port}");
    // Packets before the client listens are lost; the first frames have no touches.
    std::thread::sleep(Duration::from_secs(1));
    let played = gelpad_ends(
        folder.path(),
        &[
            "play",
            "--source",
            "simulated:touches.txt",
            "--output",
            "trace",
            "--headless",
            "--tuio",
            &address,
        ],
        0,
    );
    // It ends when its standard input is closed.
    drop(client.stdin.take());
    let output = client.wait_with_output()?;
    played?;
    ensure!(output.status.success(), "{}", said(&output));
    let text = printed(&output);
    let places: Vec<[f32; 2]> = text
        .lines()
        .filter_map(|line| line.strip_prefix("cursor "))
        .map(|line| {
            let mut words = line.split(' ').skip(1).map(str::parse::<f32>);
            let mut next = || words.next().context("a number")?.context("a number");
            Ok([next()?, next()?])
        })
        .collect::<Result<_>>()?;
    check(&places)
}
