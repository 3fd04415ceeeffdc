//! Cases of a study: solved side by side, each kept as soon as it is done, so that a killed study goes on where it was.
//!
//! A folder holds `study.json` (what is studied) and `cases/ID.json` (what each case gave). Everything else in it is made
//! from these alone. So a resumed study, and shards that are merged, end with the same files as one unbroken run.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::StudyError;
use super::report::Report;

/// A study: cases that are solved one by one, and a report of them all.
pub trait Study: Sync {
    /// What is solved at once.
    type Case: Sync;
    /// What a case gives; kept as JSON.
    type Outcome: Serialize + DeserializeOwned;

    /// The cases, in order.
    fn cases(&self) -> &[Self::Case];

    /// The name under which a case's outcome is kept.
    fn id(case: &Self::Case) -> String;

    /// Solves a case.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    fn solve(&self, case: &Self::Case) -> Result<Self::Outcome, StudyError>;

    /// The report of all outcomes, in the order of the cases.
    ///
    /// # Errors
    /// Figures that cannot be drawn.
    fn report(&self, outcomes: &[Self::Outcome]) -> Result<Report, StudyError>;
}

/// A part of the cases: K of N, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text
            .split_once('/')
            .and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parsed {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("write K/N with K from 1 to N, as in 2/8".to_owned()),
        }
    }
}

impl Shard {
    /// The whole.
    pub const ALL: Self = Self { index: 1, count: 1 };

    fn holds(self, case: usize) -> bool {
        case % self.count == self.index - 1
    }
}

/// What a finished case left behind.
#[derive(Deserialize, Serialize)]
struct Kept<R> {
    /// What it was solved for: a case of another study of the same name is not taken.
    study: String,
    result: R,
}

/// The folder of a study.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    study: String,
}

impl Folder {
    /// Opens or makes a folder for a study, described by its settings.
    ///
    /// # Errors
    /// A folder that cannot be written, or that holds another study.
    pub fn open(path: &Path, settings: &impl Serialize) -> Result<Self, StudyError> {
        let study = serde_json::to_string_pretty(settings)
            .map_err(|error| StudyError::Internal(error.to_string()))?;
        let folder = Self {
            path: path.to_owned(),
            study,
        };
        let cases = path.join("cases");
        fs::create_dir_all(&cases).map_err(|error| StudyError::file(&cases, error))?;
        let manifest = path.join("study.json");
        match fs::read_to_string(&manifest) {
            Ok(other) if other != folder.study => Err(StudyError::Refused {
                reason: format!(
                    "{} holds another study: choose another --out",
                    path.display()
                ),
            }),
            Ok(_) => Ok(folder),
            Err(_) => {
                folder.write("study.json", folder.study.as_bytes())?;
                Ok(folder)
            }
        }
    }

    /// What a folder's study is, as it was written.
    ///
    /// # Errors
    /// A folder that holds no study.
    pub fn settings_text(path: &Path) -> Result<String, StudyError> {
        let manifest = path.join("study.json");
        fs::read_to_string(&manifest).map_err(|error| StudyError::file(&manifest, error))
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file into it, as [`write_whole`].
    ///
    /// # Errors
    /// The disk.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        write_whole(&self.path, name, bytes)
    }

    fn case_name(id: &str) -> String {
        format!("cases/{id}.json")
    }

    /// What a case gave, if it is there and of this study.
    #[must_use]
    pub fn kept<R: DeserializeOwned>(&self, id: &str) -> Option<R> {
        let text = fs::read(self.path.join(Self::case_name(id))).ok()?;
        let kept: Kept<R> = serde_json::from_slice(&text).ok()?;
        (kept.study == self.study).then_some(kept.result)
    }

    fn keep<R: Serialize>(&self, id: &str, result: &R) -> Result<(), StudyError> {
        let kept = Kept {
            study: self.study.clone(),
            result,
        };
        let text =
            serde_json::to_vec(&kept).map_err(|error| StudyError::Internal(error.to_string()))?;
        self.write(&Self::case_name(id), &text)
    }

    /// Takes over the cases that another folder of the same study has.
    ///
    /// # Errors
    /// Another study there; the disk.
    pub fn take_over(&self, other: &Path) -> Result<(), StudyError> {
        if Self::settings_text(other)? != self.study {
            return Err(StudyError::Refused {
                reason: format!(
                    "{} holds another study than the first folder",
                    other.display()
                ),
            });
        }
        let cases = other.join("cases");
        let entries = fs::read_dir(&cases).map_err(|error| StudyError::file(&cases, error))?;
        for entry in entries {
            let path = entry
                .map_err(|error| StudyError::file(&cases, error))?
                .path();
            if path
                .extension()
                .is_some_and(|extension| extension == "json")
                && let Some(name) = path.file_name().and_then(|name| name.to_str())
            {
                let bytes = fs::read(&path).map_err(|error| StudyError::file(&path, error))?;
                self.write(&format!("cases/{name}"), &bytes)?;
            }
        }
        Ok(())
    }
}

/// Writes a file whole or not at all: beside its place first, then renamed.
///
/// # Errors
/// The disk.
pub fn write_whole(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
    let path = folder.join(name);
    let beside = path.with_extension("part");
    fs::write(&beside, bytes)
        .and_then(|()| fs::rename(&beside, &path))
        .map_err(|error| StudyError::file(&path, error))
}

