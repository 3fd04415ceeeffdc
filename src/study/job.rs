//! Runs the cases of a study on all cores. Each result is stored as soon as it is there, so that a study that was killed
//! continues where it stopped.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use super::folder::{Folder, write_whole};

use super::StudyError;
use super::report::Report;

/// A study: independent cases, and a report of all results.
pub trait Study: Sync {
    /// The input of one case.
    type Case: Sync;
    /// The result of one case, stored as JSON.
    type Outcome: Serialize + DeserializeOwned;

    /// The cases, in order.
    fn cases(&self) -> &[Self::Case];

    /// The file name (without ending) under which a case's result is stored.
    fn id(case: &Self::Case) -> String;

    /// Solves a case.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    fn solve(&self, case: &Self::Case) -> Result<Self::Outcome, StudyError>;

    /// The report of all results, which are in the order of the cases.
    ///
    /// # Errors
    /// Figures that cannot be drawn.
    fn report(&self, outcomes: &[Self::Outcome]) -> Result<Report, StudyError>;
}

/// Part `index` of `count` of the cases, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of this part, 1 to `count`.
    pub index: usize,
    /// Number of parts.
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
    /// All cases.
    pub const ALL: Self = Self { index: 1, count: 1 };

    fn holds(self, case: usize) -> bool {
        case % self.count == self.index - 1
    }
}

/// Solves and stores the cases of a shard that have no result yet. `progress` receives (done, total).
///
/// # Errors
/// The error of a case that failed; no further case is started, finished ones stay stored.
pub fn run_shard<S: Study>(
    folder: &Folder,
    study: &S,
    shard: Shard,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<(), StudyError> {
    let cases = study.cases().iter().enumerate();
    let mine: Vec<&S::Case> = cases
        .filter_map(|(index, case)| shard.holds(index).then_some(case))
        .collect();
    let is_missing = |case: &&S::Case| folder.stored_result::<S::Outcome>(&S::id(case)).is_none();
    let missing: Vec<&S::Case> = mine.iter().copied().filter(is_missing).collect();
    let stored = mine.len() - missing.len();
    solve_in_parallel(
        &missing,
        |case| folder.store_result(&S::id(case), &study.solve(case)?),
        |done, _| progress(stored + done, mine.len()),
    )?;
    Ok(())
}

/// Solves cases on all cores, each on one thread, and returns the results in the order of the cases. `progress` receives
/// (done, total).
///
/// # Errors
/// The error of a case that failed; no further case is started.
pub fn solve_in_parallel<C, R>(
    cases: &[C],
    solve: impl Fn(&C) -> Result<R, StudyError> + Sync,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<R>, StudyError>
where
    C: Sync,
    R: Send,
{
    let done = AtomicUsize::new(0);
    progress(0, cases.len());
    cases
        .par_iter()
        // A case takes seconds to minutes: each is a job of its own.
        .with_max_len(1)
        .map(|case| {
            let result = solve(case)?;
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, cases.len());
            Ok(result)
        })
        .collect()
}

/// The stored results of all cases, in order.
///
/// # Errors
/// Missing results, with their number.
pub fn load_results<S: Study>(folder: &Folder, study: &S) -> Result<Vec<S::Outcome>, StudyError> {
    let cases = study.cases();
    let stored: Vec<S::Outcome> = cases
        .iter()
        .filter_map(|case| folder.stored_result(&S::id(case)))
        .collect();
    if stored.len() < cases.len() {
        return Err(StudyError::refused(format!(
            "{}: {} of {} cases are missing: run the remaining shards",
            folder.path().display(),
            cases.len() - stored.len(),
            cases.len()
        )));
    }
    Ok(stored)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Multiplies numbers and counts how often it did.
    struct Multiply {
        numbers: Vec<u32>,
        solved: AtomicUsize,
    }

    impl Study for Multiply {
        type Case = u32;
        type Outcome = f64;

        fn cases(&self) -> &[u32] {
            &self.numbers
        }

        fn id(case: &u32) -> String {
            format!("number-{case}")
        }

        fn solve(&self, case: &u32) -> Result<f64, StudyError> {
            self.solved.fetch_add(1, Ordering::Relaxed);
            Ok(f64::from(*case) * 0.1)
        }

        fn report(&self, _: &[f64]) -> Result<Report, StudyError> {
            Err(StudyError::internal("no report"))
        }
    }

    #[test]
    fn stored_cases_are_not_solved_again_and_shards_share_the_work() {
        let root = tempfile::tempdir().expect("a folder");
        let study = Multiply {
            numbers: (0..7).collect(),
            solved: AtomicUsize::new(0),
        };
        let open = |name: &str| Folder::open(&root.path().join(name), &"settings").expect("opened");
        let solve = |folder: &Folder, shard: &str| {
            run_shard(folder, &study, shard.parse().expect("a shard"), |_, _| {}).expect("solved");
            study.solved.load(Ordering::Relaxed)
        };
        let (one, two, whole) = (open("one"), open("two"), open("whole"));
        solve(&one, "1/2");
        assert_eq!(solve(&two, "2/2"), 7);
        assert_eq!(solve(&one, "1/2"), 7, "stored results are used");
        assert_eq!(solve(&whole, "1/1"), 14);
        assert!(load_results(&one, &study).is_err(), "half is missing");
        one.copy_results_from(two.path()).expect("the same study");
        assert_eq!(
            load_results(&one, &study).expect("complete"),
            load_results(&whole, &study).expect("complete")
        );
    }

    #[test]
    fn results_come_in_order_and_a_failure_is_returned() {
        let numbers: Vec<u32> = (0..100).collect();
        let doubled = solve_in_parallel(&numbers, |n| Ok(2 * n), |_, _| {}).expect("solved");
        assert!(doubled.into_iter().eq((0..100).map(|n| 2 * n)));
        let fail = |n: &u32| match n {
            50 => Err(StudyError::refused("fifty")),
            n => Ok(*n),
        };
        let error = solve_in_parallel(&numbers, fail, |_, _| {}).expect_err("one fails");
        assert_eq!(error.to_string(), "fifty");
    }
}
