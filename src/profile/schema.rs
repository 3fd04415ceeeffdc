//! The JSON schema of a profile, from the list of keys. Editors use it to complete and check texts (`#:schema`).

use serde_json::{Map, Value, json};

use super::key_list::keys_of;
use super::keys::{Fallback, Key, KeyKind, Table};

/// The schema as text.
#[must_use]
pub fn schema() -> String {
    let table = |kind: Table, required: &[&str]| {
        json!({
            "type": "object",
            "additionalProperties": false,
            "required": required,
            "properties": properties(kind),
        })
    };
    let mut whole = table(Table::Profile, &["schema"]);
    let tables = json!({
        "vars": {
            "description": "values that others refer to as \"$name\"",
            "type": "object",
            "additionalProperties": { "type": ["number", "string", "boolean"] },
        },
        "match": table(Table::Match, &[]),
        "region": { "type": "array", "items": table(Table::Region, &["name"]) },
        "binding": { "type": "array", "items": table(Table::Binding, &[]) },
    });
    if let (Some(Value::Object(properties)), Value::Object(tables)) =
        (whole.get_mut("properties"), tables)
    {
        properties.extend(tables);
    }
    if let Value::Object(whole) = &mut whole {
        whole.insert(
            "$schema".to_owned(),
            json!("https://json-schema.org/draft/2020-12/schema"),
        );
        whole.insert("title".to_owned(), json!("A gelpad profile"));
    }
    format!("{whole:#}\n")
}

fn properties(table: Table) -> Map<String, Value> {
    keys_of(table)
        .map(|key| (key.name.to_owned(), property(key)))
        .collect()
}

fn property(key: &Key) -> Value {
    let variable = json!({ "type": "string", "pattern": "^\\$" });
    let mut about = key.about.to_owned();
    if key.default != Fallback::None {
        about.push_str(&format!(" (default: {})", key.default));
    }
    if !key.only.is_empty() {
        about.push_str(&format!("; applies to {}", key.only.join(", ")));
    }
    let own = match key.kind {
        KeyKind::Number(least, most, _) => {
            json!({ "type": "number", "minimum": least, "maximum": most })
        }
        KeyKind::Count(least, most) => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        KeyKind::Word(words) => json!({ "enum": words }),
        KeyKind::Text => json!({ "type": "string" }),
        KeyKind::Texts => json!({ "type": ["string", "array"], "items": { "type": "string" } }),
        KeyKind::Flag => json!({ "type": "boolean" }),
        KeyKind::Points => {
            json!({ "type": "array", "minItems": 3, "items": { "type": "array", "minItems": 2, "maxItems": 2 } })
        }
    };
    json!({ "description": about, "anyOf": [own, variable] })
}
