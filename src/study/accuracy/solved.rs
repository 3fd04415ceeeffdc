//! What pads other than the drawing are located with, solved here.

use std::sync::Arc;

use crate::eit::ResponseBuilder;
use crate::pad::Pad;
use crate::study::StudyError;
use crate::touch::SensingBuilder;

/// The sensing of a pad as found, from that of its drawing, as play derives it.
pub(super) fn found_pad(pad: &Pad, drawn: &SensingBuilder) -> Result<SensingBuilder, StudyError> {
    let Some(table) = drawn.table() else {
        return Err(StudyError::refused("the pad has no response table"));
    };
    let responses = ResponseBuilder::from_drawing(pad, Arc::clone(table))?;
    with_table(pad, drawn, responses)
}

/// The sensing of a pad with its table; method as of `like`.
pub(super) fn with_table(
    pad: &Pad,
    like: &SensingBuilder,
    responses: ResponseBuilder,
) -> Result<SensingBuilder, StudyError> {
    let rows: Vec<_> = (0..responses.rows())
        .map(|row| responses.solve_row(row))
        .collect();
    let table = Arc::new(responses.finish(&rows));
    Ok(SensingBuilder::new(pad, like.method())?.with_table(table))
}
