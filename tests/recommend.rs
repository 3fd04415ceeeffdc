//! Settings recommended from a person's own presses, against the best settings that are the same for everybody.
//!
//! Simulated people (tests/recommend/people.rs), ten of each kind or twenty with `GELPAD_FULL=1`, press what they are asked
//! for, once to be learned from and once to be judged. The fixed settings are the best that the same search finds when it is
//! shown the presses that are judged, of all people together: no other choice of one setting for all does better there, as far
//! as the search sees. Beside them stand the best that do not spoil the pad for steady hands.
//!
//! `GELPAD_FULL=1 cargo test --test recommend -- --nocapture` prints the table of docs/calibration.md. `GELPAD_TUNING=1`
//! takes the people on whom the search was tuned instead of those who were held out.

#[path = "recommend/people.rs"]
mod people;

use gelpad::calibrate::recommend::{
    Judge, Outcome, Overlay, Recommendation, Trial, climb, recommend,
};
use gelpad::profile::{Source, find_shipped};
use people::{KINDS, Kind, Person};

const PAD_MM: [f64; 2] = [100.0, 100.0];
/// Presses that a person is asked for before settings are recommended, and presses that are judged.
const LEARNED: usize = 60;
const JUDGED: usize = 120;
/// What own settings are worth to slow and to trembling hands, at least, in 100 presses.
const GAIN_POINTS: f64 = 15.0;
/// People on whom the search was tuned, and people whom nobody looked at then.
const TUNED: std::ops::RangeInclusive<u64> = 1..=20;
const HELD_OUT: std::ops::RangeInclusive<u64> = 1001..=1020;
/// Without `GELPAD_FULL`: so many of each kind.
const SAMPLE: usize = 10;

fn profile() -> Source {
    find_shipped("super-mario-classified").expect("shipped")
}

fn judge() -> Judge<'static> {
    Judge::new(&profile(), &find_shipped, PAD_MM)
}

/// A person's presses that are judged, and what is recommended to that person.
struct Case {
    kind: Kind,
    judged: Vec<Trial>,
    minutes: f64,
    recommended: Recommendation,
}

fn case(kind: Kind, seed: u64) -> Case {
    let mut person = Person::new(kind, seed);
    let (learned, _) = person.session(LEARNED);
    let (judged, minutes) = person.session(JUDGED);
    let recommended = recommend(&learned, &profile(), &find_shipped, PAD_MM).expect("recommended");
    Case {
        kind,
        judged,
        minutes,
        recommended,
    }
}

/// The same settings for everybody: the best for all of these presses together, or the best of those under which steady
/// hands fare no worse than with the profile as it is shipped.
fn best_fixed(cases: &[Case], spares_steady: bool) -> Overlay {
    let plain = Overlay::of_profile(&judge().profile(None).expect("sound"));
    let of = |steady: bool| -> Vec<Trial> {
        cases
            .iter()
            .filter(|case| (case.kind == Kind::Steady) == steady)
            .flat_map(|case| case.judged.iter().map(Trial::thinned))
            .collect()
    };
    let (steady, others) = (of(true), of(false));
    let shipped = outcome(&steady, None).share();
    let mut value = |overlay: &Overlay| {
        let mut all = outcome(&steady, Some(overlay));
        let lost = if spares_steady {
            (shipped - all.share()).max(0.0)
        } else {
            0.0
        };
        all += outcome(&others, Some(overlay));
        Ok::<f64, std::convert::Infallible>(all.share() - 100.0 * lost)
    };
    // Two settings come out nearly alike: the search begins at both.
    let joining = Overlay {
        long_ms: 700,
        when_decided: true,
        tremor_ms: 130,
        tremor_mm: 20,
        slow_keys_ms: 60,
        bounce_keys_ms: 200,
        ..plain.clone()
    };
    let mut found: Vec<(f64, Overlay)> = [plain, joining]
        .into_iter()
        .map(|from| {
            let best = climb(from, &mut value).expect("found");
            (value(&best).expect("judged"), best)
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.pop().expect("two").1
}

fn outcome(part: &[Trial], overlay: Option<&Overlay>) -> Outcome {
    judge()
        .outcome(part, overlay)
        .expect("the profile's own regions")
}

/// Share that came out right, and wrong presses a minute, of one kind of people.
fn figures(cases: &[Case], kind: Kind, overlay: impl Fn(&Case) -> Option<Overlay>) -> (f64, f64) {
    let judge = judge();
    let (mut all, mut minutes) = (Outcome::default(), 0.0);
    for case in cases.iter().filter(|case| case.kind == kind) {
        all += judge
            .outcome(&case.judged, overlay(case).as_ref())
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
        let told = |(share, wrong): (f64, f64)| format!("{share:.1} %, {wrong:.2}");
        println!(
            "| {kind:?} | {} | {} | {} | {} |",
            told(shipped),
            told(same),
            told(spared),
            told(own)
        );
        // The best for all swallow presses of steady hands, wrong ones too.
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
