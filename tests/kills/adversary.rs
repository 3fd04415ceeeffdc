//! What an adversary draws and whom it kills.

use std::fs;
use std::path::PathBuf;

/// A pseudo-random sequence that is the same in each run (Knuth's LCG).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, end: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(end)) as u32
    }
}

/// Process ids of the processes of gelpad with certain commands (`watch`, `guard`) and a setting in their environment (`NAME=value`).
pub fn processes_with(setting: &str, names: &[&str]) -> Vec<i32> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter(|pid: &i32| {
        let folder = PathBuf::from(format!("/proc/{pid}"));
        let words = |name: &str| {
            let bytes = fs::read(folder.join(name)).unwrap_or_default();
            let words = bytes.split(|byte| *byte == 0);
            words
                .map(|word| String::from_utf8_lossy(word).into_owned())
                .collect::<Vec<_>>()
        };
        let command = words("cmdline");
        let is_watcher = command
            .get(1)
            .is_some_and(|word| names.contains(&word.as_str()));
        is_watcher && words("environ").iter().any(|word| word == setting)
    })
    .collect()
}
