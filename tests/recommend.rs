//! Settings recommended from a person's own presses, compared with the best fixed settings.
//!
//! Simulated people (tests/recommend/people.rs), ten of each kind or twenty with `GELPAD_FULL=1`, make requested presses, once
//! for learning and once for the test. The fixed settings are the best that the same search finds on the test presses of all
//! people together, so no other fixed settings are known to be better. The second fixed settings are the best of those that
//! do not harm steady hands.
//!
//! `GELPAD_FULL=1 cargo test --test recommend -- --nocapture` prints the table of docs/calibration.md. `GELPAD_TUNING=1`
//! takes the people of the tuning instead of those held out.

#[path = "recommend/people.rs"]
mod people;

use gelpad::calibrate::recommend::{
    PressTrial, Recommendation, RecommendedSettings, TrialScore, TrialScorer, recommend,
    search_settings,
};
use gelpad::profile::{Source, find_shipped};
use people::{KINDS, Kind, Person};

const PAD_MM: [f64; 2] = [100.0, 100.0];
/// Presses of a person for learning and for the test.
const LEARNED: usize = 60;
const JUDGED: usize = 120;
/// Least gain of recommended settings for slow and trembling hands, percentage points.
const GAIN_POINTS: f64 = 15.0;
/// Seeds of the people used for tuning, and of those held out.
const TUNED: std::ops::RangeInclusive<u64> = 1..=20;
const HELD_OUT: std::ops::RangeInclusive<u64> = 1001..=1020;
/// People of each kind without `GELPAD_FULL`.
const SAMPLE: usize = 10;

fn profile() -> Source {
    find_shipped("super-mario-classified").expect("shipped")
}

fn judge() -> TrialScorer<'static> {
    TrialScorer::new(&profile(), &find_shipped, PAD_MM)
}

/// The test presses of a person, and the recommendation for that person.
struct Case {
    kind: Kind,
    judged: Vec<PressTrial>,
    minutes: f64,
    recommended: Recommendation,
}

fn case(kind: Kind, seed: u64) -> Case {
    let mut person = Person::new(kind, seed);
    let (learned, _) = person.session(LEARNED);
    let (judged, minutes) = person.session(JUDGED);
    let recommended = recommend(&learned, &profile(), &find_shipped, PAD_MM).expect("recommended");
    let value = |score: &TrialScore| score.right as i64 - 2 * score.wrong as i64;
    let (before, after) = (&recommended.before, &recommended.after);
    assert!(
        value(after) >= value(before),
        "{kind:?} {seed}: {after:?} is worse than {before:?}"
    );
    Case {
        kind,
        judged,
        minutes,
        recommended,
    }
}

