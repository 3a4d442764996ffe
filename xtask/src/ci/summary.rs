//! What test runners say of themselves, in their own words.

/// The last line of one test runner.
#[derive(Debug, PartialEq)]
pub struct Summary {
    /// What was tested.
    pub suite: String,
    /// The runner's own words: `test result: ok. 3 passed; ...`, or pytest's `93 passed in 41.20s`.
    pub result: String,
}

/// The summaries in the output of a suite; documentation tests have one for each crate.
pub fn find(suite: &str, output: &str) -> Vec<Summary> {
    let mut suite = suite.to_owned();
    let mut summaries = vec![];
    for line in output.lines().map(str::trim) {
        if let Some(crate_name) = line.strip_prefix("Doc-tests ") {
            suite = format!("{crate_name} (documentation)");
        } else if line.starts_with("test result: ") || is_pytest(line) {
            let result = line.trim_matches(['=', ' ']).to_owned();
            summaries.push(Summary { suite: suite.clone(), result });
        }
    }
    summaries
}

/// Whether a line is pytest's last one: `=== 1 failed, 47 passed in 6.40s ===`.
fn is_pytest(line: &str) -> bool {
    let words = line.trim_matches(['=', ' ']);
    let has_counts =
        words.split([' ', ',']).any(|word| matches!(word, "passed" | "failed" | "error" | "errors"));
    has_counts && words.starts_with(|c: char| c.is_ascii_digit()) && words.contains(" in ")
}

#[derive(Debug, Default, PartialEq)]
pub struct Counts {
    pub passed: u64,
    pub failed: u64,
    /// Left out, because they are slow or cannot run everywhere.
    pub ignored: u64,
}

impl Counts {
    fn parse(result: &str) -> Self {
        let mut words = result.split([' ', ';', ',']).filter(|word| !word.is_empty()).peekable();
        let mut counts = Self::default();
        while let Some(word) = words.next() {
            let (Ok(number), Some(what)) = (word.parse(), words.peek()) else { continue };
            match *what {
                "passed" => counts.passed = number,
                "failed" => counts.failed = number,
                "ignored" | "deselected" => counts.ignored = number,
                _ => {}
            }
        }
        counts
    }

    pub fn parse_all(summaries: &[Summary]) -> Self {
        summaries.iter().map(|summary| Self::parse(&summary.result)).sum()
    }
}

impl std::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
        items.fold(Self::default(), |a, b| Self {
            passed: a.passed + b.passed,
            failed: a.failed + b.failed,
            ignored: a.ignored + b.ignored,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_carry_the_suite_they_belong_to() {
        let output = "running 3 tests
test camera::tests::a ... ok
test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.12s
   Doc-tests lumivox_core
test result: FAILED. 1 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s";
        let summaries = find("lumivox_core", output);
        let suites: Vec<_> = summaries.iter().map(|s| s.suite.as_str()).collect();
        assert_eq!(suites, ["lumivox_core", "lumivox_core (documentation)"]);
        assert_eq!(Counts::parse_all(&summaries), Counts { passed: 4, failed: 2, ignored: 1 });
    }

    #[test]
    fn pytest_counts_what_it_left_out() {
        let output = "==> Tests, of the wheel that is installed
tests/test_a.py ....F [100%]
====== 1 failed, 47 passed, 9 deselected, 4 warnings in 6.40s ======";
        let summaries = find("pytest", output);
        assert_eq!(summaries.len(), 1, "{summaries:?}");
        assert_eq!(summaries[0].result, "1 failed, 47 passed, 9 deselected, 4 warnings in 6.40s");
        assert_eq!(Counts::parse_all(&summaries), Counts { passed: 47, failed: 1, ignored: 9 });
        assert_eq!(find("pytest", "283 passed in 204.01s (0:03:24)").len(), 1);
    }
}