/// Solves the cases of a shard that are not there yet, on all cores, each on one thread. `progress` is told
/// (done, of how many).
///
/// # Errors
/// The first case that fails; the others are kept.
pub fn run<S: Study>(
    folder: &Folder,
    study: &S,
    shard: Shard,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<(), StudyError> {
    let mine: Vec<&S::Case> = study
        .cases()
        .iter()
        .enumerate()
        .filter(|(index, _)| shard.holds(*index))
        .map(|(_, case)| case)
        .collect();
    let todo: Vec<&S::Case> = mine
        .iter()
        .copied()
        .filter(|case| folder.kept::<S::Outcome>(&S::id(case)).is_none())
        .collect();
    let already = mine.len() - todo.len();
    side_by_side(
        &todo,
        |case| {
            let outcome = study.solve(case)?;
            folder.keep(&S::id(case), &outcome)
        },
        |done, _| progress(already + done, mine.len()),
    )?;
    Ok(())
}

/// Solves cases on all cores, each on one thread, and gives what each gave, in their order. `progress` is told
/// (done, of how many).
///
/// # Errors
/// The first case that fails.
pub fn side_by_side<C, R>(
    cases: &[C],
    solve: impl Fn(&C) -> Result<R, StudyError> + Sync,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<R>, StudyError>
where
    C: Sync,
    R: Send,
{
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let solved: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::with_capacity(cases.len()));
    let failure: Mutex<Option<StudyError>> = Mutex::new(None);
    progress(0, cases.len());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(case) = cases.get(index) else { return };
            match solve(case) {
                Ok(result) => {
                    if let Ok(mut solved) = solved.lock() {
                        solved.push((index, result));
                    }
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, cases.len());
                }
                Err(error) => {
                    next.store(cases.len(), Ordering::Relaxed);
                    if let Ok(mut failure) = failure.lock() {
                        failure.get_or_insert(error);
                    }
                }
            }
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for _ in 1..workers.min(cases.len().max(1)) {
            scope.spawn(work);
        }
        work();
    });
    if let Ok(Some(error)) = failure.into_inner() {
        return Err(error);
    }
    // A lock is poisoned only if a thread panicked, and the scope has passed that on by now.
    let mut solved = solved
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    solved.sort_by_key(|(index, _)| *index);
    Ok(solved.into_iter().map(|(_, result)| result).collect())
}

/// What every case gave, in order.
///
/// # Errors
/// Cases that are missing, with how many.
pub fn outcomes<S: Study>(folder: &Folder, study: &S) -> Result<Vec<S::Outcome>, StudyError> {
    let cases = study.cases();
    let kept: Vec<Option<S::Outcome>> =
        cases.iter().map(|case| folder.kept(&S::id(case))).collect();
    let missing = kept.iter().filter(|result| result.is_none()).count();
    if missing > 0 {
        return Err(StudyError::Refused {
            reason: format!(
                "{}: {missing} of {} cases are missing: run the remaining shards",
                folder.path.display(),
                cases.len()
            ),
        });
    }
    Ok(kept.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    /// Squares of a few numbers, counting how often one is solved.
    struct Squares {
        numbers: Vec<u32>,
        solved: AtomicUsize,
    }

    impl Study for Squares {
        type Case = u32;
        type Outcome = f64;

        fn cases(&self) -> &[u32] {
            &self.numbers
        }

        fn id(case: &u32) -> String {
            format!("square-{case}")
        }

        fn solve(&self, case: &u32) -> Result<f64, StudyError> {
            self.solved.fetch_add(1, Ordering::Relaxed);
            Ok(f64::from(*case) * 0.1)
        }

        fn report(&self, _: &[f64]) -> Result<Report, StudyError> {
            Err(StudyError::Internal("nothing to tell".to_owned()))
        }
    }

    #[test]
    fn what_is_done_is_not_done_again_and_shards_share_the_work() {
        let root = tempfile::tempdir().expect("a folder");
        let study = Squares {
            numbers: (0..7).collect(),
            solved: AtomicUsize::new(0),
        };
        let open = |name: &str| Folder::open(&root.path().join(name), &"settings").expect("opened");
        let solve = |folder: &Folder, shard: &str| {
            run(folder, &study, shard.parse().expect("a shard"), |_, _| {}).expect("solved");
            study.solved.load(Ordering::Relaxed)
        };
        let (one, two, whole) = (open("one"), open("two"), open("whole"));
        solve(&one, "1/2");
        assert_eq!(solve(&two, "2/2"), 7);
        assert_eq!(solve(&one, "1/2"), 7, "kept cases are taken");
        assert_eq!(solve(&whole, "1/1"), 14);
        assert!(outcomes(&one, &study).is_err(), "half is missing");
        one.take_over(two.path()).expect("the same study");
        assert_eq!(
            outcomes(&one, &study).expect("complete"),
            outcomes(&whole, &study).expect("complete")
        );
    }

    #[test]
    fn a_folder_of_another_study_is_refused() {
        let root = tempfile::tempdir().expect("a folder");
        Folder::open(root.path(), &"one").expect("opened");
        let said = Folder::open(root.path(), &"two")
            .expect_err("another")
            .to_string();
        assert!(said.contains("holds another study"), "{said}");
    }
}
