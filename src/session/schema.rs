//! The JSON schema of each topic, for MCAP tools. The texts are part of the format: changing one changes every new file.

/// Name and text of the schema of each topic, in the order of [`super::TOPICS`].
pub(super) const SCHEMAS: [(&str, &str); 14] = [
    (
        "gelpad.Frames",
        r#"{"type":"object","description":"Readings of the pad as received: t_ns of the first frame, dt_ns from each to the next, volts: f32 values, see docs/recordings.md","properties":{"t_ns":{"type":"integer"},"dt_ns":{"type":"array","items":{"type":"integer"}},"volts":{"type":"string","contentEncoding":"base64"}}}"#,
    ),
    (
        "gelpad.Tick",
        r#"{"type":"object","description":"A time that the engine waited for came","properties":{"t_ns":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.Profile",
        r#"{"type":"object","description":"A profile takes over: bases first, its own text last, one person's settings","properties":{"t_ns":{"type":"integer"},"chain":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"toml":{"type":"string"}}}},"user":{"type":"object","properties":{"name":{"type":"string"},"toml":{"type":"string"}}}}}"#,
    ),
    (
        "gelpad.Pause",
        r#"{"type":"object","description":"The player pauses, or goes on","properties":{"t_ns":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.Matrix",
        r#"{"type":"object","description":"Another matrix takes over: the attachment of that name","properties":{"attachment":{"type":"string"}}}"#,
    ),
    (
        "gelpad.Rezero",
        r#"{"type":"object","description":"The pad counts as untouched as it is","properties":{"t_ns":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.Lost",
        r#"{"type":"object","description":"Frames were lost before the engine","properties":{"frames":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.End",
        r#"{"type":"object","description":"The source ended or fell silent","properties":{"t_ns":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.Gap",
        r#"{"type":"object","description":"Inputs that the recorder had to leave out","properties":{"inputs":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.Touches",
        r#"{"type":"object","description":"Touches that are down in a frame; sum: a check sum of what they were to the bit","properties":{"t_ns":{"type":"integer"},"sum":{"type":"integer"},"touches":{"type":"array","items":{"type":"object","properties":{"id":{"type":"integer"},"x_mm":{"type":"number"},"y_mm":{"type":"number"},"area_mm2":{"type":"number"},"force":{"type":"number"}}}}}}"#,
    ),
    (
        "gelpad.Event",
        r#"{"type":"object","description":"What a device was told","properties":{"t_ns":{"type":"integer"},"action":{"type":"string","enum":["press","release","axis","motion","wheel"]},"target":{"type":"string"},"value":{"type":"number"},"dx":{"type":"integer"},"dy":{"type":"integer"}}}"#,
    ),
    (
        "gelpad.Control",
        r#"{"type":"object","description":"What gamepads and switches say","properties":{"t_ns":{"type":"integer"},"present":{"type":"boolean"},"buttons":{"type":"integer"},"axes":{"type":"array","items":{"type":"number"}}}}"#,
    ),
    (
        "gelpad.Parts",
        r#"{"type":"object","description":"Readings of frames that were still being read: t_ns of the first part, dt_ns from each to the next, first channel and count of voltages of each, volts: f32 values of so many frames, see docs/recordings.md","properties":{"t_ns":{"type":"integer"},"dt_ns":{"type":"array","items":{"type":"integer"}},"first":{"type":"array","items":{"type":"integer"}},"count":{"type":"array","items":{"type":"integer"}},"frames":{"type":"integer"},"volts":{"type":"string","contentEncoding":"base64"}}}"#,
    ),
    (
        "gelpad.TouchBlock",
        r#"{"type":"object","description":"Touches of several frames, each as in gelpad.Touches","properties":{"frames":{"type":"array","items":{"type":"object","properties":{"t_ns":{"type":"integer"},"sum":{"type":"integer"},"touches":{"type":"array","items":{"type":"object","properties":{"id":{"type":"integer"},"x_mm":{"type":"number"},"y_mm":{"type":"number"},"area_mm2":{"type":"number"},"force":{"type":"number"}}}}}}}}}"#,
    ),
];