/// Fixed settings: the best for all of these presses together, or the best of those with which steady hands are no worse than
/// with the shipped profile.
fn best_fixed(cases: &[Case], spares_steady: bool) -> RecommendedSettings {
    let plain = RecommendedSettings::from_profile(&judge().profile(None).expect("sound"));
    let of = |steady: bool| -> Vec<PressTrial> {
        cases
            .iter()
            .filter(|case| (case.kind == Kind::Steady) == steady)
            .flat_map(|case| case.judged.iter().map(PressTrial::thinned))
            .collect()
    };
    let (steady, others) = (of(true), of(false));
    let shipped = outcome(&steady, None).share();
    let mut value = |overlay: &RecommendedSettings| {
        let mut all = outcome(&steady, Some(overlay));
        let lost = if spares_steady {
            (shipped - all.share()).max(0.0)
        } else {
            0.0
        };
        all += outcome(&others, Some(overlay));
        Ok::<f64, std::convert::Infallible>(all.share() - 100.0 * lost)
    };
    // Two settings are nearly equal: the search starts at both.
    let joining = RecommendedSettings {
        long_ms: 700,
        when_decided: true,
        tremor_ms: 130,
        tremor_mm: 20,
        slow_keys_ms: 60,
        bounce_keys_ms: 200,
        ..plain.clone()
    };
    let mut found: Vec<(f64, RecommendedSettings)> = [plain, joining]
        .into_iter()
        .map(|from| {
            let best = search_settings(from, &mut value).expect("found");
            (value(&best).expect("judged"), best)
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.pop().expect("two").1
}

fn outcome(part: &[PressTrial], overlay: Option<&RecommendedSettings>) -> TrialScore {
    judge()
        .score(part, overlay)
        .expect("the profile's own regions")
}

/// Share of right presses, and wrong presses per minute, of one kind of people.
fn figures(
    cases: &[Case],
    kind: Kind,
    overlay: impl Fn(&Case) -> Option<RecommendedSettings>,
) -> (f64, f64) {
    let judge = judge();
    let (mut all, mut minutes) = (TrialScore::default(), 0.0);
    for case in cases.iter().filter(|case| case.kind == kind) {
        all += judge
            .score(&case.judged, overlay(case).as_ref())
            .expect("sound");
        minutes += case.minutes;
    }
    (100.0 * all.share(), all.wrong as f64 / minutes)
}

#[test]
fn own_settings_beat_the_best_fixed_ones_for_slow_and_for_trembling_hands() {
    let seeds = if std::env::var_os("GELPAD_TUNING").is_some() {
        TUNED
    } else {
        HELD_OUT
    };
    let count = match std::env::var_os("GELPAD_FULL") {
        Some(_) => seeds.clone().count(),
        None => SAMPLE,
    };
    let all: Vec<(Kind, u64)> = KINDS
        .into_iter()
        .flat_map(|kind| seeds.clone().take(count).map(move |seed| (kind, seed)))
        .collect();
    let (left, right) = all.split_at(all.len() / 2);
    let cases: Vec<Case> = std::thread::scope(|scope| {
        let half = |part: &[(Kind, u64)]| -> Vec<Case> {
            part.iter().map(|(kind, seed)| case(*kind, *seed)).collect()
        };
        let other = scope.spawn(move || half(right));
        let mut cases = half(left);
        cases.extend(other.join().expect("no panic"));
        cases
    });
    let (fixed, sparing) = std::thread::scope(|scope| {
        let sparing = scope.spawn(|| best_fixed(&cases, true));
        let fixed = best_fixed(&cases, false);
        (fixed, sparing.join().expect("no panic"))
    });
    println!("the best settings for all:\n{}", fixed.toml(None));
    println!("the best that spare steady hands:\n{}", sparing.toml(None));
    println!(
        "| hands | as shipped | fixed, best for all | fixed, sparing steady hands | recommended |"
    );
    println!("| --- | --- | --- | --- | --- |");
    let mut failed = Vec::new();
    for kind in KINDS {
        let shipped = figures(&cases, kind, |_| None);
        let same = figures(&cases, kind, |_| Some(fixed.clone()));
        let spared = figures(&cases, kind, |_| Some(sparing.clone()));
        let own = figures(&cases, kind, |case| Some(case.recommended.overlay.clone()));
        let cell = |(share, wrong): (f64, f64)| format!("{share:.1} %, {wrong:.2}");
        println!(
            "| {kind:?} | {} | {} | {} | {} |",
            cell(shipped),
            cell(same),
            cell(spared),
            cell(own)
        );
        // The best settings for all drop presses of steady hands, including wrong ones.
        let gains = match kind {
            Kind::Steady => own.0 >= same.0 && own.1 <= shipped.1,
            Kind::Slow | Kind::Tremor => {
                own.0 >= same.0.max(spared.0) + GAIN_POINTS && own.1 <= same.1.min(spared.1)
            }
        };
        if !gains {
            failed.push(kind);
        }
    }
    if std::env::var_os("GELPAD_TUNING").is_some() {
        for case in &cases {
            println!("{:?} {:?}", case.kind, case.recommended.overlay);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
