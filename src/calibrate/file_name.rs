//! Names for files that must not overwrite others.

/// `PAD.calibration.json`, or `PAD-2.calibration.json` and so on if that name is taken.
pub fn calibration_file_name(pad: &str, is_taken: impl Fn(&str) -> bool) -> String {
    free_file_name(pad, "calibration.json", is_taken)
}

/// `STEM.ENDING`, or `STEM-2.ENDING` and so on if that name is taken.
pub fn free_file_name(stem: &str, ending: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut name = format!("{stem}.{ending}");
    let mut number = 2;
    while is_taken(&name) {
        name = format!("{stem}-{number}.{ending}");
        number += 1;
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_calibration_does_not_overwrite_the_first() {
        let mut names: Vec<String> = Vec::new();
        for _ in 0..3 {
            names.push(calibration_file_name("strip", |name| {
                names.iter().any(|taken| taken == name)
            }));
        }
        assert_eq!(
            names,
            [
                "strip.calibration.json",
                "strip-2.calibration.json",
                "strip-3.calibration.json"
            ]
        );
    }
}
