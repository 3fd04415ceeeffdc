//! Listeners of a game: the recorder, and the sender of touches as TUIO.

use super::AppError;
use super::recording::ActiveRecording;
use super::request::{PlayRequest, SourceChoice};
use crate::files;
use crate::output::Tuio;
use crate::runtime::{self, StepListener};
use crate::tape::EngineConfig;
use crate::types::Method;

/// Listeners of a game, and the recording that one of them makes.
#[derive(Default)]
pub(super) struct Listeners {
    pub listeners: Vec<Box<dyn StepListener>>,
    pub recording: Option<ActiveRecording>,
}

impl Listeners {
    pub(super) fn start(
        request: &PlayRequest,
        config: &EngineConfig,
        method: Method,
    ) -> Result<Self, AppError> {
        let mut started = Self::default();
        if let Some(address) = &request.tuio {
            let tuio = Tuio::connect(address, config.pad.outline.size_mm())?;
            let listener = runtime::send_touches(tuio).map_err(AppError::Thread)?;
            started.listeners.push(listener);
        }
        if let Some(path) = &request.record {
            let setup = match request.slim {
                true => config.to_setup().into_slim(method.name()),
                false => config.to_setup(),
            };
            let (listener, recorder) = runtime::start_recording(path, &setup, request.existing)?;
            started.listeners.push(listener);
            started.recording = Some(ActiveRecording {
                path: path.clone(),
                recorder,
            });
        }
        Ok(started)
    }
}

/// Checks, before anything is opened, that the recording of a request can be written.
pub(super) fn check_recording(request: &PlayRequest) -> Result<(), AppError> {
    let Some(path) = &request.record else {
        return Ok(());
    };
    if let SourceChoice::Replay(file) = &request.source
        && files::is_same(file, path)
    {
        return Err(AppError::Content {
            path: path.clone(),
            reason: "this recording is being played\n  help: record to another file".to_owned(),
        });
    }
    Ok(runtime::check_recording(path, request.existing)?)
}
