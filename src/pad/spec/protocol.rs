//! The protocol of a pad as written: patterns by name or by pairs, or a list of readings.

use toml::Spanned;

use super::{ProtocolSpec, ReadingsSpec};
use crate::pad::{Channel, Pair, Protocol};
use crate::types::Diagnostic;

/// Most readings of a frame.
const MOST_CHANNELS: usize = 5000;

pub(super) fn protocol(
    spec: &Spanned<ProtocolSpec>,
    electrodes: usize,
) -> Result<Protocol, Diagnostic> {
    let written = spec.get_ref();
    let half = written.readings == ReadingsSpec::Half;
    let made = if let Some(list) = &written.channels {
        let others = written.stimulation.is_some()
            || written.measurement.is_some()
            || written.drives.is_some()
            || written.measures.is_some()
            || half;
        if others {
            return Err(Diagnostic::new(
                spec.span(),
                "`channels` lists every reading: remove the other patterns",
                "in this table",
            ));
        }
        let channels = list
            .iter()
            .map(|[a, b, p, q]| Channel {
                drive: Pair(*a, *b),
                measure: Pair(*p, *q),
            })
            .collect();
        Protocol::from_channels(electrodes, channels)
    } else {
        let drives = pattern(
            spec,
            &written.stimulation,
            &written.drives,
            "stimulation",
            electrodes,
        )?;
        let measures = pattern(
            spec,
            &written.measurement,
            &written.measures,
            "measurement",
            electrodes,
        )?;
        Protocol::from_patterns(electrodes, &drives, &measures, half)
    };
    let protocol =
        made.map_err(|error| Diagnostic::new(spec.span(), error.to_string(), "in this table"))?;
    let protocol = match &written.order {
        Some(order) => protocol
            .with_drive_order(order.get_ref())
            .map_err(|error| Diagnostic::new(order.span(), error.to_string(), "here"))?,
        None => protocol,
    };
    if protocol.channels.len() > MOST_CHANNELS {
        return Err(Diagnostic::new(
            spec.span(),
            format!(
                "{} readings: a frame has at most {MOST_CHANNELS}",
                protocol.channels.len()
            ),
            "in this table",
        ));
    }
    Ok(protocol)
}

/// The pairs of a named pattern, or of an explicit list.
fn pattern(
    table: &Spanned<ProtocolSpec>,
    named: &Option<Spanned<String>>,
    listed: &Option<Vec<[usize; 2]>>,
    key: &str,
    electrodes: usize,
) -> Result<Vec<Pair>, Diagnostic> {
    match (named, listed) {
        (Some(name), None) => {
            let step = step_of(name.get_ref(), electrodes).ok_or_else(|| {
                Diagnostic::new(
                    name.span(),
                    format!("`{}` is not a {key} pattern", name.get_ref()),
                    "unknown",
                )
                .help(format!(
                    "write adjacent, opposite, or skip-K with K electrodes between the two (skip-2), K at most {}",
                    electrodes - 2
                ))
            })?;
            Ok(Protocol::pairs_with_step(electrodes, step))
        }
        (None, Some(list)) => Ok(list.iter().map(|[a, b]| Pair(*a, *b)).collect()),
        _ => Err(Diagnostic::new(
            table.span(),
            format!("the protocol needs either `{key}` or its list of pairs"),
            "in this table",
        )),
    }
}

fn step_of(name: &str, electrodes: usize) -> Option<usize> {
    match name {
        "adjacent" => Some(1),
        "opposite" => Some(electrodes / 2),
        _ => {
            let skip: usize = name.strip_prefix("skip-")?.parse().ok()?;
            skip.checked_add(1).filter(|step| *step < electrodes)
        }
    }
}
