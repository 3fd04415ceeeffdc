//! Reads a recording, or frames as CSV, into a timeline.

use std::path::Path;
use std::sync::Arc;

use super::pads::{choose_method, load_pad, no_image, sensing};
use super::profiles::load_profile;
use super::recording::{is_recording, open_recording};
use super::services::PlayRequest;
use super::timeline::RecordingTimeline;
use super::{AppError, Progress, calibration};
use crate::engine::{Engine, Input};
use crate::source::{SourceReading, open_file};
use crate::tape::RecordedItem;

/// Runs a file through its engine: a recording through its own, frames as CSV through that of a request.
pub(super) fn load_timeline(
    file: &Path,
    request: &PlayRequest,
    progress: Progress<'_>,
) -> Result<RecordingTimeline, AppError> {
    if is_recording(file)? {
        play_recording(file)
    } else {
        play_frames(file, request, progress)
    }
}

fn play_recording(file: &Path) -> Result<RecordingTimeline, AppError> {
    let (mut player, config) = open_recording(file)?;
    let mut timeline = RecordingTimeline::new(config.pad.clone(), config.engine());
    loop {
        let played = player.next().map_err(|error| AppError::Recording {
            path: file.to_owned(),
            error,
        })?;
        match played {
            Some(RecordedItem::Input(input)) if !timeline.add_input(&input) => return Ok(timeline),
            Some(_) => {}
            None => return Ok(timeline),
        }
    }
}

fn play_frames(
    file: &Path,
    request: &PlayRequest,
    progress: Progress<'_>,
) -> Result<RecordingTimeline, AppError> {
    let pad = load_pad(&request.pad)?.pad;
    let mut frames = open_file(file, &pad)?;
    let profile = load_profile(&request.profile, request.user.as_deref())?.profile;
    let correction = request
        .calibration
        .as_deref()
        .map(|file| calibration::load(file, &pad))
        .transpose()?;
    let method = choose_method(request.method, &profile, &pad);
    let first = sensing(&pad, method, progress)?
        .build_initial()
        .map_err(|error| no_image(&pad, error))?;
    let engine = Engine::new(&pad, Arc::new(first), Arc::new(profile)).with_correction(correction);
    let mut timeline = RecordingTimeline::new(pad, engine);
    loop {
        let has_room = match frames.read()? {
            SourceReading::Frame(frame) => timeline.add_input(&Input::Frame(frame)),
            SourceReading::End => false,
            _ => true,
        };
        if !has_room {
            return Ok(timeline);
        }
    }
}
