//! Stimulation and measurement of a pad as written: by name, by pairs, or reading by reading.

use toml::Spanned;

use super::{ProtocolSpec, ReadingsSpec};
use crate::pad::{Channel, Pair, Protocol};
use crate::types::Fault;

/// More readings than this are no frame of a pad.
const MOST_CHANNELS: usize = 5000;
pub(super) fn protocol(spec: &Spanned<ProtocolSpec>, electrodes: usize) -> Result<Protocol, Fault> {
    let written = spec.get_ref();
    let half = written.readings == ReadingsSpec::Half;
    let made = if let Some(list) = &written.channels {
        let others = written.stimulation.is_some()
            || written.measurement.is_some()
            || written.drives.is_some()
            || written.measures.is_some()
            || half;
        if others {
            return Err(Fault::new(
                spec.span(),
                "`channels` lists every reading and goes without other patterns",
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
        Protocol::listed(electrodes, channels)
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
        Protocol::crossed(electrodes, &drives, &measures, half)
    };
    let protocol =
        made.map_err(|error| Fault::new(spec.span(), error.to_string(), "in this table"))?;
    if protocol.channels.len() > MOST_CHANNELS {
        return Err(Fault::new(
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
) -> Result<Vec<Pair>, Fault> {
    match (named, listed) {
        (Some(name), None) => {
            let step = step_of(name.get_ref(), electrodes).ok_or_else(|| {
                Fault::new(
                    name.span(),
                    format!("`{}` is no {key} pattern", name.get_ref()),
                    "not known",
                )
                .help(format!(
                    "write adjacent, opposite, or skip-K with K electrodes between the two (skip-2), K at most {}",
                    electrodes - 2
                ))
            })?;
            Ok(Protocol::stepped(electrodes, step))
        }
        (None, Some(list)) => Ok(list.iter().map(|[a, b]| Pair(*a, *b)).collect()),
        _ => Err(Fault::new(
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
