//! Names of calibration files.

/// `PAD.calibration.json`, or `PAD-2.calibration.json` and so on if that name is taken: no calibration is overwritten.
pub fn calibration_file_name(pad: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut name = format!("{pad}.calibration.json");
    let mut number = 2;
    while is_taken(&name) {
        name = format!("{pad}-{number}.calibration.json");
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
