//! All keys, gathered from the files that read them.

use std::sync::LazyLock;

use super::check::{binding, region, settings, top};
use super::keys::{Key, Table};

static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let shared = binding::shared_keys();
    let inherited = shared.iter().map(|(key, _)| *key);
    let mut keys = [top::KEYS, settings::KEYS].concat();
    keys.extend(inherited.filter(|key| key.table == Table::Setting));
    keys.extend(settings::USER_KEYS);
    keys.push(top::PROCESS);
    keys.extend(region::KEYS);
    keys.extend(binding::KEYS);
    keys.extend(shared.into_iter().map(|(key, only)| Key {
        table: Table::Binding,
        // The list lives as long as the program.
        only: only.leak(),
        ..key
    }));
    keys
});

/// Every key, in the order of the guide.
#[must_use]
pub fn keys() -> &'static [Key] {
    &KEYS
}

/// The keys that may stand in a table of a text.
pub(super) fn keys_of(table: Table) -> impl Iterator<Item = &'static Key> {
    let is_shared = matches!(table, Table::Profile | Table::User);
    keys()
        .iter()
        .filter(move |key| key.table == table || (is_shared && key.table == Table::Setting))
}

/// A key by name.
pub(super) fn find_key(table: Table, name: &str) -> Option<&'static Key> {
    keys_of(table).find(|key| key.name == name)
}
