//! Tests of the reference.

use super::*;

const FRAME_NS: u64 = 10_000_000;
const CHANNELS: usize = 7;

/// Readings of 1 V with a deterministic noise of about 60 dB and a drift per second.
fn reading(frame: u64, drift_per_s: f64) -> [f32; CHANNELS] {
    std::array::from_fn(|channel| {
        let wobble = (frame as f64 * 1.7 + channel as f64 * 2.9).sin() * 1.4e-3;
        (1.0 + wobble + drift_per_s * frame as f64 * 0.01) as f32
    })
}

fn played(frames: u64, drift_per_s: f64, touched: impl Fn(u64) -> bool) -> Reference {
    let mut reference = Reference::new(CHANNELS);
    for frame in 0..frames {
        let (t_ns, volts) = (frame * FRAME_NS, reading(frame, drift_per_s));
        if !reference.is_ready() {
            reference.add_first_frame(t_ns, &volts);
            continue;
        }
        reference.advance(t_ns);
        if touched(frame) {
            reference.skip_frame();
        } else {
            reference.update(&volts, &[0.0; CHANNELS]);
        }
    }
    reference
}

#[test]
fn it_starts_as_the_mean_of_the_first_frames() {
    let mut reference = Reference::new(1);
    for frame in 0..REFERENCE_FRAMES {
        assert!(!reference.is_ready());
        reference.add_first_frame(0, &[frame as f32]);
    }
    assert!(reference.is_ready());
    assert!((reference.volts()[0] - 4.5).abs() < 1e-12);
}

#[test]
fn the_level_is_taken_again_from_few_frames_of_which_one_is_odd() {
    let mut reference = played(100, 0.0, |_| false);
    let noise = reference.change_noise();
    let lifted = [1.3, 1.1, 1.1].map(|factor| {
        let volts = reading(0, 0.0).iter().map(|volt| volt * factor).collect();
        (2_000_000_000, volts)
    });
    reference.retake_level(&lifted);
    assert!(reference.is_ready());
    for (volt, expected) in reference.volts().iter().zip(&lifted[1].1) {
        assert!((volt / f64::from(*expected) - 1.0).abs() < 1e-6);
    }
    let doubt = reference.doubt();
    assert!((1.1..1.5).contains(&doubt), "of three frames: {doubt}");
    assert!((0.9..1.5).contains(&(reference.change_noise() / noise)));
}

#[test]
fn a_wire_that_came_loose_is_no_noise_that_is_known() {
    let reference = played(100, 0.0, |_| false);
    let frame = |index: u64| (index * FRAME_NS, reading(index, 0.0).to_vec());
    assert!(reference.differ_by_noise_only(&[frame(101), frame(102)]));
    assert!(
        !reference.differ_by_noise_only(&[frame(101)]),
        "one tells nothing"
    );
    let mut loose = frame(102);
    loose.1[1] *= 1.5;
    assert!(!reference.differ_by_noise_only(&[frame(101), loose.clone()]));
    // Of a channel that is muted, nothing is expected, and its level stays.
    let mut muted = reference.clone();
    muted.mute(1, true, 0.0);
    let frames = [frame(101), loose.clone(), loose];
    assert!(muted.differ_by_noise_only(&frames));
    muted.retake_level(&frames);
    assert!((muted.volts()[1] - reference.volts()[1]).abs() < 1e-12);
}

#[test]
fn drift_is_predicted_during_a_hold() {
    // 2 % per minute; measured for ten seconds, held for five.
    let drift = 0.02 / 60.0;
    let reference = played(1500, drift, |frame| frame >= 1000);
    let truth = 1.0 + drift * 15.0;
    for volt in reference.volts() {
        assert!((volt - truth).abs() < 4e-4, "{volt} for {truth}");
    }
    assert!(reference.doubt() > 1.05, "a hold leaves uncertainty");
}

#[test]
fn a_hold_does_not_move_a_steady_reference() {
    let reference = played(3000, 0.0, |frame| frame >= 1000);
    for volt in reference.volts() {
        assert!((volt - 1.0).abs() < 2e-3, "{volt}");
    }
}

#[test]
fn a_loose_channel_is_muted() {
    let mut reference = Reference::new(CHANNELS);
    for frame in 0..REFERENCE_FRAMES as u64 {
        let mut volts = reading(frame, 0.0);
        volts[2] = if frame % 2 == 0 { 1.0 } else { -0.4 };
        reference.add_first_frame(frame * FRAME_NS, &volts);
    }
    assert_eq!(reference.muted_channels(), [2]);
    let mut changes = [9.0; CHANNELS];
    reference.relative_changes(&[2.0; CHANNELS], &mut changes);
    assert_eq!(changes[2], 0.0);
    assert!(changes[3] > 0.9);
}

#[test]
fn a_dead_channel_has_no_change() {
    let mut reference = Reference::new(1);
    for _ in 0..REFERENCE_FRAMES {
        reference.add_first_frame(0, &[0.0]);
    }
    let mut changes = [9.0];
    reference.relative_changes(&[0.5], &mut changes);
    assert_eq!(changes, [0.0]);
}

/// Readings of a converter of steps of 1 mV: all but the last channel waver by some steps, the last always reads three.
fn rounded(frame: u64) -> [f32; CHANNELS] {
    let mut volts = reading(frame, 0.0).map(|volt| (volt * 1000.0).round() / 1000.0);
    volts[CHANNELS - 1] = 0.003;
    volts
}

#[test]
fn a_channel_that_always_reads_the_same_few_steps_does_not_pull_the_others() {
    let mut reference = Reference::new(CHANNELS);
    reference.set_step(Some(1e-3));
    for frame in 0..100 {
        let (t_ns, volts) = (frame * FRAME_NS, rounded(frame));
        if reference.is_ready() {
            reference.advance(t_ns);
            reference.update(&volts, &[0.0; CHANNELS]);
        } else {
            reference.add_first_frame(t_ns, &volts);
        }
    }
    for frame in 100..200 {
        // A deformation is found that lowers its level: it reads on what it read.
        let mut change = [0.0; CHANNELS];
        change[CHANNELS - 1] = -2e-3;
        reference.shift(&change, &mut [0.0; CHANNELS]);
        reference.advance(frame * FRAME_NS);
        reference.update(&rounded(frame), &[0.0; CHANNELS]);
    }
    for (channel, volt) in reference.volts()[..CHANNELS - 1].iter().enumerate() {
        assert!((volt - 1.0).abs() < 1e-3, "channel {channel}: {volt}");
    }
}
