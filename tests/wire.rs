//! gelpad's own packets in C: `wire/gelpad_wire.h` gives the same bytes as the library.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use gelpad::pad::{Channel, Pair};
use gelpad::source::wire::gelpad::{Values, encode, encode_listing, encode_part};
use gelpad::source::wire::{Decoded, Dialect, gelpad::Gelpad};

/// Reads type, sequence, time and count, then the values, and writes the packet of the frame and those of its two halves;
/// repeats until the input ends. Last come the names of six readings.
const PROGRAM: &str = r#"
#include <stdio.h>
#include "gelpad_wire.h"

int main(void) {
    static uint8_t packet[GELPAD_PACKET_MAX(GELPAD_MOST_VALUES)];
    static float volts[GELPAD_MOST_VALUES];
    static int32_t counts[GELPAD_MOST_VALUES];
    uint32_t head[4];
    while (fread(head, 4, 4, stdin) == 4) {
        size_t length;
        uint16_t count = (uint16_t)head[3];
        if (head[0] == GELPAD_KIND_F32) {
            if (fread(volts, 4, count, stdin) != count) return 1;
            length = gelpad_encode_f32(packet, GELPAD_PACKET_MAX(count), head[1], head[2], volts, count);
        } else {
            if (fread(counts, 4, count, stdin) != count) return 1;
            length = gelpad_encode_i32(packet, GELPAD_PACKET_MAX(count), head[1], head[2], counts, count);
        }
        if (length == 0 || gelpad_encode_f32(packet + sizeof packet, 0, 0, 0, volts, 1) != 0) return 2;
        fwrite(packet, 1, length, stdout);
        /* The same frame in two parts. */
        for (int part = 0; part < 2; part++) {
            uint16_t first = part ? count / 2 : 0;
            uint16_t some = part ? count - first : count / 2;
            if (head[0] == GELPAD_KIND_F32)
                length = gelpad_encode_part_f32(packet, sizeof packet, head[1], head[2], volts, count, first, some);
            else
                length = gelpad_encode_part_i32(packet, sizeof packet, head[1], head[2], counts, count, first, some);
            if (length == 0) return 3;
            fwrite(packet, 1, length, stdout);
        }
    }
    static const uint8_t readings[6][4] = {{0, 1, 2, 3}, {0, 1, 3, 4}, {4, 5, 0, 1}, {4, 5, 2, 3}, {2, 3, 0, 1}, {2, 3, 5, 255}};
    fwrite(packet, 1, gelpad_encode_readings(packet, sizeof packet, readings, 6), stdout);
    return 0;
}
"#;

/// A pseudo-random sequence that is the same on every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }
}

#[test]
fn the_c_header_writes_the_same_bits_as_the_library() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("main.c");
    let program = folder.path().join("encode");
    std::fs::write(&source, PROGRAM).expect("written");
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("wire");
    let compiled = Command::new(std::env::var("CC").unwrap_or("cc".to_owned()))
        .args([
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            "-O1",
            "-fsanitize=undefined",
            "-fsanitize-undefined-trap-on-error",
            "-I",
        ])
        .arg(include)
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .output()
        .expect("a C compiler, as gelpad needs one to build");
    let said = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{said}");

    let mut numbers = Numbers(7);
    let (mut input, mut expected, mut sent) = (Vec::new(), Vec::new(), Vec::new());
    // Around the length of a block (254), with and without many zeros; the largest count; 208 is a pad's.
    for count in (5..130).chain([208, 208, 208, 1024, 2048]) {
        for kind in [Values::F32, Values::I32] {
            let [sequence, time_us] = [0; 2].map(|_| numbers.next() as u32);
            let values: Vec<f32> = (0..count)
                .map(|_| match numbers.next() % 3 {
                    0 => 0.0,
                    1 => numbers.next() as f32 * 1e-7 - 50.0,
                    _ => (numbers.next() % 1000) as f32,
                })
                .map(|value| {
                    if kind == Values::I32 {
                        value.round()
                    } else {
                        value
                    }
                })
                .collect();
            for word in [1 + u32::from(kind == Values::I32), sequence, time_us, count] {
                input.extend_from_slice(&word.to_le_bytes());
            }
            for value in &values {
                input.extend_from_slice(&match kind {
                    Values::F32 => value.to_le_bytes(),
                    Values::I32 => (*value as i32).to_le_bytes(),
                });
            }
            expected.extend(encode(kind, sequence, time_us, &values));
            for part in [0..values.len() / 2, values.len() / 2..values.len()] {
                expected.extend(encode_part(kind, sequence, time_us, &values, part));
            }
            sent.extend([values.clone(), values]);
        }
    }
    let named = [
        [0, 1, 2, 3],
        [0, 1, 3, 4],
        [4, 5, 0, 1],
        [4, 5, 2, 3],
        [2, 3, 0, 1],
        [2, 3, 5, 255],
    ];
    let named = named.map(|[a, b, p, q]| Channel {
        drive: Pair(a, b),
        measure: Pair(p, q),
    });
    expected.extend(encode_listing(&named));
    let mut running = Command::new(&program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("started");
    let mut stdin = running.stdin.take().expect("piped");
    let feeder = std::thread::Builder::new()
        .spawn(move || stdin.write_all(&input).expect("taken"))
        .expect("a thread");
    let output = running.wait_with_output().expect("ended");
    feeder.join().expect("fed");
    assert!(output.status.success(), "{:?}", output.status);
    assert!(output.stdout == expected, "the C header writes other bytes");

    let mut decoded = Vec::new();
    Gelpad::default().feed(0, &output.stdout, &mut decoded);
    assert_eq!(decoded.len(), sent.len());
    for (one, values) in decoded.iter().zip(&sent) {
        let Decoded::Frame(frame) = one else {
            panic!("{one:?}")
        };
        assert_eq!(&frame.values, values);
    }
}
